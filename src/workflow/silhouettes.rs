//! The silhouettes of a recording in clutter, found by a body that predicts them, as files.

use std::collections::BTreeMap;
use std::path::Path;

use super::Error;
use crate::body::BodyModel;
use crate::io::folder::silhouettes::{ContourRow, SilhouetteExtras, SilhouetteFolder};
use crate::io::model;
use crate::io::recording::Recording;
use crate::io::recording::footage::Footage;
use crate::io::result::ResultFile;
use crate::likelihood::Measure;
use crate::math::stats::mean;
use crate::pipeline::silhouettes::{
    FrameSilhouettes, SilhouettePipeline, SilhouetteSearch, StartingFit,
};
use crate::pipeline::{FrameRange, Progress, check_measure};
use crate::silhouette::{FrameIndex, FrameObservations};

/// Mean reliability below which contours are not to be trusted: of people it was .54 to .70, of an arm sought in a person
/// .17 to .38.
const UNSURE: f64 = 0.45;

/// How the silhouettes of a recording are found and written.
#[derive(Debug, Clone, Copy)]
pub struct SilhouetteFiles<'a> {
    /// Where they are written to.
    pub folder: &'a Path,
    /// The body that is followed, of metaballs: a shipped one or the path of one.
    pub body: &'a str,
    /// Which frames.
    pub frames: FrameRange,
    /// How body and contours work together.
    pub pipeline: SilhouettePipeline,
    /// The folder of a fit of the same body to begin with; `None`: one is fitted to what moves.
    pub start: Option<&'a Path>,
    /// What is written beside masks and contours.
    pub extras: SilhouetteExtras,
}

/// What was written.
#[derive(Debug, Clone, PartialEq)]
pub struct WrittenSilhouettes {
    /// Names of the cameras.
    pub cameras: Vec<String>,
    /// View by view.
    pub rows: Vec<ContourRow>,
    /// What was left out, and why.
    pub notes: Vec<String>,
    /// That the contours are hardly on edges, where they are not.
    pub warning: Option<String>,
}

impl SilhouetteFiles<'_> {
    /// The body that is followed when nobody names one: contours and depths are those of a skin.
    pub const DEFAULT_BODY: &'static str = "human-metaballs";
}

impl Recording {
    /// Finds the silhouettes in the pictures and writes masks, contours and `quality.csv` (PF02, §4).
    ///
    /// # Errors
    /// [`Error`] says in one line what cannot be used.
    pub fn write_silhouettes(
        &self,
        files: &SilhouetteFiles<'_>,
        progress: &dyn Progress,
    ) -> Result<WrittenSilhouettes, Error> {
        let footage = self.footage()?;
        let all = footage.frames();
        let frames = files.frames.select(&all)?;
        let model = load_body(files.body)?;

        // 1. where the body is
        let start = match files.start {
            Some(folder) => read_start(folder, &footage, frames, &model, progress)?,
            None => StartingFit::find(&footage, frames, &model, progress)?,
        };
        // 2. contours, frame by frame
        let mut folder = SilhouetteFolder::open(files.folder, files.extras)?;
        let search = SilhouetteSearch {
            pictures: &footage,
            frames,
            model: &model,
            start: &start,
            pipeline: files.pipeline,
        };
        let notes = search.run(progress, |found| {
            write(&mut folder, &found, &footage, &model)
        })?;
        let rows = folder.finish()?;

        Ok(WrittenSilhouettes {
            cameras: footage.rig.names().map(str::to_owned).collect(),
            warning: doubt(&rows, files.body),
            rows,
            notes,
        })
    }
}

/// Silhouettes and points of some frames by the joint pipeline, to be fitted to; masks, contours and quality are kept in a
/// folder.
pub(super) fn observe(
    footage: &Footage,
    frames: &[FrameIndex],
    body: &str,
    folder: &Path,
    progress: &dyn Progress,
) -> Result<Vec<FrameObservations>, Error> {
    let model = load_body(body)?;
    let start = StartingFit::find(footage, frames, &model, progress)?;
    let search = SilhouetteSearch {
        pictures: footage,
        frames,
        model: &model,
        start: &start,
        pipeline: SilhouettePipeline::Joint,
    };

    let mut folder = SilhouetteFolder::open(folder, SilhouetteExtras::default())?;
    let mut observed = Vec::new();
    let notes = search.run(progress, |found| {
        write(&mut folder, &found, footage, &model)?;
        observed.push(found.sighting.observed);
        Ok::<(), Error>(())
    })?;
    folder.finish()?;

    notes.iter().for_each(|note| progress.note(note));
    Ok(observed)
}

/// A body whose skin can be seen in depth.
fn load_body(name: &str) -> Result<BodyModel, Error> {
    let model = model::load(name, Path::new(""))?;
    check_measure(&model, Some(Measure::Metaballs))?;
    Ok(model)
}

/// The fit of an earlier run.
fn read_start(
    folder: &Path,
    footage: &Footage,
    frames: &[FrameIndex],
    model: &BodyModel,
    progress: &dyn Progress,
) -> Result<StartingFit, Error> {
    let result = ResultFile::read(folder)?;
    let shape = result.shape_of(model)?;
    let fitted = result.motion.frames.iter();
    let motions: BTreeMap<_, _> = fitted.map(|f| (FrameIndex(f.frame), f.motion())).collect();
    Ok(StartingFit::from_motions(
        shape, motions, footage, frames, progress,
    ))
}

/// Writes every view of a frame.
fn write(
    folder: &mut SilhouetteFolder,
    found: &FrameSilhouettes<'_>,
    footage: &Footage,
    model: &BodyModel,
) -> Result<(), Error> {
    let seen = found.sighting.seen.iter().zip(found.pictures);
    for ((seen, picture), camera) in seen.zip(&footage.rig.cameras) {
        if let (Some(seen), Some(picture)) = (seen, picture) {
            folder.view(found.frame, camera, picture, seen, model)?;
        }
    }
    Ok(())
}

/// That the contours are hardly on edges; `None` where they are.
fn doubt(rows: &[ContourRow], body: &str) -> Option<String> {
    let reliability = mean(rows.iter().map(|row| row.reliability))?;
    (reliability < UNSURE).then(|| {
        format!(
            "the contours hardly lie on edges (mean reliability {reliability:.2}): does {body} look like the person who is seen, and is the calibration right? Look with --overlays"
        )
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn contours_that_lie_on_no_edges_are_doubted_and_others_are_not() {
        let row = |reliability| ContourRow {
            frame: 0,
            camera: "left".into(),
            area_px: 1000,
            reliability,
            moved_px: 1.0,
            faults: String::new(),
        };
        let line = doubt(&[row(0.6), row(0.1)], "arm").expect("their mean is 0.35");
        assert!(line.contains("0.35") && line.contains("arm"), "{line}");
        assert!(!line.contains('\n'), "{line}");
        assert_eq!(doubt(&[row(0.6), row(0.5)], "arm"), None);
        assert_eq!(doubt(&[], "arm"), None);
    }
}
