//! The stages, one after the other.

use super::ambiguity::facing_warning;
use super::camera_covariance::CameraCovariances;
use super::diagnosis::{CameraFaults, Cleared, Seen};
use super::estimate::{Estimate, LastStage};
use super::fitted::{FittedFrame, TriedHypothesis};
use super::joint_stage::zoomed;
use super::judged::Judge;
use super::jumps::{Settled, shown_number};
use super::measures::Measures;
use super::quality::{self, CameraQuality};
use super::strayed::Strayed;
use super::watch::WatchedJournal;
use super::worn::Worn;
use super::{EstimateOptions, FitError, NoProgress, Progress, Verdict, Warning, check_scene};
use crate::body::{BodyModel, Layout, Motion, Shape};
use crate::camera::{CameraId, Rig};
use crate::inference::covariance::ShapeUncertainty;
use crate::inference::noise::Noise;
use crate::inference::search::{Journal, NoJournal, Search, Trial, search};
use crate::inference::{Evidence, Sequence, ShapeConfidence};
use crate::silhouette::FrameObservations;

/// The most probable shape and motion, what else was tried, and how good and how sure they are.
#[derive(Debug, Clone)]
pub struct Fit {
    /// The body; after the joint optimum, with the places of its joints and the offsets of its surface as coefficients.
    pub model: BodyModel,
    /// s.
    pub shape: Shape,
    /// How sure it is; only of the joint optimum.
    pub uncertainty: Option<ShapeUncertainty>,
    /// How the residuals err, as the joint optimum found it.
    pub noise: Option<Noise>,
    /// The cameras, where they were found to look.
    pub rig: Rig,
    /// How sure it is where and when they are, all together.
    pub camera_covariances: CameraCovariances,
    /// Its lengths at rest, metres, in the order of [`BodyModel::lengths`].
    pub lengths_m: Vec<f64>,
    /// The motion, frame by frame.
    pub frames: Vec<FittedFrame>,
    /// Every hypothesis of Algorithm 1: the prior's mean, then the keyframes' readings.
    pub hypotheses: Vec<TriedHypothesis>,
    /// Which of them won.
    pub winner: usize,
    /// How far the keyframes agree.
    pub confidence: ShapeConfidence,
    /// How well each camera is covered, in the order of the rig.
    pub cameras: Vec<CameraQuality>,
    /// Whether it can be used, and what is wrong with the recording.
    pub verdict: Verdict,
    /// What a person should know besides.
    pub warnings: Vec<Warning>,
}

/// Fits a body to the observations of a sequence.
///
/// `journal` is told what is finished, and asked for what an earlier run has finished.
///
/// # Errors
/// [`FitError`] if the options or the observations cannot be used.
pub fn fit(
    model: &BodyModel,
    rig: &Rig,
    sequence: Sequence<'_>,
    options: &EstimateOptions,
    journal: &dyn Journal,
) -> Result<Fit, FitError> {
    fit_watched(model, rig, sequence, options, journal, &NoProgress)
}

/// The same, and `progress` is told how far it is.
///
/// # Errors
/// As [`fit`].
pub fn fit_watched(
    model: &BodyModel,
    rig: &Rig,
    sequence: Sequence<'_>,
    options: &EstimateOptions,
    journal: &dyn Journal,
    progress: &dyn Progress,
) -> Result<Fit, FitError> {
    options.validate()?;
    let frames = sequence.frames.len();
    let keyframes = frames.div_ceil(options.search.keyframe_spacing(frames));
    let watched = WatchedJournal::new(journal, progress, keyframes, frames);
    let fit = stages(model, rig, sequence, options, &watched);
    progress.end();
    fit
}

/// Algorithm 1 and the joint optimum alone, without what tells how good they are.
pub(super) fn estimated(
    model: &BodyModel,
    rig: &Rig,
    sequence: Sequence<'_>,
    options: &EstimateOptions,
    progress: &dyn Progress,
) -> Result<Estimate, FitError> {
    estimated_of_any(model, rig, &[sequence], options, progress).map(|(_, estimate)| estimate)
}

