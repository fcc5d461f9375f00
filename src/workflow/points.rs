//! Points of the surface, measured by cameras that stand side by side, as files.

use std::path::Path;

use super::Error;
use crate::io::folder::stereo::{StereoExtras, StereoFolder};
use crate::io::recording::footage::Footage;
use crate::io::recording::{Note, ObservationFiles, Recording, RecordingError};
use crate::pipeline::stereo::{StereoOptions, SurfaceSummary, measure_surface, unmasked_note};
use crate::pipeline::{FrameRange, MaskSource, Progress};
use crate::silhouette::FrameIndex;

/// How the points of a recording are measured and written.
#[derive(Debug, Clone, Copy)]
pub struct PointFiles<'a> {
    /// Where they are written to.
    pub folder: &'a Path,
    /// Which frames.
    pub frames: FrameRange,
    /// How they are found.
    pub options: &'a StereoOptions,
    /// Whether pictures of disparities, clouds and motion are written beside them.
    pub pictures: bool,
}

impl Recording {
    /// Measures points of the surface, where there are masks those of the person, and writes them.
    ///
    /// # Errors
    /// [`Error`] says in one line what cannot be used.
    pub fn write_points(
        &self,
        files: &PointFiles<'_>,
        progress: &dyn Progress,
    ) -> Result<SurfaceSummary, Error> {
        // read and check everything
        let footage = self.footage()?;
        let all = footage.frames();
        let frames = files.frames.select(&all)?;
        files.options.choose_cameras(&footage.rig)?;
        let masks = self.masks_at(footage.fps)?;
        let source = masks.as_ref().map(|masks| masks as &dyn MaskSource);

        let notes = footage.notes.iter().map(ToString::to_string);
        let notes = notes.chain(masks.iter().flat_map(odd_masks));
        let unmasked = unmasked_note(&footage, source, files.options)?;
        notes.chain(unmasked).for_each(|note| progress.note(&note));

        // frame by frame
        let extras = StereoExtras {
            pictures: files.pictures,
            trajectories: files.options.tracks,
        };
        let folder = StereoFolder::open(files.folder, footage.up, extras)?;
        measure(&footage, source, frames, files.options, folder, progress)
    }

    /// The masks at this frame rate; `None` without any.
    fn masks_at(&self, fps: f64) -> Result<Option<ObservationFiles>, Error> {
        match self.clone().with_fps(fps).masks() {
            Ok(files) => Ok(Some(files).filter(ObservationFiles::has_masks)),
            Err(RecordingError::NoMasks { .. }) => Ok(None),
            Err(fault) => Err(fault.into()),
        }
    }
}

/// Measures the points of these frames and writes them into a folder.
pub(super) fn measure(
    footage: &Footage,
    masks: Option<&dyn MaskSource>,
    frames: &[FrameIndex],
    options: &StereoOptions,
    mut folder: StereoFolder,
    progress: &dyn Progress,
) -> Result<SurfaceSummary, Error> {
    let write = |frame| folder.write(frame).map_err(Error::from);
    let found = measure_surface(footage, masks, frames, options, progress, write)?;
    folder.finish()?;
    found.notes.iter().for_each(|note| progress.note(note));
    Ok(found)
}

/// What is odd about the masks; that pictures are not read for them is not.
fn odd_masks(masks: &ObservationFiles) -> impl Iterator<Item = String> {
    let is_odd = |note: &&Note| !matches!(note, Note::Ignored { .. });
    masks.notes.iter().filter(is_odd).map(ToString::to_string)
}
