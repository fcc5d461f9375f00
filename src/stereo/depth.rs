//! From disparities to points.
//!
//! Take the left camera of a rectified pair, with focal length f, and the second camera at a distance B to its right. A
//! pixel with x = u − c_left and y = v − c_v and the disparity d∞ + D, d∞ = c_left − c_right, shows Z = f·B/D, X = Z·r,
//! r = (x/f, y/f, 1). Both lines of sight meet there, so this is the point of least squares that
//! [`intersect`](super::intersect) would find. Columns err by σ in either image and the row, measured twice, by σ/√2:
//!
//! cov X = σ² (aaᵀ + bbᵀ + ½ccᵀ), a = ∂X/∂u_left = Z·(1/f, 0, 0) − b, b = ∂X/∂u_right = (Z/D)·r, c = ∂X/∂v = Z·(0, 1/f, 0).

use nalgebra::{Matrix3, Point3, Vector3};

use super::correlation::{CorrelationOptions, DisparityRange, correlate};
use super::rectify::{RectifiedPair, bytes, rectify};
use super::view::StereoView;
use super::{CloudPoint, DepthError, Spread};
use crate::image::{Mask, Plane};
use crate::math::Rigid3;

/// Standard deviation of a place in either image, px: a disparity has √2 times that, 0.3 px, as on `stereo/cones`.
const SIGMA_PX: f64 = 0.2;
/// Most disparities that are computed.
const MOST_DISPARITIES: f64 = 256.0;

/// The points that correlation of a pair gives.
#[derive(Debug, Clone, PartialEq)]
pub struct DepthMap {
    /// The rectified images.
    pub pair: RectifiedPair,
    /// u_left − u_right of each pixel of the left one, px; NaN where none is sure or the pixel does not show the subject.
    pub disparities: Plane<f32>,
    /// A point for each disparity, row by row.
    pub points: Vec<CloudPoint>,
}

impl RectifiedPair {
    /// The disparities of points between two depths (nearest, farthest), m; by default from a shift of a third of an image to
    /// infinity. Of more than 256 disparities, those of the farthest points.
    pub fn range(&self, depth: Option<(f64, f64)>) -> DisparityRange {
        // parallaxes of the nearest and the farthest point
        let infinity = self.infinity();
        let base = self.left.camera.intrinsics.fx_px * self.baseline();
        let third = f64::from(self.left.camera.width_px.min(self.right.camera.width_px)) / 3.0;
        let third = third * base.signum();
        let (far, near) = depth.map_or((0.0, third), |(near, far)| (base / far, base / near));

        // and one more at each end, which is never a result
        let count = (near - far).abs().ceil().clamp(0.0, MOST_DISPARITIES - 3.0) + 3.0;
        let least = if near > far { far - 1.0 } else { far + 2.0 - count };
        DisparityRange { first: (infinity + least).floor() as i32, count: count as usize }
    }

    /// d∞: the disparity of a point at infinity, px.
    pub fn infinity(&self) -> f64 {
        self.left.camera.intrinsics.cx_px - self.right.camera.intrinsics.cx_px
    }

    /// How far away something with a disparity is, m.
    pub fn depth_m(&self, disparity: f32) -> f64 {
        let parallax = f64::from(disparity) - self.infinity();
        self.left.camera.intrinsics.fx_px * self.baseline() / parallax
    }

    /// How far the second camera stands to the right of the first, m; negative to the left.
    pub fn baseline(&self) -> f64 {
        (self.left.camera.camera_from_world * self.right.camera.centre_world()).x
    }
}

/// Rectifies two views, correlates them, and intersects the lines of sight of every disparity.
///
/// `mask` shows the subject in the first view. `depth` as in [`RectifiedPair::range`], which replaces the options' range.
///
/// # Errors
/// [`DepthError`] for cameras that do not stand side by side, and options outside their range.
pub fn depth_map(
    first: &StereoView,
    second: &StereoView,
    mask: Option<&Mask>,
    depth: Option<(f64, f64)>,
    options: &CorrelationOptions,
) -> Result<DepthMap, DepthError> {
    // 1. disparities of the rectified pair
    let pair = rectify(first, second)?;
    let options = CorrelationOptions { range: pair.range(depth), ..*options };
    let (left, right) = (bytes(&pair.left.image), bytes(&pair.right.image));
    let mut disparities = correlate(&left, &right, &options)?;

    // 2. the point of each, where the image was recorded and shows the subject
    let triangulation = Triangulation::new(&pair);
    let mut points = Vec::new();
    for y in 0..disparities.height() {
        for (x, disparity) in disparities.row_mut(y).iter_mut().enumerate() {
            let is_recorded = pair.left.image.get(x, y).is_some_and(f32::is_finite);
            let point = triangulation.point([x, y], *disparity);
            let point = point.filter(|point| is_recorded && shows(first, mask, point));
            if point.is_none() {
                *disparity = f32::NAN;
            }
            points.extend(point);
        }
    }

    Ok(DepthMap { pair, disparities, points })
}

