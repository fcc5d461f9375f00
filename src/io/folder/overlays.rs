//! Pictures of the fit over the masks, or without any over the detections of joints: `<camera>/%06d.png`, and as a film `<camera>.mp4`.

use std::path::{Path, PathBuf};

use nalgebra::Vector2;
use rayon::prelude::*;

use super::film;
use super::png::{self, Effort};
use super::{OutError, file_name, make_folder, write_encoded};
use crate::body::{Motion, Posed};
use crate::camera::{Camera, CameraId};
use crate::image::{Mask, Picture};
use crate::io::recording::{ObservationFiles, RecordingError};
use crate::pipeline::{Fit, FittedFrame};
use crate::render::{Canvas, Pen, overlay};
use crate::silhouette::Keypoint;

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

/// Writes a picture for each mask of each fitted frame into a folder; `done` is called after each. Then writes each camera's as
/// a film, and gives the reason where there is none.
///
/// # Errors
/// [`OverlayError`] for the first that fails.
pub fn write(
    folder: &Path,
    recording: &ObservationFiles,
    fit: &Fit,
    done: &(dyn Fn() + Sync),
) -> Result<Option<String>, OverlayError> {
    let cameras: Vec<(CameraId, PathBuf)> = recording
        .rig
        .iter()
        .map(|(id, camera)| (id, folder.join(file_name(&camera.name))))
        .collect();

    for (_, path) in &cameras {
        make_folder(path)?;
    }

    let all: Vec<_> = (0..fit.frames.len())
        .flat_map(|i| cameras.iter().map(move |(id, path)| (i, *id, path)))
        .collect();

    let shown = fit.shown(recording.fps);
    all.into_par_iter().try_for_each(|(i, id, folder)| {
        if let Some(canvas) = picture(recording, fit, &shown(i, id), (i, id))? {
            let path = folder.join(format!("{:06}.png", fit.frames[i].frame.0));
            write_picture(canvas.pixels(), &path)?;
        }
        done();
        Ok::<(), OverlayError>(())
    })?;

    let films = cameras.par_iter().map(|(_, folder)| {
        let picture = |frame: &FittedFrame| {
            let path = folder.join(format!("{:06}.png", frame.frame.0));
            path.is_file().then_some(path)
        };
        let pictures: Vec<Option<PathBuf>> = fit.frames.iter().map(picture).collect();
        // a camera's name may hold a point, which is no extension
        let name = folder.file_name().unwrap_or_default().to_string_lossy();
        film::write(&folder.with_file_name(format!("{name}.mp4")), &pictures, recording.fps)
    });
    let films: Vec<Result<(), String>> = films.collect();
    Ok(films.into_iter().find_map(Result::err))
}

/// The body over the mask of a frame and a camera, or over the detections of a recording without masks; `None` where there is neither.
fn picture(
    recording: &ObservationFiles,
    fit: &Fit,
    shown: &Motion,
    (i, id): (usize, CameraId),
) -> Result<Option<Canvas>, RecordingError> {
    let Some(camera) = fit.rig.camera(id) else { return Ok(None) };
    let body = Posed::new(&fit.model, &fit.shape, shown);
    let frame = fit.frames[i].frame;
    if recording.has_masks() {
        let mask = recording.load_mask(id, frame)?;
        return Ok(mask.map(|mask| overlay(camera, &mask, &body)));
    }

    let people = recording.people(id, frame)?;
    let nothing = Mask::from_fn(camera.width_px as usize, camera.height_px as usize, |_, _| false);
    let mut canvas = overlay(camera, &nothing, &body);
    draw_keypoints(&mut canvas, camera, people.iter().flatten());
    Ok((!people.is_empty()).then_some(canvas))
}

/// Half the size of the cross on a keypoint, over the picture's larger side.
const CROSS: f64 = 0.005;
const KEYPOINT: [u8; 3] = [255, 214, 0];

/// A cross on each keypoint, where the recorded picture shows it.
fn draw_keypoints<'a>(
    canvas: &mut Canvas,
    camera: &Camera,
    keypoints: impl Iterator<Item = &'a Keypoint>,
) {
    let half = CROSS * f64::from(camera.width_px.max(camera.height_px));
    let cross = |keypoint: &Keypoint| {
        let at = camera.distort(&keypoint.pixel);
        [Vector2::new(half, half), Vector2::new(half, -half)].map(|arm| [at - arm, at + arm])
    };
    let segments: Vec<_> = keypoints.flat_map(cross).collect();
    canvas.draw(&segments, Pen { color: KEYPOINT, opacity: 1.0, width_px: 0.4 * half });
}

/// Writes a picture as PNG.
///
/// # Errors
/// [`OutError::Write`].
pub fn write_picture(picture: &Picture, path: &Path) -> Result<(), OutError> {
    write_encoded(path, png::encode_picture(picture, Effort::Quick))
}
