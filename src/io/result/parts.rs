//! How a fit is written down.

use nalgebra::{DMatrix, Vector3};

use super::schema::{
    CoefficientPart, FramePart, HypothesisPart, LengthPart, MotionPart, OptionsPart, OriginPart,
    OutcomePart, PlacePart, Program, QualityPart, RecordingPart, RejectedPart, ResultFile,
    ShapePart,
};
use super::{FORMAT, VERSION};
use crate::body::BodyModel;
use crate::camera::{Camera, CameraId, Rig};
use crate::inference::search::Origin;
use crate::io::recording::{InputChecksum, ObservationFiles};
use crate::pipeline::{Fit, FittedFrame, FrameSd, TriedHypothesis};
use crate::silhouette::{FrameIndex, FrameObservations};

/// What p_ε,σ(K) speaks of, and what not.
const CONFIDENCE_OF: &str = "the model's optimum, not the true length: the probability that one of the K keyframes' \
    estimates lies within epsilon of it; an error that all keyframes share does not show in it";

/// What a fit was made from.
#[derive(Debug, Clone, Copy)]
pub struct Provenance<'a> {
    /// The recording.
    pub recording: &'a ObservationFiles,
    /// The observations of the frames that were fitted.
    pub observations: &'a [FrameObservations],
    /// Everything that was read.
    pub inputs: &'a [InputChecksum],
    /// The body.
    pub model: &'a BodyModel,
    /// Every option.
    pub options: &'a OptionsPart,
}

impl ResultFile {
    /// Writes down a fit.
    pub fn new(fit: &Fit, from: Provenance<'_>) -> Self {
        let model = from.model;
        let notes = from.recording.notes.iter().map(ToString::to_string);
        let warnings = fit.verdict.headline().into_iter();
        let warnings = warnings.chain(fit.warnings.iter().map(ToString::to_string));

        Self {
            format: FORMAT.into(),
            version: VERSION,
            program: Program {
                name: env!("CARGO_PKG_NAME").into(),
                version: env!("CARGO_PKG_VERSION").into(),
            },
            recording: recording(from),
            inputs: from.inputs.to_vec(),
            options: from.options.clone(),
            body: model.name.clone(),
            shape: shape(fit, &fit.model),
            motion: MotionPart {
                angles: model.joints.iter().map(|j| j.name.clone()).collect(),
                points: model.points.iter().map(|p| p.name.clone()).collect(),
                frames: fit.frames.iter().map(|f| frame(f, from.recording.fps)).collect(),
            },
            hypotheses: hypotheses(fit, model),
            winner: fit.winner,
            quality: quality(fit, &from.recording.rig),
            verdict: fit.verdict.clone(),
            warnings: warnings.chain(notes).collect(),
        }
    }
}

fn recording(from: Provenance<'_>) -> RecordingPart {
    let rig = &from.recording.rig;
    let is_fitted = |frame: &FrameIndex| {
        let known = from.observations.binary_search_by_key(frame, |observed| observed.frame);
        known.is_ok()
    };

    let mut missing = from.recording.missing.clone();
    for masks in &mut missing {
        masks.frames.retain(is_fitted);
    }
    missing.retain(|masks| !masks.frames.is_empty());

    let rejected = from.observations.iter().flat_map(|observed| {
        let one = |(camera, reason): &(CameraId, _)| RejectedPart {
            frame: observed.frame.0,
            camera: rig.cameras[camera.0].name.clone(),
            reason: ToString::to_string(reason),
        };
        observed.rejected.iter().map(one).collect::<Vec<_>>()
    });

    RecordingPart {
        fps: from.recording.fps,
        frames: from.observations.len(),
        first_frame: from.observations.first().map_or(0, |o| o.frame.0),
        last_frame: from.observations.last().map_or(0, |o| o.frame.0),
        cameras: rig.names().map(Into::into).collect(),
        offset_frames: from.recording.beginnings.iter().map(|beginning| beginning.0).collect(),
        missing,
        rejected: rejected.collect(),
    }
}

