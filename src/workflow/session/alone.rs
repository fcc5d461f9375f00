//! Each trial of a session by itself, or what an earlier run has found of it.
//!
//! Two trials at a time: what of a fit is one step after the other leaves processors idle, and another fit uses them.

use std::sync::atomic::{AtomicBool, Ordering};

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
        let trials = &self.manifest.trials;
        progress.begin("trials alone", trials.len());
        let all = two_at_a_time(trials, |entry| {
            let trial = self.fit_one(entry, folder, options, &InPart(progress));
            let trial = trial.map_err(|source| named(&entry.name, source))?;
            if let Some(why) = trial.fitted.result.verdict.why_unusable() {
                return Err(Error::from(SessionError::Unusable { name: trial.name, why }));
            }
            progress.step();
            Ok(trial)
        });
        progress.end();

        let all = all?;
        let differs = |trial: &&AloneTrial| trial.input.model != all[0].input.model;
        if let Some(other) = all.iter().find(differs) {
            let [(first, body), (second, other)] =
                [&all[0], other].map(|trial| (trial.name.clone(), trial.input.model.name.clone()));
            return Err(SessionError::TwoBodies { first, body, second, other }.into());
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

/// Does some work on all, in their order, two at a time; none is begun after one has failed.
fn two_at_a_time<T: Sync, R: Send>(
    all: &[T],
    work: impl Fn(&T) -> Result<R, Error> + Sync,
) -> Result<Vec<R>, Error> {
    let has_failed = AtomicBool::new(false);
    let every_other = |first: usize| {
        let left = all.iter().skip(first).step_by(2);
        let left = left.take_while(|_| !has_failed.load(Ordering::Relaxed));
        left.map(&work)
            .inspect(|done| _ = has_failed.fetch_or(done.is_err(), Ordering::Relaxed))
            .collect::<Result<Vec<R>, Error>>()
    };
    let (even, odd) = rayon::join(|| every_other(0), || every_other(1));
    let mut odd = odd?.into_iter();
    Ok(even?.into_iter().flat_map(|done| [Some(done), odd.next()]).flatten().collect())
}

/// Passes on what the user should know of one trial of several; its steps count for none of the whole, but the work may be
/// stopped at each.
struct InPart<'a>(&'a dyn Progress);

impl Progress for InPart<'_> {
    fn advance(&self, _steps: usize) {
        self.0.advance(0);
    }

    fn note(&self, line: &str) {
        self.0.note(line);
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn all_are_done_in_their_order_and_none_is_begun_after_one_has_failed() {
        for n in 0..6 {
            let all: Vec<usize> = (0..n).collect();
            assert_eq!(
                two_at_a_time(&all, |i| Ok(10 * i)).unwrap(),
                all.iter().map(|i| 10 * i).collect::<Vec<_>>()
            );
        }
        let begun = std::sync::Mutex::new(Vec::new());
        let pool = rayon::ThreadPoolBuilder::new().num_threads(1).build().unwrap();
        let failed = pool.install(|| {
            two_at_a_time(&[0, 1, 2, 3, 4, 5], |i| {
                begun.lock().unwrap().push(*i);
                match i {
                    2 => Err(SessionError::NothingLeft.into()),
                    _ => Ok(()),
                }
            })
        });
        assert!(matches!(failed, Err(Error::Session(_))), "{failed:?}");
        assert_eq!(*begun.lock().unwrap(), [0, 2]);
    }
}
