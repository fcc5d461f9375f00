//! The stages, one after the other.

use rayon::prelude::*;

use super::ambiguity::{facing_warning, outline_warnings, scale_warning};
use super::camera_covariance::CameraCovariances;
use super::detected::detection_qualities;
use super::diagnosis::{CameraFaults, Diagnosis, Seen, lost_frames};
use super::estimate::{Estimate, LastStage};
use super::fitted::{FittedFrame, TriedHypothesis};
use super::measures::Measures;
use super::points;
use super::quality::{self, CameraQuality};
use super::unseen::{self, prior_angles_sd};
use super::warning::warnings;
use super::watch::WatchedJournal;
use super::{EstimateOptions, FitError, NoProgress, Progress, Verdict, Warning, check_scene};
use crate::body::{BodyModel, Layout, Motion, Posed, Shape};
use crate::camera::{CameraId, Rig};
use crate::inference::chain::ChainPrior;
use crate::inference::covariance::ShapeUncertainty;
use crate::inference::frame::FrameFit;
use crate::inference::instant::times_s;
use crate::inference::joint::JointOptions;
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
    let frames = sequence.frames.len();
    let keyframes = frames.div_ceil(options.search.keyframe_spacing(frames));
    let journal = WatchedJournal::new(&NoJournal, progress, keyframes, frames);
    check_scene(model, rig, sequence.frames)?;

    let measures = measures(model, sequence.frames, options)?;
    let evidence = Evidence::new(model, rig, options.likelihood, measures.search);
    let faults = CameraFaults::of(rig, sequence.frames);
    let found = searched(&evidence, &faults, sequence, options, &journal)?;
    let (estimate, _) =
        LastStage { evidence: &evidence, sequence, measures, options, faults: &faults, progress }
            .run(&found.trials[found.winner]);
    Ok(estimate)
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

    // 2. Algorithm 1, before the cameras that agree
    let measures = measures(model, sequence.frames, options)?;
    let coarse = Evidence::new(model, rig, options.likelihood, measures.search);
    let faults = CameraFaults::of(rig, sequence.frames);
    let found = searched(&coarse, &faults, sequence, options, journal)?;

    // 3. the joint optimum, from its winner, and where and when the cameras are
    let body = options.joint.map_or_else(|| model.clone(), |_| model.detailed());
    let detailed = Evidence::new(&body, rig, options.likelihood, measures.search);
    let (evidence, progress) = (&detailed, journal.progress);
    let stage = LastStage { evidence, sequence, measures, options, faults: &faults, progress };
    let (estimate, measure) = stage.run(&found.trials[found.winner]);
    let looked_at = Evidence::new(&body, &estimate.rig, options.likelihood, measure);

    // 4. how far the keyframes agree
    journal.progress.begin("checks", 1);
    let sizes = estimate.shape.first(model.coefficients.len());
    let lengths_m = body.rest_lengths_m(&estimate.shape);
    let (trials, epsilons) = (&found.trials, &options.confidence);
    let confidence = ShapeConfidence::from_trials(model, trials, &sizes, &lengths_m, epsilons);

    // 5. how well the body covers the masks
    let frames = fitted_frames(&looked_at, sequence, &estimate);
    let cameras = quality::camera_qualities(&estimate.rig, &frames, &estimate.cameras);
    let hypotheses = all_tried(&coarse, sequence.frames, found.trials);

    // 6. what it is worth, and what a person should know of it
    let verdict = Diagnosis {
        evidence: &coarse,
        faults: &faults,
        observations: sequence.frames,
        fps: sequence.fps,
        shape: &sizes,
        uncertainty: estimate.uncertainty.as_ref().map(|u| &u.shape),
        height_m: options.height_m,
        frames: &frames,
        cameras: &cameras,
    }
    .verdict();
    notes.extend(facing_warning(&coarse, &hypotheses, found.winner, estimate.data_weight()));
    notes.extend(outline_warnings(&coarse, sequence.frames, &sizes, &frames));
    notes.extend(scale_warning(model, &sizes, options.height_m));
    notes.extend(warnings(rig, sequence.frames, &frames, &cameras, &confidence));
    notes.extend(options.joint.and_then(|joint| unseen(model, sequence, &frames, &joint)));
    notes.retain(|warning| verdict.causes.is_empty() || !warning.is_symptom());

    journal.progress.step();
    let fit = Fit {
        verdict,
        lengths_m,
        uncertainty: estimate.uncertainty.map(|u| u.shape),
        noise: estimate.noise,
        rig: estimate.rig,
        camera_covariances: estimate.covariances,
        shape: estimate.shape,
        model: body,
        frames,
        hypotheses,
        winner: found.winner,
        confidence,
        cameras,
        warnings: notes,
    };
    Ok(fit.without_false_certainty())
}

