//! From a recording to a fitted body.

use std::path::Path;

use tempfile::TempDir;

use super::derived::Derived;
use super::input::FitInput;
use super::people::People;
use super::{Error, FitOptions, FittedRecording};
use crate::inference::search::{Journal, NoJournal};
use crate::io::folder::journal::{DiskJournal, JournalError};
use crate::io::folder::overlays::OverlayError;
use crate::io::folder::{Existing, OutFolder, check_out, origin, overlays, write_atomically};
use crate::io::recording::Recording;
use crate::io::result::{Provenance, ResultFile};
use crate::pipeline::{self, Fit, NoProgress, Progress};

/// The folder that a fit is written into.
#[derive(Debug, Clone, Copy)]
pub struct FitFolder<'a> {
    /// Where it is.
    pub path: &'a Path,
    /// What to do with what it holds.
    pub existing: Existing,
    /// Whether pictures of the fit over the masks are written into its `overlays/`.
    pub overlays: bool,
}

impl Recording {
    /// Fits a body to the recording, in memory.
    ///
    /// Masks, contours and points that have to be made of pictures are kept in a temporary folder until it is done.
    ///
    /// # Errors
    /// [`Error`] says in one line which file, camera or frame cannot be used.
    ///
    /// ```no_run
    /// # fn main() -> Result<(), maquette::Error> {
    /// let recording = maquette::Recording::open("data/sequences/walker")?;
    /// let fit = recording.fit(&maquette::FitOptions::default())?;
    /// let thigh = fit.length("thigh")?;
    /// println!("{:.3} ± {:.3} m", thigh.metres, thigh.sd.unwrap_or(f64::NAN));
    /// # Ok(())
    /// # }
    /// ```
    pub fn fit(&self, options: &FitOptions) -> Result<FittedRecording, Error> {
        let folder = tempfile::tempdir()?;
        let out = OutFolder::open(folder.path())?;
        let derived = Derived { out: &out, is_resumed: false, progress: &NoProgress };
        let input = FitInput::read(self, options, &derived)?;
        let input = People::part(input, &NoProgress)?.measured;
        let fit = search(&input, &NoJournal, &NoProgress)?;
        Ok(fitted(&input, &fit))
    }

    /// Fits a body and writes the result into a folder, where a run that is stopped can be continued.
    ///
    /// What it leaves there is described in docs/formats.md. Nothing is written until the recording is known to be
    /// usable, and an older result stays until the new one is complete. Where something that is finished cannot be kept the
    /// run stops at once; what was kept before is continued from.
    ///
    /// # Errors
    /// [`Error`], as [`Recording::fit`], and [`Error::Out`] and [`Error::Journal`] about the folder.
    pub fn fit_into(
        &self,
        folder: FitFolder<'_>,
        options: &FitOptions,
        progress: &dyn Progress,
    ) -> Result<FittedRecording, Error> {
        // 1. read and check everything
        let (out, input) = self.read_for(folder, options, progress)?;

        // 2. the people, and first those who are not measured: where the result stands all of it stands
        let People { measured, others } = People::part(input, progress)?;
        let kept: Vec<usize> = others.iter().map(|(number, _)| *number).collect();
        for (number, other) in others {
            progress.note(&format!("person {number}:"));
            let path = out.person(number);
            let folder = FitFolder { path: &path, ..folder };
            let out = OutFolder::open(&path)?;
            match self.fit_read(folder, &out, &other, progress) {
                Err(Error::Fit(fault)) => progress.note(&format!("person {number}: {fault}")),
                fitted => drop(fitted?),
            }
        }
        out.keep_people(&kept);

        // 3. who is measured
        self.fit_read(folder, &out, &measured, progress)
    }

