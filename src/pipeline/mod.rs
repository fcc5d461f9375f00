//! The main job: from observations to shape, motion and confidence.
//!
//! | stage                               | where                              |
//! |-------------------------------------|------------------------------------|
//! | 1. do cameras and masks agree       | [`check_scene`]                    |
//! | 2. Algorithm 1                      | [`crate::inference::search`]       |
//! | 3. how far the keyframes agree      | [`ShapeConfidence`]                |
//! | 4. how well the body covers the masks | [`ViewQuality`], [`CameraQuality`] |
//! | 5. what a person should know of it  | [`Warning`]                        |

mod confidence;
mod fit;
mod options;
mod quality;
mod scene;
mod warning;

pub use confidence::{ShapeConfidence, rest_lengths_m};
pub use fit::{Fit, FitError, FittedFrame, TriedHypothesis, fit};
pub use options::{ConfidenceOptions, FitOptions};
pub use quality::{CameraQuality, ViewQuality, projected_ellipses};
pub use scene::{SceneFault, check_scene};
pub use warning::{Frames, Warning};
