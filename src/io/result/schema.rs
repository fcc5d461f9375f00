//! `result.json`, field by field; the same with more words in docs/formats.md.

use serde::{Deserialize, Serialize};

use crate::inference::confidence::Confidence;
use crate::inference::noise::Noise;
use crate::io::recording::{InputChecksum, Missing};
use crate::pipeline::{
    CameraQuality, DetectionQuality, EstimateOptions, FrameSd, MinusLogPosterior,
    ObservationOptions, PointQuality, Verdict, ViewQuality,
};

/// What a fit found, and what it was made from. Version 3.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct ResultFile {
    /// `maquette-result`.
    pub format: String,
    /// 3.
    pub version: u32,
    /// What wrote it.
    pub program: Program,
    /// What was recorded.
    pub recording: RecordingPart,
    /// Fingerprints of everything that was read.
    pub inputs: Vec<InputChecksum>,
    /// Every option, also those left at their defaults.
    pub options: OptionsPart,
    /// Name of the body model.
    pub body: String,
    /// s.
    pub shape: ShapePart,
    /// m₁ … mₙ.
    pub motion: MotionPart,
    /// Everything that was tried.
    pub hypotheses: Vec<HypothesisPart>,
    /// Index into `hypotheses` of the one that `shape` and `motion` are of.
    pub winner: usize,
    /// How well the body covers the masks.
    pub quality: QualityPart,
    /// Whether all this can be used, and what is wrong with the recording.
    pub verdict: Verdict,
    /// What a person should know, in plain words; the verdict first.
    pub warnings: Vec<String>,
}

/// Every option of a fit.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct OptionsPart {
    /// How masks and points become observations.
    pub observations: ObservationOptions,
    /// The estimate.
    pub estimate: EstimateOptions,
}

/// A program and its version.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct Program {
    /// `maquette`.
    pub name: String,
    /// As in Cargo.toml.
    pub version: String,
}

/// What was recorded, and what is missing.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct RecordingPart {
    /// Frames per second.
    pub fps: f64,
    /// Number of frames that were fitted.
    pub frames: usize,
    /// Number of the first.
    pub first_frame: usize,
    /// Number of the last.
    pub last_frame: usize,
    /// Names of the cameras.
    pub cameras: Vec<String>,
    /// By how many frames each began after the recording, as its files were numbered: offset_frames + start_s·fps.
    #[serde(default)]
    pub offset_frames: Vec<f64>,
    /// Masks that are not there.
    pub missing: Vec<Missing>,
    /// Masks without a silhouette.
    pub rejected: Vec<RejectedPart>,
}

/// Where a camera stands by its calibration, and where it looks; world axes.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct PlacePart {
    /// Its centre, metres.
    pub centre_m: [f64; 3],
    /// Along its optical axis, of length 1.
    pub looks: [f64; 3],
}

/// A mask without a silhouette.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct RejectedPart {
    /// The frame.
    pub frame: usize,
    /// The camera.
    pub camera: String,
    /// Why.
    pub reason: String,
}

/// The shape of the winner.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct ShapePart {
    /// The coefficients s.
    pub coefficients: Vec<CoefficientPart>,
    /// Covariance of the coefficients, of the joint optimum, row by row.
    #[serde(default)]
    pub covariance: Option<Vec<Vec<f64>>>,
    /// The lengths that they make.
    pub lengths: Vec<LengthPart>,
    /// How the residuals err; only of the joint optimum.
    pub noise: Option<Noise>,
    /// What the confidences are a confidence of.
    pub confidence_of: String,
    /// Of all coefficients at once.
    pub all_coefficients: Confidence,
    /// Of all lengths at once.
    pub all_lengths: Confidence,
}

/// One shape coefficient.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct CoefficientPart {
    /// Its name in the model.
    pub name: String,
    /// s: a logarithm, or metres of a shift.
    pub value: f64,
    /// Its standard deviation, of the joint optimum.
    pub sd: Option<f64>,
    /// Mean of p(s).
    pub prior_mean: f64,
    /// Standard deviation of p(s).
    pub prior_sd: f64,
    /// How far the keyframes agree; `None` of what a keyframe alone is not asked for.
    pub confidence: Option<Confidence>,
}

