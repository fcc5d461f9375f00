//! The silhouettes of a recording in clutter, found by a body that predicts them, as files.

use std::collections::BTreeMap;
use std::path::Path;

use super::Error;
use crate::body::BodyModel;
use crate::io::folder::OutFolder;
use crate::io::folder::silhouettes::{ContourRow, SilhouetteExtras, SilhouetteFolder};
use crate::io::model;
use crate::io::recording::Recording;
use crate::io::recording::footage::Footage;
use crate::io::result::ResultFile;
use crate::likelihood::Measure;
use crate::pipeline::silhouettes::{
    FoundSilhouettes, SilhouetteError, SilhouettePipeline, SilhouetteSearch, StartingFit,
    rows_apart,
};
use crate::pipeline::{FrameRange, Progress, check_measure};
use crate::silhouette::FrameIndex;

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
    /// The frames in which depth speaks against a contour or a limb.
    pub doubtful: Vec<FrameIndex>,
    /// What was left out, and why.
    pub notes: Vec<String>,
    /// That the contours are hardly on edges, where they are not.
    pub warning: Option<String>,
    /// Why they are not to be used, where they are nobody's outline.
    pub failure: Option<String>,
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

        let out = OutFolder::open(files.folder)?;

        // 1. where the body is
        let start = match files.start {
            Some(folder) => read_start(folder, &footage, frames, &model, progress)?,
            None => first_fit(&footage, frames, &model, progress)?,
        };
        // 2. contours, frame by frame
        let search = SilhouetteSearch {
            pictures: &footage,
            frames,
            model: &model,
            start: &start,
            pipeline: files.pipeline,
        };
        let (found, rows) = find_and_keep(&search, &out, files.extras, progress)?;

        let known = footage.notes.iter().map(ToString::to_string);
        Ok(WrittenSilhouettes {
            cameras: footage.rig.names().map(str::to_owned).collect(),
            warning: doubt(&found, files.body, &footage, frames),
            failure: found.failure(files.body).map(|line| explained(line, &footage, frames)),
            doubtful: found.doubtful,
            rows,
            notes: known.chain(found.notes).collect(),
        })
    }
}

/// Silhouettes and points of some frames by the joint pipeline, to be fitted to; masks, contours and quality are kept in a
/// folder. What speaks against them is one of the notes; [`Error::Unusable`] says why they are nobody's outline.
pub(super) fn observe(
    footage: &Footage,
    frames: &[FrameIndex],
    body: &str,
    out: &OutFolder,
    progress: &dyn Progress,
) -> Result<FoundSilhouettes, Error> {
    let model = load_body(body)?;
    let start = first_fit(footage, frames, &model, progress)?;
    let search = SilhouetteSearch {
        pictures: footage,
        frames,
        model: &model,
        start: &start,
        pipeline: SilhouettePipeline::Joint,
    };

    let (mut found, _) = find_and_keep(&search, out, SilhouetteExtras::default(), progress)?;
    found.notes.iter().for_each(|note| progress.note(note));
    if let Some(line) = found.failure(body) {
        return Err(Error::Unusable(explained(line, footage, frames)));
    }
    found.notes.extend(doubt(&found, body, footage, frames));
    Ok(found)
}

/// That the contours are hardly on edges, with its cause, or that depth backs too little of them; `None` where neither is so.
fn doubt(
    found: &FoundSilhouettes,
    body: &str,
    footage: &Footage,
    frames: &[FrameIndex],
) -> Option<String> {
    let line = found.doubt(body)?;
    Some(match found.off_edges() {
        Some(_) => explained(line, footage, frames),
        None => line,
    })
}

/// The first fit, by depth.
fn first_fit(
    footage: &Footage,
    frames: &[FrameIndex],
    model: &BodyModel,
    progress: &dyn Progress,
) -> Result<StartingFit, Error> {
    StartingFit::find(footage, frames, model, progress).map_err(|fault| match fault {
        SilhouetteError::Fit(fit) => match cause(footage, frames) {
            Some(cause) => Error::Unusable(format!("{cause}; so {fit}")),
            None => SilhouetteError::Fit(fit).into(),
        },
        other => other.into(),
    })
}

/// What is amiss, after its cause where the pictures tell one.
fn explained(line: String, footage: &Footage, frames: &[FrameIndex]) -> String {
    cause(footage, frames).map_or_else(|| line.clone(), |cause| format!("{cause}; so {line}"))
}

/// Why contours cannot be found, as far as the pictures tell.
fn cause(footage: &Footage, frames: &[FrameIndex]) -> Option<String> {
    let apart: Vec<String> = rows_apart(footage, frames).iter().map(ToString::to_string).collect();
    (!apart.is_empty()).then(|| apart.join("; "))
}

/// Finds silhouettes, and keeps masks, contours and quality in a folder.
fn find_and_keep(
    search: &SilhouetteSearch<'_, Footage>,
    out: &OutFolder,
    extras: SilhouetteExtras,
    progress: &dyn Progress,
) -> Result<(FoundSilhouettes, Vec<ContourRow>), Error> {
    let mut folder = SilhouetteFolder::open(out, extras)?;
    let rig = &search.pictures.rig;
    let found = search.run(progress, |found| folder.write(found, rig, search.model))?;
    Ok((found, folder.finish()?))
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
    Ok(StartingFit::from_motions(shape, motions, footage, frames, progress))
}