/// From disparities of one rectified pair to points.
#[derive(Debug, Clone, Copy)]
struct Triangulation {
    world_from_left: Rigid3,
    turn: Matrix3<f64>,
    principal_px: [f64; 2],
    focal_px: f64,
    /// d∞, px.
    infinity: f64,
    /// B, m.
    baseline: f64,
}

impl Triangulation {
    fn new(pair: &RectifiedPair) -> Self {
        let left = &pair.left.camera;
        let world_from_left = left.camera_from_world.inverse();
        Self {
            world_from_left,
            turn: *world_from_left.rotation.to_rotation_matrix().matrix(),
            principal_px: [left.intrinsics.cx_px, left.intrinsics.cy_px],
            focal_px: left.intrinsics.fx_px,
            infinity: pair.infinity(),
            baseline: pair.baseline(),
        }
    }

    /// The point that a pixel (column, row) of the left image shows; `None` without a disparity, and for a point that is
    /// not in front of both cameras.
    fn point(&self, pixel: [usize; 2], disparity: f32) -> Option<CloudPoint> {
        let parallax = f64::from(disparity) - self.infinity;
        let depth = self.focal_px * self.baseline / parallax;
        if !depth.is_finite() || depth <= 0.0 {
            return None;
        }

        let [x, y] = [0, 1].map(|k| pixel[k] as f64 - self.principal_px[k]);
        let across = 1.0 / self.focal_px;
        let ray = Vector3::new(x * across, y * across, 1.0);

        // b, a and c
        let by_right = ray * (depth / parallax);
        let by_left = Vector3::new(depth * across, 0.0, 0.0) - by_right;
        let by_row = Vector3::new(0.0, depth * across, 0.0);

        let square = |v: Vector3<f64>| v * v.transpose();
        let covariance = square(by_left) + square(by_right) + square(by_row) * 0.5;
        let covariance = self.turn * covariance * self.turn.transpose() * SIGMA_PX.powi(2);

        Some(CloudPoint {
            position_world: self.world_from_left * Point3::from(ray * depth),
            spread: Spread::Full(covariance),
        })
    }
}

/// Whether a point is seen within the mask, if there is one.
fn shows(view: &StereoView, mask: Option<&Mask>, point: &CloudPoint) -> bool {
    let Some(pixel) = view.camera.project_undistorted(&point.position_world) else {
        return false;
    };
    let inside = pixel.x > -0.5 && pixel.y > -0.5;
    mask.is_none_or(|m| {
        inside && m.is_foreground(pixel.x.round() as usize, pixel.y.round() as usize)
    })
}

#[cfg(test)]
mod tests {
    use nalgebra::Point2;

    use super::*;
    use crate::camera::{Camera, Distortion, Intrinsics};
    use crate::stereo::{Sighting, intersect, rectify};

    fn view(name: &str, x_m: f64, turn: f64) -> StereoView {
        let turned = Rigid3::rotation(Vector3::new(0.02, turn, 0.01));
        StereoView {
            camera: Camera {
                name: name.into(),
                width_px: 64,
                height_px: 48,
                intrinsics: Intrinsics {
                    fx_px: 60.0,
                    fy_px: 61.0,
                    cx_px: 30.0,
                    cy_px: 25.0,
                    skew_px: 0.0,
                },
                distortion: Distortion::None,
                camera_from_world: turned * Rigid3::translation(-x_m, 0.3, 0.1),
            },
            image: Plane::filled(64, 48, 9.0),
        }
    }

    #[test]
    fn a_point_and_its_covariance_are_those_of_the_intersection() {
        // the second camera to the right of the first, and to the left
        for x_m in [0.2, -0.3] {
            let pair = rectify(&view("a", 0.0, 0.03), &view("b", x_m, -0.05)).unwrap();
            let triangulation = Triangulation::new(&pair);
            let infinity = pair.infinity();
            for (place, parallax) in [([3, 40], 1.5), ([50, 7], 4.0), ([20, 20], 11.25)] {
                let disparity = infinity + parallax * x_m.signum();
                let found = triangulation.point(place, disparity as f32).unwrap();
                let [u, v] = place.map(|k| k as f64);
                let disparity = f64::from(disparity as f32);
                let seen = [(&pair.left, u), (&pair.right, u - disparity)];
                let met = intersect(&seen.map(|(view, u)| Sighting {
                    camera: &view.camera,
                    pixel: Point2::new(u, v),
                    sigma_px: SIGMA_PX,
                }));
                let met = met.unwrap();
                let off = (found.position_world - met.position_world).norm();
                assert!(off < 1e-7, "{off}");
                let Spread::Full(covariance) = found.spread else {
                    panic!("no covariance");
                };
                approx::assert_relative_eq!(
                    covariance,
                    met.covariance,
                    max_relative = 1e-5,
                    epsilon = 1e-12
                );
            }
            assert!(triangulation.point([3, 3], infinity as f32).is_none());
            let behind = infinity - 2.0 * x_m.signum();
            assert!(triangulation.point([3, 3], behind as f32).is_none());
            assert!(triangulation.point([3, 3], f32::NAN).is_none());
        }
    }
}
