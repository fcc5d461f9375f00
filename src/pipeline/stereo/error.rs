//! Why no surface could be measured.

use crate::stereo::matching::MatchError;
use crate::stereo::{DepthError, NoneSideBySide};

/// Why no surface could be measured, in one line that says what to mend.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum StereoError {
    /// No cameras to choose from.
    #[error(transparent)]
    NoneSideBySide(#[from] NoneSideBySide),
    /// A camera that was asked for and is not there.
    #[error("--cameras {camera}: no such camera: the recording has {known}")]
    NoCamera {
        /// As asked for.
        camera: String,
        /// Those that there are.
        known: String,
    },
    /// One camera, or one twice.
    #[error("--cameras {cameras}: expected two different cameras or more")]
    FewCameras {
        /// As asked for.
        cameras: String,
    },
    /// A pair that cannot be correlated.
    #[error(transparent)]
    Depth(#[from] DepthError),
    /// Images that cannot be matched.
    #[error(transparent)]
    Match(#[from] MatchError),
}
