//! Forward intersection: where lines of sight meet, and how sure that is.

use nalgebra::{Matrix3, Point2, Point3, Vector3};

use crate::camera::{Camera, Ray, closest_point};

/// Steps of the refinement; from the rays' closest point two are enough.
const STEPS: usize = 4;

/// An image point in one camera.
#[derive(Debug, Clone, Copy)]
pub struct Sighting<'a> {
    /// Which camera.
    pub camera: &'a Camera,
    /// Where, undistorted pixels.
    pub pixel: Point2<f64>,
    /// Standard deviation of either coordinate, px.
    pub sigma_px: f64,
}

/// The point that several cameras see.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Intersection {
    /// Where, metres.
    pub position_world: Point3<f64>,
    /// (Σ JᵢᵀJᵢ/σᵢ²)⁻¹, m².
    pub covariance: Matrix3<f64>,
    /// Root mean square distance of its images from the sightings, px.
    pub residual_px: f64,
}

/// The point with the least Σ |π(X) − u|²/σ², by Gauss–Newton from the point closest to the lines of sight.
///
/// `None` for fewer than two sightings, lines of sight that are parallel, and a point that is not in front of every camera.
pub fn intersect(sightings: &[Sighting<'_>]) -> Option<Intersection> {
    let ray = |sighting: &Sighting<'_>| sighting.camera.ray(&sighting.pixel);
    let rays: Vec<Ray> = sightings.iter().map(ray).collect();
    let mut position_world = closest_point(&rays)?;
    for _ in 0..STEPS {
        let (normal, right, _) = normal_equations(sightings, &position_world)?;
        position_world += normal.cholesky()?.solve(&right);
    }
    let (normal, _, squares) = normal_equations(sightings, &position_world)?;
    Some(Intersection {
        position_world,
        covariance: normal.cholesky()?.inverse(),
        residual_px: (squares / sightings.len() as f64).sqrt(),
    })
}

/// Σ JᵀJ/σ², Σ Jᵀ(u − π(X))/σ², and Σ |u − π(X)|².
fn normal_equations(
    sightings: &[Sighting<'_>],
    position_world: &Point3<f64>,
) -> Option<(Matrix3<f64>, Vector3<f64>, f64)> {
    let mut sums = (Matrix3::zeros(), Vector3::zeros(), 0.0);
    for sighting in sightings {
        let camera = sighting.camera;
        let (pixel, jacobian) = camera.project_undistorted_with_jacobian(position_world)?;
        let off = sighting.pixel - pixel;
        let weight = sighting.sigma_px.powi(-2);
        sums.0 += jacobian.transpose() * jacobian * weight;
        sums.1 += jacobian.transpose() * off * weight;
        sums.2 += off.norm_squared();
    }
    Some(sums)
}
