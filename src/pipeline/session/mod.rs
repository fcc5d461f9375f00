//! Several trials of one person: one body for all of them, and each trial's own motion.
//!
//! The trials lie end to end in one chain without a link between the last frame of one and the first of the next
//! ([`chain`](crate::inference::chain)); s, where the joints lie in the flesh, how far clothes stand off, and where the cameras are, are
//! the border that all trials share:
//!
//! E(s, c, m) = −log p(s) − log p(c) + Σₖ Eₖ(s, c, mₖ),  Eₖ the data and the motion prior of trial k.
//!
//! It is the joint optimum of a recording and nothing else, in O(all frames). p(s) and p(c) count once, and not once a trial; what is known of motions counts
//! as in two seconds of one trial ([`motion_prior`](crate::inference::motion_prior)). A camera
//! whose calibration is the same in two trials has one pose in both; each trial has its own clocks. How much the data count
//! is estimated from all trials together ([`Noise`](crate::inference::noise::Noise)): what repeats at one place of the body in every trial, a
//! fold or a wrong girth, counts once however many trials there are.
//!
//! The start is what each trial was found to be alone before a part of its border points ([`Rounds::Thinned`]), its motion with the mean shape s̄ = (Σ Λₖ)⁻¹ Σ Λₖ sₖ, Λₖ the inverse covariance of
//! trial k's shape.
//!
//! | file           | holds                                        |
//! |----------------|----------------------------------------------|
//! | `rig.rs`       | which cameras of the trials are the same      |
//! | `agreement.rs` | [`disagreements`]: a trial of somebody else; [`one_body`]: whether two sessions are of one person |

mod agreement;
mod rig;

use std::ops::Range;

use nalgebra::{DMatrix, DVector};

pub use agreement::{Disagreement, OneBody, disagreements, one_body};
pub use rig::OtherCalibration;

use super::camera_covariance::CameraCovariances;
use super::diagnosis::{CameraFaults, Cause, Cleared};
use super::estimate::Estimate;
use super::fit::measures;
use super::joint_stage::{Joined, camera_prior, count_from_calibrated, detected_names, zoomed};
use super::judged::Judge;
use super::jumps::without_jumps;
use super::measures::Measures;
use super::worn::for_worn;
use super::{CameraFound, EstimateOptions, Fit, FitError, Progress, check_scene};
use crate::body::{BodyModel, Motion, Shape};
use crate::camera::Rig;
use crate::inference::camera_offset::CameraOffset;
use crate::inference::camera_prior::{CameraPrior, Free};
use crate::inference::joint::{JointOptimum, JointOptions, Rounds, joint_optimum_from_terms};
use crate::inference::{
    Evidence, Look, Sequence, SequenceState, SequenceTerms, ShapeConfidence, keyframe_shapes,
};
use rig::SharedRig;

/// A trial of a session, and what it was found to be alone.
#[derive(Debug, Clone)]
pub struct SessionTrial<'a> {
    /// Its name, for messages.
    pub name: &'a str,
    /// Its cameras, as they were calibrated.
    pub rig: &'a Rig,
    /// What was seen.
    pub sequence: Sequence<'a>,
    /// As it was fitted alone.
    pub options: &'a EstimateOptions,
    /// What it was found to be.
    pub alone: AloneFit,
}

/// The fit of one trial alone, by its joint optimum.
#[derive(Debug, Clone, PartialEq)]
pub struct AloneFit {
    /// sₖ, with all coefficients of the [detailed](BodyModel::detailed) body.
    pub shape: Shape,
    /// Its covariance; `None` where it is not known.
    pub covariance: Option<DMatrix<f64>>,
    /// The motion, frame by frame.
    pub motions: Vec<Motion>,
    /// The frames that the search lost and found again.
    pub recovered: Vec<bool>,
    /// By how much its cameras were off, in the order of the rig.
    pub cameras: Vec<CameraFound>,
    /// s*ₖ, what each of its keyframes found: the most probable reading.
    pub keyframes: Vec<Shape>,
    /// Where its cameras jump, the largest first.
    pub jumps: Vec<Cause>,
    /// What its masks hold that moves with the person, if there is such.
    pub worn: Option<Cause>,
}

