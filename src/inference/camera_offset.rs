//! Where and when a camera is, against its calibration and its clock: unknowns of the joint optimum.
//!
//! A camera with the centre o that was touched is turned about it by R and displaced by t: what its calibration has at x̃ is at
//! x = o + t + R(x̃ − o). Of a body whose root is at p, turned by W, it shows what the calibrated camera shows of the same body at
//!
//! p̃ = o + Rᵀq,  W̃ = RᵀW,  q = p − o − t,
//!
//! so no likelihood needs a derivative of its own. A lens whose focal length is e^ζ times the calibrated one shows what is q from the
//! camera's centre as large as the calibrated one what is nearer along the optical axis z by that factor,
//!
//! p̃ = o + SRᵀq,  S = 1 + (e^−ζ − 1) zzᵀ.
//!
//! That holds for the root. A part of the body that is d farther away lies as far behind it before as after, where it should be nearer,
//! too: it is shown by the share ζd/q_z too far out, a centimetre for ζ = .1 at the side of a picture. Where ζ is not small, the optimum
//! is sought again before a camera that has the found focal length, and ζ is what is left.
//!
//! With R ← exp(ω)R, t ← t + δt, ζ ← ζ + δζ, and δp, δr the root's own displacement,
//!
//! δp̃ = SRᵀ(δp − δt + \[q\]ω) − e^−ζ z(zᵀRᵀq) δζ,  δr̃ = δr − Wᵀω.
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
    /// ζ: the logarithm of the focal length over the calibrated one.
    #[serde(default)]
    pub log_zoom: f64,
    /// τ: by how much later than the recording's own moment its picture was taken, seconds.
    pub ahead_s: f64,
}

/// Components of one camera: ω, δt, δζ, δτ.
pub const COMPONENTS: usize = 8;
/// The place of δζ among them.
pub const ZOOM: usize = 6;
/// The place of δτ among them.
pub const AHEAD: usize = 7;

impl CameraOffset {
    /// None.
    pub fn none() -> Self {
        Self {
            turn: UnitQuaternion::identity(),
            displacement_m: Vector3::zeros(),
            log_zoom: 0.0,
            ahead_s: 0.0,
        }
    }

    /// Of a lens alone, by ζ.
    pub fn zoomed(log_zoom: f64) -> Self {
        Self { log_zoom, ..Self::none() }
    }

    /// After the step (ω, δt, δζ, δτ).
    pub(super) fn retract(&self, step: &SVector<f64, COMPONENTS>) -> Self {
        let turn: Vector3<f64> = step.fixed_rows::<3>(0).into();
        Self {
            turn: UnitQuaternion::from_scaled_axis(turn) * self.turn,
            displacement_m: self.displacement_m + step.fixed_rows::<3>(3),
            log_zoom: self.log_zoom + step[ZOOM],
            ahead_s: self.ahead_s + step[AHEAD],
        }
    }

    /// The motion before the calibrated camera that shows what this one shows.
    pub fn seen(&self, camera: &Camera, motion: &Motion) -> Motion {
        let centre_world = camera.centre_world().coords;
        let q = motion.position_world - centre_world - self.displacement_m;
        Motion {
            position_world: centre_world + self.nearer(camera) * (self.turn.inverse() * q),
            world_from_root: self.turn.inverse().to_rotation_matrix() * motion.world_from_root,
            angles: motion.angles.clone(),
        }
    }

    /// S.
    fn nearer(&self, camera: &Camera) -> Matrix3<f64> {
        let axis = camera.optical_axis().direction_world.into_inner();
        Matrix3::identity() + axis * axis.transpose() * (-self.log_zoom).exp_m1()
    }

    /// SRᵀ, and how the root moves with (ω, δt, δζ): rows of p̃ and r̃.
    pub(super) fn slopes(
        &self,
        camera: &Camera,
        motion: &Motion,
    ) -> (Matrix3<f64>, SMatrix<f64, 6, AHEAD>) {
        let turned_back: Matrix3<f64> = self.turn.inverse().to_rotation_matrix().into();
        let back = self.nearer(camera) * turned_back;
        let q = motion.position_world - camera.centre_world().coords - self.displacement_m;
        let axis = camera.optical_axis().direction_world.into_inner();
        let nearer = axis * (axis.dot(&(turned_back * q)) * (-self.log_zoom).exp());
        let mut slopes = SMatrix::<f64, 6, AHEAD>::zeros();
        slopes.fixed_view_mut::<3, 3>(0, 0).copy_from(&(back * q.cross_matrix()));
        slopes.fixed_view_mut::<3, 3>(0, 3).copy_from(&-back);
        slopes.fixed_view_mut::<3, 1>(0, ZOOM).copy_from(&-nearer);
        let turned = -motion.world_from_root.matrix().transpose();
        slopes.fixed_view_mut::<3, 3>(3, 0).copy_from(&turned);
        (back, slopes)
    }

    /// The cameras where they are, with the focal lengths that they have.
    pub fn applied(rig: &Rig, offsets: impl IntoIterator<Item = Self>) -> Rig {
        let moved = |(camera, offset): (&Camera, Self)| {
            let centre = camera.centre_world().coords;
            let place = centre + offset.displacement_m - offset.turn * centre;
            let moved = Rigid3::from_parts(place.into(), offset.turn);
            let camera_from_world = camera.camera_from_world * moved.inverse();
            Camera { camera_from_world, ..camera.zoomed(offset.log_zoom.exp()) }
        };
        Rig { cameras: rig.cameras.iter().zip(offsets).map(moved).collect() }
    }
}
