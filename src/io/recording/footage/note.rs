//! Notes on pictures: odd, but not wrong.

use std::path::PathBuf;

use crate::io::recording::CalibrationNote;
use crate::pipeline::{Frames, counted};

/// A note for the user on the pictures of a recording, in one line.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum FootageNote {
    /// Where the cameras were calibrated.
    #[error(transparent)]
    Calibration(#[from] CalibrationNote),
    /// A camera of the manifest without pictures, while others have some.
    #[error("camera {camera}: no images or video in the manifest: not used")]
    Without {
        /// The camera.
        camera: String,
    },
    /// A camera whose video holds no pictures, while others have some.
    #[error("camera {camera}: {reason}: not used")]
    Unusable {
        /// The camera.
        camera: String,
        /// What is wrong with the file.
        reason: String,
    },
    /// Pictures whose name is no calibrated camera's.
    #[error("pictures of {camera}: no camera of this name is calibrated: not used")]
    Uncalibrated {
        /// The name.
        camera: String,
    },
    /// Images whose names hold no number.
    #[error("camera {camera}: {files} images without a frame number in their names: not used")]
    Unnumbered {
        /// The camera.
        camera: String,
        /// How many.
        files: usize,
    },
    /// Another rate than that of the recording.
    #[error(
        "camera {camera}: the video states {video_hz:.3} frames per second, the recording {fps:.3}: the recording's rate is used"
    )]
    Rate {
        /// The camera.
        camera: String,
        /// Of the video.
        video_hz: f64,
        /// Of the recording.
        fps: f64,
    },
    /// Cameras that have different numbers of pictures.
    #[error("the cameras have different numbers of pictures: {}", listed(cameras))]
    Lengths {
        /// Camera and number of pictures.
        cameras: Vec<(String, usize)>,
    },
    /// Pictures that cannot be decoded.
    #[error(
        "{whose}: {} of {of} pictures cannot be decoded ({frames}): {}",
        frames.0.len(), reason.trim_end_matches('.')
    )]
    Undecodable {
        /// Camera or file.
        whose: String,
        /// The frames.
        frames: Frames,
        /// How many there should be.
        of: usize,
        /// What the decoder said.
        reason: String,
    },
    /// Damage that the decoder covered up.
    #[error(
        "{whose}: damaged ({}, the first: {reason}): the pictures are used as decoded",
        counted(*times, "decoder error")
    )]
    Damaged {
        /// Camera or file.
        whose: String,
        /// How often the decoder complained.
        times: usize,
        /// What it said first.
        reason: String,
    },
    /// Pictures of another size than the camera's.
    #[error(
        "{whose}: {} of another size ({} × {} px, expected {} × {} px): not used",
        counted(*pictures, "picture"), found[0], found[1], expected[0], expected[1]
    )]
    WrongSize {
        /// Camera or file.
        whose: String,
        /// How many.
        pictures: usize,
        /// Width and height of the first.
        found: [usize; 2],
        /// Width and height of the camera.
        expected: [usize; 2],
    },
    /// The decoder cannot be run any more.
    #[error("{whose}: {}: {reason}", path.display())]
    Stopped {
        /// The camera.
        whose: String,
        /// Why.
        reason: String,
        /// The file.
        path: PathBuf,
    },
}

fn listed(cameras: &[(String, usize)]) -> String {
    let all: Vec<_> = cameras.iter().map(|(name, n)| format!("{name} {n}")).collect();
    all.join(", ")
}