impl From<&Fit> for AloneFit {
    fn from(fit: &Fit) -> Self {
        let hypotheses = fit.hypotheses.iter().map(|tried| &tried.trial.hypothesis);
        Self {
            shape: fit.shape.clone(),
            covariance: fit.uncertainty.as_ref().map(|u| u.covariance.clone()),
            motions: fit.frames.iter().map(|frame| frame.fit.motion.clone()).collect(),
            recovered: fit.frames.iter().map(|frame| frame.fit.recovered).collect(),
            cameras: fit.cameras.iter().map(|camera| camera.found).collect(),
            keyframes: keyframe_shapes(hypotheses).into_iter().cloned().collect(),
            jumps: fit.verdict.jumps().cloned().collect(),
            worn: fit.verdict.worn().cloned(),
        }
    }
}

/// The trials with one body.
#[derive(Debug, Clone)]
pub struct SessionFit {
    /// Trial by trial, all with the same shape and without hypotheses: the search was each trial's own.
    pub fits: Vec<Fit>,
    /// Cameras whose calibration changed within the session.
    pub other_calibrations: Vec<OtherCalibration>,
}

/// The joint optimum of several trials of one person, which were each fitted alone before.
///
/// All must have been fitted by the same options and the same `model`, which has no details yet.
///
/// # Errors
/// [`FitError`] if the observations of a trial cannot be used.
pub fn fit_session(
    model: &BodyModel,
    trials: &[SessionTrial<'_>],
    progress: &dyn Progress,
) -> Result<SessionFit, FitError> {
    let body = model.detailed();
    let cleared = trials.iter().map(|trial| {
        let Cleared { frames, causes } = Cleared::new(trial.rig, trial.sequence.frames);
        let frames = without_jumps(trial.rig, frames, &trial.alone.jumps);
        Cleared { frames, causes: [causes, trial.alone.jumps.clone()].concat() }
    });
    let cleared: Vec<Cleared<'_>> = cleared.collect();
    let options_of = |trial: &SessionTrial<'_>| match trial.alone.worn {
        Some(_) => for_worn(trial.options),
        None => trial.options.clone(),
    };
    let options: Vec<EstimateOptions> = trials.iter().map(options_of).collect();
    let prepared = trials.iter().zip(cleared.iter().zip(&options));
    let trials = prepared.map(|(trial, (cleared, options))| SessionTrial {
        sequence: Sequence { frames: &cleared.frames, ..trial.sequence },
        options,
        ..trial.clone()
    });
    let trials: &[SessionTrial<'_>] = &trials.collect::<Vec<_>>();
    let faults: Vec<CameraFaults> =
        trials.iter().map(|trial| CameraFaults::of(trial.rig, trial.sequence.frames)).collect();
    let measures: Vec<Measures> = trials
        .iter()
        .map(|trial| measures(model, trial.sequence.frames, trial.options))
        .collect::<Result<_, _>>()?;
    let shared = SharedRig::new(trials);

    // 1. one body for all
    let session = Session { body: &body, trials, measures: &measures };
    let joined = session.optimum(&shared, progress);

    // 2. what each trial is worth with it
    let keyframes: Vec<&Shape> = trials.iter().flat_map(|trial| &trial.alone.keyframes).collect();
    progress.begin("checks", trials.len());
    let mut fits = Vec::with_capacity(trials.len());
    for (k, (trial, joined)) in trials.iter().zip(joined).enumerate() {
        let notes = check_scene(model, trial.rig, trial.sequence.frames)?;
        let coarse = Evidence::new(model, trial.rig, trial.options.likelihood, measures[k].search);
        let left_out: Vec<Cause> =
            cleared[k].causes.iter().chain(&trial.alone.worn).cloned().collect();
        let judge = Judge {
            coarse: &coarse,
            body: &body,
            sequence: trial.sequence,
            options: trial.options,
            faults: &faults[k],
            left_out: &left_out,
        };
        let estimate = Estimate::joint(joined, trial.rig, &trial.alone.recovered);
        let confidence = ShapeConfidence::from_shapes(
            model,
            &keyframes,
            &estimate.shape.first(model.coefficients.len()),
            &body.rest_lengths_m(&estimate.shape),
            &trial.options.confidence,
        );
        let frames = estimate.frames(&body, trial.sequence, trial.options, measures[k].joint);
        fits.push(judge.fit(estimate, frames, confidence, notes));
        progress.step();
    }
    progress.end();
    Ok(SessionFit { fits, other_calibrations: shared.others })
}

/// The trials, and what is known of each.
struct Session<'a> {
    body: &'a BodyModel,
    trials: &'a [SessionTrial<'a>],
    measures: &'a [Measures],
}

