//! The masks of a recording, cut out of its pictures.

use std::ops::RangeInclusive;
use std::path::Path;

use super::Error;
use crate::io::folder::OutFolder;
use crate::io::folder::segmented::{self, Extras, QualityRow};
use crate::io::recording::Recording;
use crate::io::recording::footage::{Footage, FootageNote};
use crate::pipeline::segment::SegmentOptions;
use crate::pipeline::{FrameRange, Progress, span};

/// How the masks of a recording are written.
#[derive(Debug, Clone, Copy)]
pub struct MaskFiles<'a> {
    /// Where they are written to.
    pub folder: &'a Path,
    /// Which frames; the background is learnt from all.
    pub frames: FrameRange,
    /// What is written beside them.
    pub extras: Extras,
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
    /// Cuts the person out of the pictures and writes masks and `quality.csv`.
    ///
    /// # Errors
    /// [`Error`] says in one line what cannot be used.
    pub fn write_masks(
        &self,
        files: &MaskFiles<'_>,
        progress: &dyn Progress,
    ) -> Result<WrittenMasks, Error> {
        let footage = self.footage()?;
        let frames = footage.frames();
        let frames = span(files.frames.select(&frames)?);
        cut_masks(&footage, frames, files.folder, files.extras, progress)
    }
}

/// Learns the background, segments and writes.
pub(super) fn cut_masks(
    footage: &Footage,
    frames: RangeInclusive<usize>,
    folder: &Path,
    extras: Extras,
    progress: &dyn Progress,
) -> Result<WrittenMasks, Error> {
    OutFolder::open(folder)?;
    let all = footage.frames();
    progress.begin("background", all.len());
    let (segmenter, found) =
        segmented::learn(footage, SegmentOptions::default(), &|| progress.step());
    progress.end();

    let count = all.iter().filter(|frame| frames.contains(&frame.0)).count();
    progress.begin("masks", count);
    let (rows, odd) = segmented::write(folder, footage, &segmenter, frames, extras, &|| {
        progress.step()
    })?;
    progress.end();

    let known = footage.notes.iter().chain(&found).chain(&odd);
    let mut notes: Vec<String> = known.map(FootageNote::to_string).collect();
    for (id, share) in segmented::never_left(footage, &segmenter) {
        let (camera, percent) = (&footage.rig.cameras[id.0].name, 100.0 * share);
        notes.push(format!(
            "camera {camera}: the background is never seen behind {percent:.0} % of the person: a picture of the empty scene (background = …) would help"
        ));
    }
    if !segmenter.is_consistent() && footage.rig.cameras.len() > 1 {
        notes.push("the cameras do not agree on where the person is: each is segmented by itself; check the calibration".into());
    }
    Ok(WrittenMasks {
        cameras: footage.rig.names().map(str::to_owned).collect(),
        rows,
        notes,
    })
}
