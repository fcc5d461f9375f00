//! What one frame shows.

use std::fmt;

use serde::{Deserialize, Serialize};

use super::{Detection, Rejected, Silhouette};
use crate::camera::CameraId;
use crate::stereo::{CloudPoint, LeftOut};

/// Number of a frame of the recording: its time is index/fps. Frames may be missing between two indices.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize)]
pub struct FrameIndex(pub usize);

impl fmt::Display for FrameIndex {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "frame {}", self.0)
    }
}

/// The silhouettes and detections of one frame, at most one for each camera, in the order of the rig, and its points in space.
#[derive(Clone, Debug)]
pub struct FrameObservations {
    /// Which frame.
    pub frame: FrameIndex,
    /// The silhouettes of the cameras that have a usable mask.
    pub views: Vec<(CameraId, Silhouette)>,
    /// The cameras whose mask was read but shows no silhouette, and why.
    pub rejected: Vec<(CameraId, Rejected)>,
    /// Where other programs see the person's joints, in the cameras in which they see the person.
    pub detections: Vec<(CameraId, Detection)>,
    /// Points on the surface; empty where there are none.
    pub points: Vec<CloudPoint>,
    /// How many points their source held besides.
    pub points_left_out: LeftOut,
}

impl FrameObservations {
    /// A frame of which nothing is known yet.
    pub fn nothing(frame: FrameIndex) -> Self {
        Self {
            frame,
            views: Vec::new(),
            rejected: Vec::new(),
            detections: Vec::new(),
            points: Vec::new(),
            points_left_out: LeftOut::default(),
        }
    }

    /// With other silhouettes in place of these; `None` leaves a camera out.
    #[must_use]
    pub fn with_views(&self, of: impl Fn(CameraId, &Silhouette) -> Option<Silhouette>) -> Self {
        let views = self.views.iter().filter_map(|(id, shown)| Some((*id, of(*id, shown)?)));
        Self {
            frame: self.frame,
            views: views.collect(),
            rejected: self.rejected.clone(),
            detections: self.detections.clone(),
            points: self.points.clone(),
            points_left_out: self.points_left_out,
        }
    }

    /// Whether anything was seen of the body: a silhouette, points, or a detection.
    pub fn is_observed(&self) -> bool {
        !(self.views.is_empty() && self.points.is_empty() && self.detections.is_empty())
    }

    /// Whether a camera shows something of the body here.
    pub fn is_shown_by(&self, camera: CameraId) -> bool {
        self.views.iter().any(|(id, _)| *id == camera)
            || self.detections.iter().any(|(id, _)| *id == camera)
    }

    /// Without what a camera shows.
    #[must_use]
    pub fn without(&self, camera: CameraId) -> Self {
        let mut others = self.clone();
        others.views.retain(|(id, _)| *id != camera);
        others.detections.retain(|(id, _)| *id != camera);
        others
    }

    /// With what a camera shows in another frame.
    #[must_use]
    pub fn with(&self, camera: CameraId, other: &Self) -> Self {
        let mut both = self.without(camera);
        both.views.extend(other.views.iter().filter(|(id, _)| *id == camera).cloned());
        both.detections.extend(other.detections.iter().filter(|(id, _)| *id == camera).cloned());
        both.views.sort_by_key(|(id, _)| *id);
        both.detections.sort_by_key(|(id, _)| *id);
        both
    }
}

/// Frames in which what a camera shows from a frame on belongs to so many frames later; negative: earlier.
pub fn numbered_anew(
    frames: &[FrameObservations],
    camera: CameraId,
    from: FrameIndex,
    later: isize,
) -> Vec<FrameObservations> {
    let shown = |number: usize| {
        let position = frames.binary_search_by_key(&number, |frame| frame.frame.0).ok()?;
        Some(&frames[position])
    };
    let anew = |frame: &FrameObservations| {
        if frame.frame < from {
            return frame.clone();
        }
        let number = frame.frame.0.checked_add_signed(-later).filter(|number| *number >= from.0);
        match number.and_then(shown) {
            Some(own) => frame.with(camera, own),
            None => frame.without(camera),
        }
    };
    frames.iter().map(anew).collect()
}
