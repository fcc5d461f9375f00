//! The motion of a model that walks.

use nalgebra::{DVector, Rotation3, Vector2, Vector3};

use super::WalkingStyle;
use super::contact::{Foot, right_load};
use crate::body::{BodyModel, Joint, Motion, Posed, Shape};
use crate::skin::SkinError;

/// A straight walk on z = 0.
#[derive(Debug, Clone, PartialEq)]
pub struct Walk {
    /// How the person walks.
    pub style: WalkingStyle,
    /// Direction of walking, from the world's x axis towards y.
    pub heading: f64,
    /// Middle of the path, metres.
    pub middle_world: Vector2<f64>,
    /// Phase of the first frame in the cycle of the right foot, 0 to 1.
    pub start_phase: f64,
    /// What the person walks on.
    pub ground: Ground,
}

/// What a person walks on.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Ground {
    /// The floor, which stays.
    #[default]
    Floor,
    /// The belt of a treadmill, which is as fast as the person on the mean.
    Treadmill,
}

/// Why a model cannot walk.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum WalkError {
    /// No foot to stand on.
    #[error(
        "model {model}: expected a part with primitives that carries the point {point}, found none"
    )]
    NoFoot {
        /// Model.
        model: String,
        /// The toe's export name.
        point: &'static str,
    },
    /// An impossible frame rate.
    #[error("expected a frame rate above 0 and up to {FASTEST} Hz, found {fps}")]
    Rate {
        /// Found.
        fps: f64,
    },
    /// A body without the skin of its make.
    #[error(transparent)]
    Skin(#[from] SkinError),
}

/// No camera records a person with more frames per second.
const FASTEST: f64 = 1e5;
/// Steps of the integration along the floor between two frames.
const SUBSTEPS: usize = 4;
/// How far angles stay within their limits, radians.
const MARGIN: f64 = 0.01;

impl Walk {
    /// One motion per frame.
    ///
    /// Joint angles and the pelvis' turns are the style's curves. The place of the pelvis follows from the feet: the
    /// loaded point of the standing foot is on the floor and does not move; while both feet stand, each has its
    /// share. So ẋ = −Σ share·ẋ_foot relative to the pelvis, z = −Σ share·z_foot, and speed and step length are
    /// those of the legs. Joints without a curve stay at rest.
    ///
    /// # Errors
    /// [`WalkError`] if the model has no feet or `fps` is impossible.
    pub fn motions(
        &self,
        model: &BodyModel,
        shape: &Shape,
        fps: f64,
        frames: usize,
    ) -> Result<Vec<Motion>, WalkError> {
        checked_rate(fps)?;
        let foot = |point: &'static str| {
            let model_name = || model.name.clone();
            Foot::find(model, shape, point)
                .ok_or_else(|| WalkError::NoFoot { model: model_name(), point })
        };
        let feet = [foot("RBigToe")?, foot("LBigToe")?];

        // from one substep to the next, the pelvis moves against the loaded points
        let advance = self.style.stride_hz / (fps * SUBSTEPS as f64);
        let mut position = Vector3::zeros();
        let mut motions = Vec::new();
        let mut now = self.at_origin(model, self.start_phase);
        for step in 0..frames.saturating_sub(1) * SUBSTEPS + 1 {
            let phase = self.start_phase + step as f64 * advance;
            let next = self.at_origin(model, phase + advance);
            let poses = [&now, &next].map(|motion| Posed::new(model, shape, motion));
            let (height, slip) = stand(&feet, right_load(phase), &poses);
            position.z = height;
            if step % SUBSTEPS == 0 && motions.len() < frames {
                motions.push(Motion { position_world: position, ..now });
            }
            position -= slip;
            now = next;
        }

        if self.ground == Ground::Treadmill {
            carry_back(&mut motions);
        }
        self.centre(&mut motions);
        Ok(motions)
    }

    /// Angles and turns at a phase, the root at the origin.
    fn at_origin(&self, model: &BodyModel, phase: f64) -> Motion {
        let [tilt, obliquity, rotation] = self.style.pelvis.each_ref().map(|c| c.at(phase));
        let about = |axis: Vector3<f64>| Rotation3::from_scaled_axis(axis);
        let world_from_root = about(Vector3::z() * (self.heading + rotation))
            * about(Vector3::x() * -obliquity)
            * about(Vector3::y() * tilt);
        let angle = |joint: &Joint| match self.style.joints.get(&joint.name) {
            Some(curve) => within_limits(joint, curve.at(phase)),
            None => joint.rest,
        };
        Motion {
            position_world: Vector3::zeros(),
            world_from_root,
            angles: DVector::from_iterator(model.joints.len(), model.joints.iter().map(angle)),
        }
    }

    /// Puts the middle between the first and the last position at `middle_world`.
    fn centre(&self, motions: &mut [Motion]) {
        let (Some(first), Some(last)) = (motions.first(), motions.last()) else {
            return;
        };
        let middle = 0.5 * (first.position_world + last.position_world).xy();
        let shift = (self.middle_world - middle).push(0.0);
        for motion in motions {
            motion.position_world += shift;
        }
    }
}

/// # Errors
/// [`WalkError::Rate`] of an impossible frame rate.
pub(super) fn checked_rate(fps: f64) -> Result<(), WalkError> {
    if fps > 0.0 && fps <= FASTEST { Ok(()) } else { Err(WalkError::Rate { fps }) }
}

/// An angle that the joint can have.
pub(super) fn within_limits(joint: &Joint, angle: f64) -> f64 {
    let (low, high) = joint.limits;
    angle.max(low + MARGIN).min(high - MARGIN)
}

/// Moves each motion back by as far as a belt has run that is as fast as all of them on the mean.
fn carry_back(motions: &mut [Motion]) {
    let (Some(first), Some(last)) = (motions.first(), motions.last()) else {
        return;
    };
    let whole = (last.position_world - first.position_world).xy().push(0.0);
    let steps = motions.len().saturating_sub(1).max(1) as f64;
    for (i, motion) in motions.iter_mut().enumerate() {
        motion.position_world -= whole * (i as f64 / steps);
    }
}

/// The root's height over the floor now, and how far the loaded points move until next, both seen from the root.
fn stand(feet: &[Foot; 2], right: f64, [now, next]: &[Posed<'_>; 2]) -> (f64, Vector3<f64>) {
    let mut height = 0.0;
    let mut slip = Vector3::zeros();
    for (foot, share) in feet.iter().zip([right, 1.0 - right]) {
        let contact = foot.contact(now);
        let from = foot.loaded_point(now, &contact);
        let to = foot.loaded_point(next, &contact);
        height -= share * from.z;
        slip += share * Vector3::new(to.x - from.x, to.y - from.y, 0.0);
    }
    (height, slip)
}