impl Fit {
    /// The motion that each camera shows in each frame of a recording at `fps`, by its own clock.
    pub fn shown(&self, fps: f64) -> impl Fn(usize, CameraId) -> Motion + Sync {
        let motions: Vec<Motion> = self.frames.iter().map(|f| f.fit.motion.clone()).collect();
        let first = self.frames.first().map_or(0, |f| f.frame.0);
        let times_s: Vec<f64> =
            self.frames.iter().map(|f| (f.frame.0 - first) as f64 / fps).collect();
        let layout = Layout::new(&self.model);
        move |i, id| self.cameras[id.0].found.shown(layout, &motions, &times_s, i)
    }

    /// Withholds the standard deviations and confidences of a fit that cannot be used, and of frames that are lost: they speak of
    /// an optimum that is not the person.
    fn without_false_certainty(mut self) -> Self {
        for lost in lost_frames(&self.frames) {
            self.frames[lost].uncertainty = None;
        }
        if !self.verdict.is_usable() {
            self.uncertainty = None;
            self.camera_covariances = CameraCovariances::default();
            self.frames.iter_mut().for_each(|frame| frame.uncertainty = None);
            self.cameras.iter_mut().for_each(|camera| camera.found.withhold());
            self.confidence.withhold();
        }
        self
    }
}

/// What the observations are compared with.
fn measures(
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

/// What nothing sees of the body, by how much less sure the priors alone would be.
fn unseen(
    model: &BodyModel,
    sequence: Sequence<'_>,
    frames: &[FittedFrame],
    joint: &JointOptions,
) -> Option<Warning> {
    let motions: Vec<Motion> = frames.iter().map(|f| f.fit.motion.clone()).collect();
    let chain_prior = ChainPrior::new(model, joint.motion_model);
    let prior = prior_angles_sd(model, &chain_prior, &motions, &sequence.intervals_s())?;
    unseen::warning(model, frames, &prior)
}

fn fitted_frames(
    evidence: &Evidence<'_>,
    sequence: Sequence<'_>,
    estimate: &Estimate,
) -> Vec<FittedFrame> {
    let (layout, times_s) = (Layout::new(evidence.model), times_s(&sequence.intervals_s()));
    let motions: Vec<Motion> = estimate.frames.iter().map(|fit| fit.motion.clone()).collect();
    let posed = |motion: &Motion| Posed::new(evidence.model, &estimate.shape, motion);
    let fitted = |(i, (observed, fit)): (usize, (&FrameObservations, &FrameFit))| {
        let body = posed(&fit.motion);
        let shown =
            |id: CameraId| posed(&estimate.cameras[id.0].shown(layout, &motions, &times_s, i));
        let bodies: Vec<Posed<'_>> = observed.views.iter().map(|(id, _)| shown(*id)).collect();
        let detected: Vec<_> = observed.detections.iter().map(|(id, _)| shown(*id)).collect();
        FittedFrame {
            frame: observed.frame,
            points_world: body.points(),
            views: quality::view_qualities(evidence, observed, &bodies),
            points: points::point_quality(evidence, observed, &body),
            detections: detection_qualities(evidence, observed, &detected),
            uncertainty: estimate.uncertainty.as_ref().map(|u| u.frames[i].clone()),
            fit: fit.clone(),
        }
    };

    let frames = sequence.frames.par_iter().zip(&estimate.frames);
    frames.enumerate().map(fitted).collect()
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
