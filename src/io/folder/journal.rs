//! What a search has finished, kept on disk, so that a run that was stopped can be continued.
//!
//! | file                    | content                                                             |
//! |-------------------------|---------------------------------------------------------------------|
//! | `run.json`              | what the run was started with: program, inputs, options              |
//! | `keyframe-000020.json`  | the hypotheses of the keyframe at that position                      |
//! | `trial-0003.json`       | what became of the hypothesis of that number                         |
//!
//! Every file appears by rename, so each is whole or absent. Numbers are written so that they come back to the bit.

use std::fs;
use std::io;
use std::path::{Path, PathBuf};
use std::sync::{Mutex, PoisonError};

use serde::Serialize;
use serde::de::DeserializeOwned;
use serde_json::Value;

use super::{OutError, write_atomically};
use crate::inference::search::{Hypothesis, Journal, Trial};

/// Name of the file that says what a run was started with.
const RUN: &str = "run.json";

/// Why a run cannot be continued.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum JournalError {
    /// The journal cannot be written or read.
    #[error(transparent)]
    Out(#[from] OutError),
    /// The journal belongs to a run with other inputs or options.
    #[error(
        "{}: the run there was started with another {what} ({was}, now {is}): continue it as it was started, or give --overwrite",
        path.display()
    )]
    OtherRun {
        /// The result's folder.
        path: PathBuf,
        /// What differs.
        what: String,
        /// What it was.
        was: String,
        /// What it is.
        is: String,
    },
}

/// A journal in a folder.
#[derive(Debug)]
pub struct DiskJournal {
    folder: PathBuf,
    fault: Mutex<Option<OutError>>,
}

impl DiskJournal {
    /// A new journal in a folder; what an earlier run left there is removed.
    ///
    /// `run` is what the run depends on: it is compared when the run is continued.
    ///
    /// # Errors
    /// [`OutError`] if the folder cannot be written.
    pub fn create(folder: &Path, run: &Value) -> Result<Self, OutError> {
        clear(folder).map_err(|source| OutError::write(folder, source))?;
        fs::create_dir_all(folder).map_err(|source| OutError::write(folder, source))?;
        write_atomically(&folder.join(RUN), run.to_string().as_bytes())?;
        Ok(Self { folder: folder.into(), fault: Mutex::default() })
    }

    /// The journal of an earlier run of the same inputs and options; a new one where there is none.
    ///
    /// # Errors
    /// [`JournalError::OtherRun`] names the first difference.
    pub fn resume(folder: &Path, run: &Value) -> Result<Self, JournalError> {
        let Some(was) = read::<Value>(&folder.join(RUN)) else {
            return Ok(Self::create(folder, run)?);
        };
        if let Some((what, was, is)) = difference("", &was, run) {
            return Err(JournalError::OtherRun {
                path: folder.parent().unwrap_or(folder).into(),
                what,
                was,
                is,
            });
        }
        Ok(Self { folder: folder.into(), fault: Mutex::default() })
    }

    /// The first thing that could not be kept, if any: the run itself does not need it.
    pub fn fault(self) -> Option<OutError> {
        self.fault.into_inner().unwrap_or_else(PoisonError::into_inner)
    }

    fn keyframe(&self, keyframe: usize) -> PathBuf {
        self.folder.join(format!("keyframe-{keyframe:06}.json"))
    }

    fn trial(&self, index: usize) -> PathBuf {
        self.folder.join(format!("trial-{index:04}.json"))
    }

    fn keep<T: Serialize + ?Sized>(&self, path: &Path, what: &T) {
        let written = match serde_json::to_vec(what) {
            Ok(bytes) => write_atomically(path, &bytes),
            Err(source) => Err(OutError::write(path, source.into())),
        };
        if let Err(fault) = written {
            let mut first = self.fault.lock().unwrap_or_else(PoisonError::into_inner);
            first.get_or_insert(fault);
        }
    }
}

impl Journal for DiskJournal {
    fn kept_keyframe(&self, keyframe: usize) -> Option<Vec<Hypothesis>> {
        read(&self.keyframe(keyframe))
    }

    fn keep_keyframe(&self, keyframe: usize, hypotheses: &[Hypothesis]) {
        self.keep(&self.keyframe(keyframe), hypotheses);
    }

    fn kept_trial(&self, index: usize) -> Option<Trial> {
        read(&self.trial(index))
    }

    fn keep_trial(&self, index: usize, trial: &Trial) {
        self.keep(&self.trial(index), trial);
    }
}

/// What a file holds; `None` if it is absent or not that.
fn read<T: DeserializeOwned>(path: &Path) -> Option<T> {
    serde_json::from_slice(&fs::read(path).ok()?).ok()
}