/// The same of the one among several things, each in a sequence of its own, that a body explains best, and which it is.
///
/// A body explains a thing the better, the more probable it makes the observations than they were if they were anywhere
/// ([`Search::evidence`]). One thing alone is taken as it is.
///
/// # Errors
/// That of the first thing, where none can be fitted.
pub(super) fn estimated_of_any(
    model: &BodyModel,
    rig: &Rig,
    things: &[Sequence<'_>],
    options: &EstimateOptions,
    progress: &dyn Progress,
) -> Result<(usize, Estimate), FitError> {
    let found = things.iter().map(|thing| Found::new(model, rig, *thing, options, progress));
    let mut found: Vec<Result<Found<'_>, FitError>> = found.collect();
    let evidence = |i: &usize| found[*i].as_ref().ok().map(|found| found.search.evidence());
    let fitted = (0..found.len()).filter_map(|i| Some((evidence(&i)?, i)));
    match fitted.max_by(|a, b| a.0.total_cmp(&b.0)) {
        Some((_, best)) => Ok((best, found.swap_remove(best)?.estimate(options, progress))),
        None => Err(found.into_iter().find_map(Result::err).unwrap_or(FitError::NoFrames)),
    }
}

/// What Algorithm 1 found of a thing.
struct Found<'a> {
    model: &'a BodyModel,
    rig: &'a Rig,
    sequence: Sequence<'a>,
    measures: Measures,
    faults: CameraFaults,
    search: Search,
}

impl<'a> Found<'a> {
    fn new(
        model: &'a BodyModel,
        rig: &'a Rig,
        sequence: Sequence<'a>,
        options: &EstimateOptions,
        progress: &dyn Progress,
    ) -> Result<Self, FitError> {
        let frames = sequence.frames.len();
        let keyframes = frames.div_ceil(options.search.keyframe_spacing(frames));
        let journal = WatchedJournal::new(&NoJournal, progress, keyframes, frames);
        check_scene(model, rig, sequence.frames)?;

        let measures = measures(model, sequence.frames, options)?;
        let faults = CameraFaults::of(rig, sequence.frames);
        faults.check(rig, sequence.frames)?;
        let shown = rig_as_shown(rig, &faults, options);
        let coarse = Evidence::new(model, &shown, options.likelihood, measures.search);
        let search = searched(&coarse, &faults, sequence, options, &journal)?;
        Ok(Self { model, rig, sequence, measures, faults, search })
    }

    /// The joint optimum from the winner.
    fn estimate(&self, options: &EstimateOptions, progress: &dyn Progress) -> Estimate {
        let Self { sequence, measures, faults, .. } = self;
        let (sequence, measures) = (*sequence, *measures);
        let evidence = &Evidence::new(self.model, self.rig, options.likelihood, measures.search);
        let stage = LastStage { evidence, sequence, measures, options, faults, progress };
        stage.run(&self.search.trials[self.search.winner]).0
    }
}

/// The stages, one after the other.
fn stages(
    model: &BodyModel,
    rig: &Rig,
    sequence: Sequence<'_>,
    options: &EstimateOptions,
    journal: &WatchedJournal<'_>,
) -> Result<Fit, FitError> {
    // 1. do cameras and masks agree
    let mut notes = check_scene(model, rig, sequence.frames)?;
    let cleared = Cleared::new(rig, sequence.frames);
    let sequence = Sequence { frames: &cleared.frames, ..sequence };

    // 2. Algorithm 1, before the cameras that agree
    let measures = measures(model, sequence.frames, options)?;
    let faults = CameraFaults::of(rig, sequence.frames);
    faults.check(rig, sequence.frames)?;
    let shown = rig_as_shown(rig, &faults, options);
    let coarse = Evidence::new(model, &shown, options.likelihood, measures.search);
    let found = searched(&coarse, &faults, sequence, options, journal)?;

    // 3. the joint optimum, from its winner, and where and when the cameras are
    let body = options.joint.map_or_else(|| model.clone(), |_| model.detailed());
    let detailed = Evidence::new(&body, rig, options.likelihood, measures.search);
    let (evidence, progress) = (&detailed, journal.progress);
    let stage = LastStage { evidence, sequence, measures, options, faults: &faults, progress };
    let winner = &found.trials[found.winner];
    let Settled { estimate, measure, frames, faults, causes: jumps } = Settled::new(&stage, winner);
    let sequence = Sequence { frames: &frames, ..sequence };
    let stage = LastStage { sequence, faults: &faults, ..stage };

    // how well the body covers the masks, without cameras that fit nowhere; where it leaves the masks, the person wears or carries something
    let frames = estimate.frames(&body, sequence, options, measure);
    let strayed = Strayed::of(&stage, &estimate, &frames);
    let stage = strayed.as_ref().map_or(stage, |strayed| strayed.stage(&stage));
    let LastStage { sequence, faults, .. } = stage;
    let (estimate, frames) =
        if strayed.is_some() { stage.covered(winner) } else { (estimate, frames) };
    let (estimate, frames, worn) = match Worn::of(&stage, winner, &estimate, &frames) {
        Some(worn) => (worn.estimate, worn.frames, Some(worn.cause)),
        None => (estimate, frames, None),
    };

    // 4. how far the keyframes agree
    journal.progress.begin("checks", 1);
    let reported =
        (estimate.shape.first(model.coefficients.len()), body.rest_lengths_m(&estimate.shape));
    let (trials, epsilons) = (&found.trials, &options.confidence);
    let confidence =
        ShapeConfidence::from_trials(model, trials, &reported.0, &reported.1, epsilons);
    let hypotheses = all_tried(&coarse, sequence.frames, found.trials);
    notes.extend(facing_warning(&coarse, &hypotheses, found.winner, estimate.data_weight()));

    // 5. what it is worth, and what a person should know of it
    let mut left_out = [cleared.causes.clone(), jumps].concat();
    left_out.extend(strayed.as_ref().map(|strayed| strayed.cause.clone()));
    left_out.extend(worn);
    let coarse = coarse.with_rig(rig);
    let judge =
        Judge { coarse: &coarse, body: &body, sequence, options, faults, left_out: &left_out };
    let fit = judge.fit(estimate, frames, confidence, notes);
    journal.progress.step();
    Ok(Fit { hypotheses, winner: found.winner, ..fit })
}

