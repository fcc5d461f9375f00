//! Why a recording could not be used.

use std::io;
use std::path::PathBuf;

use super::footage::FootageError;
use super::{MaskFault, ScaleFault};
use crate::io::calibration::CalibrationError;
use crate::io::points::CloudError;
use crate::io::recording::layout::LayoutError;
use crate::io::recording::manifest::ManifestError;
use crate::silhouette::FrameIndex;

/// Why a recording could not be used, in one line that says what to mend.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum RecordingError {
    /// The files are not where or what they should be.
    #[error(transparent)]
    Layout(#[from] LayoutError),
    /// The manifest is at fault.
    #[error(transparent)]
    Manifest(#[from] ManifestError),
    /// The calibration is at fault.
    #[error(transparent)]
    Calibration(#[from] CalibrationError),
    /// The pictures are at fault.
    #[error(transparent)]
    Footage(#[from] FootageError),
    /// No camera has masks.
    #[error(
        "{}: no masks and no pictures: expected masks/<camera>/, videos/<camera>.* or images/<camera>/ beside the calibration, or masks, video or images = … for each camera in sequence.toml",
        path.display()
    )]
    NoMasks {
        /// The recording.
        path: PathBuf,
    },
    /// A camera's masks were promised and are not there.
    #[error("camera {camera}: no mask at {}", pattern.display())]
    MissingMasks {
        /// The camera.
        camera: String,
        /// Where they should be.
        pattern: PathBuf,
    },
    /// A single camera.
    #[error(
        "{}: only one camera ({camera}) has masks: one camera cannot tell size from distance; expected two or more",
        path.display()
    )]
    OneCamera {
        /// The recording.
        path: PathBuf,
        /// The camera.
        camera: String,
    },
    /// A mask that cannot be used.
    #[error("{}: camera {camera}, {frame}: {fault}", path.display())]
    Mask {
        /// The file.
        path: PathBuf,
        /// The camera.
        camera: String,
        /// The frame.
        frame: FrameIndex,
        /// Why.
        fault: Box<MaskFault>,
    },
    /// Point clouds were promised and are not there.
    #[error("points: no point cloud (.ply, .xyz, .txt, .csv) at {}", pattern.display())]
    MissingPoints {
        /// Where they should be.
        pattern: PathBuf,
    },
    /// A point cloud that cannot be used.
    #[error("{frame}: {source}")]
    Cloud {
        /// The frame.
        frame: FrameIndex,
        /// Why, with the file.
        source: Box<CloudError>,
    },
    /// A point cloud of another size than the cameras' view.
    #[error("{}: {frame}: {fault}", path.display())]
    PointsScale {
        /// The file.
        path: PathBuf,
        /// The frame.
        frame: FrameIndex,
        /// How the sizes differ.
        fault: ScaleFault,
    },
    /// An input that cannot be read for its checksum.
    #[error("{}: cannot be read: {source}", path.display())]
    Checksum {
        /// The file.
        path: PathBuf,
        /// Why.
        source: io::Error,
    },
    /// Another recording than the one that a result was fitted to.
    #[error(
        "{}: this is not the recording of the result: {reason}; give the one that was fitted, or fit this one",
        path.display()
    )]
    Another {
        /// The recording.
        path: PathBuf,
        /// What differs.
        reason: String,
    },
    /// A frame was asked for that the recording does not have.
    #[error("frame at position {position} of a recording of {count}")]
    NoFrame {
        /// Position asked for, from 0.
        position: usize,
        /// Number of frames.
        count: usize,
    },
}
