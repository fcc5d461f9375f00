//! Notes on pictures: odd, but not wrong.

use std::fmt;
use std::path::PathBuf;

use crate::pipeline::{Frames, counted};

/// A note for the user on the pictures of a recording, in one line.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub enum FootageNote {
    /// A camera of the manifest without pictures, while others have some.
    Without {
        /// The camera.
        camera: String,
    },
    /// A camera whose video holds no pictures, while others have some.
    Unusable {
        /// The camera.
        camera: String,
        /// What is wrong with the file.
        reason: String,
    },
    /// Pictures whose name is no calibrated camera's.
    Uncalibrated {
        /// The name.
        camera: String,
    },
    /// Images whose names hold no number.
    Unnumbered {
        /// The camera.
        camera: String,
        /// How many.
        files: usize,
    },
    /// Another rate than that of the recording.
    Rate {
        /// The camera.
        camera: String,
        /// Of the video.
        video_hz: f64,
        /// Of the recording.
        fps: f64,
    },
    /// Cameras that have different numbers of pictures.
    Lengths {
        /// Camera and number of pictures.
        cameras: Vec<(String, usize)>,
    },
    /// Pictures that cannot be decoded.
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
    Damaged {
        /// Camera or file.
        whose: String,
        /// How often the decoder complained.
        times: usize,
        /// What it said first.
        reason: String,
    },
    /// Pictures of another size than the camera's.
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
    Stopped {
        /// The camera.
        whose: String,
        /// Why.
        reason: String,
        /// The file.
        path: PathBuf,
    },
}

impl fmt::Display for FootageNote {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Without { camera } => {
                write!(
                    f,
                    "camera {camera}: no images or video in the manifest: not used"
                )
            }
            Self::Unusable { camera, reason } => {
                write!(f, "camera {camera}: {reason}: not used")
            }
            Self::Uncalibrated { camera } => {
                write!(
                    f,
                    "pictures of {camera}: no camera of this name is calibrated: not used"
                )
            }
            Self::Unnumbered { camera, files } => write!(
                f,
                "camera {camera}: {files} images without a frame number in their names: not used"
            ),
            Self::Rate {
                camera,
                video_hz,
                fps,
            } => write!(
                f,
                "camera {camera}: the video states {video_hz:.3} frames per second, the recording {fps:.3}: the recording's rate is used"
            ),
            Self::Lengths { cameras } => {
                let all = cameras.iter().map(|(name, n)| format!("{name} {n}"));
                let all: Vec<_> = all.collect();
                write!(
                    f,
                    "the cameras have different numbers of pictures: {}",
                    all.join(", ")
                )
            }

            // what was found while decoding
            Self::Undecodable {
                whose,
                frames,
                of,
                reason,
            } => {
                let (lost, reason) = (frames.0.len(), reason.trim_end_matches('.'));
                write!(
                    f,
                    "{whose}: {lost} of {of} pictures cannot be decoded ({frames}): {reason}"
                )
            }
            Self::Damaged {
                whose,
                times,
                reason,
            } => write!(
                f,
                "{whose}: damaged ({}, the first: {reason}): the pictures are used as decoded",
                counted(*times, "decoder error")
            ),
            Self::WrongSize {
                whose,
                pictures,
                found: [width, height],
                expected: [columns, rows],
            } => write!(
                f,
                "{whose}: {} of another size ({width} × {height} px, expected {columns} × {rows} px): not used",
                counted(*pictures, "picture")
            ),
            Self::Stopped {
                whose,
                path,
                reason,
            } => {
                write!(f, "{whose}: {}: {reason}", path.display())
            }
        }
    }
}
