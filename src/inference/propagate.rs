//! One hypothesis along the Markov chain, forwards and backwards from its keyframe (ZS06, Alg. 1, line 4).

use super::Evidence;
use super::frame::{FrameFit, FramePosterior};
use super::start::{Detail, StartOptions, readings};
use super::step::{MotionModel, StepPrior, extrapolate};
use crate::body::{Layout, Motion, Shape};
use crate::math::stats::median;
use crate::silhouette::FrameObservations;
use crate::solver::{Options, levenberg_marquardt};

/// Settings of the tracking.
#[derive(Debug, Clone, Copy, PartialEq, serde::Serialize, serde::Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct TrackOptions {
    /// Iterations per frame; four are enough at gait's frame rates.
    pub iterations: usize,
    /// What mᵢ is expected to be.
    pub motion_model: MotionModel,
    /// A frame whose cost per observation exceeds this many times the usual one is searched anew.
    pub recovery_ratio: f64,
}

impl Default for TrackOptions {
    fn default() -> Self {
        Self {
            iterations: 4,
            motion_model: MotionModel::ConstantPosition,
            recovery_ratio: 3.0,
        }
    }
}

/// Frames of a recording with their time base.
#[derive(Debug, Clone, Copy)]
pub struct Sequence<'a> {
    /// Observations, ascending by frame.
    pub frames: &'a [FrameObservations],
    /// Frames per second.
    pub fps: f64,
}

/// A track that grows from its keyframe to one end of the sequence.
#[derive(Debug, Clone)]
pub(super) struct Track {
    /// Frames still to be visited, nearest last.
    ahead: Vec<usize>,
    last: (usize, Motion),
    before: Option<(usize, Motion)>,
    levels: Vec<f64>,
    rest_until: usize,
}

/// Frames whose usual cost is remembered, and frames to wait after a search that did not help.
const MEMORY: usize = 15;
const PATIENCE: usize = 10;
/// Frames from which the usual cost is known: right beside the keyframe nothing is called lost.
const SETTLED: usize = 5;

impl Track {
    pub(super) fn new(ahead: Vec<usize>, keyframe: usize, fit: &FrameFit) -> Self {
        let last = (keyframe, fit.motion.clone());
        Self {
            ahead,
            last,
            before: None,
            levels: vec![fit.level()],
            rest_until: 0,
        }
    }

    pub(super) fn finished(&self) -> bool {
        self.ahead.is_empty()
    }

    /// Fits the next `count` frames with a given shape.
    pub(super) fn advance(
        &mut self,
        evidence: &Evidence<'_>,
        sequence: Sequence<'_>,
        shape: &Shape,
        (options, start): (&TrackOptions, &StartOptions),
        count: usize,
    ) -> Vec<(usize, FrameFit)> {
        let mut fits = Vec::new();
        while let Some(index) = (fits.len() < count).then(|| self.ahead.pop()).flatten() {
            let fit = self.fit(evidence, sequence, shape, (options, start), index);
            if fit.observations > 0.0 {
                self.levels.push(fit.level());
            }
            self.levels
                .drain(..self.levels.len().saturating_sub(MEMORY));
            self.before = Some(std::mem::replace(
                &mut self.last,
                (index, fit.motion.clone()),
            ));
            fits.push((index, fit));
        }
        fits
    }

    fn fit(
        &mut self,
        evidence: &Evidence<'_>,
        sequence: Sequence<'_>,
        shape: &Shape,
        (options, start): (&TrackOptions, &StartOptions),
        index: usize,
    ) -> FrameFit {
        let frame = &sequence.frames[index];
        // the interval to the frame before, the step's prior, and where the frame is expected
        let interval_frames = frame
            .frame
            .0
            .abs_diff(sequence.frames[self.last.0].frame.0)
            .max(1) as f64;
        let step = StepPrior::new(evidence.model, interval_frames / sequence.fps);
        let predicted = self.predicted(evidence, sequence, interval_frames);
        let mean = match options.motion_model {
            MotionModel::ConstantPosition => &self.last.1,
            MotionModel::ConstantVelocity => &predicted,
        };
        let terms = evidence.terms(frame, Detail::Fine);
        let posterior = FramePosterior {
            model: evidence.model,
            shape,
            pose_prior: &evidence.pose_prior,
            step: Some((&step, mean)),
            terms: &terms,
        };
        // the most probable motion from the prediction
        let fit = solve(&posterior, predicted.clone(), options.iterations);
        if self.plausible(&fit, options.recovery_ratio) {
            return fit;
        }
        // lost: search the frame anew, and take what is more probable
        self.rest_until = self.ahead.len().saturating_sub(PATIENCE);
        let anew = readings(evidence, frame, start)
            .into_iter()
            .map(|start| solve(&posterior, start.state.motion, 30))
            .min_by(|a, b| a.cost().total_cmp(&b.cost()))
            .filter(|anew| anew.cost() < fit.cost());
        match anew {
            Some(anew) => FrameFit {
                recovered: true,
                ..anew
            },
            None => fit,
        }
    }

    fn plausible(&self, fit: &FrameFit, ratio: f64) -> bool {
        let usual = median(&mut self.levels.clone()).unwrap_or(f64::INFINITY);
        self.levels.len() < SETTLED
            || fit.level() <= ratio * usual
            || (self.rest_until > 0 && self.ahead.len() > self.rest_until)
    }

    fn predicted(
        &self,
        evidence: &Evidence<'_>,
        sequence: Sequence<'_>,
        interval_frames: f64,
    ) -> Motion {
        let Some((index, before)) = &self.before else {
            return self.last.1.clone();
        };
        let past = sequence.frames[self.last.0]
            .frame
            .0
            .abs_diff(sequence.frames[*index].frame.0)
            .max(1);
        extrapolate(
            Layout::of(evidence.model),
            before,
            &self.last.1,
            interval_frames / past as f64,
        )
    }
}

/// Maximises a frame posterior and takes its cost apart.
pub(super) fn solve(
    posterior: &FramePosterior<'_>,
    start: Motion,
    max_iterations: usize,
) -> FrameFit {
    let options = Options {
        max_iterations,
        damping: 1e-4,
        relative_decrease: 1e-4,
    };
    let solution = levenberg_marquardt(posterior, start, &options);
    posterior.taken_apart(solution.state, solution.cost)
}
