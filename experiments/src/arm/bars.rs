//! Two bars: straight, they do not show where the joint is.
//!
//! The observed arm is no pair of ellipses but two round bars of nearly constant thickness, hinged in the
//! x–z plane like the model `arm-2d`: shoulder at the origin, the upper bar along x, the lower one turned
//! by φ from x towards z, 2 m from end to end. Cameras stand far away, before the plane.

use maquette::camera::{Camera, CameraId, Distortion, Intrinsics, Rig};
use maquette::image::Mask;
use maquette::math::Rigid3;
use maquette::silhouette::{FrameIndex, FrameObservations, SilhouetteOptions, extract};
use maquette::synth::SegmentationErrors;
use nalgebra::{Matrix3, Point2, Point3, Rotation3, Translation3, UnitQuaternion, Vector3};
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;

/// Length from end to end, metres: that of the model.
const LENGTH: f64 = 2.0;

/// An arm of two round bars.
#[derive(Debug, Clone, Copy, PartialEq, serde::Serialize)]
pub struct BarArm {
    /// The upper bar's share of the length: the model's a.
    pub a: f64,
    /// Radius at the shoulder, the elbow and the tip, metres.
    pub radii: [f64; 3],
}

/// A ball that is swept along a segment while its radius changes linearly.
#[derive(Debug, Clone, Copy)]
struct Bar {
    from: Point3<f64>,
    along: Vector3<f64>,
    radius: f64,
    widening: f64,
}

impl Bar {
    /// Whether a ray (a whole line) meets the bar: min_t ‖across(p(t))‖ − r(t) ≤ 0, convex in t.
    fn is_hit(&self, origin: &Point3<f64>, direction: &Vector3<f64>) -> bool {
        let across = |v: Vector3<f64>| v - direction * direction.dot(&v);
        let (u, w) = (across(self.along), across(self.from - origin));
        // ‖w + t·u‖ = √(A(t + B/A)² + D)
        let (a, b) = (u.norm_squared(), u.dot(&w));
        let t = if a > 1e-18 {
            let rest = (w.norm_squared() - b * b / a).max(0.0);
            let k = self.widening;
            let slide =
                if a > k * k { k * (rest / (a * (a - k * k))).sqrt() } else { k.signum() * 1e9 };
            (slide - b / a).clamp(0.0, 1.0)
        } else {
            0.0
        };
        (w + u * t).norm() <= self.radius + self.widening * t
    }
}

impl BarArm {
    fn bars(&self, phi: f64) -> [Bar; 2] {
        let [shoulder, elbow, tip] = self.radii;
        let upper = Vector3::x() * (LENGTH * self.a);
        let lower = Vector3::new(phi.cos(), 0.0, phi.sin()) * (LENGTH * (1.0 - self.a) - tip);
        // the balls at both ends lie within the length
        let from = Point3::new(shoulder, 0.0, 0.0);
        let joint = Point3::from(upper);
        [
            Bar { from, along: joint - from, radius: shoulder, widening: elbow - shoulder },
            Bar { from: joint, along: lower, radius: elbow, widening: tip - elbow },
        ]
    }

    /// What a camera sees of the arm bent by φ.
    pub fn mask(&self, camera: &Camera, phi: f64) -> Mask {
        let bars = self.bars(phi);
        Mask::from_fn(camera.width_px as usize, camera.height_px as usize, |x, y| {
            let ray = camera.ray(&Point2::new(x as f64, y as f64));
            bars.iter().any(|bar| bar.is_hit(&ray.origin_world, &ray.direction_world))
        })
    }
}

