//! What can be wrong with a camera.

use super::reading::Flip;
use crate::camera::CameraId;

/// What is wrong with a camera or two.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum CameraFault {
    /// All pictures are flipped.
    AllFlipped(Flip),
    /// The pictures of one camera are flipped.
    Flipped(CameraId, Flip),
    /// The pictures of two cameras are exchanged.
    Exchanged(CameraId, CameraId),
    /// A camera shows the person so many frames late; negative: early.
    Late(CameraId, isize),
    /// The focal lengths of all cameras are so many times the calibrated ones.
    AllZoomed(f64),
    /// The focal length of a camera is so many times the calibrated one.
    Zoomed(CameraId, f64),
    /// A camera shows the person elsewhere than the others do.
    Elsewhere {
        camera: CameraId,
        /// By how much its outlines miss the others', m.
        miss_m: f64,
    },
}

impl CameraFault {
    pub(super) fn is_of_lens(&self) -> bool {
        matches!(self, Self::AllZoomed(_) | Self::Zoomed(..))
    }

    /// The camera, of faults of one.
    pub(super) fn camera(self) -> Option<usize> {
        match self {
            Self::Flipped(id, _)
            | Self::Late(id, _)
            | Self::Zoomed(id, _)
            | Self::Elsewhere { camera: id, .. } => Some(id.0),
            Self::AllFlipped(_) | Self::AllZoomed(_) | Self::Exchanged(..) => None,
        }
    }
}
