//! The joint optimum, and where the cameras look, by turns.

use nalgebra::Vector2;

use crate::body::BodyModel;
use crate::camera::Rig;
use crate::inference::Evidence;
use crate::inference::aim;
use crate::inference::joint::{Joint, JointOptions, intervals, joint_optimum_of, residuals, terms};
use crate::inference::propagate::Sequence;
use crate::inference::sequence::SequenceState;
use crate::likelihood::{LikelihoodOptions, Measure};

/// A turn that moves no camera's image by this much is the last; a camera that looks elsewhere by less is no news. Pixels.
pub(super) const LEAST_PX: f64 = 1.0;
/// Turns at most.
const TURNS: usize = 6;

/// The joint optimum before cameras that look where they are found to look.
pub(super) struct Aimed {
    pub(super) joint: Joint,
    pub(super) rig: Rig,
    /// By how much each image lies elsewhere than the calibration says, px.
    pub(super) aims_px: Vec<Vector2<f64>>,
}

/// Improves body and aims by turns; without `aim` the cameras look where their calibration says.
pub(super) fn joint_and_aims(
    model: &BodyModel,
    calibrated: &Rig,
    (likelihood, measure): (LikelihoodOptions, Measure),
    sequence: Sequence<'_>,
    start: SequenceState,
    (options, aim): (&JointOptions, bool),
) -> Aimed {
    let mut aims_px = vec![Vector2::zeros(); calibrated.cameras.len()];
    let mut turn = 1;
    loop {
        // the body, before cameras that look there; from the start again, for cameras that look elsewhere bend bodies
        let rig = calibrated.aimed(&aims_px);
        let evidence = Evidence::new(model, &rig, likelihood, measure);
        let terms = terms(&evidence, sequence);
        let joint = joint_optimum_of(
            &evidence,
            &terms,
            &intervals(sequence),
            start.clone(),
            options,
        );
        // where they look, before that body
        let next = match aim && turn < TURNS {
            true => {
                let residuals = residuals(model, &terms, &joint.state());
                aim::aims_px(
                    calibrated,
                    &aims_px,
                    sequence.frames,
                    &residuals,
                    &joint.noise,
                )
            }
            false => aims_px.clone(),
        };
        let moved = next.iter().zip(&aims_px).map(|(a, b)| (a - b).norm());
        if moved.fold(0.0, f64::max) < LEAST_PX {
            return Aimed {
                joint,
                rig,
                aims_px,
            };
        }
        aims_px = next;
        turn += 1;
    }
}
