//! Algorithm 1: the most probable shape and motion of a sequence, from keyframe hypotheses (ZS06).

use rayon::prelude::*;

use super::Evidence;
use super::frame::FramePosterior;
use super::propagate::{FrameFit, Sequence, Track, TrackOptions, solve};
use super::start::{Detail, StartOptions, readings};
use super::together::{Member, refine};
use crate::body::{Motion, Shape};
use crate::likelihood::Term;

/// Settings of the search.
#[derive(Debug, Clone, PartialEq, serde::Serialize, serde::Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct SearchOptions {
    /// Every how many frames a keyframe is taken (ZS06: 20).
    pub keyframe_every: usize,
    /// Settings of the search for a start.
    pub start: StartOptions,
    /// Settings of the tracking.
    pub track: TrackOptions,
    /// Frames that are asked for one shape together after the keyframes were tried; 0 or 1: none (ZS06).
    pub together: usize,
    /// Whether hypotheses that can no longer win are dropped; the winner is the same.
    pub pruning: Pruning,
}

/// Whether hypotheses that can no longer win are dropped.
#[derive(Debug, Clone, Copy, PartialEq, Eq, serde::Serialize, serde::Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Pruning {
    /// Every term of E is ≥ 0: a partial sum above the best total cannot win.
    Exact,
    /// Every hypothesis is followed to the end.
    Off,
}

impl Default for SearchOptions {
    fn default() -> Self {
        Self {
            keyframe_every: 20,
            start: StartOptions::default(),
            track: TrackOptions::default(),
            together: 64,
            pruning: Pruning::Exact,
        }
    }
}

/// Where a shape hypothesis comes from.
#[derive(Debug, Clone, Copy, PartialEq, Eq, serde::Serialize, serde::Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Origin {
    /// The mean of p(s).
    Prior,
    /// argmax p(mₖ, s | Zₖ): the reading of that number, 0 the best.
    Keyframe(usize),
    /// One shape for many frames at once, started from the best of the others.
    Together,
}

/// A shape s*ₖ with the motion of its keyframe.
#[derive(Debug, Clone, PartialEq, serde::Serialize, serde::Deserialize)]
pub struct Hypothesis {
    /// Where it comes from.
    pub origin: Origin,
    /// Position of the keyframe among the frames.
    pub keyframe: usize,
    /// s.
    pub shape: Shape,
    /// mₖ.
    pub motion: Motion,
    /// −log p(mₖ, s | Zₖ) at the keyframe.
    pub keyframe_cost: f64,
}

/// What became of a hypothesis.
#[derive(Debug, Clone, PartialEq, serde::Serialize, serde::Deserialize)]
pub struct Trial {
    /// The hypothesis.
    pub hypothesis: Hypothesis,
    /// −log p(s).
    pub shape_cost: f64,
    /// The frames that were fitted; all of them unless it was pruned.
    pub frames: Vec<Option<FrameFit>>,
}

impl Trial {
    /// E of what was fitted: the sequence posterior's −log (eq. 1), or a lower bound if it was pruned.
    pub fn energy(&self) -> f64 {
        self.shape_cost
            + self
                .frames
                .iter()
                .flatten()
                .map(FrameFit::cost)
                .sum::<f64>()
    }

    /// Every frame was fitted.
    pub fn finished(&self) -> bool {
        self.frames.iter().all(Option::is_some)
    }
}

/// What Algorithm 1 found.
#[derive(Debug, Clone, PartialEq)]
pub struct Search {
    /// All hypotheses in the order of their keyframes, the prior's first.
    pub trials: Vec<Trial>,
    /// Which of them is the most probable.
    pub winner: usize,
}

/// Keeps what is finished and tells how far the search is; the search itself has no memory.
pub trait Journal: Sync {
    /// The hypotheses of a keyframe, if an earlier run kept them.
    fn kept_keyframe(&self, _keyframe: usize) -> Option<Vec<Hypothesis>> {
        None
    }
    /// A keyframe is finished.
    fn keep_keyframe(&self, _keyframe: usize, _hypotheses: &[Hypothesis]) {}
    /// The trial of a hypothesis, if an earlier run kept it.
    fn kept_trial(&self, _index: usize) -> Option<Trial> {
        None
    }
    /// A trial is finished or pruned.
    fn keep_trial(&self, _index: usize, _trial: &Trial) {}
    /// The hypotheses are known: this many will be tried.
    fn hypotheses(&self, _count: usize) {}
    /// Frames of a hypothesis were fitted.
    fn advanced(&self, _index: usize, _frames: usize) {}
}