fn shape(fit: &Fit, model: &BodyModel) -> ShapePart {
    let statistics = &model.statistics;
    let coefficient = |(i, name): (usize, &String)| CoefficientPart {
        name: name.clone(),
        value: fit.shape.0[i],
        sd: fit.uncertainty.as_ref().map(|u| u.covariance[(i, i)].sqrt()),
        prior_mean: statistics.mean[i],
        prior_sd: statistics.covariance[(i, i)].sqrt(),
        confidence: fit.confidence.coefficients.get(i).cloned(),
    };

    let point = |i: usize| model.points[i].name.clone();
    let length = |(i, (name, from, to)): (usize, &(String, usize, usize))| LengthPart {
        name: name.clone(),
        from: point(*from),
        to: point(*to),
        length_m: fit.lengths_m[i],
        sd_m: fit.uncertainty.as_ref().map(|u| u.lengths_sd_m[i]),
        confidence: fit.confidence.lengths[i].clone(),
    };

    ShapePart {
        coefficients: model.coefficients.iter().enumerate().map(coefficient).collect(),
        covariance: fit.uncertainty.as_ref().map(|u| rows(&u.covariance)),
        lengths: model.lengths.iter().enumerate().map(length).collect(),
        noise: fit.noise,
        confidence_of: CONFIDENCE_OF.into(),
        all_coefficients: fit.confidence.all_coefficients.clone(),
        all_lengths: fit.confidence.all_lengths.clone(),
    }
}

fn rows(matrix: &DMatrix<f64>) -> Vec<Vec<f64>> {
    matrix.row_iter().map(|row| row.iter().copied().collect()).collect()
}

fn frame(fitted: &FittedFrame, fps: f64) -> FramePart {
    let motion = &fitted.fit.motion;

    FramePart {
        frame: fitted.frame.0,
        time_s: fitted.frame.0 as f64 / fps,
        views: fitted.cameras(),
        recovered: fitted.fit.recovered,
        position_m: motion.position_world.into(),
        rotation_rad: motion.world_from_root.scaled_axis().into(),
        angles_rad: motion.angles.as_slice().to_vec(),
        points_m: fitted.points_world.iter().map(|p| p.coords.into()).collect(),
        sd: fitted.uncertainty.as_ref().map(FrameSd::from),
        data: fitted.fit.data,
        pose: fitted.fit.pose,
        step: fitted.fit.step,
    }
}

fn hypotheses(fit: &Fit, model: &BodyModel) -> Vec<HypothesisPart> {
    let part = |(i, tried): (usize, &TriedHypothesis)| {
        let hypothesis = &tried.trial.hypothesis;
        let (origin, reading) = match hypothesis.origin {
            Origin::Prior => (OriginPart::Prior, None),
            Origin::Keyframe(reading) => (OriginPart::Keyframe, Some(reading)),
            Origin::Turned => (OriginPart::Turned, None),
        };

        let outcome = match tried.trial.finished() {
            _ if i == fit.winner => OutcomePart::Won,
            true => OutcomePart::Finished,
            false => OutcomePart::Pruned,
        };

        HypothesisPart {
            origin,
            reading,
            keyframe: tried.keyframe.0,
            outcome,
            frames_fitted: tried.fitted,
            minus_log_posterior: tried.minus_log_posterior(),
            keyframe_cost: hypothesis.keyframe_cost,
            iou: tried.iou,
            coefficients: hypothesis.shape.0.as_slice().to_vec(),
            lengths_m: model.rest_lengths_m(&hypothesis.shape),
        }
    };

    fit.hypotheses.iter().enumerate().map(part).collect()
}

fn quality(fit: &Fit, calibrated: &Rig) -> QualityPart {
    let place = |camera: &Camera| PlacePart {
        centre_m: camera.centre_world().into(),
        looks: (camera.camera_from_world.rotation.inverse() * Vector3::z()).into(),
    };
    QualityPart {
        cameras: fit.cameras.clone(),
        places: calibrated.cameras.iter().map(place).collect(),
        poses_covariance: fit.camera_covariances.poses.as_ref().map(rows),
        clocks_covariance: fit.camera_covariances.clocks.as_ref().map(rows),
        views: fit.frames.iter().flat_map(|fitted| fitted.views.clone()).collect(),
        points: fit.frames.iter().filter_map(|fitted| fitted.points).collect(),
        detections: fit.frames.iter().flat_map(|fitted| fitted.detections.clone()).collect(),
    }
}
