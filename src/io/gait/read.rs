//! A movement for gait analysis, from a TRC of any system or from a fit.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use crate::body::BodyModel;
use crate::gait::{Movement, MovementError};
use crate::io::input::{self, MOST_OF_A_TABLE};
use crate::io::points::trc::{TrcError, read_with_rate};
use crate::io::result::{FramePart, ResultError, ResultFile};
use crate::pipeline::{FittedBody, FittedMotion, FramePose};
use crate::silhouette::FrameIndex;

/// Why a file or a fit gives no movement.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum GaitInputError {
    /// A file that cannot be read.
    #[error("{}: cannot be read: {source}", path.display())]
    Read {
        /// The file.
        path: PathBuf,
        /// Why.
        source: std::io::Error,
    },
    /// A text that is no TRC.
    #[error(transparent)]
    Trc(#[from] TrcError),
    /// A TRC that states two frame rates.
    #[error(
        "{}: the header states {stated_hz} Hz, the Time column {counted_hz:.6} Hz: give the right one with --fps",
        path.display()
    )]
    Rate {
        /// The file.
        path: PathBuf,
        /// In the header.
        stated_hz: f64,
        /// From the times.
        counted_hz: f64,
    },
    /// Points that are no movement of a person.
    #[error("{}: {source}", path.display())]
    Points {
        /// The file.
        path: PathBuf,
        /// Why.
        source: MovementError,
    },
    /// A fitted body that has no gait.
    #[error("the fitted body {body}: {source}")]
    Body {
        /// Its model.
        body: String,
        /// Why.
        source: MovementError,
    },
    /// A fit of another body.
    #[error(transparent)]
    Result(#[from] ResultError),
}

/// What gait analysis works on.
#[derive(Debug, Clone, PartialEq)]
pub struct GaitInput {
    /// The moving body.
    pub movement: Movement,
    /// `points` or the name of the fitted body.
    pub source: String,
    /// The body of a fit.
    pub body: Option<FittedBody>,
}

/// Reads a TRC; `rate_hz` replaces the rate that it states.
///
/// # Errors
/// [`GaitInputError`] names the file, and the line where there is one.
pub fn read_points(path: &Path, rate_hz: Option<f64>) -> Result<GaitInput, GaitInputError> {
    let bytes = input::read(path, MOST_OF_A_TABLE)
        .map_err(|source| GaitInputError::Read { path: path.into(), source })?;
    let text = String::from_utf8_lossy(&bytes);
    let (points, counted_hz) = read_with_rate(&text, path)?;

    let stated_hz = points.rate_hz;
    let differs = |counted_hz: &f64| (counted_hz / stated_hz - 1.0).abs() > 0.02;
    let counted_hz = counted_hz.filter(differs);
    if let (None, Some(counted_hz)) = (rate_hz, counted_hz) {
        return Err(GaitInputError::Rate { path: path.into(), stated_hz, counted_hz });
    }

    let rate_hz = rate_hz.unwrap_or(stated_hz);
    let movement =
        Movement::from_points(rate_hz, points.first_frame, &points.names, &points.frames);
    Ok(GaitInput {
        movement: movement
            .map_err(|source| GaitInputError::Points { path: path.into(), source })?,
        source: "points".into(),
        body: None,
    })
}

/// Takes the moving body from a fit in memory and its model; `rate_hz` replaces the rate of the recording.
///
/// # Errors
/// [`GaitInputError::Result`] if the fit is of another body, and [`GaitInputError::Body`] if this one has no gait.
pub fn from_result(
    result: &ResultFile,
    model: BodyModel,
    rate_hz: Option<f64>,
) -> Result<GaitInput, GaitInputError> {
    let model = result.body_of(&model)?;
    let cameras = camera_bits(result);
    let pose = |part: &FramePart| FramePose {
        frame: FrameIndex(part.frame),
        is_seen: part.views > 0,
        motion: part.motion(),
        points_m: part.points_m.clone(),
        sd: part.sd.clone(),
        cameras: cameras.get(&part.frame).copied().unwrap_or(0),
    };
    let fitted = FittedMotion {
        shape: result.shape_of(&model)?,
        model,
        rate_hz: rate_hz.unwrap_or(result.recording.fps),
        points: result.motion.points.clone(),
        frames: result.motion.frames.iter().map(pose).collect(),
    };

    let (movement, body) = fitted
        .into_movement()
        .map_err(|source| GaitInputError::Body { body: result.body.clone(), source })?;
    Ok(GaitInput { movement, source: result.body.clone(), body: Some(body) })
}

/// Which of the first seven cameras saw the person, as bits, by the number of the frame.
fn camera_bits(result: &ResultFile) -> BTreeMap<usize, u8> {
    let mut bits = BTreeMap::new();
    let views = result.quality.views.iter().map(|view| (view.frame, &view.camera));
    let detected = result.quality.detections.iter().map(|picture| (picture.frame, &picture.camera));
    for (frame, camera) in views.chain(detected) {
        let mut names = result.recording.cameras.iter();
        let camera = names.position(|name| name == camera);
        if let Some(camera) = camera.filter(|i| *i < 7) {
            *bits.entry(frame.0).or_insert(0) |= 1_u8 << camera;
        }
    }
    bits
}
