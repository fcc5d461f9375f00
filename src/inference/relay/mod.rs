//! What the winner lost is found again: in the motions of other hypotheses, and from the person's own poses in other frames.
//!
//! A track that loses a limb keeps it lost to its end, and the joint optimum stays in that basin. Two things may have it: another
//! hypothesis, from a keyframe beyond, and the poses of frames that are fitted well, for a person moves as before and the canonical
//! poses are few. Where one of them fits a frame far better, that is followed with the winner's shape s as long as it fits better.
//! Of the two motions of each frame, m⁰ᵢ of the winner and m¹ᵢ found so, the most probable sequence is taken:
//!
//! argmin over c ∈ {0, 1}ⁿ of Σᵢ \[−log p(Zᵢ | mᵢ, s) − log p(mᵢ)\] − Σᵢ log p(mᵢ | mᵢ₋₁), mᵢ = mᵢ^cᵢ,
//!
//! by dynamic programming (A. Viterbi, *Error bounds for convolutional codes and an asymptotically optimum decoding algorithm*,
//! IEEE Trans. Inf. Theory 13, 1967). It is no less probable than the winner's, for that is one of them. Steps are those about the last
//! motion; of tracks at constant velocity nothing is taken.

mod choices;

use std::collections::BTreeMap;

use nalgebra::DVector;
use rayon::prelude::*;

use self::choices::Choices;
use super::frame::FrameFit;
use super::hypothesis::Trial;
use super::keyframe::keyframe_fit;
use super::propagate::{Track, Tracking};
use super::step::MotionModel;
use crate::body::Motion;
use crate::math::stats::median;

/// Another hypothesis is tried in a frame where the winner costs as many times as much. Any value gives a sequence that is no less
/// probable; a smaller one takes longer.
const LOST: f64 = 1.5;
/// A frame is searched anew where it costs as many times as much as usual: before a track counts as lost in it
/// ([`TrackOptions::recovery_ratio`](super::propagate::TrackOptions)).
const UNUSUAL: f64 = 2.0;
/// Poses of other frames from which it is searched; the shipped persons have 14 canonical poses.
const POSES: usize = 12;

/// The winner with what it lost; `None` where nothing is more probable.
pub(super) fn relayed(tracking: &Tracking<'_>, trials: &[Trial], winner: usize) -> Option<Trial> {
    if tracking.options.motion_model != MotionModel::ConstantPosition {
        return None;
    }
    let won = &trials[winner];
    let own: Vec<&FrameFit> = won.frames.iter().map(Option::as_ref).collect::<Option<_>>()?;

    // 1. lost frames, from other hypotheses and from poses of other frames
    let mut others = of_hypotheses(tracking, trials, &own);
    for (i, fit) in of_poses(tracking, &own) {
        let known = others.get(&i).map_or(f64::INFINITY, FrameFit::alone);
        if fit.alone() < known {
            others.insert(i, fit);
        }
    }
    others.retain(|i, fit| fit.alone() < own[*i].alone());
    if others.is_empty() {
        return None;
    }

    // 2. the frames on both sides of them
    follow_on(tracking, &own, &mut others);

    // 3. the most probable sequence
    let choices = Choices { tracking, own, others };
    let frames = choices.with_steps(choices.most_probable(), won.hypothesis.keyframe);
    let relayed = Trial { frames, ..won.clone() };
    (relayed.energy() < won.energy()).then_some(relayed)
}

/// The frames that another hypothesis fits far better, from its motions.
fn of_hypotheses(
    tracking: &Tracking<'_>,
    trials: &[Trial],
    own: &[&FrameFit],
) -> BTreeMap<usize, FrameFit> {
    let better = |i: usize| {
        let fits = trials.iter().filter_map(|trial| trial.frames[i].as_ref());
        let best = fits.min_by(|a, b| a.alone().total_cmp(&b.alone()))?;
        let is_lost = own[i].observations > 0.0 && own[i].alone() > LOST * best.alone();
        is_lost.then(|| (i, refitted(tracking, i, &best.motion)))
    };
    (0..own.len()).into_par_iter().filter_map(better).collect()
}

/// The worst frames, from the poses of other frames where the winner stands.
fn of_poses(tracking: &Tracking<'_>, own: &[&FrameFit]) -> BTreeMap<usize, FrameFit> {
    let seen = own.iter().filter(|fit| fit.observations > 0.0);
    let Some(usual) = median(&mut seen.map(|fit| fit.level()).collect::<Vec<f64>>()) else {
        return BTreeMap::new();
    };
    let poses = usual_poses(own, usual);
    let found = |i: usize| {
        let from = |angles: &&DVector<f64>| {
            let start = Motion { angles: (*angles).clone(), ..own[i].motion.clone() };
            refitted(tracking, i, &start)
        };
        let fits = poses.par_iter().map(from);
        Some((i, fits.min_by(|a, b| a.alone().total_cmp(&b.alone()))?))
    };
    worst(own, UNUSUAL * usual).into_iter().filter_map(found).collect()
}

/// The joint angles of frames whose level is not above the usual one, spread over the recording.
fn usual_poses<'f>(own: &[&'f FrameFit], usual: f64) -> Vec<&'f DVector<f64>> {
    let is_usual = |fit: &&&FrameFit| fit.observations > 0.0 && fit.level() <= usual;
    let usual = own.iter().filter(is_usual).map(|fit| &fit.motion.angles);
    let all: Vec<&DVector<f64>> = usual.collect();
    all.iter().step_by(all.len().div_ceil(POSES).max(1)).copied().collect()
}

