//! Algorithm 1: the most probable shape and motion of a sequence, from keyframe hypotheses (ZS06, eqs. 1–3).

use rayon::prelude::*;

use super::facing::turned_hypothesis;
use super::frame::FrameFit;
use super::hypothesis::most_probable;
pub use super::hypothesis::{Hypothesis, Origin, Search, Trial};
pub use super::journal::{Journal, NoJournal};
use super::keyframe::{keyframe_fit, keyframe_hypotheses, keyframes, mean_hypothesis};
use super::propagate::{Track, TrackOptions, Tracking};
use super::relay::relayed;
use super::start::StartOptions;
use super::{Evidence, Sequence};
use crate::body::Shape;

/// Settings of the search.
#[derive(Debug, Clone, PartialEq, serde::Serialize, serde::Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct SearchOptions {
    /// Every how many frames a keyframe is taken. `None`: every 20th (ZS06), more often where that would give fewer than
    /// [`ENOUGH_KEYFRAMES`], and less often where it would give more than [`MOST_KEYFRAMES`].
    pub keyframe_every: Option<usize>,
    /// Settings of the search for a start.
    pub start: StartOptions,
    /// Settings of the tracking.
    pub track: TrackOptions,
    /// Whether hypotheses that can no longer win are dropped; the winner is the same.
    pub pruning: Pruning,
}

/// Frames from one keyframe to the next (ZS06, Experiments: "each twentieth frame").
const EVERY: usize = 20;
/// Fewer keyframes leave the choice between readings and the spread σ uncertain: σ has a relative error of 1/√(2(K − 1)), 35 % at five.
pub const ENOUGH_KEYFRAMES: usize = 5;
/// More keyframes tell little more: σ is known to 20 %. Each proposes a body that is carried through all frames, so the search would cost
/// the square of the recording's length.
pub const MOST_KEYFRAMES: usize = 13;
/// Keyframes of a trial of a session at least.
const LEAST_OF_A_TRIAL: usize = 2;

impl SearchOptions {
    /// Frames from one keyframe to the next, in a recording of so many frames.
    pub fn keyframe_spacing(&self, frames: usize) -> usize {
        let enough = frames.saturating_sub(1) / (ENOUGH_KEYFRAMES - 1);
        let few = frames.div_ceil(MOST_KEYFRAMES);
        self.keyframe_every.unwrap_or(EVERY.min(enough).max(few)).max(1)
    }

    /// The same for one of so many trials of one person, of so many frames: the keyframes of all are hypotheses of one shape, so
    /// [`MOST_KEYFRAMES`] are enough for all together. A spacing that was asked for stays.
    #[must_use]
    pub fn of_trial(&self, trials: usize, frames: usize) -> Self {
        let of_each = MOST_KEYFRAMES.div_ceil(trials.max(1)).max(LEAST_OF_A_TRIAL);
        let fewer = (of_each < ENOUGH_KEYFRAMES).then(|| frames.div_ceil(of_each).max(1));
        Self { keyframe_every: self.keyframe_every.or(fewer), ..self.clone() }
    }
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
            keyframe_every: None,
            start: StartOptions::default(),
            track: TrackOptions::default(),
            pruning: Pruning::Exact,
        }
    }
}

/// Hypotheses that are followed at the same time, and frames between two comparisons with the bound.
///
/// These are constants, not the number of threads: what is pruned must not depend on the machine.
const ABREAST: usize = 4;
const STRIDE: usize = 8;

