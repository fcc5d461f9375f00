//! `session.toml`, as a person writes it.

use std::path::{Path, PathBuf};

use serde::Deserialize;

use super::{Date, Person, SessionFileError};
use crate::io::folder::file_name;
use crate::io::{input, unknown_key};

/// The name of the file in a folder.
pub(super) const MANIFEST: &str = "session.toml";

/// Who walked, and in which recordings.
#[derive(Debug, Clone, Default, PartialEq, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct SessionManifest {
    /// The day.
    pub date: Option<Date>,
    /// What all trials have in common: with an orthosis, after the operation, …
    pub condition: Option<String>,
    /// Who measured.
    pub operator: Option<String>,
    /// Who walked.
    pub person: Person,
    /// The trials, in their order.
    #[serde(rename = "trial")]
    pub trials: Vec<TrialEntry>,
}

/// A trial.
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct TrialEntry {
    /// Its name; that of the recording's folder, if none is stated.
    #[serde(default)]
    pub name: String,
    /// The recording, relative to the file.
    pub recording: PathBuf,
    /// What is particular to it.
    #[serde(default)]
    pub condition: Option<String>,
    /// Whether the person stands still in it: the zero of the angles of all others.
    #[serde(default)]
    pub standing: bool,
}

impl SessionManifest {
    /// Reads a `session.toml`; an unknown key, a wrong date and two trials of one name are faults.
    ///
    /// # Errors
    /// [`SessionFileError`] names the file, and the line where there is one.
    pub fn read(path: &Path) -> Result<Self, SessionFileError> {
        let text = input::read_text(path)
            .map_err(|source| SessionFileError::Read { path: path.into(), source })?;
        let manifest: Self = toml::from_str(&text).map_err(|fault| SessionFileError::Manifest {
            path: path.into(),
            line: fault.span().map_or(1, |span| unknown_key::line_of(&text, span.start)),
            message: fault.message().replace('\n', " "),
        })?;
        if manifest.trials.is_empty() {
            return Err(SessionFileError::NoTrials { path: path.into() });
        }
        if manifest.trials.iter().all(|trial| trial.standing) {
            return Err(SessionFileError::NoWalks { path: path.into() });
        }
        let folder = path.parent().unwrap_or(Path::new(""));
        let trials = manifest.trials.into_iter();
        let trials = trials.map(|trial| trial.below(folder)).collect();
        Self { trials, ..manifest }.with_distinct_names()
    }

    /// The same, if no two trials have one name.
    pub(super) fn with_distinct_names(self) -> Result<Self, SessionFileError> {
        for (i, trial) in self.trials.iter().enumerate() {
            let before = self.trials[..i].iter().find(|other| other.name == trial.name);
            if let Some(first) = before {
                return Err(SessionFileError::SameName {
                    name: trial.name.clone(),
                    first: first.recording.clone(),
                    second: trial.recording.clone(),
                });
            }
        }
        Ok(self)
    }
}

impl TrialEntry {
    /// Of a recording, named as its folder.
    pub(super) fn of(recording: &Path) -> Self {
        let whole = recording.canonicalize().unwrap_or_else(|_| recording.into());
        let folder = if whole.is_file() { whole.parent().unwrap_or(&whole) } else { &whole };
        let name = folder.file_name().map(|name| name.to_string_lossy().into_owned());
        let name = name.unwrap_or_default();
        Self { name, recording: recording.into(), condition: None, standing: false }
    }

    /// The name of its folder.
    pub fn folder(&self) -> String {
        file_name(&self.name)
    }

    fn below(self, folder: &Path) -> Self {
        let own = Self::of(&folder.join(&self.recording));
        let name = if self.name.is_empty() { own.name } else { self.name };
        Self { name, recording: own.recording, ..self }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn read(text: &str) -> Result<SessionManifest, String> {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join(MANIFEST);
        std::fs::write(&path, text).unwrap();
        SessionManifest::read(&path).map_err(|fault| fault.to_string())
    }

    #[test]
    fn trials_are_named_as_their_folders_unless_they_say_otherwise() {
        let text = "date = \"2026-03-02\"\n[person]\nid = \"P 017\"\nsex = \"female\"\nfootwear = \"shoes\"\n\
                    affected_side = \"left\"\n[[trial]]\nrecording = \"a/walk_1\"\n[[trial]]\nname = \"fast\"\nrecording = \"b\"";
        let manifest = read(text).unwrap();
        let names: Vec<&str> = manifest.trials.iter().map(|trial| trial.name.as_str()).collect();
        assert_eq!(names, ["walk_1", "fast"]);
        assert!(manifest.trials[0].recording.ends_with("a/walk_1"));
        assert_eq!(manifest.person.id.as_deref(), Some("P 017"));
    }

    #[test]
    fn what_is_wrong_is_named_with_its_line() {
        let wrong = read("[person]\nbirthdate = \"1953-04-12\"\n[[trial]]\nrecording = \"a\"");
        let fault = wrong.unwrap_err();
        assert!(fault.contains(":2: unknown field `birthdate`"), "{fault}");
        let fault = read("[person]\nbirth_date = \"12.4.53\"\n").unwrap_err();
        assert!(fault.contains(":2: ") && fault.contains("1953-04-12"), "{fault}");
        assert!(read("[person]\nid = \"x\"").unwrap_err().contains("no trials"));
        let standing = read("[[trial]]\nrecording = \"a\"\nstanding = true");
        assert!(standing.unwrap_err().contains("every trial is a standing one"));
        let twice = read("[[trial]]\nrecording = \"a/w\"\n[[trial]]\nrecording = \"b/w\"");
        assert!(twice.unwrap_err().contains("two trials are named w"));
    }
}
