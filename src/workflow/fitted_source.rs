//! A recording that is fitted for its cameras, or the folder of a fit that was made before.

use std::path::Path;

use super::{Error, FitFolder, FitOptions};
use crate::io::folder::{Existing, origin};
use crate::io::recording::Recording;
use crate::io::result::{RESULT, ResultFile};
use crate::pipeline::{Cameras, Clocks, Progress};

/// A fit and its recording.
#[derive(Debug)]
pub(super) struct FittedSource {
    pub(super) recording: Recording,
    pub(super) result: ResultFile,
}

/// Whether a path is the folder of a finished fit.
pub(super) fn is_fit(path: &Path) -> bool {
    path.join(RESULT).is_file()
}

impl FittedSource {
    /// Reads the folder of a fit, or fits a recording; the fit must be usable.
    pub(super) fn open(
        path: &Path,
        fps: Option<f64>,
        options: &FitOptions,
        progress: &dyn Progress,
    ) -> Result<Self, Error> {
        let source = match is_fit(path) {
            true => Self::read(path)?,
            false => Self::fit(&Recording::open(path)?.with_fps(fps), options, progress)?,
        };
        let why = source.result.verdict.why_unusable();
        why.map_or(Ok(source), |why| Err(Error::Unusable(format!("{}: {why}", path.display()))))
    }

    /// Fits a recording in a folder that is gone afterwards.
    pub(super) fn fit(
        recording: &Recording,
        options: &FitOptions,
        progress: &dyn Progress,
    ) -> Result<Self, Error> {
        let folder = tempfile::tempdir()?;
        let out = FitFolder { path: folder.path(), existing: Existing::Refuse, overlays: false };
        let fitted = recording.fit_into(out, options, progress)?;
        Ok(Self { recording: recording.clone(), result: fitted.result })
    }

    fn read(path: &Path) -> Result<Self, Error> {
        let result = ResultFile::read(path)?;
        let origin = origin::read(path).ok_or_else(|| Error::NoOrigin { path: path.into() })?;
        // seen from the fit's folder it has steps up and down again
        let origin = origin.canonicalize().unwrap_or(origin);
        let recording = Recording::open(origin)?.with_fps(result.recording.fps);
        Ok(Self { recording, result })
    }

    /// Whether the fit had the cameras' poses as unknowns.
    pub(super) fn asks_for_poses(&self) -> bool {
        let estimate = &self.result.options.estimate;
        estimate.joint.is_some() && estimate.cameras != Cameras::Trust
    }

    /// Whether it had their clocks.
    pub(super) fn asks_for_clocks(&self) -> bool {
        let estimate = &self.result.options.estimate;
        estimate.joint.is_some() && estimate.clocks == Clocks::Estimate
    }
}
