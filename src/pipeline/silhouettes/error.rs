//! Why no silhouettes can be found.

use crate::pipeline::FitError;
use crate::stereo::NoneSideBySide;

/// Why no silhouettes can be found before clutter.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum SilhouetteError {
    /// No camera sees depth.
    #[error("{0}; give a fitted body to begin with: --fit DIR")]
    NoDepth(#[from] NoneSideBySide),
    /// Nothing that moves can be fitted, or the body has no metaballs.
    #[error(transparent)]
    Fit(#[from] FitError),
}
