//! The pixels of a camera in another that stands at the same place.

use nalgebra::{Matrix3, Point2, Vector3};

use super::Camera;

/// H = K₂R₂R₁ᵀK₁⁻¹, the infinite homography: where a second camera sees what the first sees in an undistorted pixel, if both stand at one
/// place or it is infinitely far away.
///
/// # Source
/// Hartley & Zisserman 2004, *Multiple View Geometry in Computer Vision*, 2nd ed., Result 13.6.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct InfiniteHomography(Matrix3<f64>);

impl InfiniteHomography {
    /// From the pixels of one camera to those of another.
    pub fn new(from: &Camera, to: &Camera) -> Self {
        let turn = to.camera_from_world.rotation * from.camera_from_world.rotation.inverse();
        let pixels = to.intrinsics.matrix() * turn.to_rotation_matrix().matrix();
        Self(pixels * from.intrinsics.inverse_matrix())
    }

    /// The undistorted pixel of the second camera; `None` if it does not look there.
    pub fn pixel(&self, from: &Point2<f64>) -> Option<Point2<f64>> {
        let seen = self.0 * Vector3::new(from.x, from.y, 1.0);
        (seen.z > 0.0).then(|| Point2::from(seen.xy() / seen.z))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::camera::{Distortion, Intrinsics};
    use crate::math::Rigid3;

    fn camera(focal_px: f64, turn: Vector3<f64>) -> Camera {
        let intrinsics = Intrinsics {
            fx_px: focal_px,
            fy_px: 1.1 * focal_px,
            cx_px: 310.0,
            cy_px: 245.0,
            skew_px: 0.7,
        };
        Camera {
            name: "any".into(),
            width_px: 640,
            height_px: 480,
            intrinsics,
            distortion: Distortion::None,
            camera_from_world: Rigid3::rotation(turn) * Rigid3::translation(-1.0, 2.0, 0.5),
        }
    }

    #[test]
    fn two_cameras_at_one_place_see_what_lies_on_a_line_of_sight_in_the_same_pixels() {
        let (first, second) =
            (camera(600.0, Vector3::zeros()), camera(450.0, Vector3::new(0.2, -0.3, 0.1)));
        let homography = InfiniteHomography::new(&first, &second);
        for pixel in [[0.0, 0.0], [639.0, 12.5], [300.2, 400.0]].map(Point2::from) {
            let there = second.project_undistorted(&first.ray(&pixel).point_at(2.5)).unwrap();
            approx::assert_relative_eq!(homography.pixel(&pixel).unwrap(), there, epsilon = 1e-9);
        }
    }

    #[test]
    fn what_lies_behind_the_second_camera_is_not_seen() {
        let behind = camera(600.0, Vector3::new(0.0, std::f64::consts::PI, 0.0));
        let homography = InfiniteHomography::new(&camera(600.0, Vector3::zeros()), &behind);
        assert_eq!(homography.pixel(&Point2::new(310.0, 245.0)), None);
    }
}