impl Fit {
    /// The motion that each camera shows in each frame of a recording at `fps`, by its own clock; after frames that it has lost, that of
    /// so many frames later.
    pub fn shown(&self, fps: f64) -> impl Fn(usize, CameraId) -> Motion + Sync {
        let motions: Vec<Motion> = self.frames.iter().map(|f| f.fit.motion.clone()).collect();
        let first = self.frames.first().map_or(0, |f| f.frame.0);
        let times_s: Vec<f64> =
            self.frames.iter().map(|f| (f.frame.0 - first) as f64 / fps).collect();
        let layout = Layout::new(&self.model);
        move |i, id| {
            let number = shown_number(&self.rig, self.verdict.jumps(), id, self.frames[i].frame);
            let later = self.frames.partition_point(|frame| frame.frame.0 < number);
            let last = self.frames.len() - 1;
            self.cameras[id.0].found.shown(layout, &motions, &times_s, later.min(last))
        }
    }
}

/// What the observations are compared with.
pub(super) fn measures(
    model: &BodyModel,
    observations: &[FrameObservations],
    options: &EstimateOptions,
) -> Result<Measures, FitError> {
    let has_points = observations.iter().any(|frame| !frame.points.is_empty());
    match has_points && !observations.iter().any(|frame| frame.views.len() >= 2) {
        true => Measures::choose_for_points(model, options.measure),
        false => Measures::choose(model, options.measure),
    }
}

/// The cameras with the lenses that the silhouettes tell, where the joint optimum finds out more.
fn rig_as_shown(rig: &Rig, faults: &CameraFaults, options: &EstimateOptions) -> Rig {
    match options.joint.is_some() && options.free().pose {
        true => zoomed(rig, &faults.log_zooms()),
        false => rig.clone(),
    }
}

/// Algorithm 1. Where the joint optimum finds out where and when the cameras are, those that disagree are left out or moved in time
/// until then.
fn searched(
    evidence: &Evidence<'_>,
    faults: &CameraFaults,
    sequence: Sequence<'_>,
    options: &EstimateOptions,
    journal: &WatchedJournal<'_>,
) -> Result<Search, FitError> {
    let is_joint = options.joint.is_some();
    let agreeing = is_joint.then(|| faults.agreeing(sequence.frames, options.free())).flatten();
    let agreeing = Sequence { frames: agreeing.as_deref().unwrap_or(sequence.frames), ..sequence };
    let found = search(evidence, agreeing, &options.search, journal);
    journal.progress.end();
    found.ok_or_else(|| {
        let (model, rig, observations) = (evidence.model, evidence.rig, sequence.frames);
        let causes = Seen { model, rig, faults, observations }.causes();
        FitError::NoHypothesis { frames: observations.len(), causes }
    })
}

/// What became of each hypothesis.
fn all_tried(
    evidence: &Evidence<'_>,
    observations: &[FrameObservations],
    trials: Vec<Trial>,
) -> Vec<TriedHypothesis> {
    let tried = |trial: Trial| {
        let shape = &trial.hypothesis.shape;
        let iou = quality::sampled_iou(evidence, observations, shape, &trial.frames);
        TriedHypothesis {
            keyframe: observations[trial.hypothesis.keyframe].frame,
            fitted: trial.frames.iter().flatten().count(),
            iou,
            trial,
        }
    };
    trials.into_iter().map(tried).collect()
}
