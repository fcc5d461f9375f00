//! Notes on a recording: odd, but not wrong.

use std::fmt;

use crate::pipeline::Frames;

/// A note for the user on a recording, in one line.
#[derive(Clone, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum Note {
    /// Keys of the manifest that are not used because there are masks.
    Ignored {
        /// The keys.
        keys: Vec<&'static str>,
    },
    /// A camera of the manifest without masks, while others have some.
    WithoutMasks {
        /// The camera.
        camera: String,
    },
    /// A folder of masks whose name is no calibrated camera's.
    Uncalibrated {
        /// Name of the folder.
        camera: String,
        /// The calibrated camera whose name is most like it.
        nearest: String,
    },
    /// Calibrated cameras for which there is no folder of masks.
    Unmasked {
        /// The cameras.
        cameras: Vec<String>,
    },
    /// Images whose names hold no number.
    Unnumbered {
        /// The camera.
        camera: String,
        /// How many.
        files: usize,
    },
    /// Masks that `offset_frames` moves before frame 0.
    BeforeFirst {
        /// The camera.
        camera: String,
        /// How many.
        files: usize,
    },
    /// No frame is seen by two cameras.
    NoCommonFrame,
    /// Point clouds without a number in their names.
    UnnumberedPoints {
        /// How many.
        files: usize,
    },
    /// Only some of the frames have points.
    PointsMissing {
        /// How many frames have points.
        with: usize,
        /// How many frames there are.
        frames: usize,
    },
    /// Point clouds without a usable point.
    PointsEmpty {
        /// The frames.
        frames: Frames,
    },
    /// Points that are not finite or have no positive spread.
    PointsUnusable {
        /// How many.
        points: usize,
        /// The frames that have them.
        frames: Frames,
    },
    /// Clouds of more points than are used.
    PointsThinned {
        /// The largest of them.
        most_points: usize,
        /// How many are used of each.
        used: usize,
        /// The frames.
        frames: Frames,
    },
}

impl fmt::Display for Note {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            // masks
            Self::Ignored { keys } => {
                write!(f, "{}: not used, because there are masks", keys.join(", "))
            }
            Self::WithoutMasks { camera } => {
                write!(f, "camera {camera}: no masks in the manifest: not used")
            }
            Self::Uncalibrated { camera, nearest } => write!(
                f,
                "masks/{camera}: no camera of this name is calibrated (did you mean {nearest}?): not used"
            ),
            Self::Unmasked { cameras } => {
                write!(f, "no masks for {}: not used", cameras.join(", "))
            }
            Self::Unnumbered { camera, files } => write!(
                f,
                "camera {camera}: {files} images without a frame number in their names: not used"
            ),
            Self::BeforeFirst { camera, files } => write!(
                f,
                "camera {camera}: offset_frames puts {files} masks before frame 0: not used"
            ),
            Self::NoCommonFrame => write!(
                f,
                "no frame has masks from two cameras: do the file numbers agree? offset_frames shifts them"
            ),

            // points
            Self::UnnumberedPoints { files } => write!(
                f,
                "points: {files} files without a frame number in their names: not used"
            ),
            Self::PointsMissing { with, frames } => {
                write!(f, "points: {with} of {frames} frames have points")
            }
            Self::PointsEmpty { frames } => {
                write!(f, "points: no usable points in frames {frames}")
            }
            Self::PointsUnusable { points, frames } => write!(
                f,
                "points: {points} points left out in frames {frames}: not finite, or a spread that is not positive"
            ),
            Self::PointsThinned {
                most_points,
                used,
                frames,
            } => write!(
                f,
                "points: up to {most_points} in a frame; thinned evenly to {used} in frames {frames}"
            ),
        }
    }
}
