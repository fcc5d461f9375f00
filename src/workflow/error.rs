//! What can go wrong between a recording and a report, in one line.

use std::path::PathBuf;

use super::{CalibrateError, OwnNormError, SessionError, StandingError, SyncError};
use crate::gait::{GaitError, MovementError};
use crate::io::calibration::CalibrationWriteError;
use crate::io::export::{BvhError, C3dError, GlbError};
use crate::io::folder::OutError;
use crate::io::folder::journal::JournalError;
use crate::io::folder::overlays::OverlayError;
use crate::io::folder::pdf::PdfError;
use crate::io::gait::{EventsError, GaitInputError, NormError};
use crate::io::model::ModelFileError;
use crate::io::recording::RecordingError;
use crate::io::result::ResultError;
use crate::io::session::SessionFileError;
use crate::pipeline::silhouettes::SilhouetteError;
use crate::pipeline::stereo::StereoError;
use crate::pipeline::{FitError, FrameRange, FrameRangeError, LensError, SizeError};
use crate::skin::SkinError;

/// Why a step from a recording to a report could not be done.
///
/// Each says in one line which file, camera or frame it is, what was expected and what was found.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum Error {
    /// The recording.
    #[error(transparent)]
    Recording(#[from] RecordingError),
    /// The frames that were asked for.
    #[error(transparent)]
    FrameRange(#[from] FrameRangeError),
    /// One picture of each camera, and none of the empty scene.
    #[error(
        "nobody can be told from the room in one picture of each camera: give masks/<camera>/, pictures of the empty scene in background/<camera>.*, or a video"
    )]
    OneInstant,
    /// The body model.
    #[error(transparent)]
    Model(#[from] ModelFileError),
    /// Observations that cannot be fitted.
    #[error(transparent)]
    Fit(#[from] FitError),
    /// Cameras that cannot be matched.
    #[error(transparent)]
    Stereo(#[from] StereoError),
    /// Pictures in which no silhouettes can be found.
    #[error(transparent)]
    Silhouettes(#[from] SilhouetteError),
    /// The folder that is written into.
    #[error(transparent)]
    Out(#[from] OutError),
    /// A run that cannot be continued.
    #[error(transparent)]
    Journal(#[from] JournalError),
    /// Pictures of the fit.
    #[error(transparent)]
    Overlay(#[from] OverlayError),
    /// A page that cannot be printed.
    #[error(transparent)]
    Pdf(#[from] PdfError),
    /// A result that cannot be read, or is of another body.
    #[error(transparent)]
    Result(#[from] ResultError),
    /// Points or a fit that gait analysis cannot use.
    #[error(transparent)]
    GaitInput(#[from] GaitInputError),
    /// A body without a movement.
    #[error(transparent)]
    Movement(#[from] MovementError),
    /// A movement without gait.
    #[error(transparent)]
    Gait(#[from] GaitError),
    /// A standing pose that cannot be used.
    #[error(transparent)]
    Standing(#[from] StandingError),
    /// Corrected events that cannot be used.
    #[error(transparent)]
    Events(#[from] EventsError),
    /// A norm that cannot be made.
    #[error(transparent)]
    OwnNorm(#[from] OwnNormError),
    /// A norm that cannot be used.
    #[error(transparent)]
    Norm(#[from] NormError),
    /// A body that has no skin.
    #[error(transparent)]
    Skin(#[from] SkinError),
    /// A C3D that cannot be written.
    #[error(transparent)]
    C3d(#[from] C3dError),
    /// A BVH that cannot be written.
    #[error(transparent)]
    Bvh(#[from] BvhError),
    /// A glTF that cannot be written.
    #[error(transparent)]
    Glb(#[from] GlbError),
    /// A table that cannot be written.
    #[error("a table cannot be written: {0}")]
    Table(#[from] std::io::Error),
    /// JSON that cannot be written.
    #[error("result.json: {0}")]
    Json(#[from] serde_json::Error),
    /// A calibration that cannot be refined.
    #[error(transparent)]
    Calibrate(#[from] CalibrateError),
    /// Cameras that a person's motion does not place.
    #[error(transparent)]
    Lenses(#[from] LensError),
    /// A size of the world that cannot be used.
    #[error(transparent)]
    Size(#[from] SizeError),
    /// Clocks that cannot be found.
    #[error(transparent)]
    Sync(#[from] SyncError),
    /// A calibration that cannot be written in a format.
    #[error(transparent)]
    CalibrationFile(#[from] CalibrationWriteError),
    /// A session that cannot be read.
    #[error(transparent)]
    SessionFile(#[from] SessionFileError),
    /// A session that cannot be made.
    #[error(transparent)]
    Session(#[from] SessionError),
    /// The folder of a fit that does not name its recording.
    #[error("{}: recording.toml names no recording: expected the folder of a fit as it was written; or give the recording", path.display())]
    NoOrigin {
        /// The folder.
        path: PathBuf,
    },
    /// A fit that is not to be used: its verdict.
    #[error("{0}")]
    Unusable(String),
    /// A length that the body does not have.
    #[error("no length named {name:?}: the body {body} has {known}")]
    NoLength {
        /// The name that was asked for.
        name: String,
        /// The body model.
        body: String,
        /// The names there are.
        known: String,
    },
    /// An angle that gait analysis does not have, or not of this body.
    #[error("no angle named {name:?}: there are {known}")]
    NoAngle {
        /// The name that was asked for.
        name: String,
        /// The names there are.
        known: String,
    },
    /// No fitted frame is what was asked for.
    #[error(
        "--frames {range}: no fitted frame has such a number: the result has {first} to {last}"
    )]
    NotFitted {
        /// The range that was asked for.
        range: FrameRange,
        /// First fitted frame.
        first: usize,
        /// Last fitted frame.
        last: usize,
    },
    /// A frame that a simulation lacks.
    #[error(
        "frame {frame} was not fitted: expected all frames from the first to the last, so that their motion is known"
    )]
    FrameGap {
        /// The first that is lacking.
        frame: usize,
    },
    /// A mesh of no known format.
    #[error("--skin {}: expected a name that ends in .ply or .obj", path.display())]
    MeshFormat {
        /// As asked for.
        path: PathBuf,
    },
    /// Points where a fit is needed.
    #[error("{}: expected the folder of a finished fit, found points without a body", path.display())]
    NoFit {
        /// As asked for.
        path: PathBuf,
    },
    /// A body that the coordinates of OpenSim do not fit.
    #[error("--format {format}: the body {body} has no part named pelvis")]
    NoCoordinates {
        /// As asked for.
        format: &'static str,
        /// The model.
        body: String,
    },
}
