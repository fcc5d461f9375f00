//! The stages, one after the other.

use nalgebra::Point3;
use rayon::prelude::*;

use super::quality::{self, CameraQuality, ViewQuality, mean};
use super::{FitOptions, SceneFault, ShapeConfidence, Warning, check_scene, rest_lengths_m};
use crate::body::{BodyModel, Posed, Shape};
use crate::camera::Rig;
use crate::inference::Evidence;
use crate::inference::propagate::{FrameFit, Sequence};
use crate::inference::search::{Journal, Trial, search};
use crate::silhouette::{FrameIndex, FrameObservations, InvalidOption};

use super::warning::{of_body, warnings};

/// The most probable shape and motion, what else was tried, and how good and how sure they are.
#[derive(Debug, Clone)]
pub struct Fit {
    /// s of the winner.
    pub shape: Shape,
    /// Its lengths at rest, metres, in the order of [`BodyModel::lengths`].
    pub lengths_m: Vec<f64>,
    /// The motion of the winner, frame by frame.
    pub frames: Vec<FittedFrame>,
    /// Every hypothesis: the prior's mean, the keyframes' readings, then the one of many frames together.
    pub hypotheses: Vec<TriedHypothesis>,
    /// Which of them won.
    pub winner: usize,
    /// How far the keyframes agree.
    pub confidence: ShapeConfidence,
    /// How well each camera is covered, in the order of the rig.
    pub cameras: Vec<CameraQuality>,
    /// What a person should know.
    pub warnings: Vec<Warning>,
}

/// One frame of the winner.
#[derive(Debug, Clone)]
pub struct FittedFrame {
    /// Which frame.
    pub frame: FrameIndex,
    /// m and its costs.
    pub fit: FrameFit,
    /// The model's points in the world, in the order of [`BodyModel::points`].
    pub points_world: Vec<Point3<f64>>,
    /// How well each silhouette is covered; empty where no camera saw anything and the motion is a guess.
    pub views: Vec<ViewQuality>,
}

impl FittedFrame {
    /// Mean overlap over the views; `None` without any.
    pub fn mean_iou(&self) -> Option<f64> {
        mean(&self.views.iter().map(|view| view.iou).collect::<Vec<_>>())
    }
}

/// A hypothesis and what became of it.
#[derive(Debug, Clone)]
pub struct TriedHypothesis {
    /// Its shape and its track.
    pub trial: Trial,
    /// The number of its keyframe.
    pub keyframe: FrameIndex,
    /// Frames that were fitted; fewer than there are if it was pruned.
    pub fitted: usize,
    /// Mean overlap over at most ten of them; `None` if nothing was seen there.
    pub iou: Option<f64>,
}

impl TriedHypothesis {
    /// Sums over the fitted frames of −log p(Zᵢ | mᵢ, s), of the limits' and rest's, and of the steps'.
    pub fn parts(&self) -> [f64; 3] {
        let frames = self.trial.frames.iter().flatten();
        frames.fold([0.0; 3], |[data, pose, step], f| {
            [data + f.data, pose + f.pose, step + f.step]
        })
    }
}

/// Why nothing could be fitted.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum FitError {
    /// An option outside its range.
    #[error(transparent)]
    Option(#[from] InvalidOption),
    /// Cameras, masks and body do not speak of one scene.
    #[error(transparent)]
    Scene(#[from] SceneFault),
    /// No hypothesis could be followed through the sequence.
    #[error("no hypothesis could be followed through the {frames} frames")]
    NoHypothesis {
        /// How many frames there are.
        frames: usize,
    },
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
    options: &FitOptions,
    journal: &dyn Journal,
) -> Result<Fit, FitError> {
    options.validate()?;
    let observations = sequence.frames;
    // 1. do cameras and masks agree
    let mut notes = check_scene(model, rig, observations)?;
    // 2. Algorithm 1
    let evidence = Evidence::new(model, rig, options.likelihood);
    let found = search(&evidence, sequence, &options.search, journal);
    let found = found.ok_or(FitError::NoHypothesis {
        frames: observations.len(),
    })?;
    // 3. how far the keyframes agree
    let confidence = ShapeConfidence::of(model, &found.trials, &options.confidence);
    // 4. how well the body covers the masks
    let shape = found.trials[found.winner].hypothesis.shape.clone();
    let frames = fitted_frames(&evidence, observations, &found.trials[found.winner]);
    let views: Vec<&[ViewQuality]> = frames.iter().map(|f| f.views.as_slice()).collect();
    let cameras = quality::of_cameras(rig, &views);
    let shape_cost = found.trials[found.winner].shape_cost;
    let hypotheses = found.trials.into_iter();
    let hypotheses = hypotheses.map(|trial| tried(model, rig, observations, trial));
    let hypotheses = hypotheses.collect();
    // 5. what a person should know of it
    notes.extend(of_body(shape_cost, shape.0.len()));
    notes.extend(warnings(rig, observations, &frames, &cameras, &confidence));
    Ok(Fit {
        lengths_m: rest_lengths_m(model, &shape),
        shape,
        frames,
        hypotheses,
        winner: found.winner,
        confidence,
        cameras,
        warnings: notes,
    })
}

fn fitted_frames(
    evidence: &Evidence<'_>,
    observations: &[FrameObservations],
    winner: &Trial,
) -> Vec<FittedFrame> {
    let shape = &winner.hypothesis.shape;
    let fitted: Vec<_> = observations.iter().zip(&winner.frames).collect();
    fitted
        .par_iter()
        .filter_map(|(observed, fit)| {
            let fit = fit.as_ref()?;
            Some(FittedFrame {
                frame: observed.frame,
                points_world: Posed::new(evidence.model, shape, &fit.motion).points(),
                views: quality::of_frame(evidence, observed, shape, fit),
                fit: fit.clone(),
            })
        })
        .collect()
}

fn tried(
    model: &BodyModel,
    rig: &Rig,
    observations: &[FrameObservations],
    trial: Trial,
) -> TriedHypothesis {
    let shape = &trial.hypothesis.shape;
    TriedHypothesis {
        keyframe: observations[trial.hypothesis.keyframe].frame,
        fitted: trial.frames.iter().flatten().count(),
        iou: quality::sampled_iou((model, rig), observations, shape, &trial.frames),
        trial,
    }
}
