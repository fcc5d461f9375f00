//! The stages, one after the other.

use rayon::prelude::*;

use super::ambiguity::{facing_warning, outline_warnings, scale_warning};
use super::diagnosis::{Diagnosis, lost_frames};
use super::estimate::{Estimate, estimate};
use super::fitted::{FittedFrame, TriedHypothesis};
use super::measures::Measures;
use super::points;
use super::quality::{self, CameraQuality, ViewQuality};
use super::unseen::{self, prior_angles_sd};
use super::warning::warnings;
use super::watch::WatchedJournal;
use super::{EstimateOptions, FitError, NoProgress, Progress, Verdict, Warning, check_scene};
use crate::body::{BodyModel, Motion, Posed, Shape};
use crate::camera::Rig;
use crate::inference::chain::ChainPrior;
use crate::inference::covariance::ShapeUncertainty;
use crate::inference::frame::FrameFit;
use crate::inference::joint::JointOptions;
use crate::inference::noise::Noise;
use crate::inference::search::{Journal, Trial, search};
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

/// The stages, one after the other.
fn stages(
    model: &BodyModel,
    rig: &Rig,
    sequence: Sequence<'_>,
    options: &EstimateOptions,
    journal: &WatchedJournal<'_>,
) -> Result<Fit, FitError> {
    let progress = journal.progress;
    let observations = sequence.frames;

    // 1. do cameras and masks agree
    let mut notes = check_scene(model, rig, observations)?;

    // 2. Algorithm 1
    let measures = match observations.iter().any(|frame| frame.views.len() >= 2) {
        true => Measures::choose(model, options.measure)?,
        false => Measures::choose_for_points(model, options.measure)?,
    };
    let coarse = Evidence::new(model, rig, options.likelihood, measures.search);
    let found = search(&coarse, sequence, &options.search, journal);
    progress.end();
    let found = found.ok_or(FitError::NoHypothesis { frames: observations.len() })?;

    // 3. the joint optimum, from its winner, and where the cameras look
    let winner = &found.trials[found.winner];
    let body = if options.joint.is_some() { model.detailed() } else { model.clone() };
    let detailed = Evidence::new(&body, rig, options.likelihood, measures.search);
    let (estimate, measure) = estimate(&detailed, sequence, winner, measures, options, progress);
    let looked_at = Evidence::new(&body, &estimate.rig, options.likelihood, measure);

    // 4. how far the keyframes agree
    progress.begin("checks", 1);
    let sizes = estimate.shape.first(model.coefficients.len());
    let lengths_m = body.rest_lengths_m(&estimate.shape);
    let (trials, epsilons) = (&found.trials, &options.confidence);
    let confidence = ShapeConfidence::from_trials(model, trials, &sizes, &lengths_m, epsilons);

    // 5. how well the body covers the masks
    let frames = fitted_frames(&looked_at, observations, &estimate);
    let views: Vec<&[ViewQuality]> = frames.iter().map(|f| f.views.as_slice()).collect();
    let cameras = quality::camera_qualities(&estimate.rig, &views, &estimate.aims_px);
    let hypotheses = all_tried(&coarse, observations, found.trials);

    // 6. what it is worth, and what a person should know of it
    let diagnosis = Diagnosis {
        evidence: &coarse,
        observations,
        fps: sequence.fps,
        shape: &sizes,
        uncertainty: estimate.uncertainty.as_ref().map(|u| &u.shape),
        height_m: options.height_m,
        frames: &frames,
        cameras: &cameras,
    };
    let verdict = diagnosis.verdict();
    notes.extend(facing_warning(&coarse, &hypotheses, found.winner, estimate.data_weight()));
    notes.extend(outline_warnings(&coarse, observations, &sizes, &frames));
    notes.extend(scale_warning(model, &sizes, options.height_m));
    notes.extend(warnings(rig, observations, &frames, &cameras, &confidence));
    notes.extend(points::warnings(&frames, observations));
    notes.extend(options.joint.and_then(|joint| unseen(model, sequence, &frames, &joint)));
    notes.retain(|warning| verdict.causes.is_empty() || !warning.is_symptom());

    let fit = Fit {
        verdict,
        lengths_m,
        uncertainty: estimate.uncertainty.map(|u| u.shape),
        noise: estimate.noise,
        rig: estimate.rig,
        shape: estimate.shape,
        model: body,
        frames,
        hypotheses,
        winner: found.winner,
        confidence,
        cameras,
        warnings: notes,
    };
    progress.step();
    Ok(fit.without_false_certainty())
}

impl Fit {
    /// Withholds the standard deviations and confidences of a fit that cannot be used, and of frames that are lost: they speak of
    /// an optimum that is not the person.
    fn without_false_certainty(mut self) -> Self {
        for lost in lost_frames(&self.frames) {
            self.frames[lost].uncertainty = None;
        }
        if !self.verdict.is_usable() {
            self.uncertainty = None;
            self.frames.iter_mut().for_each(|frame| frame.uncertainty = None);
            self.confidence.withhold();
        }
        self
    }
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
    observations: &[FrameObservations],
    estimate: &Estimate,
) -> Vec<FittedFrame> {
    let fitted = |(i, (observed, fit)): (usize, (&FrameObservations, &FrameFit))| {
        let body = Posed::new(evidence.model, &estimate.shape, &fit.motion);
        FittedFrame {
            frame: observed.frame,
            points_world: body.points(),
            views: quality::view_qualities(evidence, observed, &body),
            points: points::point_quality(evidence, observed, &body),
            uncertainty: estimate.uncertainty.as_ref().map(|u| u.frames[i].clone()),
            fit: fit.clone(),
        }
    };

    let frames = observations.par_iter().zip(&estimate.frames);
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
