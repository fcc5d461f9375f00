//! The main job: from observations to shape, motion and confidence.
//!
//! | stage                               | where                              |
//! |-------------------------------------|------------------------------------|
//! | 1. do cameras and masks agree       | [`check_scene`]                    |
//! | 2. Algorithm 1                      | [`crate::inference::search`]       |
//! | 3. the joint optimum                | [`crate::inference::joint`]        |
//! | 4. how far the keyframes agree      | [`ShapeConfidence`]                |
//! | 5. how well the body covers the masks | [`ViewQuality`], [`CameraQuality`] |
//! | 6. what a person should know of it  | [`Warning`]                        |

mod confidence;
mod fit;
mod measures;
mod options;
mod overlap;
mod quality;
mod scene;
mod uncertainty;
mod warning;

pub use confidence::{ShapeConfidence, rest_lengths_m};
pub use fit::{Fit, FitError, FittedFrame, TriedHypothesis, fit};
pub use options::{ConfidenceOptions, FitOptions};
pub use overlap::projected_ellipses;
pub use quality::{CameraQuality, ViewQuality, ViewResiduals};
pub use scene::{SceneFault, check_scene};
pub use uncertainty::ShapeUncertainty;
pub use warning::{Frames, Warning};
