//! The masks of a recording, cut out of its pictures.

use std::ops::RangeInclusive;
use std::path::Path;

use super::Error;
use super::detections::MOST_PEOPLE;
use super::mistakes::check_scale;
use crate::io::folder::OutFolder;
use crate::io::folder::segmented::{MaskExtras, MaskFolder, QualityRow};
use crate::io::recording::Recording;
use crate::io::recording::footage::{Footage, FootageNote};
use crate::pipeline::segment::{SegmentOptions, SegmentedFrame, segment};
use crate::pipeline::{FrameRange, Person, Progress, detected_people, span};

/// How the masks of a recording are written.
#[derive(Debug, Clone, Copy)]
pub struct MaskFiles<'a> {
    /// Where they are written to.
    pub folder: &'a Path,
    /// Which frames; the background is learnt from all.
    pub frames: FrameRange,
    /// What is written beside them.
    pub extras: MaskExtras,
}

/// What was written.
#[derive(Debug, Clone, PartialEq)]
pub struct WrittenMasks {
    /// Names of the cameras.
    pub cameras: Vec<String>,
    /// Mask by mask.
    pub rows: Vec<QualityRow>,
    /// What the user should know.
    pub notes: Vec<String>,
}

impl Recording {
    /// Cuts the person out of the pictures, where detections say that they are if there are some, and writes masks and `quality.csv`.
    ///
    /// # Errors
    /// [`Error`] says in one line what cannot be used.
    pub fn write_masks(
        &self,
        files: &MaskFiles<'_>,
        progress: &dyn Progress,
    ) -> Result<WrittenMasks, Error> {
        let footage = self.footage()?;
        let people = people(self, &footage, MOST_PEOPLE)?;
        let frames = footage.frames();
        let frames = span(files.frames.select(&frames)?);
        let out = OutFolder::open(files.folder)?;
        cut_masks(&footage, &people, frames, &out, files.extras, progress)
    }
}

/// The people whom detections show in the pictures, at most so many; nobody without detections.
pub(super) fn people(
    recording: &Recording,
    footage: &Footage,
    most: usize,
) -> Result<Vec<Person>, Error> {
    let frames = recording.people_in(footage)?;
    check_scale(&footage.rig, &frames)?;
    let seen = |person: &Person| person.detections.iter().any(|(_, seen)| !seen.is_empty());
    let found = detected_people(&footage.rig, &frames, footage.fps, most);
    Ok(found.into_iter().filter(seen).collect())
}

/// Segments and writes.
pub(super) fn cut_masks(
    footage: &Footage,
    people: &[Person],
    frames: RangeInclusive<usize>,
    out: &OutFolder,
    extras: MaskExtras,
    progress: &dyn Progress,
) -> Result<WrittenMasks, Error> {
    let is_empty_seen = footage.cameras.iter().any(|camera| camera.background.is_some());
    if footage.frames().len() == 1 && !is_empty_seen {
        return Err(Error::OneInstant);
    }
    let folder = MaskFolder::open(out, &footage.rig, extras)?;
    let options = SegmentOptions::default();
    let write = |frame: &SegmentedFrame| folder.write(frame);
    let found = segment(footage, people, frames, options, progress, write)?;
    let rows = folder.finish(&found.masks)?;

    let known = footage.notes.iter().map(FootageNote::to_string);
    Ok(WrittenMasks {
        cameras: footage.rig.names().map(str::to_owned).collect(),
        rows,
        notes: known.chain(found.notes).collect(),
    })
}
