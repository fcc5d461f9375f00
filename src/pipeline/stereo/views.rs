//! The pictures and masks of the cameras that are used.

use crate::camera::CameraId;
use crate::image::{Mask, Picture, luma};
use crate::pipeline::{MaskSource, PictureSource};
use crate::silhouette::FrameIndex;
use crate::stereo::StereoView;
use crate::stereo::tracking::FrameViews;

/// The cameras that are used, and what they show.
pub(super) struct StereoCameras<'a> {
    pub(super) pictures: &'a dyn PictureSource,
    pub(super) masks: Option<&'a dyn MaskSource>,
    /// The template's first.
    pub(super) ids: Vec<CameraId>,
}

impl StereoCameras<'_> {
    /// What the cameras show in a frame; why it is not measured, where a picture or the template's mask is missing.
    pub(super) fn views(
        &self,
        frame: FrameIndex,
        pictures: &[Option<Picture>],
    ) -> Result<FrameViews, String> {
        let mut frame_views = FrameViews { views: Vec::new(), masks: Vec::new() };
        for id in &self.ids {
            let picture = pictures.get(id.0).and_then(Option::as_ref);
            let (Some(picture), Some(camera)) = (picture, self.pictures.rig().camera(*id)) else {
                return Err("a camera has no picture".into());
            };
            let view = StereoView::undistorted(camera, &luma(picture));
            frame_views.views.push(view.map_err(|e| e.to_string())?);

            let mask = self.mask(&camera.name, frame)?;
            if mask.is_none() && self.is_masked_template(*id, &camera.name) {
                return Err(format!("camera {} has no mask of it", camera.name));
            }
            frame_views.masks.push(mask);
        }
        Ok(frame_views)
    }

    fn mask(&self, camera: &str, frame: FrameIndex) -> Result<Option<Mask>, String> {
        match self.masks {
            Some(masks) if masks.has_masks_of(camera) => masks.mask(camera, frame),
            _ => Ok(None),
        }
    }

    /// Whether a camera is the template's, and has masks: of a frame without one it says nothing of the person.
    fn is_masked_template(&self, id: CameraId, camera: &str) -> bool {
        let has_masks = self.masks.is_some_and(|masks| masks.has_masks_of(camera));
        has_masks && self.ids.first() == Some(&id)
    }
}