/// A camera 40 m away that looks along +y, turned about the vertical through the arm's middle; 140 px/m.
fn camera(name: &str, turn: f64) -> Camera {
    const DISTANCE: f64 = 40.0;
    const PX_PER_M: f64 = 140.0;
    let (width_px, height_px) = (400, 260);
    let middle = Point3::new(0.5 * LENGTH, 0.0, 0.3);
    let world_from_turned = Rotation3::from_axis_angle(&Vector3::z_axis(), turn);
    // rows: the camera's x, y and z axes in the world
    let looking_along_y = Matrix3::new(1.0, 0.0, 0.0, 0.0, 0.0, -1.0, 0.0, 1.0, 0.0);
    let axes = Rotation3::from_matrix_unchecked(looking_along_y) * world_from_turned.inverse();
    let translation = Vector3::z() * DISTANCE - axes * middle.coords;
    Camera {
        name: name.to_owned(),
        width_px,
        height_px,
        intrinsics: Intrinsics {
            fx_px: PX_PER_M * DISTANCE,
            fy_px: PX_PER_M * DISTANCE,
            cx_px: 0.5 * (f64::from(width_px) - 1.0),
            cy_px: 0.5 * (f64::from(height_px) - 1.0),
            skew_px: 0.0,
        },
        distortion: Distortion::None,
        camera_from_world: Rigid3::from_parts(
            Translation3::from(translation),
            UnitQuaternion::from_rotation_matrix(&axes),
        ),
    }
}

/// Two cameras, 10° to the left and to the right of the plane's normal: a search starts from two views.
pub fn rig() -> Rig {
    let turn = 10.0_f64.to_radians();
    Rig { cameras: vec![camera("left", -turn), camera("right", turn)] }
}

/// The arm in a sequence of angles φ, segmented with errors; each mask draws from a stream of its own.
pub fn observe(
    arm: &BarArm,
    angles: &[f64],
    rig: &Rig,
    errors: &SegmentationErrors,
    seed: u64,
) -> Vec<FrameObservations> {
    let frame = |(index, &phi): (usize, &f64)| {
        let mut frame = FrameObservations::nothing(FrameIndex(index));
        for (id, camera) in rig.iter() {
            let mut rng = ChaCha8Rng::seed_from_u64(seed);
            rng.set_stream((index * rig.cameras.len() + id.0) as u64);
            let mask = errors.apply(&arm.mask(camera, phi), &mut rng);
            match extract(&mask, camera, &SilhouetteOptions::default()) {
                Ok(silhouette) => frame.views.push((id, silhouette)),
                Err(reason) => frame.rejected.push((CameraId(id.0), reason)),
            }
        }
        frame
    };
    angles.iter().enumerate().map(frame).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    const ARM: BarArm = BarArm { a: 0.5, radii: [0.1; 3] };

    #[test]
    fn a_straight_arm_is_two_metres_long_and_as_thick_as_its_bars() {
        let camera = camera("front", 0.0);
        let mask = ARM.mask(&camera, 0.0);
        let columns =
            (0..mask.width()).filter(|&x| (0..mask.height()).any(|y| mask.is_foreground(x, y)));
        let rows = (0..mask.height()).filter(|&y| mask.is_foreground(mask.width() / 2, y));
        assert!(columns.count().abs_diff(280) <= 1);
        assert!(rows.count().abs_diff(28) <= 1);
    }

    #[test]
    fn a_straight_arm_hides_its_joint_and_a_bent_one_shows_it() {
        let camera = camera("front", 0.1);
        let other = BarArm { a: 0.3, ..ARM };
        assert_eq!(ARM.mask(&camera, 0.0), other.mask(&camera, 0.0));
        assert_ne!(ARM.mask(&camera, 0.3), other.mask(&camera, 0.3));
    }

    #[test]
    fn a_positive_angle_raises_the_tip() {
        let camera = camera("front", 0.0);
        let mask = ARM.mask(&camera, 0.5);
        let tip = camera.project_undistorted(&Point3::new(
            1.0 + 0.5f64.cos() * 0.8,
            0.0,
            0.5f64.sin() * 0.8,
        ));
        let tip = tip.unwrap();
        assert!(mask.is_foreground(tip.x.round() as usize, tip.y.round() as usize));
    }

    #[test]
    fn a_tapered_bar_is_thinner_where_it_ends() {
        let camera = camera("front", 0.0);
        let mask = BarArm { a: 0.5, radii: [0.12, 0.1, 0.06] }.mask(&camera, 0.0);
        let thickness = |x: usize| (0..mask.height()).filter(|&y| mask.is_foreground(x, y)).count();
        // the left image side is the shoulder's; the middle column the elbow's
        assert!(thickness(90) > thickness(199) && thickness(199) > thickness(310));
    }
}
