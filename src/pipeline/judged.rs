//! The last stages of a fit: how well the body covers what was seen, what it is worth, and what a person should know of it.

use super::ambiguity::{outline_warnings, scale_warning};
use super::camera_covariance::CameraCovariances;
use super::diagnosis::{
    CameraFaults, Cause, Diagnosis, MOST_ASTRAY, Swollen, astray_share, lost_frames,
};
use super::estimate::Estimate;
use super::fitted::FittedFrame;
use super::unseen::{self, prior_angles_sd};
use super::warning::warnings;
use super::{EstimateOptions, Fit, Warning};
use crate::body::{BodyModel, Motion, Shape};
use crate::inference::motion_prior::MotionPrior;
use crate::inference::{Evidence, Sequence, ShapeConfidence};

/// What an estimate is judged by.
pub(super) struct Judge<'a> {
    /// The body of Algorithm 1 before the cameras as they are calibrated.
    pub(super) coarse: &'a Evidence<'a>,
    /// The body that was fitted.
    pub(super) body: &'a BodyModel,
    pub(super) sequence: Sequence<'a>,
    pub(super) options: &'a EstimateOptions,
    pub(super) faults: &'a CameraFaults,
    /// What was left out of the recording.
    pub(super) left_out: &'a [Cause],
}

impl Judge<'_> {
    /// An estimate and its frames with what it is worth, without the hypotheses that it came from; `notes` is what is known already.
    pub(super) fn fit(
        &self,
        estimate: Estimate,
        frames: Vec<FittedFrame>,
        confidence: ShapeConfidence,
        mut notes: Vec<Warning>,
    ) -> Fit {
        let Self { coarse, body, sequence, options, faults, left_out } = *self;
        let (model, calibrated) = (coarse.model, coarse.rig);
        let sizes = estimate.shape.first(model.coefficients.len());
        let cameras = estimate.qualities(&frames);

        // what it is worth, and what a person should know of it
        let verdict = Diagnosis {
            evidence: coarse,
            faults,
            left_out,
            observations: sequence.frames,
            fps: sequence.fps,
            shape: &sizes,
            uncertainty: estimate.uncertainty.as_ref().map(|u| &u.shape),
            height_m: options.height_m,
            frames: &frames,
            cameras: &cameras,
        }
        .verdict();
        if verdict.is_usable() {
            notes.extend(
                astray_warning(&frames).into_iter().chain(swollen_warning(body, &estimate.shape)),
            );
        }
        notes.extend(outline_warnings(coarse, sequence.frames, &sizes, &frames));
        notes.extend(scale_warning(model, &sizes, options.height_m));
        notes.extend(warnings(calibrated, sequence.frames, &frames, &cameras, &confidence));
        let motion_prior = estimate.motion_prior.as_ref();
        notes.extend(motion_prior.and_then(|prior| unseen(model, sequence, &frames, prior)));
        notes.retain(|warning| verdict.causes.is_empty() || !warning.is_symptom());

        let fit = Fit {
            verdict,
            lengths_m: body.rest_lengths_m(&estimate.shape),
            uncertainty: estimate.uncertainty.map(|u| u.shape),
            noise: estimate.noise,
            rig: estimate.rig,
            camera_covariances: estimate.covariances,
            shape: estimate.shape,
            model: body.clone(),
            frames,
            hypotheses: Vec::new(),
            winner: 0,
            confidence,
            cameras,
            warnings: notes,
        };
        fit.without_false_certainty()
    }
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
            self.camera_covariances = CameraCovariances::default();
            self.frames.iter_mut().for_each(|frame| frame.uncertainty = None);
            self.cameras.iter_mut().for_each(|camera| camera.found.withhold());
            self.confidence.withhold();
        }
        self
    }
}

/// Says so if limbs lie where the masks show nobody.
fn astray_warning(frames: &[FittedFrame]) -> Option<Warning> {
    let share = astray_share(frames).filter(|share| *share > MOST_ASTRAY)?;
    Some(Warning::Astray { share })
}

/// Says so if a part is as thick as nobody's.
fn swollen_warning(body: &BodyModel, shape: &Shape) -> Option<Warning> {
    let Swollen { part, times } = Swollen::of(body, shape)?;
    Some(Warning::Swollen { part, times })
}

/// What nothing sees of the body, by how much less sure the priors alone would be.
fn unseen(
    model: &BodyModel,
    sequence: Sequence<'_>,
    frames: &[FittedFrame],
    motion_prior: &MotionPrior,
) -> Option<Warning> {
    let motions: Vec<Motion> = frames.iter().map(|f| f.fit.motion.clone()).collect();
    let prior = prior_angles_sd(model, motion_prior, &motions, &sequence.intervals_s())?;
    unseen::warning(model, frames, &prior)
}
