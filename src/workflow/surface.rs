//! Points of the surface, measured in a recording's pictures, as files.

use std::path::Path;

use super::Error;
use crate::io::folder::OutFolder;
use crate::io::folder::stereo::{StereoExtras, StereoFolder};
use crate::io::recording::footage::Footage;
use crate::io::recording::{Note, ObservationFiles, Recording, RecordingError};
use crate::pipeline::stereo::{StereoOptions, SurfaceSummary, measure_surface, unmasked_note};
use crate::pipeline::{FrameRange, MaskSource, Progress};
use crate::silhouette::FrameIndex;

/// How the points of a recording are measured and written.
#[derive(Debug, Clone)]
pub struct SurfaceFiles<'a> {
    /// Where they are written to.
    pub folder: &'a Path,
    /// Which frames.
    pub frames: FrameRange,
    /// How points are found.
    pub options: StereoOptions,
    /// Whether pictures of disparities, points and motion are written beside them.
    pub pictures: bool,
}

impl Recording {
    /// Measures points in the pictures of cameras side by side and writes them; where there are masks, those of the person.
    ///
    /// What is odd about pictures and masks is told to `progress` at once.
    ///
    /// # Errors
    /// [`Error`] says in one line what cannot be used.
    pub fn write_surface(
        &self,
        files: &SurfaceFiles<'_>,
        progress: &dyn Progress,
    ) -> Result<SurfaceSummary, Error> {
        let footage = self.footage()?;
        let all = footage.frames();
        let frames = files.frames.select(&all)?;
        let options = &files.options;
        options.choose_cameras(&footage.rig)?;
        let masks = masks(&self.clone().with_fps(footage.fps))?;

        let source = masks.as_ref().map(|masks| masks as &dyn MaskSource);
        let unmasked = unmasked_note(&footage, source, options)?;
        let of_pictures = footage.notes.iter().map(ToString::to_string);
        let of_masks = masks.iter().flat_map(odd_masks).map(ToString::to_string);
        for note in of_pictures.chain(of_masks).chain(unmasked) {
            progress.note(&note);
        }

        let out = OutFolder::open(files.folder)?;
        let extras = StereoExtras { pictures: files.pictures, trajectories: options.tracks };
        let folder = StereoFolder::open(&out, footage.up, extras)?;
        measure_points(&footage, source, frames, options, folder, progress)
    }
}

/// The masks, if the recording has some; its points are what is to be measured.
fn masks(recording: &Recording) -> Result<Option<ObservationFiles>, Error> {
    match recording.masks() {
        Ok(files) => Ok(Some(files).filter(ObservationFiles::has_masks)),
        Err(RecordingError::NoMasks { .. }) => Ok(None),
        Err(fault) => Err(fault.into()),
    }
}

/// What is odd about the masks; that pictures are not read for them is not.
fn odd_masks(masks: &ObservationFiles) -> impl Iterator<Item = &Note> {
    let is_odd = |note: &&Note| !matches!(note, Note::Ignored { .. });
    masks.notes.iter().filter(is_odd)
}

/// Measures the points of some frames and writes them.
pub(super) fn measure_points(
    footage: &Footage,
    masks: Option<&dyn MaskSource>,
    frames: &[FrameIndex],
    options: &StereoOptions,
    mut folder: StereoFolder<'_>,
    progress: &dyn Progress,
) -> Result<SurfaceSummary, Error> {
    let write = |frame| folder.write(frame).map_err(Error::from);
    let found = measure_surface(footage, masks, frames, options, progress, write)?;
    folder.finish()?;
    Ok(found)
}