impl Session<'_> {
    /// The joint optimum, trial by trial.
    fn optimum(&self, shared: &SharedRig, progress: &dyn Progress) -> Vec<Joined> {
        let Some(first) = self.trials.first() else { return Vec::new() };
        let names: Vec<&str> =
            self.trials.iter().flat_map(|trial| detected_names(trial.sequence)).collect();
        let detected = self.body.with_keypoints(&distinct(names));
        let joint = first.options.joint.unwrap_or_default();
        let joint = JointOptions { rounds: Rounds::FromThinned, ..joint };

        // what each trial shows, its cameras counted through all trials
        let (state, zooms) = self.start(shared);
        let rig = zoomed(&shared.rig, &zooms);
        let (mut thinned, mut all, mut priors) = (Vec::new(), Vec::new(), Vec::new());
        for (k, trial) in self.trials.iter().enumerate() {
            let own = Rig { cameras: rig.cameras[shared.cameras[k].clone()].to_vec() };
            let evidence = self.evidence(&detected, &own, k);
            let prior = self.camera_prior(k);
            let terms = evidence.sequence_terms(trial.sequence, prior.clone());
            thinned.extend(counted_from(terms.thinned, shared.cameras[k].start));
            all.extend(counted_from(terms.all, shared.cameras[k].start));
            priors.push((prior, trial.rig.cameras.len()));
        }
        let camera_prior = CameraPrior::of_trials(&priors, |camera| shared.same[camera]);
        let camera_prior = camera_prior.with_zooms(&zooms);
        let terms = SequenceTerms { thinned, all, camera_prior };

        progress.begin("one body for all trials", joint.most_steps());
        let evidence = self.evidence(&detected, &rig, 0);
        let (seconds, step) = (seconds(self.trials), || progress.step());
        let mut optimum =
            joint_optimum_from_terms(&evidence, &terms, &seconds, state, &joint, &step);
        progress.end();
        count_from_calibrated(&mut optimum, &zooms);
        let part =
            |(k, frames)| self.part(&optimum, &terms.camera_prior, frames, &shared.cameras[k]);
        frames(self.trials).into_iter().enumerate().map(part).collect()
    }

    fn evidence<'b>(&self, detected: &'b BodyModel, rig: &'b Rig, k: usize) -> Evidence<'b> {
        Evidence::new(detected, rig, self.trials[k].options.likelihood, self.measures[k].joint)
    }

    /// The mean shape, every trial's own motion, and the cameras as they were found alone: before lenses as they were found, ζ of each.
    fn start(&self, shared: &SharedRig) -> (SequenceState, Vec<f64>) {
        let alone = || self.trials.iter().map(|trial| &trial.alone);
        let motions = alone().flat_map(|alone| alone.motions.clone()).collect();
        let mut cameras: Vec<CameraOffset> =
            alone().flat_map(|alone| alone.cameras.iter().map(CameraFound::offset)).collect();
        for (i, same) in shared.same.iter().enumerate() {
            if let Some(same) = same {
                cameras[i] = CameraOffset { ahead_s: cameras[i].ahead_s, ..cameras[*same] };
            }
        }
        let zooms = cameras.iter_mut().map(|camera| std::mem::take(&mut camera.log_zoom)).collect();
        (SequenceState { shape: mean_shape(alone()), motions, cameras }, zooms)
    }

    /// What of a trial's cameras is unknown: what was, when it was fitted alone.
    fn camera_prior(&self, k: usize) -> CameraPrior {
        let SessionTrial { alone, rig, sequence, options, .. } = &self.trials[k];
        let free: Vec<Free> = alone.cameras.iter().map(CameraFound::free).collect();
        camera_prior(&free, rig, *sequence, options)
    }

    /// A trial's part of the optimum, without what a detector means by each joint.
    fn part(
        &self,
        optimum: &JointOptimum,
        prior: &CameraPrior,
        frames: Range<usize>,
        cameras: &Range<usize>,
    ) -> Joined {
        let own = optimum.of_trial(frames, cameras.clone());
        let prior = prior.of_some(cameras.clone());
        let covariances = CameraCovariances::new(&prior, &own);
        Joined { optimum: own.of_first(self.body.coefficients.len()), prior, covariances }
    }
}

