//! Pictures of the fit over the masks: `<camera>/%06d.png`.

use std::path::{Path, PathBuf};

use rayon::prelude::*;

use super::png::{self, Effort};
use super::{OutError, file_name, make_folder, write_encoded};
use crate::body::{BodyModel, Posed};
use crate::camera::CameraId;
use crate::image::Picture;
use crate::io::recording::{ObservationFiles, RecordingError};
use crate::pipeline::{Fit, FittedFrame};
use crate::render::{Canvas, overlay};

/// Why an overlay could not be written.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum OverlayError {
    /// The mask under it cannot be read any more.
    #[error(transparent)]
    Mask(#[from] RecordingError),
    /// A file or folder that cannot be written.
    #[error(transparent)]
    Out(#[from] OutError),
}

/// Writes a picture for each mask of each fitted frame into a folder; `done` is called after each.
///
/// # Errors
/// [`OverlayError`] for the first that fails.
pub fn write(
    folder: &Path,
    recording: &ObservationFiles,
    model: &BodyModel,
    fit: &Fit,
    done: &(dyn Fn() + Sync),
) -> Result<(), OverlayError> {
    let cameras: Vec<(CameraId, PathBuf)> = recording
        .rig
        .iter()
        .map(|(id, camera)| (id, folder.join(file_name(&camera.name))))
        .collect();

    for (_, path) in &cameras {
        make_folder(path)?;
    }

    let all: Vec<_> = fit
        .frames
        .iter()
        .flat_map(|frame| cameras.iter().map(move |(id, path)| (frame, *id, path)))
        .collect();

    all.into_par_iter().try_for_each(|(frame, id, folder)| {
        if let Some(canvas) = picture(recording, model, fit, frame, id)? {
            let path = folder.join(format!("{:06}.png", frame.frame.0));
            write_picture(canvas.pixels(), &path)?;
        }
        done();
        Ok(())
    })
}

/// `None` where the camera has no mask of the frame.
fn picture(
    recording: &ObservationFiles,
    model: &BodyModel,
    fit: &Fit,
    frame: &FittedFrame,
    id: CameraId,
) -> Result<Option<Canvas>, RecordingError> {
    let mask = recording.load_mask(id, frame.frame)?;
    let body = Posed::new(model, &fit.shape, &frame.fit.motion);
    let over = |mask| Some(overlay(fit.rig.camera(id)?, &mask, &body));
    Ok(mask.and_then(over))
}

/// Writes a picture as PNG.
///
/// # Errors
/// [`OutError::Write`].
pub fn write_picture(picture: &Picture, path: &Path) -> Result<(), OutError> {
    write_encoded(path, png::encode_picture(picture, Effort::Quick))
}
