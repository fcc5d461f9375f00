//! Which way a person faces: silhouettes say little of it, so the other way is always a hypothesis.

use nalgebra::{Rotation3, Vector3};

use super::hypothesis::{Hypothesis, Origin, Trial};
use super::start::refined;
use super::{Detail, Evidence, Sequence};
use crate::body::{BodyModel, Motion, Root, State};

/// Whether two bodies face to opposite sides, seen from above.
fn faces_away(one: &Motion, other: &Motion) -> bool {
    one.forwards_world().xy().dot(&other.forwards_world().xy()) < 0.0
}

/// Whether one trial faces away from another in the first frame that both have.
pub fn trial_faces_away(one: &Trial, other: &Trial) -> bool {
    let mut both =
        one.frames.iter().zip(&other.frames).filter_map(|(a, b)| Some((a.as_ref()?, b.as_ref()?)));
    both.next().is_some_and(|(a, b)| faces_away(&a.motion, &b.motion))
}

/// A body turned by 180° whose left limbs do what the right ones did: seen from afar its outline is nearly the same.
pub fn turned(model: &BodyModel, motion: &Motion) -> Motion {
    let mut turned = motion.clone();
    turned.world_from_root *= Rotation3::from_axis_angle(&Vector3::z_axis(), std::f64::consts::PI);
    for (right, left) in model.joint_pairs() {
        turned.angles.swap_rows(right, left);
    }
    turned
}

/// The winner's keyframe read the other way; `None` if a trial faces there already, or the body cannot turn.
pub(super) fn turned_hypothesis(
    evidence: &Evidence<'_>,
    sequence: Sequence<'_>,
    trials: &[Trial],
    winner: usize,
) -> Option<Hypothesis> {
    let Evidence { model, .. } = *evidence;
    let won = &trials[winner];
    if model.root == Root::Fixed || trials.iter().any(|trial| trial_faces_away(won, trial)) {
        return None;
    }

    let keyframe = won.hypothesis.keyframe;
    let motion = &won.frames[keyframe].as_ref()?.motion;
    let start = State { motion: turned(model, motion), shape: won.hypothesis.shape.clone() };
    let terms = evidence.terms(&sequence.frames[keyframe], Detail::Fine);
    let reading = refined(evidence, &terms, start);
    let found = Hypothesis {
        origin: Origin::Turned,
        keyframe,
        shape: reading.state.shape,
        motion: reading.state.motion,
        keyframe_cost: reading.cost,
    };
    faces_away(&found.motion, motion).then_some(found)
}
