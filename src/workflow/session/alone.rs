//! Each trial of a session by itself, or what an earlier run has found of it.

use serde_json::{Value, json};

use super::{ALONE, Session, SessionError, SessionFolder, named};
use crate::io::folder::Existing;
use crate::io::recording::Recording;
use crate::io::result::ResultFile;
use crate::io::session::TrialEntry;
use crate::pipeline::{Progress, SessionTrial};
use crate::workflow::fitted_source::is_fit;
use crate::workflow::input::{FitInput, identity};
use crate::workflow::people::People;
use crate::workflow::{Error, FitFolder, FitOptions, FittedRecording};

/// A trial that was fitted alone.
pub(super) struct AloneTrial {
    pub(super) name: String,
    pub(super) recording: Recording,
    pub(super) input: FitInput,
    pub(super) fitted: FittedRecording,
}

impl Session {
    /// Every trial alone; all with one body model.
    pub(super) fn fit_alone(
        &self,
        folder: SessionFolder<'_>,
        options: &FitOptions,
        progress: &dyn Progress,
    ) -> Result<Vec<AloneTrial>, Error> {
        let mut all: Vec<AloneTrial> = Vec::with_capacity(self.manifest.trials.len());
        for entry in &self.manifest.trials {
            let trial = self.fit_one(entry, folder, options, progress);
            let trial = trial.map_err(|source| named(&entry.name, source))?;
            if let Some(why) = trial.fitted.result.verdict.why_unusable() {
                return Err(SessionError::Unusable { name: trial.name, why }.into());
            }
            if let Some(first) = all.first().filter(|first| first.input.model != trial.input.model)
            {
                let [body, other] =
                    [&first.input, &trial.input].map(|input| input.model.name.clone());
                let (first, second) = (first.name.clone(), trial.name);
                return Err(SessionError::TwoBodies { first, body, second, other }.into());
            }
            all.push(trial);
        }
        Ok(all)
    }

    fn fit_one(
        &self,
        entry: &TrialEntry,
        folder: SessionFolder<'_>,
        options: &FitOptions,
        progress: &dyn Progress,
    ) -> Result<AloneTrial, Error> {
        let recording = Recording::open(&entry.recording)?.with_fps(self.fps);
        let path = folder.path.join(ALONE).join(entry.folder());
        // what is made of its pictures is used again, whatever becomes of its fit
        let existing = Existing::Resume;
        let alone = FitFolder { path: &path, existing, overlays: false };
        let (out, input) = recording.read_for(alone, options, progress)?;
        let mut input = People::part(input, progress)?.measured;
        let name = entry.name.clone();
        if let Some(fitted) = taken_up(&path, &mut input) {
            progress.note(&format!("trial {name}: taken up as it was fitted before"));
            return Ok(AloneTrial { name, recording, input, fitted });
        }

        progress.note(&format!("trial {name}: fitted alone"));
        let existing = match folder.existing {
            Existing::Overwrite => Existing::Overwrite,
            Existing::Refuse | Existing::Resume => Existing::Resume,
        };
        let alone = FitFolder { existing, ..alone };
        let asked = input.options.estimate.search.clone();
        let (trials, frames) = (self.manifest.trials.len(), input.observations.len());
        input.options.estimate.search = asked.of_trial(trials, frames);
        let fitted = recording.fit_read(alone, &out, &input, progress)?;
        if fitted.result.verdict.is_usable() || input.options.estimate.search == asked {
            return Ok(AloneTrial { name, recording, input, fitted });
        }

        // a keyframe more may read right what few of them misread
        input.options.estimate.search = asked;
        let again = FitFolder { existing: Existing::Overwrite, ..alone };
        let fitted = recording.fit_read(again, &out, &input, progress)?;
        Ok(AloneTrial { name, recording, input, fitted })
    }
}

/// The result of an earlier run of the same inputs and options, with any number of keyframes unless one is asked for: a session
/// of more or fewer trials has other numbers.
fn taken_up(path: &std::path::Path, input: &mut FitInput) -> Option<FittedRecording> {
    let result = is_fit(path).then(|| ResultFile::read(path).ok()).flatten()?;
    let model = result.body_of(&input.model).ok()?;
    let asked = input.options.estimate.search.keyframe_every;
    let had = result.options.estimate.search.keyframe_every;
    input.options.estimate.search.keyframe_every = asked.or(had);
    if identity_of(&result) == input.identity() {
        return Some(FittedRecording { result, model });
    }
    input.options.estimate.search.keyframe_every = asked;
    None
}

/// What a result depends on, as [`FitInput::identity`] has it.
fn identity_of(result: &ResultFile) -> Value {
    let recording = &result.recording;
    let frames = [recording.first_frame, recording.last_frame].map(Some);
    let version = &result.program.version;
    identity(version, &result.inputs, recording.fps, frames, json!(result.options))
}

impl AloneTrial {
    /// The trial as the session's optimum takes it.
    pub(super) fn session_trial(&self) -> Result<SessionTrial<'_>, SessionError> {
        let alone = self.fitted.result.alone_fit(&self.input.model);
        Ok(SessionTrial {
            name: &self.name,
            rig: &self.input.files.rig,
            sequence: self.input.sequence(),
            options: &self.input.options.estimate,
            alone: alone.ok_or_else(|| SessionError::NotJoint { name: self.name.clone() })?,
        })
    }
}