    /// Everything that a fit is made from, and the folder that it will be written into.
    pub(super) fn read_for(
        &self,
        folder: FitFolder<'_>,
        options: &FitOptions,
        progress: &dyn Progress,
    ) -> Result<(OutFolder, FitInput), Error> {
        check_out(folder.path, folder.existing)?;
        let out = OutFolder::open(folder.path)?;
        let derived =
            Derived { out: &out, is_resumed: folder.existing == Existing::Resume, progress };
        let input = FitInput::read(self, options, &derived)?;
        Ok((out, input))
    }

    /// Fits a body to what was read, and writes the result.
    pub(super) fn fit_read(
        &self,
        folder: FitFolder<'_>,
        out: &OutFolder,
        input: &FitInput,
        progress: &dyn Progress,
    ) -> Result<FittedRecording, Error> {
        // 1. fit, keeping what is finished
        let journal = journal(out, folder.existing, input)?;
        journal.note().iter().for_each(|note| progress.note(note));
        let found = search(input, &journal, progress);
        journal.into_whole()?;
        let fit = found.inspect_err(|_| out.abandon())?;

        // 2. write the result, and only then replace an older one
        let written = self.write_fit(folder, out, input, &fit, progress);
        written.map_err(|fault| match fault {
            Error::Out(fault) | Error::Overlay(OverlayError::Out(fault)) => {
                JournalError::NotKept(fault).into()
            }
            fault => fault,
        })
    }

    /// Writes all files of a fit beside their places, and then puts them there.
    fn write_fit(
        &self,
        folder: FitFolder<'_>,
        out: &OutFolder,
        input: &FitInput,
        fit: &Fit,
        progress: &dyn Progress,
    ) -> Result<FittedRecording, Error> {
        let scratch = out.scratch()?;
        if folder.overlays {
            let pictures = fit.frames.len() * input.files.rig.cameras.len();
            progress.begin("overlays", pictures);
            let into = scratch.path().join("overlays");
            let done = || progress.step();
            let no_film = overlays::write(&into, &input.files, fit, &done)?;
            progress.end();
            if let Some(reason) = no_film {
                progress.note(&format!("overlays: pictures only, no films: {reason}"));
            }
        }

        let fitted = fitted(input, fit);
        self.publish(out, scratch, &fitted.result)?;
        Ok(fitted)
    }

    /// Puts a result, and where its recording is, into a folder, with what stands in its scratch folder already.
    pub(super) fn publish(
        &self,
        out: &OutFolder,
        scratch: TempDir,
        result: &ResultFile,
    ) -> Result<(), Error> {
        for (name, bytes) in result.files()? {
            write_atomically(&scratch.path().join(name), &bytes)?;
        }
        if let Some(text) = origin::text(self.path(), out.path()) {
            write_atomically(&scratch.path().join(origin::ORIGIN), text.as_bytes())?;
        }
        Ok(out.publish(scratch)?)
    }
}

/// The journal of a new run, or of the one that is continued.
fn journal(out: &OutFolder, existing: Existing, input: &FitInput) -> Result<DiskJournal, Error> {
    let (folder, identity) = (out.journal(), input.identity());
    match existing {
        Existing::Resume => Ok(DiskJournal::resume(&folder, &identity)?),
        Existing::Refuse | Existing::Overwrite => {
            let created = DiskJournal::create(&folder, &identity);
            Ok(created.inspect_err(|_| out.abandon())?)
        }
    }
}

fn search(input: &FitInput, journal: &dyn Journal, progress: &dyn Progress) -> Result<Fit, Error> {
    let (model, rig, options) = (&input.model, &input.files.rig, &input.options.estimate);
    Ok(pipeline::fit_watched(model, rig, input.sequence(), options, journal, progress)?)
}

pub(super) fn fitted(input: &FitInput, fit: &Fit) -> FittedRecording {
    let result = ResultFile::new(
        fit,
        Provenance {
            recording: &input.files,
            observations: &input.observations,
            inputs: &input.checksums,
            model: &input.model,
            options: &input.options,
        },
    );
    FittedRecording { result, model: fit.model.clone() }
}
