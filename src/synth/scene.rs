//! Cameras around a volume.

use std::f64::consts::TAU;

use nalgebra::{Matrix3, Point3, Rotation3, Translation3, UnitQuaternion, Vector3};
use rand::{Rng, RngExt};

use crate::camera::{Camera, Distortion, Intrinsics, Rig};
use crate::math::Rigid3;

/// A ring of cameras that look at one point.
#[derive(Debug, Clone, PartialEq)]
pub struct Ring {
    /// How many.
    pub cameras: usize,
    /// Horizontal distance from the point looked at, metres.
    pub radius: f64,
    /// Height of the cameras over the floor z = 0, metres.
    pub height: f64,
    /// The point looked at.
    pub target_world: Point3<f64>,
    /// Focal length.
    pub focal_px: f64,
    /// Width of the images.
    pub width_px: u32,
    /// Height of the images.
    pub height_px: u32,
    /// The lens.
    pub distortion: Distortion,
    /// How irregular [`Ring::irregular`] is: 0 regular; 1 moves each camera by up to ±30 % of the spacing, ±10 % of the
    /// radius, ±40 % of the height, ±8 cm of the point looked at, and rolls it by up to ±3°.
    pub irregularity: f64,
}

impl Default for Ring {
    /// Six cameras of 640 × 480, 4.6 m from the middle of a person and 1.9 m high, that see 2.4 m of path.
    fn default() -> Self {
        Self {
            cameras: 6,
            radius: 4.6,
            height: 1.9,
            target_world: Point3::new(0.0, 0.0, 0.95),
            focal_px: 660.0,
            width_px: 640,
            height_px: 480,
            distortion: Distortion::None,
            irregularity: 1.0,
        }
    }
}

impl Ring {
    /// Evenly spaced; the first camera stands half a spacing from the world's x axis.
    pub fn regular(&self) -> Rig {
        let camera = |k| self.camera(k, self.eye(k, 0.0, 0.0, 0.0), self.target_world, 0.0);
        Rig { cameras: (0..self.cameras).map(camera).collect() }
    }

    /// As a person would set them up: off the even places by [`Ring::irregularity`].
    pub fn irregular(&self, rng: &mut impl Rng) -> Rig {
        let mut draw = || self.irregularity * rng.random_range(-1.0..=1.0);
        let mut camera = |k| {
            let eye = self.eye(k, 0.3 * draw(), 0.1 * draw(), 0.4 * draw());
            let aim = self.target_world + Vector3::new(draw(), draw(), draw()) * 0.08;
            self.camera(k, eye, aim, 3.0_f64.to_radians() * draw())
        };
        Rig { cameras: (0..self.cameras).map(&mut camera).collect() }
    }

    /// Place of camera `k`: off by fractions of the spacing, the radius and the height.
    fn eye(&self, k: usize, spacing: f64, radius: f64, height: f64) -> Point3<f64> {
        let turn = TAU * (k as f64 + 0.5 + spacing) / self.cameras as f64;
        let reach = self.radius * (1.0 + radius);
        let (sin, cos) = turn.sin_cos();
        Point3::new(
            self.target_world.x + reach * cos,
            self.target_world.y + reach * sin,
            self.height * (1.0 + height),
        )
    }

    fn camera(&self, k: usize, eye: Point3<f64>, target: Point3<f64>, roll: f64) -> Camera {
        Camera {
            name: format!("cam_{:02}", k + 1),
            width_px: self.width_px,
            height_px: self.height_px,
            intrinsics: Intrinsics {
                fx_px: self.focal_px,
                fy_px: self.focal_px,
                cx_px: 0.5 * (f64::from(self.width_px) - 1.0),
                cy_px: 0.5 * (f64::from(self.height_px) - 1.0),
                skew_px: 0.0,
            },
            distortion: self.distortion,
            camera_from_world: looking_at(&eye, &target, roll),
        }
    }
}

/// Pose of an upright camera: z towards the target, y down, then rolled about z.
pub(super) fn looking_at(eye: &Point3<f64>, target: &Point3<f64>, roll: f64) -> Rigid3 {
    let unit = |v: Vector3<f64>, otherwise| v.try_normalize(1e-9).unwrap_or(otherwise);
    let forward = unit(target - eye, Vector3::x());
    // a camera that looks straight down has no upright: take the world's x for its right
    let right = unit(forward.cross(&Vector3::z()), Vector3::x());
    let down = forward.cross(&right);
    let world_from_camera =
        Rotation3::from_matrix_unchecked(Matrix3::from_columns(&[right, down, forward]));
    let camera_from_world =
        Rotation3::from_axis_angle(&Vector3::z_axis(), roll) * world_from_camera.inverse();
    let rotation = UnitQuaternion::from_rotation_matrix(&camera_from_world);
    Rigid3::from_parts(Translation3::from(-(rotation * eye.coords)), rotation)
}

#[cfg(test)]
mod tests {
    use nalgebra::Point2;
    use rand::SeedableRng;
    use rand_chacha::ChaCha8Rng;

    use super::*;

    #[test]
    fn every_camera_of_a_regular_ring_sees_the_target_in_its_middle_and_up_above_it() {
        let ring = Ring::default();
        for camera in &ring.regular().cameras {
            let middle = camera.project(&ring.target_world).unwrap();
            approx::assert_relative_eq!(middle, Point2::new(319.5, 239.5), epsilon = 1e-9);
            let above = camera.project(&(ring.target_world + Vector3::z() * 0.5)).unwrap();
            assert!(above.y < middle.y - 50.0 && (above.x - middle.x).abs() < 1e-9);
        }
    }

    #[test]
    fn an_irregular_ring_still_sees_a_walking_person_whole() {
        let ring = Ring::default();
        for seed in 0..50 {
            let rig = ring.irregular(&mut ChaCha8Rng::seed_from_u64(seed));
            for camera in &rig.cameras {
                for x in [-1.2, 1.2] {
                    for z in [0.0, 1.85] {
                        let pixel = camera.project(&Point3::new(x, 0.0, z)).unwrap();
                        assert!(camera.contains(&pixel), "{seed} {} {pixel}", camera.name);
                    }
                }
            }
        }
    }
}
