//! What moves with the person and is not the body: a bag, a skirt, a long coat.
//!
//! A body that was drawn into such a thing is astray: limbs lie where masks show nobody
//! ([`astray_share`]). Then the optimum is sought again, and lines of sight count less where the border lies outside the body
//! (w⁺, see [`RayOptions`](crate::likelihood::RayOptions)): whatever a mask holds besides, it holds the body. It stands if the body
//! leaves the masks no longer, or half as much. What is worn no camera contradicts: where one is at fault, that is the cause. It is not the rule, because the inside of a border is as good as its outside where
//! nothing is worn: limbs are then found half as surely.

use super::EstimateOptions;
use super::diagnosis::{Cause, MOST_ASTRAY, astray_share};
use super::estimate::{Estimate, LastStage};
use super::fitted::FittedFrame;
use crate::inference::search::Trial;

/// w⁺: an error outwards is expected to be twice as large as one inwards.
const OUTWARD: f64 = 0.25;

/// The options of a fit before masks that hold what is worn.
pub(super) fn for_worn(options: &EstimateOptions) -> EstimateOptions {
    let mut options = options.clone();
    options.likelihood.rays.outward = OUTWARD;
    options
}

/// An optimum with its frames, for which something is worn.
pub(super) struct Worn {
    pub(super) estimate: Estimate,
    pub(super) frames: Vec<FittedFrame>,
    pub(super) cause: Cause,
}

impl Worn {
    /// `None` if the body of the frames is not astray, or is as far astray where something may be worn.
    pub(super) fn of(
        stage: &LastStage<'_>,
        winner: &Trial,
        frames: &[FittedFrame],
    ) -> Option<Self> {
        let share = astray_share(frames).filter(|share| *share > MOST_ASTRAY)?;
        let has_lines = stage.measures.joint.has_metaballs() && stage.options.joint.is_some();
        if !has_lines || !stage.faults.all_agree() {
            return None;
        }

        let options = for_worn(stage.options);
        let (estimate, measure) = LastStage { options: &options, ..*stage }.run(winner);
        let LastStage { evidence, sequence, .. } = *stage;
        let frames = estimate.frames(evidence.model, sequence, &options, measure);
        let left = astray_share(&frames).unwrap_or_default();
        let is_better = left < MOST_ASTRAY || left < 0.5 * share;
        is_better.then_some(Self { estimate, frames, cause: Cause::Worn { share } })
    }
}
