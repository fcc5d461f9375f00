//! Where and when a camera is, against its calibration and its clock: unknowns of the joint optimum.
//!
//! A camera with the centre o that was touched is turned about it by R and displaced by t: what its calibration has at x̃ is at
//! x = o + t + R(x̃ − o). Of a body whose root is at p, turned by W, it shows what the calibrated camera shows of the same body at
//!
//! p̃ = o + Rᵀq,  W̃ = RᵀW,  q = p − o − t,
//!
//! so no likelihood needs a derivative of its own. With R ← exp(ω)R, t ← t + δt, and δp, δr the root's own displacement,
//!
//! δp̃ = Rᵀ(δp − δt + \[q\]ω),  δr̃ = δr − Wᵀω.
//!
//! Its picture i is τ ahead: it shows the body of the time tᵢ + τ ([`Instant`](super::instant::Instant)).

use nalgebra::{Matrix3, SMatrix, SVector, UnitQuaternion, Vector3};
use serde::{Deserialize, Serialize};

use crate::body::Motion;
use crate::camera::{Camera, Rig};
use crate::math::Rigid3;

/// By how much a camera is turned, displaced and ahead.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct CameraOffset {
    /// R, about the camera's centre, in world axes.
    pub turn: UnitQuaternion<f64>,
    /// t, world axes.
    pub displacement_m: Vector3<f64>,
    /// τ: by how much later than the recording's own moment its picture was taken, seconds.
    pub ahead_s: f64,
}

/// Components of one camera: ω, δt, δτ.
pub const COMPONENTS: usize = 7;
/// The place of δτ among them.
pub const AHEAD: usize = 6;

impl CameraOffset {
    /// None.
    pub fn none() -> Self {
        Self { turn: UnitQuaternion::identity(), displacement_m: Vector3::zeros(), ahead_s: 0.0 }
    }

    /// After the step (ω, δt, δτ).
    pub(super) fn retract(&self, step: &SVector<f64, COMPONENTS>) -> Self {
        let turn: Vector3<f64> = step.fixed_rows::<3>(0).into();
        Self {
            turn: UnitQuaternion::from_scaled_axis(turn) * self.turn,
            displacement_m: self.displacement_m + step.fixed_rows::<3>(3),
            ahead_s: self.ahead_s + step[AHEAD],
        }
    }

    /// The motion before the calibrated camera that shows what this one shows.
    pub fn seen(&self, centre_world: &Vector3<f64>, motion: &Motion) -> Motion {
        let back = self.turn.inverse();
        let q = motion.position_world - centre_world - self.displacement_m;
        Motion {
            position_world: centre_world + back * q,
            world_from_root: back.to_rotation_matrix() * motion.world_from_root,
            angles: motion.angles.clone(),
        }
    }

    /// Rᵀ, and how root and time move with (ω, δt): rows of p̃ and r̃.
    pub(super) fn slopes(
        &self,
        centre_world: &Vector3<f64>,
        motion: &Motion,
    ) -> (Matrix3<f64>, SMatrix<f64, 6, 6>) {
        let back: Matrix3<f64> = self.turn.inverse().to_rotation_matrix().into();
        let q = motion.position_world - centre_world - self.displacement_m;
        let mut slopes = SMatrix::<f64, 6, 6>::zeros();
        slopes.fixed_view_mut::<3, 3>(0, 0).copy_from(&(back * q.cross_matrix()));
        slopes.fixed_view_mut::<3, 3>(0, 3).copy_from(&-back);
        let turned = -motion.world_from_root.matrix().transpose();
        slopes.fixed_view_mut::<3, 3>(3, 0).copy_from(&turned);
        (back, slopes)
    }

    /// The cameras where they are.
    pub fn applied(rig: &Rig, offsets: impl IntoIterator<Item = Self>) -> Rig {
        let moved = |(camera, offset): (&Camera, Self)| {
            let centre = camera.centre_world().coords;
            let place = centre + offset.displacement_m - offset.turn * centre;
            let moved = Rigid3::from_parts(place.into(), offset.turn);
            let camera_from_world = camera.camera_from_world * moved.inverse();
            Camera { camera_from_world, ..camera.clone() }
        };
        Rig { cameras: rig.cameras.iter().zip(offsets).map(moved).collect() }
    }
}
