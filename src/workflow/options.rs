//! How a recording is fitted.

use crate::pipeline::stereo::StereoMethod;
use crate::pipeline::{EstimateOptions, FrameRange, ObservationOptions};

/// How a recording is fitted. The default fits every frame to the masks, or to masks that are made of the pictures.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct FitOptions {
    /// A shipped body model or the path of one. `None`: that of the recording, or `human-ellipsoids`, or where there are
    /// points `human-metaballs`.
    pub body: Option<String>,
    /// The frames that are fitted (default all).
    pub frames: FrameRange,
    /// How silhouettes are found where there are pictures. `None`: the masks; without masks by [`SilhouetteSource::Joint`] if
    /// cameras stand side by side and no picture of the empty scene is given, else by [`SilhouetteSource::Background`].
    pub silhouettes: Option<SilhouetteSource>,
    /// How points are measured by cameras that stand side by side, to be fitted to as well. `None`: they are not.
    pub stereo: Option<StereoMethod>,
    /// From masks and points to what is fitted to.
    pub observations: ObservationOptions,
    /// The estimate.
    pub estimate: EstimateOptions,
}

/// Where silhouettes come from.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum SilhouetteSource {
    /// Masks: given, or cut out by learning the background.
    Background,
    /// Contours that the body predicts, by depth and active contours (PF02, §4.3), and points with them.
    Joint,
}
