//! One camera's silhouette, as ellipses are compared with it.

use nalgebra::{Matrix3x4, Vector2};

use crate::camera::{Camera, Ray};
use crate::silhouette::{ContourPoint, DistanceMap, Silhouette};

/// One camera's silhouette, ready for the likelihood.
#[derive(Debug, Clone)]
pub struct EllipseView<'a> {
    /// P.
    pub(super) projection: Matrix3x4<f64>,
    pub(super) camera: Camera,
    pub(super) points: Vec<Vector2<f64>>,
    /// Their lines of sight.
    pub(super) rays: Vec<Ray>,
    pub(super) lengths_px: Vec<f64>,
    pub(super) normals: Vec<Vector2<f64>>,
    pub(super) outside: &'a DistanceMap,
    pub(super) px_per_m: f64,
}

impl<'a> EllipseView<'a> {
    /// A silhouette thinned to one border point every `spacing_m`, of a body at depth `depth_m`.
    pub fn new(camera: &Camera, silhouette: &'a Silhouette, depth_m: f64, spacing_m: f64) -> Self {
        let px_per_m = camera.intrinsics.focal_px() / depth_m;
        let contour = silhouette.thinned(spacing_m * px_per_m);
        Self {
            camera: camera.clone(),
            projection: camera.projection(),
            points: contour.iter().map(|p| p.pixel.coords).collect(),
            rays: contour.iter().map(|p| camera.ray(&p.pixel)).collect(),
            lengths_px: contour.iter().map(ContourPoint::counted_px).collect(),
            normals: contour.iter().map(|p| p.normal).collect(),
            outside: &silhouette.outside,
            px_per_m,
        }
    }

    /// Number of border points.
    pub fn len(&self) -> usize {
        self.points.len()
    }

    /// No border point at all.
    pub fn is_empty(&self) -> bool {
        self.points.is_empty()
    }

    /// Only some of the border points.
    pub(super) fn only(&self, points: &[usize]) -> Self {
        Self {
            camera: self.camera.clone(),
            projection: self.projection,
            points: points.iter().map(|&i| self.points[i]).collect(),
            rays: points.iter().map(|&i| self.rays[i]).collect(),
            lengths_px: points.iter().map(|&i| self.lengths_px[i]).collect(),
            normals: points.iter().map(|&i| self.normals[i]).collect(),
            outside: self.outside,
            px_per_m: self.px_per_m,
        }
    }
}