/// One length.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct LengthPart {
    /// Its name in the model.
    pub name: String,
    /// The point where it begins.
    pub from: String,
    /// The point where it ends.
    pub to: String,
    /// Metres, at rest.
    pub length_m: f64,
    /// Its standard deviation, of the joint optimum.
    pub sd_m: Option<f64>,
    /// How far the keyframes agree.
    pub confidence: Confidence,
}

/// The motion of the winner.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct MotionPart {
    /// Names of the angles, in the order of `angles_rad`.
    pub angles: Vec<String>,
    /// Names of the points, in the order of `points_m`.
    pub points: Vec<String>,
    /// Frame by frame.
    pub frames: Vec<FramePart>,
}

/// The motion of one frame. World: metres, Z up.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct FramePart {
    /// Number of the frame.
    pub frame: usize,
    /// Its time, frame / fps.
    pub time_s: f64,
    /// Number of cameras that see the person; 0: the motion is a guess.
    pub views: usize,
    /// The track was lost here and the frame searched anew.
    pub recovered: bool,
    /// The root's origin.
    pub position_m: [f64; 3],
    /// The root's orientation, world from root, as axis times angle.
    pub rotation_rad: [f64; 3],
    /// The joints' angles.
    pub angles_rad: Vec<f64>,
    /// The points' places.
    pub points_m: Vec<[f64; 3]>,
    /// Standard deviations, of the joint optimum.
    pub sd: Option<FrameSd>,
    /// −log p(Zᵢ | mᵢ, s).
    pub data: f64,
    /// −log p of limits and rest.
    pub pose: f64,
    /// −log p(mᵢ | its neighbours).
    pub step: f64,
}

/// A hypothesis.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct HypothesisPart {
    /// Where its shape is from.
    pub origin: OriginPart,
    /// Of a keyframe: which reading, 0 the most probable there.
    pub reading: Option<usize>,
    /// Number of the frame from which it was followed.
    pub keyframe: usize,
    /// How it ended.
    pub outcome: OutcomePart,
    /// Frames that were fitted.
    pub frames_fitted: usize,
    /// −log of the sequence posterior up to a constant (eq. 1), or a lower bound of it if pruned.
    pub minus_log_posterior: MinusLogPosterior,
    /// −log p(mₖ, s | Zₖ) at the keyframe.
    pub keyframe_cost: f64,
    /// Mean overlap over at most ten fitted frames.
    pub iou: Option<f64>,
    /// s.
    pub coefficients: Vec<f64>,
    /// The lengths, in the order of `shape.lengths`.
    pub lengths_m: Vec<f64>,
}

/// Where the shape of a hypothesis is from.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum OriginPart {
    /// The mean of p(s).
    Prior,
    /// One keyframe.
    Keyframe,
    /// The winner of the others, turned to face the other way.
    Turned,
}

/// What became of a hypothesis.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum OutcomePart {
    /// The most probable.
    Won,
    /// Followed to the end.
    Finished,
    /// Dropped when it could no longer win.
    Pruned,
}

/// How well the body covers the masks.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct QualityPart {
    /// Camera by camera.
    pub cameras: Vec<CameraQuality>,
    /// Where each camera stands by its calibration, in the same order.
    #[serde(default)]
    pub places: Vec<PlacePart>,
    /// Covariance of the turns (rad), displacements (m) and logarithms of the focal lengths of the cameras whose poses were estimated,
    /// seven rows each in their order.
    #[serde(default)]
    pub poses_covariance: Option<Vec<Vec<f64>>>,
    /// Covariance of the times (s) by which the cameras are ahead whose clocks were estimated, in their order.
    #[serde(default)]
    pub clocks_covariance: Option<Vec<Vec<f64>>>,
    /// View by view, in the order of the frames.
    pub views: Vec<ViewQuality>,
    /// Frame by frame, those that have points.
    pub points: Vec<PointQuality>,
    /// Picture by picture, those that have detections of the person.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub detections: Vec<DetectionQuality>,
}
