//! How far pixels lie from the outline of a body.

use nalgebra::Point2;

use super::ellipse_distance::{EllipseDistance, OutlineEllipse};
use crate::body::Posed;
use crate::camera::Camera;
use crate::math::quadric::project;

/// The outline of a body's ellipsoids, as one camera sees them.
#[derive(Debug, Clone)]
pub struct BodyOutline {
    ellipses: Vec<OutlineEllipse>,
}

impl BodyOutline {
    /// That of a body before a camera; of ellipsoids around or behind it nothing is seen.
    pub fn new(camera: &Camera, body: &Posed<'_>) -> Self {
        let projection = camera.projection();
        let seen = body.ellipsoids();
        let seen = seen.iter().filter_map(|e| project(&projection, e));
        Self { ellipses: seen.map(|e| OutlineEllipse::new(&e)).collect() }
    }

    /// min dᵢ over the ellipses, undistorted px, to first order: 0 on the outline, negative inside; infinite where nothing is seen.
    pub fn distance_px(&self, pixel: &Point2<f64>) -> f64 {
        let mut least = f64::INFINITY;
        for ellipse in &self.ellipses {
            if !ellipse.is_farther_than(least, &pixel.coords) {
                least = least.min(ellipse.distance(&pixel.coords, EllipseDistance::Gradient).0);
            }
        }
        least
    }
}
