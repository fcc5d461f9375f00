//! A point of the surface, as the likelihood sees it.

use nalgebra::{Matrix3, Point3};

use crate::stereo::{CloudPoint, Spread};

/// A point measured on the surface.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SurfacePoint {
    /// Where.
    pub position_world: Point3<f64>,
    /// C: covariance of its error, world, m²; 0 where it is not known.
    pub covariance: Matrix3<f64>,
}

impl SurfacePoint {
    /// A point with the same standard deviation in all directions, metres.
    pub fn isotropic(position_world: Point3<f64>, sigma_m: f64) -> Self {
        Self { position_world, covariance: Matrix3::from_diagonal_element(sigma_m * sigma_m) }
    }

    /// Root mean square of its error along a direction, over all directions, metres.
    pub fn mean_sigma_m(&self) -> f64 {
        (self.covariance.trace() / 3.0).sqrt()
    }
}

impl From<&CloudPoint> for SurfacePoint {
    fn from(point: &CloudPoint) -> Self {
        let CloudPoint { position_world, spread } = *point;
        match spread {
            Spread::Unknown => Self::isotropic(position_world, 0.0),
            Spread::Isotropic(sigma_m) => Self::isotropic(position_world, sigma_m),
            Spread::Full(covariance) => Self { position_world, covariance },
        }
    }
}
