//! What the user should know of a segmentation.

use super::{MaskQuality, SegmentedFrame, Segmenter};
use crate::camera::{CameraId, Rig};
use crate::pipeline::{Frames, counted};

/// Below this share of the person's place an unknown background does no harm.
const NOTEWORTHY: f64 = 0.01;

/// The notes of a run, in one line each.
pub(super) struct Notes<'a> {
    rig: &'a Rig,
    /// Of each camera, the frames of which it has a picture and no mask.
    refused: Vec<Frames>,
    pub(super) lines: Vec<String>,
}

impl<'a> Notes<'a> {
    pub(super) fn new(rig: &'a Rig) -> Self {
        Self { rig, refused: vec![Frames::default(); rig.cameras.len()], lines: Vec::new() }
    }

    /// Counts the pictures of a frame that became no masks.
    pub(super) fn count_refused(&mut self, frame: &SegmentedFrame) {
        let views = frame.pictures.iter().zip(&frame.cuts);
        for (refused, (picture, cut)) in self.refused.iter_mut().zip(views) {
            if picture.is_some() && cut.is_none() {
                refused.0.push(frame.frame);
            }
        }
    }

    /// Which pictures became no masks, and in whose pictures nobody is.
    pub(super) fn add_masks(&mut self, masks: &[MaskQuality]) {
        for (name, frames) in self.rig.names().zip(&self.refused) {
            if !frames.0.is_empty() {
                let pictures = counted(frames.0.len(), "picture");
                self.lines.push(format!(
                    "camera {name}: {pictures} ({frames}) with more than half of it other than the empty scene, over-exposed or moved: no masks of that"
                ));
            }
        }

        for (id, camera) in self.rig.iter() {
            let own = || masks.iter().filter(|mask| mask.camera == id);
            let pictures = own().count();
            if pictures > 0 && own().all(|mask| mask.quality.area_px == 0) {
                let name = &camera.name;
                let nobody = format!("camera {name}: nobody in any of its {pictures} pictures");
                self.lines.push(nobody);
            }
        }
    }

    /// Whose background is not known behind the person, and whether the cameras agree.
    pub(super) fn add_background(&mut self, segmenter: &Segmenter) {
        for (camera, share) in segmenter.unseen_background().into_iter().enumerate() {
            let camera = self.rig.camera(CameraId(camera));
            if let Some(camera) = camera.filter(|_| share > NOTEWORTHY) {
                self.lines.push(format!(
                    "camera {}: the background is never seen behind {:.0} % of the person: a picture of the empty scene (background = …) would help",
                    camera.name,
                    100.0 * share
                ));
            }
        }

        if !segmenter.is_consistent() && self.rig.cameras.len() > 1 {
            let alone = "the cameras do not agree on where the person is: each is segmented by itself; check the calibration";
            self.lines.push(alone.into());
        }
    }
}