/// The frame of highest level in each run of frames whose level is above a limit.
fn worst(own: &[&FrameFit], limit: f64) -> Vec<usize> {
    let level = |i: &usize| own[*i].level();
    let unusual: Vec<usize> = (0..own.len()).filter(|i| level(i) > limit).collect();
    let runs = unusual.chunk_by(|before, after| before + 1 == *after);
    let worst = |run: &[usize]| run.iter().copied().max_by(|a, b| level(a).total_cmp(&level(b)));
    runs.filter_map(worst).collect()
}

/// A frame by itself, from a motion.
fn refitted(tracking: &Tracking<'_>, i: usize, start: &Motion) -> FrameFit {
    let Tracking { evidence, sequence, shape, .. } = *tracking;
    FrameFit { recovered: true, ..keyframe_fit(evidence, sequence, i, shape, start.clone()) }
}

/// Adds the frames on both sides of others, as long as they are fitted better from there than the winner fits them.
fn follow_on(tracking: &Tracking<'_>, own: &[&FrameFit], others: &mut BTreeMap<usize, FrameFit>) {
    let from: Vec<usize> = others.keys().copied().collect();
    for i in from {
        let sides: [Vec<usize>; 2] = [(i + 1..own.len()).rev().collect(), (0..i).collect()];
        for ahead in sides {
            let mut track = Track::new(ahead.clone(), i, &others[&i]);
            for next in ahead.into_iter().rev() {
                if others.contains_key(&next) {
                    break;
                }
                let Some((_, fit)) = track.advance(tracking, 1).pop() else {
                    break;
                };
                if fit.alone() >= own[next].alone() {
                    break;
                }
                others.insert(next, fit);
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::inference::frame::FramePosterior;
    use crate::inference::hypothesis::{Hypothesis, Origin};
    use crate::inference::propagate::tests::walker;
    use crate::inference::propagate::{TrackOptions, solve};
    use crate::inference::start::StartOptions;
    use crate::inference::{Detail, Evidence, Sequence};
    use crate::likelihood::{LikelihoodOptions, Measure};

    const FRAMES: usize = 14;
    /// From this frame on the winner has lost a shank.
    const LOST_FROM: usize = 8;
    /// How far its knee is bent too much, radians.
    const BENT: f64 = 1.5;

    /// A trial of the true shape from its first frame, of some motions.
    fn trial(tracking: &Tracking<'_>, motions: Vec<Option<Motion>>) -> Trial {
        let Tracking { evidence, sequence, shape, .. } = *tracking;
        let Evidence { model, pose_prior, .. } = evidence;
        let fit = |(i, motion): (usize, Option<Motion>)| {
            let terms = evidence.terms(&sequence.frames[i], Detail::Fine);
            let posterior = FramePosterior { model, shape, pose_prior, step: None, terms: &terms };
            Some(solve(&posterior, motion?, 0))
        };
        let hypothesis = Hypothesis {
            origin: Origin::Keyframe(0),
            keyframe: 0,
            shape: shape.clone(),
            motion: motions.iter().flatten().next().unwrap().clone(),
            keyframe_cost: 0.0,
        };
        let mut trial = Trial {
            hypothesis,
            shape_cost: 0.0,
            frames: motions.into_iter().enumerate().map(fit).collect(),
        };
        if let Some(own) = trial.frames.iter().map(Option::as_ref).collect::<Option<Vec<_>>>() {
            let choices = Choices { tracking, own, others: BTreeMap::new() };
            trial.frames = choices.with_steps(choices.most_probable(), 0);
        }
        trial
    }

    #[test]
    fn a_lost_shank_is_found_in_another_hypothesis_and_from_the_poses_of_other_frames() {
        let (walker, frames) = walker(FRAMES, 25.0);
        let options = LikelihoodOptions::default();
        let evidence = Evidence::new(&walker.model, &walker.rig, options, Measure::Metaballs);
        let tracking = Tracking {
            evidence: &evidence,
            sequence: Sequence { frames: &frames, fps: walker.fps },
            shape: &walker.shape,
            options: &TrackOptions::default(),
            start: &StartOptions::default(),
            leader: None,
        };
        let knee = walker.model.joints.iter().position(|j| j.name == "knee_flexion_r").unwrap();
        let lost = |(i, motion): (usize, &Motion)| {
            let mut motion = motion.clone();
            motion.angles[knee] += if i < LOST_FROM { 0.0 } else { BENT };
            Some(motion)
        };
        let winner = trial(&tracking, walker.motions.iter().enumerate().map(lost).collect());
        let beyond = |(i, motion): (usize, &Motion)| (i >= LOST_FROM).then(|| motion.clone());
        let other = trial(&tracking, walker.motions.iter().enumerate().map(beyond).collect());

        for trials in [vec![winner.clone(), other], vec![winner.clone()]] {
            let found = relayed(&tracking, &trials, 0).expect("the shank is lost");
            assert!(
                found.energy() < 0.7 * winner.energy(),
                "{} {}",
                found.energy(),
                winner.energy()
            );
            for (i, (fit, truth)) in found.frames.iter().flatten().zip(&walker.motions).enumerate()
            {
                let off = fit.motion.angles[knee] - truth.angles[knee];
                assert!(off.abs() < 0.15, "frame {i}: {off}");
            }
        }

        let right = trial(&tracking, walker.motions.iter().cloned().map(Some).collect());
        assert!(relayed(&tracking, &[right], 0).is_none(), "nothing is lost");
    }
}
