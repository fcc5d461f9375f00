//! Why pictures could not be used.

use std::io;
use std::path::PathBuf;

/// Why the pictures of a recording could not be used, in one line that says what to mend.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum FootageError {
    /// No camera has images or a video.
    #[error(
        "{}: no pictures: expected videos/<camera>.* or images/<camera>/ beside the calibration, or images = … or video = … for each camera in sequence.toml{hint}",
        path.display()
    )]
    NoPictures {
        /// The recording.
        path: PathBuf,
        /// The videos that lie elsewhere, or nothing.
        hint: String,
    },
    /// A camera's pictures are missing from where the manifest says.
    #[error("camera {camera}: no {key} at {}", path.display())]
    Missing {
        /// The camera.
        camera: String,
        /// Of the manifest: images, video, background.
        key: &'static str,
        /// Where it should be.
        path: PathBuf,
    },
    /// Both images and a video.
    #[error("camera {camera}: both images and video are given: expected one of them")]
    Both {
        /// The camera.
        camera: String,
    },
    /// Two videos of one name.
    #[error(
        "camera {camera}: both {} and {} are its videos: expected one of them; remove one, or say in sequence.toml which it is (video = …)",
        first.display(), second.display()
    )]
    Two {
        /// The camera.
        camera: String,
        /// One.
        first: PathBuf,
        /// The other.
        second: PathBuf,
    },
    /// A video whose clock jumps back.
    #[error(
        "{}: the time stamps go backwards, from {from_s:.3} s to {to_s:.3} s at picture {picture} of {pictures}: expected one recording from beginning to end; write it anew (ffmpeg -fflags +genpts -i IN -c copy OUT), or cut it there",
        path.display()
    )]
    Backwards {
        /// The video.
        path: PathBuf,
        /// Before the jump.
        from_s: f64,
        /// After it.
        to_s: f64,
        /// The first picture after it, from 1.
        picture: usize,
        /// How many there are.
        pictures: usize,
    },
    /// Pictures of another size than the camera was calibrated for.
    #[error(
        "camera {camera}: {}: the pictures are {} × {} px, expected {} × {} px as calibrated",
        path.display(), found[0], found[1], expected[0], expected[1]
    )]
    Size {
        /// The camera.
        camera: String,
        /// The video or the first image.
        path: PathBuf,
        /// Width and height of the calibration.
        expected: [u32; 2],
        /// Width and height of the pictures.
        found: [u32; 2],
    },
    /// An image that cannot be read.
    #[error("{}: the image cannot be read: {reason}", path.display())]
    Image {
        /// The file.
        path: PathBuf,
        /// Why.
        reason: String,
    },
    /// A file that is no video, or an empty one.
    #[error("{}: no video in this file: {reason}", path.display())]
    NoVideo {
        /// The file.
        path: PathBuf,
        /// What `ffprobe` says.
        reason: String,
    },
    /// The program that decodes videos is missing.
    #[error(
        "{}: videos are read by the program ffmpeg, which is not installed: `apt install ffmpeg` (Debian, Ubuntu), `brew install ffmpeg` (macOS), `winget install ffmpeg` (Windows)",
        path.display()
    )]
    NoFfmpeg {
        /// The video.
        path: PathBuf,
    },
    /// The program that decodes videos cannot be started.
    #[error("{}: ffmpeg cannot be run: {source}", path.display())]
    Ffmpeg {
        /// The video.
        path: PathBuf,
        /// Why.
        source: io::Error,
    },
}