/// Seconds from the frame before, infinitely many where a trial begins.
fn seconds(trials: &[SessionTrial<'_>]) -> Vec<f64> {
    let of_trial = |trial: &SessionTrial<'_>| {
        let intervals_s = trial.sequence.intervals_s().into_iter();
        let first = |(i, interval_s)| if i == 0 { f64::INFINITY } else { interval_s };
        intervals_s.enumerate().map(first).collect::<Vec<f64>>()
    };
    trials.iter().flat_map(of_trial).collect()
}

/// The frames of each trial, counted through all of them.
fn frames(trials: &[SessionTrial<'_>]) -> Vec<Range<usize>> {
    let of_trial = |first: &mut usize, trial: &SessionTrial<'_>| {
        let own = *first..*first + trial.sequence.frames.len();
        *first = own.end;
        Some(own)
    };
    trials.iter().scan(0, of_trial).collect()
}

/// The same looks, with cameras that are counted from another one on.
fn counted_from(frames: Vec<Vec<Look<'_>>>, first: usize) -> impl Iterator<Item = Vec<Look<'_>>> {
    frames.into_iter().map(move |mut looks| {
        for look in &mut looks {
            look.camera = look.camera.map(|camera| camera + first);
        }
        looks
    })
}

fn distinct(mut names: Vec<&'static str>) -> Vec<&'static str> {
    names.sort_unstable();
    names.dedup();
    names
}

/// s̄: each trial's shape by what is known of it; the plain mean where that is not known of every trial.
fn mean_shape<'a>(trials: impl Iterator<Item = &'a AloneFit> + Clone) -> Shape {
    let p = trials.clone().next().map_or(0, |alone| alone.shape.0.len());
    let (mut precision, mut right) = (DMatrix::zeros(p, p), DVector::zeros(p));
    let (mut sum, mut is_known) = (DVector::zeros(p), true);
    for alone in trials.clone() {
        sum += &alone.shape.0;
        match alone.covariance.clone().and_then(|covariance| covariance.cholesky()) {
            Some(covariance) => {
                right += covariance.solve(&alone.shape.0);
                precision += covariance.inverse();
            }
            None => is_known = false,
        }
    }
    let weighted = precision.cholesky().filter(|_| is_known).map(|all| all.solve(&right));
    Shape(weighted.unwrap_or_else(|| sum / trials.count().max(1) as f64))
}
