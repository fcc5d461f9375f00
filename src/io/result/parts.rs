//! How a fit is written down.

use super::schema::{
    CameraPart, CoefficientPart, FramePart, HypothesisPart, InputPart, LengthPart, MissingPart,
    MotionPart, NoisePart, OptionsPart, OriginPart, OutcomePart, PointPart, PosteriorPart, Program,
    QualityPart, RecordingPart, RejectedPart, ResultFile, ShapePart, ViewPart,
};
use crate::body::BodyModel;
use crate::camera::{CameraId, Rig};
use crate::inference::search::Origin;
use crate::io::recording::{InputChecksum, ObservationFiles};
use crate::pipeline::{Fit, FittedFrame, FrameSd, TriedHypothesis, rest_lengths_m};
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
        let (model, rig) = (from.model, &from.recording.rig);
        let notes = from.recording.notes.iter().map(ToString::to_string);
        let warnings = fit.warnings.iter().map(ToString::to_string);

        Self {
            format: "maquette-result".into(),
            version: 2,
            program: Program {
                name: env!("CARGO_PKG_NAME").into(),
                version: env!("CARGO_PKG_VERSION").into(),
            },
            recording: recording(from),
            inputs: from.inputs.iter().map(input).collect(),
            options: from.options.clone(),
            body: model.name.clone(),
            shape: shape(fit, model),
            motion: MotionPart {
                angles: model.joints.iter().map(|j| j.name.clone()).collect(),
                points: model.points.iter().map(|p| p.name.clone()).collect(),
                frames: fit.frames.iter().map(|f| frame(f, from.recording.fps)).collect(),
            },
            hypotheses: hypotheses(fit, model),
            winner: fit.winner,
            quality: quality(fit, rig),
            warnings: warnings.chain(notes).collect(),
        }
    }
}

fn name(rig: &Rig, id: CameraId) -> String {
    rig.camera(id).map_or_else(|| id.to_string(), |camera| camera.name.clone())
}

fn recording(from: Provenance<'_>) -> RecordingPart {
    let rig = &from.recording.rig;
    let fitted = |frame: &&FrameIndex| {
        let known = from.observations.binary_search_by_key(*frame, |observed| observed.frame);
        known.is_ok()
    };

    let missing = from.recording.missing.iter().map(|missing| MissingPart {
        camera: name(rig, missing.camera),
        frames: missing.frames.iter().filter(fitted).map(|f| f.0).collect(),
    });
    let rejected = from.observations.iter().flat_map(|observed| {
        let one = |(camera, reason): &(CameraId, _)| RejectedPart {
            frame: observed.frame.0,
            camera: name(rig, *camera),
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
        missing: missing.filter(|m| !m.frames.is_empty()).collect(),
        rejected: rejected.collect(),
    }
}

fn input(checksum: &InputChecksum) -> InputPart {
    InputPart {
        input: checksum.input.clone(),
        files: checksum.files,
        blake3: checksum.blake3.clone(),
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
        confidence: fit.confidence.coefficients[i].clone(),
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
        covariance: fit.uncertainty.as_ref().map(|u| {
            let rows = u.covariance.row_iter();
            rows.map(|row| row.iter().copied().collect()).collect()
        }),
        lengths: model.lengths.iter().enumerate().map(length).collect(),
        noise: fit.noise.map(|noise| NoisePart {
            scale: noise.scale,
            along_border: noise.along_border,
            within_frame: noise.within_frame,
            repeated: noise.repeated,
            over_time: noise.over_time,
        }),
        confidence_of: CONFIDENCE_OF.into(),
        all_coefficients: fit.confidence.all_coefficients.clone(),
        all_lengths: fit.confidence.all_lengths.clone(),
    }
}

fn frame(fitted: &FittedFrame, fps: f64) -> FramePart {
    let motion = &fitted.fit.motion;

    FramePart {
        frame: fitted.frame.0,
        time_s: fitted.frame.0 as f64 / fps,
        views: fitted.views.len(),
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
        };

        let outcome = match tried.trial.finished() {
            _ if i == fit.winner => OutcomePart::Won,
            true => OutcomePart::Finished,
            false => OutcomePart::Pruned,
        };

        let [data, pose, step] = tried.parts();
        HypothesisPart {
            origin,
            reading,
            keyframe: tried.keyframe.0,
            outcome,
            frames_fitted: tried.fitted,
            minus_log_posterior: PosteriorPart {
                total: tried.trial.energy(),
                shape: tried.trial.shape_cost,
                data,
                pose,
                step,
            },
            keyframe_cost: hypothesis.keyframe_cost,
            iou: tried.iou,
            coefficients: hypothesis.shape.0.as_slice().to_vec(),
            lengths_m: rest_lengths_m(model, &hypothesis.shape),
        }
    };

    fit.hypotheses.iter().enumerate().map(part).collect()
}

fn quality(fit: &Fit, rig: &Rig) -> QualityPart {
    let cameras = fit.cameras.iter().map(|quality| CameraPart {
        camera: name(rig, quality.camera),
        frames: quality.frames,
        mean_iou: quality.mean_iou,
        median_px: quality.median_px,
        rms_px: quality.rms_px,
        aim_px: quality.aim_px.into(),
    });

    let views = fit.frames.iter().flat_map(|fitted| {
        fitted.views.iter().map(|view| ViewPart {
            frame: fitted.frame.0,
            camera: name(rig, view.camera),
            iou: view.iou,
            points: view.residuals.map_or(0, |r| r.points),
            rms_px: view.residuals.map(|r| r.rms_px),
            median_px: view.residuals.map(|r| r.median_px),
            p95_px: view.residuals.map(|r| r.p95_px),
        })
    });

    let points = fit.frames.iter().filter_map(|fitted| {
        let quality = fitted.points.as_ref()?;
        Some(PointPart {
            frame: fitted.frame.0,
            points: quality.points,
            outside: quality.outside,
            outside_m: quality.outside_m,
            off_skin_m: quality.off_skin_m,
        })
    });

    QualityPart { cameras: cameras.collect(), views: views.collect(), points: points.collect() }
}
