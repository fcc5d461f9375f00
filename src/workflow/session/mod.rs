//! Several trials of one person: each fitted alone, then all with one body.
//!
//! | file       | holds                                                        |
//! |------------|--------------------------------------------------------------|
//! | `alone.rs` | each trial by itself, or what an earlier run has found of it   |
//! | `study.rs` | [`SessionStudy`]: the gait of all trials                       |
//! | `compare.rs` | [`Comparison`]: two sessions of one person                   |
//! | `report.rs` | the reports of both, with the feature `report`                |
//! | `error.rs` | [`SessionError`]                                              |

mod alone;
mod compare;
mod error;
#[cfg(feature = "report")]
mod report;
mod study;

use std::path::{Path, PathBuf};

pub use compare::Comparison;
pub use error::SessionError;
pub use study::SessionStudy;

use super::fit::fitted;
use super::{Error, FitOptions, FittedRecording};
use crate::io::folder::{Existing, OutFolder, check_out};
use crate::io::session::{
    DisagreementPart, SESSION, SessionFile, SessionLength, SessionManifest, TrialPart, session_of,
};
use crate::pipeline::{Disagreement, Progress, SessionFit, disagreements, fit_session};
use alone::AloneTrial;

/// Several trials of one person, to be fitted.
#[derive(Debug, Clone, PartialEq)]
pub struct Session {
    /// Who walked, and where.
    pub manifest: SessionManifest,
    /// Trials that are left out.
    pub without: Vec<String>,
    /// Frames per second, where neither a video nor a file states them.
    pub fps: Option<f64>,
}

/// The folder that a session is written into.
#[derive(Debug, Clone, Copy)]
pub struct SessionFolder<'a> {
    /// Where it is.
    pub path: &'a Path,
    /// What to do with what it holds.
    pub existing: Existing,
}

/// A session with one body for all trials.
#[derive(Debug, Clone, PartialEq)]
pub struct FittedSession {
    /// What `session.json` holds.
    pub file: SessionFile,
    /// Trial by trial, in the order of the file.
    pub trials: Vec<FittedRecording>,
}

/// The folders within that of a session.
const TRIALS: &str = "trials";
const ALONE: &str = "alone";

impl Session {
    /// One `session.toml` or its folder, one folder of recordings, or recordings.
    ///
    /// # Errors
    /// [`Error::SessionFile`] says what is wrong with the file, or that there is nothing to fit.
    pub fn open(paths: &[PathBuf]) -> Result<Self, Error> {
        Ok(Self { manifest: session_of(paths)?, without: Vec::new(), fps: None })
    }

    /// The same without some of the trials.
    ///
    /// # Errors
    /// [`SessionError::NoTrial`] for a name that no trial has, and [`SessionError::NothingLeft`].
    pub fn without(mut self, names: &[String]) -> Result<Self, Error> {
        let trials = &mut self.manifest.trials;
        for name in names {
            let before = trials.len();
            let known = trials.iter().map(|trial| trial.name.clone()).collect::<Vec<_>>();
            trials.retain(|trial| trial.name != *name);
            if trials.len() == before {
                let (name, known) = (name.clone(), known.join(", "));
                return Err(SessionError::NoTrial { name, known }.into());
            }
        }
        if trials.iter().all(|trial| trial.standing) {
            return Err(SessionError::NothingLeft.into());
        }
        self.without.extend_from_slice(names);
        Ok(self)
    }

    /// Fits every trial alone, then all with one body, and writes the folder: `alone/NAME` and `trials/NAME` with the files of a
    /// fit, and last `session.json`. A trial that was fitted there before with the same inputs and options is taken up.
    ///
    /// # Errors
    /// [`Error::Out`] about the folder; [`SessionError`] names the trial that cannot be fitted or used.
    pub fn fit_into(
        &self,
        folder: SessionFolder<'_>,
        options: &FitOptions,
        progress: &dyn Progress,
    ) -> Result<FittedSession, Error> {
        check_out(folder.path, folder.existing)?;
        let out = OutFolder::open(folder.path)?;
        let mut options = options.clone();
        let estimate = &mut options.estimate;
        estimate.height_m = estimate.height_m.or(self.manifest.person.height_m);
        let asked = estimate.joint;
        *estimate = estimate.of_trial_alone();

        // 1. each trial alone
        let mut alone = self.fit_alone(folder, &options, progress)?;
        let trials = alone.iter().map(AloneTrial::session_trial).collect::<Result<Vec<_>, _>>()?;
        let model = &alone[0].input.model;

        // 2. one body for all
        let odd = disagreements(model, &trials);
        let found = fit_session(model, &trials, progress)?;
        drop(trials);

        // 3. trial by trial, with the options that were asked for, and the session last
        for trial in &mut alone {
            trial.input.options.estimate.joint = asked;
        }
        let fitted = self.write_trials(folder.path, &alone, &found)?;
        let file = self.file(&alone, &fitted, &found, &odd);
        out.write(SESSION, file.text()?.as_bytes())?;
        Ok(FittedSession { file, trials: fitted })
    }

