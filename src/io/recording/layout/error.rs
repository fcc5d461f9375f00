//! Why the files of a recording could not be found.

use std::io;
use std::path::PathBuf;

use crate::io::frame_rate;

/// Why the files of a recording could not be found, in one line that says what to mend.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum LayoutError {
    /// Neither a folder nor a manifest.
    #[error("{}: no such folder or file", path.display())]
    NotFound {
        /// As given.
        path: PathBuf,
    },
    /// A folder that cannot be listed.
    #[error("{}: the folder cannot be read: {source}", path.display())]
    Folder {
        /// The folder.
        path: PathBuf,
        /// Why.
        source: io::Error,
    },
    /// No frame rate anywhere.
    #[error(
        "{}: the frame rate is not known: give --fps, or fps = … in sequence.toml", path.display()
    )]
    NoFps {
        /// The recording.
        path: PathBuf,
    },
    /// A given frame rate that no camera has.
    #[error("frame rate {fps}: expected {}", frame_rate::EXPECTED)]
    Fps {
        /// As given.
        fps: f64,
    },
    /// A pattern that is none.
    #[error("{key} = {pattern:?}: expected {expected}")]
    Pattern {
        /// Whose: `camera left: masks` or `points`.
        key: String,
        /// As written.
        pattern: String,
        /// What a pattern looks like.
        expected: &'static str,
    },
    /// Two masks of one camera, or two clouds, of one frame.
    #[error("{key}: {} and {} are both number {number}", first.display(), second.display())]
    DuplicateFrame {
        /// Whose: `camera left: masks` or `points`.
        key: String,
        /// The number in both names.
        number: u64,
        /// One file.
        first: PathBuf,
        /// The other.
        second: PathBuf,
    },
}