/// Keeps nothing.
#[derive(Debug, Clone, Copy)]
pub struct NoJournal;
impl Journal for NoJournal {}

/// Hypotheses that are followed at the same time, and frames between two looks at the bound.
///
/// Constants, not the number of threads: what is pruned must not depend on the machine.
const TOGETHER: usize = 4;
const STRIDE: usize = 8;

/// Algorithm 1: the most probable shape and motion of a sequence.
///
/// `None` if no frame shows anything to two cameras.
pub fn search(
    evidence: &Evidence<'_>,
    sequence: Sequence<'_>,
    options: &SearchOptions,
    journal: &dyn Journal,
) -> Option<Search> {
    // 1. the keyframes K
    let keyframes = keyframes(sequence, options.keyframe_every);
    // 3. one hypothesis from each keyframe and reading: argmax p(mₖ, s | Zₖ)
    let found: Vec<Hypothesis> = keyframes
        .par_iter()
        .flat_map_iter(|&k| keyframe_hypotheses(evidence, sequence, k, options, journal))
        .collect();
    // 2. first hypothesis: the mean of p(s), in the pose of the keyframe that was fitted best
    let best = (0..found.len())
        .min_by(|&a, &b| found[a].keyframe_cost.total_cmp(&found[b].keyframe_cost))?;
    let mut hypotheses = vec![mean_hypothesis(evidence, sequence, &found[best])];
    hypotheses.extend(found);
    journal.hypotheses(hypotheses.len());
    // 4. propagate every hypothesis along the chain, the most promising first: it bounds the others
    let follow = |hypotheses: &[Hypothesis], index: usize, bound: f64| {
        let kept = journal.kept_trial(index);
        kept.unwrap_or_else(|| {
            let trial = propagate(
                evidence,
                sequence,
                &hypotheses[index],
                options,
                (index, bound, journal),
            );
            journal.keep_trial(index, &trial);
            trial
        })
    };
    let mut trials: Vec<Option<Trial>> = vec![None; hypotheses.len()];
    let mut bound = f64::INFINITY;
    let order: Vec<usize> = std::iter::once(best + 1)
        .chain((0..hypotheses.len()).filter(|i| *i != best + 1))
        .collect();
    for batch in [&order[..1]].into_iter().chain(order[1..].chunks(TOGETHER)) {
        let done: Vec<(usize, Trial)> = batch
            .par_iter()
            .map(|&index| (index, follow(&hypotheses, index, bound)))
            .collect();
        for (index, trial) in done {
            if trial.finished() && options.pruning == Pruning::Exact {
                bound = bound.min(trial.energy());
            }
            trials[index] = Some(trial);
        }
    }
    let mut trials: Vec<Trial> = trials.into_iter().flatten().collect();
    // beyond the paper: one more hypothesis, the best one's frames asked for a shape together
    if options.together > 1 {
        let hypothesis = together_hypothesis(
            evidence,
            sequence,
            &trials[best_of(&trials)?],
            options.together,
        );
        hypotheses.push(hypothesis);
        trials.push(follow(&hypotheses, trials.len(), bound));
    }
    // 5. the most probable sequence posterior (eq. 1)
    let winner = best_of(&trials)?;
    Some(Search { trials, winner })
}

fn best_of(trials: &[Trial]) -> Option<usize> {
    let finished = (0..trials.len()).filter(|&i| trials[i].finished());
    finished.min_by(|&a, &b| trials[a].energy().total_cmp(&trials[b].energy()))
}

/// The shape that up to `count` evenly spaced frames of a trial agree on.
fn together_hypothesis(
    evidence: &Evidence<'_>,
    sequence: Sequence<'_>,
    trial: &Trial,
    count: usize,
) -> Hypothesis {
    let n = sequence.frames.len();
    let spacing = n.div_ceil(count).max(1);
    let mut members: Vec<Member<'_>> = (0..n)
        .step_by(spacing)
        .filter_map(|i| {
            let motion = trial.frames[i].as_ref()?.motion.clone();
            Some(Member {
                terms: evidence.terms(&sequence.frames[i], Detail::Fine),
                motion,
            })
        })
        .collect();
    let weight = (members.len() as f64).powf(-TEMPER);
    let shape = refine(
        evidence,
        trial.hypothesis.shape.clone(),
        &mut members,
        weight,
    );
    let k = trial.hypothesis.keyframe;
    let motion = trial.frames[k]
        .as_ref()
        .map_or_else(|| trial.hypothesis.motion.clone(), |f| f.motion.clone());
    let fit = keyframe_fit(evidence, sequence, k, &shape, motion, 30);
    Hypothesis {
        origin: Origin::Together,
        keyframe: k,
        keyframe_cost: fit.cost() + evidence.shape_prior.cost(&shape),
        motion: fit.motion,
        shape,
    }
}

