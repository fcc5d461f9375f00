//! What a recording hands to the verbs of the pipeline: pictures and masks, from disk or from anywhere else.

use std::ops::RangeInclusive;

use crate::camera::{CameraId, Rig};
use crate::image::{Mask, Picture};
use crate::silhouette::FrameIndex;

/// The pictures of one frame, a place for each camera of the rig; `None` where a camera has none.
pub type FramePictures = (FrameIndex, Vec<Option<Picture>>);

/// The pictures of calibrated cameras, frame by frame.
pub trait PictureSource: Sync {
    /// The cameras.
    fn rig(&self) -> &Rig;

    /// Frames per second.
    fn fps(&self) -> f64;

    /// The frames of which at least one camera should have a picture, ascending.
    fn frames(&self) -> Vec<FrameIndex>;

    /// The pictures of the frames of these numbers, both included, ascending.
    fn pictures(&self, frames: RangeInclusive<usize>)
    -> Box<dyn PictureStream<FramePictures> + '_>;

    /// The pictures of a camera's empty scene; none if there are none.
    fn empty_scene(&self, camera: CameraId) -> Box<dyn PictureStream<Picture> + '_>;
}

/// Pictures that are decoded while they are taken.
pub trait PictureStream<T>: Iterator<Item = T> {
    /// What could not be read, in one line each; complete when all pictures have been taken.
    fn notes(&self) -> Vec<String>;
}

/// Masks of the person, camera by camera and frame by frame.
pub trait MaskSource: Sync {
    /// Whether the camera of this name has masks.
    fn has_masks_of(&self, camera: &str) -> bool;

    /// The mask of the camera of this name in a frame; `None` if it is missing.
    ///
    /// # Errors
    /// One line for a mask that cannot be read.
    fn mask(&self, camera: &str, frame: FrameIndex) -> Result<Option<Mask>, String>;
}
