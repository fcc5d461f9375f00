//! Lines of sight.

use nalgebra::{Matrix3, Point3, Unit, Vector3};
use serde::{Deserialize, Serialize};

/// Rays whose mean angle has a smaller sine² count as parallel.
const LEAST_SPREAD: f64 = 1e-12;

/// A half-line in the world frame.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Ray {
    /// Where it starts: the camera's centre.
    pub origin_world: Point3<f64>,
    /// Where it goes.
    pub direction_world: Unit<Vector3<f64>>,
}

impl Ray {
    /// The point at distance `t` metres from the origin; negative `t` lies behind it.
    pub fn point_at(&self, t: f64) -> Point3<f64> {
        self.origin_world + self.direction_world.into_inner() * t
    }

    /// Distance along the ray to where it is this high, metres; `None` where it never is.
    pub fn to_height(&self, height_m: f64) -> Option<f64> {
        let along = (height_m - self.origin_world.z) / self.direction_world.z;
        (along.is_finite() && along > 0.0).then_some(along)
    }

    /// Distance along the ray to the foot of the perpendicular from a point.
    fn foot_of(&self, point_world: &Point3<f64>) -> f64 {
        (point_world - self.origin_world).dot(&self.direction_world)
    }

    /// Distance of a point from the whole line.
    pub fn distance_to(&self, point_world: &Point3<f64>) -> f64 {
        (point_world - self.point_at(self.foot_of(point_world))).norm()
    }
}

/// The point nearest to all rays, taken as whole lines: argmin_x Σ ‖(I − ddᵀ)(x − o)‖².
///
/// `None` for fewer than two rays, and for parallel rays.
pub fn closest_point(rays: &[Ray]) -> Option<Point3<f64>> {
    let count = f64::from(u32::try_from(rays.len()).ok().filter(|&n| n >= 2)?);
    // about the mean origin, so that distant worlds lose no digits
    let mean = rays.iter().map(|ray| ray.origin_world.coords / count).sum::<Vector3<f64>>();

    // normal equations Σ (I − ddᵀ)·x = Σ (I − ddᵀ)·o
    let mut normal = Matrix3::zeros();
    let mut right = Vector3::zeros();
    for ray in rays {
        let d = ray.direction_world.as_ref();
        let across = Matrix3::identity() - d * d.transpose();
        normal += across / count;
        right += across * (ray.origin_world.coords - mean) / count;
    }

    (normal.symmetric_eigenvalues().min() > LEAST_SPREAD)
        .then(|| normal.cholesky().map(|n| n.solve(&right)))
        .flatten()
        .map(|x| Point3::from(x + mean))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn ray(origin: [f64; 3], through: [f64; 3]) -> Ray {
        let origin_world = Point3::from(origin);
        Ray {
            origin_world,
            direction_world: Unit::new_normalize(Point3::from(through) - origin_world),
        }
    }

    #[test]
    fn rays_through_one_point_meet_there() {
        let point = [0.3, -1.2, 0.9];
        let rays = [
            ray([4.0, 0.0, 1.0], point),
            ray([0.0, 5.0, 2.0], point),
            ray([-3.0, -2.0, 0.5], point),
        ];
        let met = closest_point(&rays).unwrap();
        approx::assert_relative_eq!(met, Point3::from(point), epsilon = 1e-12);
        assert!(rays.iter().all(|ray| ray.distance_to(&met) < 1e-12));
    }

    #[test]
    fn a_ray_that_goes_down_meets_the_floor_and_no_other_does() {
        let down = ray([1.0, 0.0, 2.0], [1.0, 1.0, 1.0]);
        let met = down.point_at(down.to_height(0.0).unwrap());
        approx::assert_relative_eq!(met, Point3::new(1.0, 2.0, 0.0), epsilon = 1e-12);
        let level = ray([1.0, 0.0, 2.0], [1.0, 1.0, 2.0]);
        let up = ray([1.0, 0.0, 2.0], [1.0, 1.0, 3.0]);
        assert_eq!([level, up].map(|ray| ray.to_height(0.0)), [None, None]);
    }

    #[test]
    fn skew_rays_are_closest_halfway_between_their_feet() {
        let rays = [ray([0.0, 0.0, 1.0], [1.0, 0.0, 1.0]), ray([0.0, 0.0, 2.0], [0.0, 1.0, 2.0])];
        let met = closest_point(&rays).unwrap();
        approx::assert_relative_eq!(met, Point3::new(0.0, 0.0, 1.5), epsilon = 1e-12);
        approx::assert_relative_eq!(rays[0].distance_to(&met), 0.5, epsilon = 1e-12);
    }

    #[test]
    fn parallel_rays_and_a_single_one_have_no_closest_point() {
        let one = ray([0.0, 0.0, 0.0], [0.0, 0.0, 1.0]);
        let other = ray([1.0, 0.0, 0.0], [1.0, 0.0, 1.0]);
        assert_eq!(closest_point(&[one, other]), None);
        assert_eq!(closest_point(&[one]), None);
        assert_eq!(closest_point(&[]), None);
    }

    #[test]
    fn rays_a_hundredth_of_a_degree_apart_still_meet() {
        let point = [0.0, 0.0, 1000.0];
        let rays = [ray([0.0; 3], point), ray([0.17, 0.0, 0.0], point)];
        let met = closest_point(&rays).unwrap();
        approx::assert_relative_eq!(met, Point3::from(point), epsilon = 1e-3);
    }
}