/// K frames weigh as much as K^(1 − TEMPER) independent ones.
const TEMPER: f64 = 0.5;

fn keyframes(sequence: Sequence<'_>, every: usize) -> Vec<usize> {
    let usable = |&i: &usize| sequence.frames[i].views.len() >= 2;
    let spaced: Vec<usize> = (0..sequence.frames.len())
        .step_by(every.max(1))
        .filter(usable)
        .collect();
    if spaced.is_empty() {
        (0..sequence.frames.len())
            .find(usable)
            .into_iter()
            .collect()
    } else {
        spaced
    }
}

fn keyframe_hypotheses(
    evidence: &Evidence<'_>,
    sequence: Sequence<'_>,
    keyframe: usize,
    options: &SearchOptions,
    journal: &dyn Journal,
) -> Vec<Hypothesis> {
    journal.kept_keyframe(keyframe).unwrap_or_else(|| {
        let hypotheses: Vec<Hypothesis> =
            readings(evidence, &sequence.frames[keyframe], &options.start)
                .into_iter()
                .enumerate()
                .map(|(reading, start)| Hypothesis {
                    origin: Origin::Keyframe(reading),
                    keyframe,
                    shape: start.state.shape,
                    motion: start.state.motion,
                    keyframe_cost: start.cost,
                })
                .collect();
        journal.keep_keyframe(keyframe, &hypotheses);
        hypotheses
    })
}

fn mean_hypothesis(
    evidence: &Evidence<'_>,
    sequence: Sequence<'_>,
    from: &Hypothesis,
) -> Hypothesis {
    let shape = evidence.shape_prior.mean();
    let fit = keyframe_fit(
        evidence,
        sequence,
        from.keyframe,
        &shape,
        from.motion.clone(),
        30,
    );
    Hypothesis {
        origin: Origin::Prior,
        shape,
        motion: fit.motion.clone(),
        keyframe_cost: fit.cost(),
        ..from.clone()
    }
}

/// The keyframe itself in eq. 1: no motion precedes it, so its step is uniform.
fn keyframe_fit(
    evidence: &Evidence<'_>,
    sequence: Sequence<'_>,
    keyframe: usize,
    shape: &Shape,
    motion: Motion,
    iterations: usize,
) -> FrameFit {
    let silhouettes = evidence.silhouettes(&sequence.frames[keyframe], Detail::Fine);
    let observations = silhouettes.effective_observations();
    let terms: Vec<Box<dyn Term + '_>> = vec![Box::new(silhouettes)];
    let pose_prior = &evidence.pose_prior;
    let posterior = FramePosterior {
        model: evidence.model,
        shape,
        pose_prior,
        step: None,
        terms: &terms,
    };
    solve(&posterior, motion, iterations, observations)
}

/// Follows a hypothesis both ways until every frame is fitted or its partial sum exceeds `bound`.
fn propagate(
    evidence: &Evidence<'_>,
    sequence: Sequence<'_>,
    hypothesis: &Hypothesis,
    options: &SearchOptions,
    (index, bound, journal): (usize, f64, &dyn Journal),
) -> Trial {
    let (shape, k) = (&hypothesis.shape, hypothesis.keyframe);
    let fit = keyframe_fit(evidence, sequence, k, shape, hypothesis.motion.clone(), 10);
    let n = sequence.frames.len();
    let mut forward = Track::new((k + 1..n).rev().collect(), k, &fit);
    let mut backward = Track::new((0..k).collect(), k, &fit);
    let mut trial = Trial {
        hypothesis: hypothesis.clone(),
        shape_cost: evidence.shape_prior.cost(shape),
        frames: vec![None; n],
    };
    trial.frames[k] = Some(fit);
    while trial.energy() <= bound && !(forward.finished() && backward.finished()) {
        let step =
            |track: &mut Track| track.advance(evidence, sequence, shape, &options.track, STRIDE);
        let (ahead, behind) = rayon::join(|| step(&mut forward), || step(&mut backward));
        journal.advanced(index, ahead.len() + behind.len());
        for (i, fit) in ahead.into_iter().chain(behind) {
            trial.frames[i] = Some(fit);
        }
    }
    trial
}