/// Removes a journal, `run.json` first: without it the rest counts for nothing.
fn clear(folder: &Path) -> io::Result<()> {
    let absent_is_fine = |result: io::Result<()>| match result {
        Err(error) if error.kind() == io::ErrorKind::NotFound => Ok(()),
        result => result,
    };
    absent_is_fine(fs::remove_file(folder.join(RUN)))?;
    absent_is_fine(fs::remove_dir_all(folder))
}

/// Where two values differ first, and the two texts there.
fn difference(place: &str, was: &Value, is: &Value) -> Option<(String, String, String)> {
    let inside = |key: &str| match place {
        "" => key.to_owned(),
        place => format!("{place} {key}"),
    };

    match (was, is) {
        (Value::Object(a), Value::Object(b)) => {
            // keys of both, so that one that is new or gone counts as well
            let mut keys: Vec<&String> = a.keys().chain(b.keys()).collect();
            keys.sort();
            keys.dedup();
            let at = |object: &serde_json::Map<String, Value>, key: &str| {
                object.get(key).cloned().unwrap_or_default()
            };
            keys.into_iter().find_map(|key| difference(&inside(key), &at(a, key), &at(b, key)))
        }
        (was, is) if was == is => None,
        (was, is) => Some((place.to_owned(), shortened(was), shortened(is))),
    }
}

fn shortened(value: &Value) -> String {
    let text = value.to_string();
    match text.char_indices().nth(24) {
        Some((end, _)) => format!("{}…", &text[..end]),
        None => text,
    }
}

#[cfg(test)]
mod tests {
    use nalgebra::{DVector, Rotation3, Vector3};
    use serde_json::json;

    use super::*;
    use crate::body::{Motion, Shape};
    use crate::inference::frame::FrameFit;
    use crate::inference::search::Origin;

    fn trial() -> Trial {
        let motion = Motion {
            position_world: Vector3::new(0.1, -0.0, 1e-300),
            world_from_root: Rotation3::from_scaled_axis(Vector3::new(0.3, 1.0 / 3.0, -2.0)),
            angles: DVector::from_vec(vec![std::f64::consts::PI, 0.1 + 0.2]),
        };
        Trial {
            hypothesis: Hypothesis {
                origin: Origin::Keyframe(1),
                keyframe: 20,
                shape: Shape(DVector::from_vec(vec![0.012_345_678_901_234_567])),
                motion: motion.clone(),
                keyframe_cost: 1.0 / 7.0,
            },
            shape_cost: 2.0_f64.sqrt(),
            frames: vec![
                None,
                Some(FrameFit {
                    motion,
                    data: 1.0 / 3.0,
                    pose: 0.0,
                    step: 5e-324,
                    observations: 99.0,
                    recovered: true,
                }),
            ],
        }
    }

    #[test]
    fn what_is_kept_comes_back_to_the_bit() {
        let folder = tempfile::tempdir().unwrap();
        let run = json!({"options": {"every": 20}});
        let journal = DiskJournal::create(&folder.path().join("journal"), &run).unwrap();
        assert_eq!(journal.kept_trial(3), None);
        journal.keep_trial(3, &trial());
        journal.keep_keyframe(20, &[trial().hypothesis]);
        let again = DiskJournal::resume(&folder.path().join("journal"), &run).unwrap();
        let bits = |t: &Trial| format!("{t:?}");
        assert_eq!(bits(&again.kept_trial(3).unwrap()), bits(&trial()));
        assert_eq!(again.kept_keyframe(20).unwrap(), [trial().hypothesis]);
        assert!(journal.fault().is_none());
    }

    #[test]
    fn a_run_with_another_option_is_refused_and_the_option_named() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join(".journal");
        DiskJournal::create(&path, &json!({"options": {"search": {"every": 20}}})).unwrap();
        let other = json!({"options": {"search": {"every": 10}}});
        let message = DiskJournal::resume(&path, &other).unwrap_err().to_string();
        let said = "another options search every (20, now 10)";
        assert!(message.contains(said), "{message}");
    }

    #[test]
    fn half_a_file_counts_as_none() {
        let folder = tempfile::tempdir().unwrap();
        let journal = DiskJournal::create(folder.path(), &json!({})).unwrap();
        journal.keep_trial(0, &trial());
        let path = folder.path().join("trial-0000.json");
        let text = fs::read(&path).unwrap();
        fs::write(&path, &text[..text.len() / 2]).unwrap();
        assert_eq!(journal.kept_trial(0), None);
    }

    #[test]
    fn what_cannot_be_kept_is_told_at_the_end() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("journal");
        let journal = DiskJournal::create(&path, &json!({})).unwrap();
        fs::remove_dir_all(&path).unwrap();
        journal.keep_trial(0, &trial());
        assert!(journal.fault().is_some());
    }
}