    fn write_trials(
        &self,
        folder: &Path,
        alone: &[AloneTrial],
        found: &SessionFit,
    ) -> Result<Vec<FittedRecording>, Error> {
        let mut all = Vec::with_capacity(alone.len());
        for ((entry, trial), fit) in self.manifest.trials.iter().zip(alone).zip(&found.fits) {
            let mut fitted = fitted(&trial.input, fit);
            fitted.result = fitted.result.with_search_of(&trial.fitted.result);
            let out = OutFolder::open(&folder.join(TRIALS).join(entry.folder()))?;
            let scratch = out.scratch()?;
            trial.recording.publish(&out, scratch, &fitted.result)?;
            all.push(fitted);
        }
        Ok(all)
    }

    /// What `session.json` holds.
    fn file(
        &self,
        alone: &[AloneTrial],
        fitted: &[FittedRecording],
        found: &SessionFit,
        odd: &[Disagreement],
    ) -> SessionFile {
        let manifest = &self.manifest;
        let entries = manifest.trials.iter().zip(fitted);
        let trials = entries.map(|(entry, fitted)| TrialPart {
            name: entry.name.clone(),
            condition: entry.condition.clone(),
            standing: entry.standing,
            folder: Path::new(TRIALS).join(entry.folder()),
            alone: Path::new(ALONE).join(entry.folder()),
            frames: fitted.result.recording.frames,
            fps: fitted.result.recording.fps,
            verdict: fitted.result.verdict.headline(),
        });
        let odd = odd.iter().map(|odd| DisagreementPart {
            trial: manifest.trials[odd.trial].name.clone(),
            f: odd.f,
            degrees: odd.degrees,
            probability: odd.probability,
            line: self.disagreement_line(odd),
        });
        let calibrations = found.other_calibrations.iter().map(ToString::to_string);
        let age = manifest.person.lacks_age(manifest.date).map(str::to_owned);
        SessionFile {
            date: manifest.date,
            condition: manifest.condition.clone(),
            operator: manifest.operator.clone(),
            lengths: lengths(alone, fitted),
            trials: trials.collect(),
            without: self.without.clone(),
            disagreements: odd.collect(),
            notes: calibrations.chain(age).collect(),
            ..SessionFile::new(manifest.person.clone(), fitted[0].result.body.clone())
        }
    }

    fn disagreement_line(&self, odd: &Disagreement) -> String {
        let name = &self.manifest.trials[odd.trial].name;
        let left_out = match self.manifest.trials.len() {
            2 => "leave one of the two out".to_owned(),
            _ => format!("leave it out with --without {name}"),
        };
        let [m, nu] = odd.degrees;
        format!(
            "trial {name} disagrees: {} {:.3} m, {:.3} m in the other trials (all lengths: F({m}, {nu}) = {:.0}): \
             another person, or a trial that failed; {left_out}",
            odd.length.replace('_', " "),
            odd.own_m,
            odd.others_m,
            odd.f
        )
    }
}

impl FittedSession {
    /// Reads the folder of a finished session; `body` is its model, if it is not a shipped one.
    ///
    /// # Errors
    /// [`Error::SessionFile`], and of each trial as [`FittedRecording::read`].
    pub fn read(folder: impl AsRef<Path>, body: Option<&str>) -> Result<Self, Error> {
        let folder = folder.as_ref();
        let file = SessionFile::read(folder)?;
        let read = |trial: &TrialPart| FittedRecording::read(folder.join(&trial.folder), body);
        let trials = file.trials.iter().map(read).collect::<Result<_, _>>()?;
        Ok(Self { file, trials })
    }

    /// Whether the session can be used: all trials, and all of one person.
    ///
    /// # Errors
    /// [`Error::Unusable`] names the trial that cannot, or that disagrees with the others.
    pub fn usable(&self) -> Result<(), Error> {
        for (part, trial) in self.file.trials.iter().zip(&self.trials) {
            if let Some(why) = trial.result.verdict.why_unusable() {
                return Err(Error::Unusable(format!("trial {}: {why}", part.name)));
            }
        }
        let odd = self.file.disagreements.first();
        odd.map_or(Ok(()), |odd| Err(Error::Unusable(odd.line.clone())))
    }
}

/// A fault of one trial.
fn named(name: &str, source: Error) -> Error {
    SessionError::Trial { name: name.into(), source: Box::new(source) }.into()
}

/// The one body's lengths, beside what each trial found alone.
fn lengths(alone: &[AloneTrial], fitted: &[FittedRecording]) -> Vec<SessionLength> {
    let of = |i: usize| alone.iter().map(move |trial| &trial.fitted.result.shape.lengths[i]);
    let all = fitted[0].result.shape.lengths.iter().enumerate();
    let length = all.map(|(i, length)| SessionLength {
        name: length.name.clone(),
        length_m: length.length_m,
        sd_m: length.sd_m,
        alone_m: of(i).map(|own| own.length_m).collect(),
        alone_sd_m: of(i).map(|own| own.sd_m).collect(),
    });
    length.collect()
}