/// Algorithm 1: the most probable shape and motion of a sequence.
///
/// `None` if no keyframe tells where the body is, no hypothesis can be followed to the end, or the journal fails.
///
/// What the journal kept is taken only if it is of this body and these frames.
///
/// # Source
/// ZS06, Algorithm 1. Differs: a keyframe gives one hypothesis for each reading (front, back); tracks run
/// both ways from the keyframe, and those after the first begin in each frame where the first one's motion goes; hypotheses that can
/// no longer win are dropped, exactly; if no keyframe proposes that the person faces the other way, the winner turned around is one more hypothesis; where the winner lost a limb and another hypothesis did
/// not, its motion goes over into the other's (`relay`).
pub fn search(
    evidence: &Evidence<'_>,
    sequence: Sequence<'_>,
    options: &SearchOptions,
    journal: &dyn Journal,
) -> Option<Search> {
    let run = Run { evidence, sequence, options, journal };

    // 1. the keyframes K
    let keyframes = keyframes(sequence, options.keyframe_spacing(sequence.frames.len()));
    // 3. one hypothesis from each keyframe and reading: argmax p(mₖ, s | Zₖ)
    let found: Vec<Hypothesis> = keyframes.par_iter().flat_map_iter(|&k| run.keyframe(k)).collect();
    // 2. first hypothesis: the mean of p(s), in the pose of the keyframe that was fitted best
    let by_cost =
        |a: &usize, b: &usize| found[*a].keyframe_cost.total_cmp(&found[*b].keyframe_cost);
    let promising = (0..found.len()).min_by(by_cost)?;
    let mut hypotheses = vec![mean_hypothesis(evidence, sequence, &found[promising])];
    hypotheses.extend(found);
    // 4. propagate every hypothesis along the chain: argmax p(mᵢ | mᵢ₋₁, s, Zᵢ)
    let mut trials = run.follow_all(&hypotheses, promising + 1);
    if journal.is_failing() {
        return None;
    }
    // 5. the most probable sequence posterior (eq. 1)
    let mut winner = most_probable(&trials)?;
    // 6. which way the person faces is compared in any case
    if let Some(turned) = turned_hypothesis(evidence, sequence, &trials, winner) {
        journal.hypotheses(1);
        let before = Followed { bound: run.bound(&trials[winner]), leader: None };
        trials.push(run.follow(trials.len(), &turned, before));
        winner = most_probable(&trials)?;
    }
    // 7. what the winner lost, another hypothesis may have
    let tracking = run.tracking(&trials[winner].hypothesis.shape, None);
    if let Some(relayed) = relayed(&tracking, &trials, winner) {
        trials[winner] = relayed;
    }
    (!journal.is_failing()).then_some(Search { trials, winner })
}

/// One search: what its steps share.
struct Run<'a> {
    evidence: &'a Evidence<'a>,
    sequence: Sequence<'a>,
    options: &'a SearchOptions,
    journal: &'a dyn Journal,
}

/// What hypotheses that were followed before have come to.
#[derive(Clone, Copy)]
struct Followed<'t> {
    /// The energy above which no other can win.
    bound: f64,
    /// The frames of the first.
    leader: Option<&'t [Option<FrameFit>]>,
}

