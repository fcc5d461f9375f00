//! What moves with the person and is not the body: a bag, a skirt, a long coat.
//!
//! A body that was drawn into such a thing is astray: limbs lie where masks show nobody ([`astray_share`]). Or legs are as thick as nobody's
//! ([`Swollen`]). Then the optimum is sought again, and lines of sight count less where the border lies outside the body
//! (w⁺, see [`RayOptions`](crate::likelihood::RayOptions)): whatever a mask holds besides, it holds the body. It stands if the body
//! leaves the masks no longer, or half as much, and no more is swollen than was. It is not the rule, because the inside of a border is as good as
//! its outside where nothing is worn: limbs are then found half as surely.

use super::EstimateOptions;
use super::diagnosis::{Cause, LEAST_OVERLAP, MOST_ASTRAY, Swollen, astray_share};
use super::estimate::{Estimate, LastStage};
use super::fitted::FittedFrame;
use crate::inference::search::Trial;
use crate::math::stats::mean;

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
    /// `None` if nothing tells of such a thing, if it is no better where something may be worn, and where the masks show something else than
    /// the body: then that is the cause.
    pub(super) fn of(
        stage: &LastStage<'_>,
        winner: &Trial,
        first: &Estimate,
        frames: &[FittedFrame],
    ) -> Option<Self> {
        let has_lines = stage.measures.joint.has_metaballs() && stage.options.joint.is_some();
        let overlap = mean(frames.iter().filter_map(FittedFrame::mean_iou))?;
        let shows_body = overlap > LEAST_OVERLAP && stage.faults.are_of_unknowns();
        let model = stage.evidence.model;
        let (share, swollen) = (astray_share(frames)?, Swollen::of(model, &first.shape));
        let is_drawn = share > MOST_ASTRAY || swollen.is_some();
        if !(has_lines && shows_body && is_drawn) {
            return None;
        }

        let options = for_worn(stage.options);
        let (estimate, frames) = LastStage { options: &options, ..*stage }.covered(winner);
        let left = astray_share(&frames)?;
        let times = |swollen: Option<Swollen>| swollen.map_or(0.0, |swollen| swollen.times);
        let is_better = (left < MOST_ASTRAY || left < 0.5 * share)
            && times(Swollen::of(model, &estimate.shape)) <= times(swollen);
        is_better.then_some(Self { estimate, frames, cause: Cause::Worn { share } })
    }
}
