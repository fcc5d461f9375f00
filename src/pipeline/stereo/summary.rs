//! What was measured in all frames.

use super::{StereoError, StereoOptions, SurfaceFrame};
use crate::pipeline::{MaskSource, PictureSource, counted};
use crate::silhouette::FrameIndex;

/// What was measured in all frames.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct SurfaceSummary {
    /// Frames that have pictures.
    pub frames: usize,
    /// Points in all of them.
    pub points: usize,
    /// Trajectories; `None` where points were not followed.
    pub trajectories: Option<usize>,
    /// What the user should know.
    pub notes: Vec<String>,
    without_points: usize,
    first_without: Option<(FrameIndex, String)>,
}

impl SurfaceSummary {
    pub(super) fn new(options: &StereoOptions) -> Self {
        Self { trajectories: options.tracks.then_some(0), ..Self::default() }
    }

    pub(super) fn count(&mut self, frame: &SurfaceFrame) {
        let points = frame.points().len();
        self.frames += 1;
        self.points += points;
        if points == 0 {
            self.without_points += 1;
            let reason = || (frame.frame, frame.reason.clone());
            self.first_without.get_or_insert_with(reason);
        }

        let tracks = frame.ended_tracks.iter();
        let ended: usize = tracks.map(|tracks| tracks.trajectories.len()).sum();
        self.trajectories = self.trajectories.map(|before| before + ended);
    }

    /// Puts what is odd about the points before what is odd about the pictures.
    pub(super) fn finish(&mut self, of_pictures: Vec<String>) {
        self.notes.extend(self.without_points());
        self.notes.extend(of_pictures);
    }

    fn without_points(&self) -> Option<String> {
        let (frame, reason) = self.first_without.as_ref()?;
        let count = counted(self.without_points, "frame");
        Some(format!("{count} without points, frame {} first: {reason}", frame.0))
    }
}

/// That not the person alone is measured, where masks are lacking: all of them, or those of the template's camera.
///
/// # Errors
/// [`StereoError`] for cameras that there are not.
pub fn unmasked_note(
    pictures: &dyn PictureSource,
    masks: Option<&dyn MaskSource>,
    options: &StereoOptions,
) -> Result<Option<String>, StereoError> {
    let cameras = options.choose_cameras(pictures.rig())?;
    let Some(masks) = masks else {
        let all = "no masks: everything that the cameras show is measured, not the person alone";
        return Ok(Some(all.into()));
    };
    let template = cameras.first().and_then(|id| pictures.rig().camera(*id));
    let bare = template.filter(|camera| !masks.has_masks_of(&camera.name));
    Ok(bare.map(|camera| {
        let name = &camera.name;
        format!("camera {name}: no masks: everything that it shows is measured")
    }))
}