impl Run<'_> {
    fn keyframe(&self, keyframe: usize) -> Vec<Hypothesis> {
        let kept = self.journal.kept_keyframe(keyframe);
        let model = self.evidence.model;
        let is_of = |found: &Hypothesis| found.keyframe == keyframe && found.fits(model);
        kept.filter(|kept| kept.iter().all(is_of)).unwrap_or_else(|| {
            if self.journal.is_failing() {
                return Vec::new();
            }
            let start = &self.options.start;
            let found = keyframe_hypotheses(self.evidence, self.sequence, keyframe, start);
            self.journal.keep_keyframe(keyframe, &found);
            found
        })
    }

    /// The energy above which no other hypothesis can win.
    fn bound(&self, finished: &Trial) -> f64 {
        match self.options.pruning {
            Pruning::Exact => finished.energy(),
            Pruning::Off => f64::INFINITY,
        }
    }

    /// Follows the most promising hypothesis first, so that it bounds the others.
    fn follow_all(&self, hypotheses: &[Hypothesis], promising: usize) -> Vec<Trial> {
        self.journal.hypotheses(hypotheses.len());
        let others: Vec<usize> = (0..hypotheses.len()).filter(|i| *i != promising).collect();
        let mut trials: Vec<Option<Trial>> = vec![None; hypotheses.len()];
        let mut bound = f64::INFINITY;

        for batch in [&[promising][..]].into_iter().chain(others.chunks(ABREAST)) {
            if self.journal.is_failing() {
                return Vec::new();
            }
            let leader = trials[promising].as_ref().map(|leader| leader.frames.as_slice());
            let before = Followed { bound, leader };
            let follow = |&index: &usize| (index, self.follow(index, &hypotheses[index], before));
            let done: Vec<(usize, Trial)> = batch.par_iter().map(follow).collect();

            for (index, trial) in done {
                if trial.finished() {
                    bound = bound.min(self.bound(&trial));
                }
                trials[index] = Some(trial);
            }
        }
        trials.into_iter().flatten().collect()
    }

    fn follow(&self, index: usize, hypothesis: &Hypothesis, before: Followed<'_>) -> Trial {
        let kept = self.journal.kept_trial(index);
        let (model, frames) = (self.evidence.model, self.sequence.frames.len());
        let is_of = |trial: &Trial| trial.hypothesis == *hypothesis && trial.fits(model, frames);
        kept.filter(is_of).unwrap_or_else(|| {
            let trial = self.propagate(index, hypothesis, before);
            // one that was given up is neither finished nor pruned
            if !self.journal.is_failing() {
                self.journal.keep_trial(index, &trial);
            }
            trial
        })
    }

    /// What tracks of a shape share.
    fn tracking<'s>(
        &'s self,
        shape: &'s Shape,
        leader: Option<&'s [Option<FrameFit>]>,
    ) -> Tracking<'s> {
        Tracking {
            evidence: self.evidence,
            sequence: self.sequence,
            shape,
            options: &self.options.track,
            start: &self.options.start,
            leader,
        }
    }

    /// Follows a hypothesis both ways until every frame is fitted or its partial sum exceeds the bound.
    fn propagate(&self, index: usize, hypothesis: &Hypothesis, before: Followed<'_>) -> Trial {
        let Followed { bound, leader } = before;
        let tracking = self.tracking(&hypothesis.shape, leader);
        let (k, n) = (hypothesis.keyframe, self.sequence.frames.len());

        // two tracks from the keyframe
        let fit = keyframe_fit(
            self.evidence,
            self.sequence,
            k,
            &hypothesis.shape,
            hypothesis.motion.clone(),
        );
        let mut forward = Track::new((k + 1..n).rev().collect(), k, &fit);
        let mut backward = Track::new((0..k).collect(), k, &fit);
        let mut trial = Trial {
            hypothesis: hypothesis.clone(),
            shape_cost: self.evidence.shape_prior.cost(&hypothesis.shape),
            frames: vec![None; n],
        };
        trial.frames[k] = Some(fit);

        // every factor costs something: the partial sum only grows
        while trial.energy() <= bound
            && !(forward.finished() && backward.finished())
            && !self.journal.is_failing()
        {
            let (ahead, behind) = rayon::join(
                || forward.advance(&tracking, STRIDE),
                || backward.advance(&tracking, STRIDE),
            );
            self.journal.advanced(index, ahead.len() + behind.len());
            for (i, fit) in ahead.into_iter().chain(behind) {
                trial.frames[i] = Some(fit);
            }
        }
        trial
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_20th_frame_is_a_keyframe_more_where_that_is_fewer_than_five_and_13_at_most() {
        let (default, third) = (
            SearchOptions::default(),
            SearchOptions { keyframe_every: Some(3), ..SearchOptions::default() },
        );
        for frames in 1..1000 {
            let every = default.keyframe_spacing(frames);
            let keyframes = frames.div_ceil(every);
            assert!((frames.min(5)..=13).contains(&keyframes), "{frames}: every {every}");
            assert_eq!(every == 20, (81..=260).contains(&frames), "{frames}");
            assert_eq!(third.keyframe_spacing(frames), 3);
        }
        assert_eq!(20_000_usize.div_ceil(default.keyframe_spacing(20_000)), 13);
    }

    #[test]
    fn trials_of_one_person_have_enough_keyframes_together() {
        let default = SearchOptions::default();
        let keyframes = |trials: usize, frames: usize| {
            frames.div_ceil(default.of_trial(trials, frames).keyframe_spacing(frames))
        };
        assert_eq!([1, 3, 5, 7, 10].map(|trials| keyframes(trials, 60)), [5, 5, 3, 2, 2]);
        // as many as a long recording has, or those of a long trial
        assert_eq!((keyframes(2, 400), keyframes(10, 400)), (13, 2));
        let asked = SearchOptions { keyframe_every: Some(7), ..default.clone() };
        assert_eq!(asked.of_trial(10, 60).keyframe_every, Some(7));
    }
}
