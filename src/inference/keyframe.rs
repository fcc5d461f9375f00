//! The shape hypotheses: from each keyframe (ZS06, Alg. 1, line 3), from the prior (line 2).

use super::frame::{FrameFit, FramePosterior};
use super::hull::locates_body;
use super::hypothesis::{Hypothesis, Origin};
use super::propagate::solve;
use super::start::{StartOptions, readings};
use super::{Detail, Evidence, Sequence};
use crate::body::{Motion, Shape};

/// The keyframes K: every `every`-th frame that two cameras see or that has points enough, or the first such frame.
pub(super) fn keyframes(sequence: Sequence<'_>, every: usize) -> Vec<usize> {
    let usable = |&i: &usize| locates_body(&sequence.frames[i]);
    let all = 0..sequence.frames.len();
    let spaced: Vec<usize> = all.clone().step_by(every.max(1)).filter(usable).collect();
    if spaced.is_empty() { all.into_iter().find(usable).into_iter().collect() } else { spaced }
}

/// argmax p(mₖ, s | Zₖ) of one keyframe (eq. 2), one hypothesis for each reading.
pub(super) fn keyframe_hypotheses(
    evidence: &Evidence<'_>,
    sequence: Sequence<'_>,
    keyframe: usize,
    options: &StartOptions,
) -> Vec<Hypothesis> {
    let readings = readings(evidence, &sequence.frames[keyframe], options);
    let numbered = readings.into_iter().enumerate();
    let hypotheses = numbered.map(|(number, reading)| Hypothesis {
        origin: Origin::Keyframe(number),
        keyframe,
        shape: reading.state.shape,
        motion: reading.state.motion,
        keyframe_cost: reading.cost,
    });
    hypotheses.collect()
}

/// The mean of p(s), in the pose of another hypothesis.
pub(super) fn mean_hypothesis(
    evidence: &Evidence<'_>,
    sequence: Sequence<'_>,
    from: &Hypothesis,
) -> Hypothesis {
    let shape = evidence.shape_prior.mean();
    let keyframe = from.keyframe;
    let fit = keyframe_fit(evidence, sequence, keyframe, &shape, from.motion.clone());
    Hypothesis {
        origin: Origin::Prior,
        keyframe,
        keyframe_cost: fit.cost() + evidence.shape_prior.cost(&shape),
        motion: fit.motion,
        shape,
    }
}

/// The keyframe itself in eq. 1: no motion precedes it, so its step is uniform.
pub(super) fn keyframe_fit(
    evidence: &Evidence<'_>,
    sequence: Sequence<'_>,
    keyframe: usize,
    shape: &Shape,
    motion: Motion,
) -> FrameFit {
    let terms = evidence.terms(&sequence.frames[keyframe], Detail::Fine);
    let pose_prior = &evidence.pose_prior;
    let posterior =
        FramePosterior { model: evidence.model, shape, pose_prior, step: None, terms: &terms };
    solve(&posterior, motion, 30)
}
