//! One hypothesis along the Markov chain, forwards and backwards from its keyframe (ZS06, Alg. 1, line 4).

use super::frame::{FrameFit, FramePosterior};
use super::start::{StartOptions, readings_by};
use super::step::{MotionModel, StepPrior, extrapolate};
use super::{Detail, Evidence, Sequence};
use crate::body::{Layout, Motion, Shape};
use crate::math::stats::median;
use crate::solver::{Options, Problem, levenberg_marquardt};

/// Settings of the tracking.
#[derive(Debug, Clone, Copy, PartialEq, serde::Serialize, serde::Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct TrackOptions {
    /// Iterations per frame at most: four are enough for a walk at 50 frames a second, and not at 10 or 15.
    pub iterations: usize,
    /// What mᵢ is expected to be.
    pub motion_model: MotionModel,
    /// A frame whose cost per observation exceeds this many times the usual one is searched anew.
    pub recovery_ratio: f64,
}

impl Default for TrackOptions {
    fn default() -> Self {
        Self { iterations: 12, motion_model: MotionModel::ConstantPosition, recovery_ratio: 3.0 }
    }
}

/// What both tracks of a hypothesis share.
#[derive(Debug, Clone, Copy)]
pub(super) struct Tracking<'a> {
    pub(super) evidence: &'a Evidence<'a>,
    pub(super) sequence: Sequence<'a>,
    /// s.
    pub(super) shape: &'a Shape,
    pub(super) options: &'a TrackOptions,
    /// How a lost frame is searched anew.
    pub(super) start: &'a StartOptions,
    /// What the hypothesis that was followed first came to, frame by frame.
    pub(super) leader: Option<&'a [Option<FrameFit>]>,
}

impl Tracking<'_> {
    /// Where a motion gets to as the leader does between two frames; `None` where the leader faces another way.
    ///
    /// Hypotheses of one reading differ by their shape, and move alike: from there a step or two suffice. A leader that is lost leads
    /// nowhere, so what it proposes is compared with the hypothesis' own prediction.
    fn led(&self, (from, motion): &(usize, Motion), to: usize) -> Option<Motion> {
        let leader = self.leader?;
        let (before, after) = (leader[*from].as_ref()?, leader[to].as_ref()?);
        let is_shown = before.observations > 0.0 && after.observations > 0.0;
        let layout = Layout::new(self.evidence.model);
        let way = layout.motion_difference(&before.motion, &after.motion);
        let is_alike = before.motion.forwards_world().dot(&motion.forwards_world()) > ALIKE;
        (is_shown && is_alike).then(|| layout.retract_motion(motion, &way))
    }
}

/// The cosine of the angle within which two bodies face the same way: 30°.
const ALIKE: f64 = 0.866;

/// A track that grows from its keyframe to one end of the sequence.
#[derive(Debug, Clone)]
pub(super) struct Track {
    /// Frames still to be visited, nearest last.
    ahead: Vec<usize>,
    /// The last frame that showed anything.
    last: (usize, Motion),
    /// The one before it, unless nothing was seen in between.
    before: Option<(usize, Motion)>,
    /// Costs per observation of the last frames.
    levels: Vec<f64>,
    /// No frame is searched anew while more frames than this are ahead.
    rest_until: usize,
}

/// Frames whose usual cost is remembered, and frames to wait after a search that did not help.
const MEMORY: usize = 15;
const PATIENCE: usize = 10;
/// Fewer frames do not tell the usual cost: right beside the keyframe no frame counts as lost.
const SETTLED: usize = 5;

impl Track {
    pub(super) fn new(ahead: Vec<usize>, keyframe: usize, fit: &FrameFit) -> Self {
        let last = (keyframe, fit.motion.clone());
        Self { ahead, last, before: None, levels: vec![fit.level()], rest_until: 0 }
    }

    pub(super) fn finished(&self) -> bool {
        self.ahead.is_empty()
    }

    /// Fits the next `count` frames.
    pub(super) fn advance(
        &mut self,
        tracking: &Tracking<'_>,
        count: usize,
    ) -> Vec<(usize, FrameFit)> {
        let mut fits = Vec::new();
        while let Some(index) = (fits.len() < count).then(|| self.ahead.pop()).flatten() {
            let fit = self.fit(tracking, index);

            // nothing is extrapolated across frames that show nothing
            if fit.observations > 0.0 {
                self.levels.push(fit.level());
                let now = (index, fit.motion.clone());
                self.before = Some(std::mem::replace(&mut self.last, now));
            } else {
                self.before = None;
            }

            let forgotten = self.levels.len().saturating_sub(MEMORY);
            self.levels.drain(..forgotten);
            fits.push((index, fit));
        }
        fits
    }

    fn fit(&mut self, tracking: &Tracking<'_>, index: usize) -> FrameFit {
        let Tracking { evidence, sequence, shape, options, start, .. } = *tracking;
        let frame = &sequence.frames[index];
        if !frame.is_observed() {
            return FrameFit::held(&evidence.pose_prior, self.last.1.clone());
        }

        // the step's prior, and where the frame is expected
        let interval_frames = sequence.frames_between(self.last.0, index);
        let step = StepPrior::new(evidence.model, interval_frames / sequence.fps);
        let predicted = self.predict(tracking, interval_frames);
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
        // from the prediction, or from where the leader's motion goes, if that is nearer
        let led = tracking.led(&self.last, index);
        let led = led.filter(|led| posterior.cost(led) < posterior.cost(&predicted));
        let begin = led.unwrap_or_else(|| predicted.clone());
        let fit = solve(&posterior, begin, options.iterations);
        if self.is_plausible(&fit, options.recovery_ratio) {
            return fit;
        }

        // lost: search the frame anew, and take what it shows more probably; the lost pose is no witness
        self.rest_until = self.ahead.len().saturating_sub(PATIENCE);
        let alone = FramePosterior { step: None, ..posterior };
        let anew = readings_by(evidence, frame, &terms, start)
            .into_iter()
            .map(|reading| solve(&alone, reading.state.motion, 30))
            .min_by(|a, b| a.cost().total_cmp(&b.cost()))
            .filter(|anew| anew.cost() < fit.alone())
            .map(|anew| FrameFit { step: step.cost(mean, &anew.motion), ..anew });
        match anew {
            Some(anew) => FrameFit { recovered: true, ..anew },
            None => fit,
        }
    }

