//! `session.json`: what a session found, and where each trial's result is.

use std::path::{Path, PathBuf};

use serde::{Deserialize, Serialize};

use super::{Date, Person, SessionFileError};
use crate::io::input::{self, MOST_OF_A_TEXT};
use crate::io::result::Program;

/// The name of the file.
pub const SESSION: &str = "session.json";
const FORMAT: &str = "maquette-session";
const VERSION: u32 = 1;

/// What a session found; the same with more words in docs/formats.md.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct SessionFile {
    /// `maquette-session`.
    pub format: String,
    /// 1.
    pub version: u32,
    /// What wrote it.
    pub program: Program,
    /// Who walked.
    pub person: Person,
    /// The day.
    #[serde(default)]
    pub date: Option<Date>,
    /// What all trials have in common.
    #[serde(default)]
    pub condition: Option<String>,
    /// Who measured.
    #[serde(default)]
    pub operator: Option<String>,
    /// Name of the body model.
    pub body: String,
    /// The one body's lengths.
    pub lengths: Vec<SessionLength>,
    /// Trial by trial.
    pub trials: Vec<TrialPart>,
    /// Trials that were left out by `--without`.
    pub without: Vec<String>,
    /// Trials whose lengths are not those of the others.
    pub disagreements: Vec<DisagreementPart>,
    /// What a person should know, each in one line.
    pub notes: Vec<String>,
}

/// A length of the one body.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct SessionLength {
    /// Its name in the model.
    pub name: String,
    /// Metres, at rest.
    pub length_m: f64,
    /// Its standard deviation.
    pub sd_m: Option<f64>,
    /// What each trial found alone, metres, in the order of the trials.
    pub alone_m: Vec<f64>,
    /// How sure each was.
    pub alone_sd_m: Vec<Option<f64>>,
}

/// A trial.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct TrialPart {
    /// Its name.
    pub name: String,
    /// What is particular to it.
    #[serde(default)]
    pub condition: Option<String>,
    /// Whether the person stands still in it: the zero of the angles of all others.
    #[serde(default)]
    pub standing: bool,
    /// The folder of its result with the one body, from that of the session.
    pub folder: PathBuf,
    /// The folder of its fit alone.
    pub alone: PathBuf,
    /// Number of frames.
    pub frames: usize,
    /// Frames per second.
    pub fps: f64,
    /// What is wrong with it, in one line.
    #[serde(default)]
    pub verdict: Option<String>,
}

/// A trial whose lengths are not those of the others.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct DisagreementPart {
    /// Its name.
    pub trial: String,
    /// F of its lengths.
    pub f: f64,
    /// The degrees of freedom of numerator and denominator.
    pub degrees: [usize; 2],
    /// The probability of such an F of the same person.
    pub probability: f64,
    /// In one line, with what to do.
    pub line: String,
}

impl SessionFile {
    /// Nothing yet of a session by this program.
    pub fn new(person: Person, body: String) -> Self {
        Self {
            format: FORMAT.into(),
            version: VERSION,
            program: Program {
                name: env!("CARGO_PKG_NAME").into(),
                version: env!("CARGO_PKG_VERSION").into(),
            },
            person,
            date: None,
            condition: None,
            operator: None,
            body,
            lengths: Vec::new(),
            trials: Vec::new(),
            without: Vec::new(),
            disagreements: Vec::new(),
            notes: Vec::new(),
        }
    }

    /// The text of the file.
    ///
    /// # Errors
    /// The serialiser's, if it has any.
    pub fn text(&self) -> Result<String, serde_json::Error> {
        Ok(serde_json::to_string_pretty(self)? + "\n")
    }

    /// Reads the `session.json` of a folder; an unknown or missing field, and a folder that leads out of the session, are faults.
    ///
    /// # Errors
    /// [`SessionFileError`] names the file.
    pub fn read(folder: &Path) -> Result<Self, SessionFileError> {
        #[derive(Deserialize)]
        struct Head {
            format: String,
            version: u32,
        }

        let path = folder.join(SESSION);
        let bytes = input::read(&path, MOST_OF_A_TEXT)
            .map_err(|source| SessionFileError::Read { path: path.clone(), source })?;
        let fault = |message: String| SessionFileError::Session { path: path.clone(), message };
        let syntax = |source: serde_json::Error| fault(source.to_string());
        let head: Head = serde_json::from_slice(&bytes).map_err(syntax)?;
        if head.format != FORMAT {
            return Err(fault(format!("expected the format {FORMAT:?}, found {:?}", head.format)));
        }
        if head.version != VERSION {
            let (found, expected) = (head.version, VERSION);
            return Err(SessionFileError::Version { path, found, expected });
        }

        let file: Self = serde_json::from_slice(&bytes).map_err(syntax)?;
        let is_within = |folder: &Path| {
            folder.components().all(|part| matches!(part, std::path::Component::Normal(_)))
        };
        let out = file.trials.iter().find(|t| !is_within(&t.folder) || !is_within(&t.alone));
        match out {
            Some(trial) => Err(fault(format!("the folders of trial {} lie elsewhere", trial.name))),
            None if file.trials.is_empty() => Err(fault("it has no trials".into())),
            None => Ok(file),
        }
    }

    /// Their age in completed years, if it is known.
    pub fn age_years(&self) -> Option<u32> {
        self.person.age_on(self.date)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn session() -> SessionFile {
        let trial = TrialPart {
            name: "walk_1".into(),
            condition: None,
            standing: false,
            folder: "trials/walk_1".into(),
            alone: "alone/walk_1".into(),
            frames: 90,
            fps: 50.0,
            verdict: None,
        };
        let file = SessionFile::new(Person::default(), "human-metaballs".into());
        SessionFile { trials: vec![trial], ..file }
    }

    fn read(text: &str) -> Result<SessionFile, String> {
        let folder = tempfile::tempdir().unwrap();
        std::fs::write(folder.path().join(SESSION), text).unwrap();
        SessionFile::read(folder.path()).map_err(|fault| fault.to_string())
    }

    #[test]
    fn what_is_written_is_read_and_nothing_else_is() {
        let text = session().text().unwrap();
        assert_eq!(read(&text).unwrap(), session());
        for (from, to, expected) in [
            ("\"without\"", "\"witout\"", "unknown field `witout`"),
            ("\"version\": 1", "\"version\": 2", "version 2 of the format"),
            ("maquette-session", "maquette-result", "expected the format"),
            ("trials/walk_1", "../walk_1", "lie elsewhere"),
        ] {
            let fault = read(&text.replacen(from, to, 1)).unwrap_err();
            assert!(fault.contains(expected), "{fault}");
        }
    }
}