    /// Whether a fit costs about what the frames before it did.
    fn is_plausible(&self, fit: &FrameFit, ratio: f64) -> bool {
        let usual = median(&mut self.levels.clone()).unwrap_or(f64::INFINITY);
        self.levels.len() < SETTLED
            || fit.level() <= ratio * usual
            || (self.rest_until > 0 && self.ahead.len() > self.rest_until)
    }

    /// The motion after an interval, at the velocity of the last two frames.
    fn predict(&self, tracking: &Tracking<'_>, interval_frames: f64) -> Motion {
        let (last, motion) = &self.last;
        let Some((index, before)) = &self.before else {
            return motion.clone();
        };
        let past_frames = tracking.sequence.frames_between(*index, *last);
        let layout = Layout::new(tracking.evidence.model);
        extrapolate(layout, before, motion, interval_frames / past_frames)
    }
}

/// Maximises a frame posterior from a motion.
pub(super) fn solve(
    posterior: &FramePosterior<'_>,
    start: Motion,
    max_iterations: usize,
) -> FrameFit {
    let options = Options { max_iterations, damping: 1e-4, relative_decrease: 1e-4 };
    let solution = levenberg_marquardt(posterior, start, &options);
    posterior.frame_fit(solution.state, solution.cost)
}

#[cfg(test)]
pub(super) mod tests {
    use std::path::Path;

    use nalgebra::{Rotation3, Unit, Vector3};

    use super::*;
    use crate::camera::CameraId;
    use crate::io::model;
    use crate::likelihood::{LikelihoodOptions, Measure};
    use crate::silhouette::{FrameIndex, FrameObservations, SilhouetteOptions, extract};
    use crate::synth::{Recipe, Ring, Synthetic};

    /// A walker, and what small pictures show of them.
    pub(in crate::inference) fn walker(
        frames: usize,
        fps: f64,
    ) -> (Synthetic, Vec<FrameObservations>) {
        let person = model::load("walker-metaballs", Path::new("")).unwrap();
        let ring = Ring { width_px: 320, height_px: 240, focal_px: 250.0, ..Ring::default() };
        let recipe = Recipe { frames: Some(frames), fps, ring, ..Recipe::default() };
        let walker = recipe.walker(&person).unwrap();
        let shown = |number: usize| {
            let mut seen = FrameObservations::nothing(FrameIndex(number));
            for (id, camera) in walker.rig.iter() {
                let mask = walker.mask(seen.frame, id).unwrap();
                let silhouette = extract(&mask, camera, &SilhouetteOptions::default());
                seen.views.extend(silhouette.ok().map(|s| -> (CameraId, _) { (id, s) }));
            }
            seen
        };
        let frames = (0..frames).map(shown).collect();
        (walker, frames)
    }

    fn fitted(motion: &Motion) -> Option<FrameFit> {
        let motion = motion.clone();
        let (data, pose, step, observations) = (1.0, 0.0, 0.0, 1.0);
        Some(FrameFit { motion, data, pose, step, observations, recovered: false })
    }

    #[test]
    fn a_hypothesis_begins_where_the_leader_goes_unless_that_is_lost_or_faces_another_way() {
        let (walker, frames) = walker(2, 12.5);
        let options = LikelihoodOptions::default();
        let evidence = Evidence::new(&walker.model, &walker.rig, options, Measure::Metaballs);
        let [first, second] = [0, 1].map(|i| walker.motions[i].clone());
        let (start, track) =
            (StartOptions::default(), TrackOptions { iterations: 1, ..TrackOptions::default() });
        let tracking = |leader| Tracking {
            evidence: &evidence,
            sequence: Sequence { frames: &frames, fps: walker.fps },
            shape: &walker.shape,
            options: &track,
            start: &start,
            leader,
        };

        // as far as the leader goes
        let right = [fitted(&first), fitted(&second)];
        let mut own = first.clone();
        own.angles[0] += 0.05;
        own.position_world.y += 0.02;
        let led = tracking(Some(&right)).led(&(0, own.clone()), 1).expect("it faces the same way");
        let layout = Layout::new(&walker.model);
        let way = layout.motion_difference(&first, &second);
        approx::assert_relative_eq!(layout.motion_difference(&own, &led), way, epsilon = 1e-9);

        // not of one that faces another way
        let about = Unit::new_unchecked(Vector3::z());
        let turn = Rotation3::from_axis_angle(&about, std::f64::consts::PI);
        let away = Motion { world_from_root: turn * own.world_from_root, ..own };
        assert_eq!(tracking(Some(&right)).led(&(0, away), 1), None);

        // one step from there is better than one from where the person was; one that is lost changes nothing
        let after = |leader| {
            let start = fitted(&first).expect("it is one");
            Track::new(vec![1], 0, &start).advance(&tracking(leader), 1).remove(0).1
        };
        let mut lost = second.clone();
        lost.position_world.z += 0.3;
        let lost = [fitted(&first), fitted(&lost)];
        let alone = after(None);
        assert!(after(Some(&right)).cost() < alone.cost());
        assert_eq!(after(Some(&lost)), alone);
    }
}
