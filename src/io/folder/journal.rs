//! What a search has finished, kept on disk, so that a run that was stopped can be continued.
//!
//! | file                    | content                                                             |
//! |-------------------------|---------------------------------------------------------------------|
//! | `run.json`              | what the run was started with: program, inputs, options              |
//! | `keyframe-000020.json`  | the hypotheses of the keyframe at that position                      |
//! | `trial-0003.json`       | what became of the hypothesis of that number                         |
//!
//! Every file appears by rename, so each is whole or absent. Numbers are written so that they come back to the bit.
//!
//! Each step is sealed: beside it stands the BLAKE3 of its name and content, keyed by what the run was started with. A step
//! of another run, of another name or with another digit is found, and computed again.

use std::fs;
use std::io;
use std::path::{Path, PathBuf};
use std::sync::{Mutex, MutexGuard, PoisonError};

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
    /// A finished step that could not be kept.
    #[error(
        "{0}; the run was stopped, what it had finished before is kept: continue it with --resume"
    )]
    NotKept(OutError),
}

/// A journal in a folder.
#[derive(Debug)]
pub struct DiskJournal {
    folder: PathBuf,
    /// Of what the run was started with.
    key: [u8; blake3::KEY_LEN],
    /// Files that an earlier run should have left and has not.
    damaged: Vec<String>,
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
        Ok(Self::at(folder, run))
    }

    fn at(folder: &Path, run: &Value) -> Self {
        let key = *blake3::hash(run.to_string().as_bytes()).as_bytes();
        Self { folder: folder.into(), key, damaged: Vec::new(), fault: Mutex::default() }
    }

    /// The journal of an earlier run of the same inputs and options; a new one where there is none.
    ///
    /// # Errors
    /// [`JournalError::OtherRun`] names the first difference.
    pub fn resume(folder: &Path, run: &Value) -> Result<Self, JournalError> {
        let run_file = folder.join(RUN);
        let was = fs::read(&run_file).ok().map(|bytes| serde_json::from_slice::<Value>(&bytes));
        let Some(Ok(was)) = was else {
            let damaged = was.map(|_| RUN.to_owned());
            let created = Self::create(folder, run)?;
            return Ok(Self { damaged: damaged.into_iter().collect(), ..created });
        };

        // the same run, or none that can be resumed
        if let Some((what, was, is)) = difference("", &was, run) {
            return Err(JournalError::OtherRun {
                path: folder.parent().unwrap_or(folder).into(),
                what,
                was,
                is,
            });
        }

        let mut journal = Self::at(folder, run);
        journal.damaged = steps(folder).filter(|name| journal.content(name).is_none()).collect();
        journal.damaged.sort();
        Ok(journal)
    }

    /// What of an earlier run cannot be used, in one line.
    pub fn note(&self) -> Option<String> {
        let (first, others) = self.damaged.split_first()?;
        let path = self.folder.join(first);
        let whole = if first == RUN { ", and all that was finished" } else { "" };
        let more = match others.len() {
            0 => String::new(),
            more => format!(", and {more} more like it"),
        };
        Some(format!(
            "{}: changed since this run wrote it, or another run's{more}: computed again{whole}",
            path.display()
        ))
    }

    /// Ends the run's use of the journal, in which all that was finished is kept.
    ///
    /// # Errors
    /// [`JournalError::NotKept`] with the first fault.
    pub fn into_whole(self) -> Result<(), JournalError> {
        match self.fault.into_inner().unwrap_or_else(PoisonError::into_inner) {
            Some(fault) => Err(JournalError::NotKept(fault)),
            None => Ok(()),
        }
    }

    fn fault(&self) -> MutexGuard<'_, Option<OutError>> {
        self.fault.lock().unwrap_or_else(PoisonError::into_inner)
    }

    fn keep<T: Serialize + ?Sized>(&self, name: &str, what: &T) {
        let path = self.folder.join(name);
        let written = match serde_json::to_string(what) {
            Ok(content) => write_atomically(&path, self.sealed(name, &content).as_bytes()),
            Err(source) => Err(OutError::write(&path, source.into())),
        };
        if let Err(fault) = written {
            self.fault().get_or_insert(fault);
        }
    }

    /// What was kept under a name; `None` if it is absent or not what this run would have written.
    fn kept<T: DeserializeOwned>(&self, name: &str) -> Option<T> {
        serde_json::from_str(&self.content(name)?).ok()
    }

    /// The content of a sealed file, if the seal is this run's.
    fn content(&self, name: &str) -> Option<String> {
        let text = fs::read_to_string(self.folder.join(name)).ok()?;
        let (_, content) = text.strip_suffix(END)?.split_once(BETWEEN)?;
        (self.sealed(name, content) == text).then(|| content.to_owned())
    }

    /// The text of a file: JSON, `{"blake3": …, "content": …}`.
    fn sealed(&self, name: &str, content: &str) -> String {
        let mut hasher = blake3::Hasher::new_keyed(&self.key);
        // no name has a line's end in it
        for part in [name, "\n", content] {
            hasher.update(part.as_bytes());
        }
        format!("{BEGIN}{}{BETWEEN}{content}{END}", hasher.finalize())
    }
}

/// What stands before, between and after the sum and the content of a sealed file.
const BEGIN: &str = "{\"blake3\":\"";
const BETWEEN: &str = "\",\n\"content\":";
const END: &str = "}\n";

fn keyframe_name(keyframe: usize) -> String {
    format!("keyframe-{keyframe:06}.json")
}

fn trial_name(index: usize) -> String {
    format!("trial-{index:04}.json")
}

/// The names of the steps that a folder holds.
fn steps(folder: &Path) -> impl Iterator<Item = String> {
    let entries = fs::read_dir(folder).into_iter().flatten().flatten();
    let names = entries.filter_map(|entry| entry.file_name().into_string().ok());
    names.filter(|name| ["keyframe-", "trial-"].iter().any(|kind| name.starts_with(kind)))
}

impl Journal for DiskJournal {
    fn kept_keyframe(&self, keyframe: usize) -> Option<Vec<Hypothesis>> {
        self.kept(&keyframe_name(keyframe))
    }

    fn keep_keyframe(&self, keyframe: usize, hypotheses: &[Hypothesis]) {
        self.keep(&keyframe_name(keyframe), hypotheses);
    }

    fn kept_trial(&self, index: usize) -> Option<Trial> {
        self.kept(&trial_name(index))
    }

    fn keep_trial(&self, index: usize, trial: &Trial) {
        self.keep(&trial_name(index), trial);
    }

    fn is_failing(&self) -> bool {
        self.fault().is_some()
    }
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
        assert!(again.note().is_none() && journal.into_whole().is_ok());
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

    /// A journal of one run with the trials 0 to 2, whose files somebody changes; the trials that are still kept, and the note.
    fn after(change: impl Fn(&Path)) -> (Vec<usize>, Option<String>) {
        let folder = tempfile::tempdir().unwrap();
        let journal = DiskJournal::create(folder.path(), &json!({"run": 1})).unwrap();
        (0..3).for_each(|i| journal.keep_trial(i, &trial()));
        change(folder.path());
        let again = DiskJournal::resume(folder.path(), &json!({"run": 1})).unwrap();
        ((0..3).filter(|i| again.kept_trial(*i).is_some()).collect(), again.note())
    }

    #[test]
    fn what_somebody_changed_is_named_once_and_counts_as_none() {
        assert_eq!(after(|_| {}), (vec![0, 1, 2], None));

        let (kept, note) = after(|folder| {
            let path = folder.join("trial-0001.json");
            let text = fs::read_to_string(&path).unwrap();
            fs::write(&path, text.replacen("\"keyframe\":20", "\"keyframe\":21", 1)).unwrap();
        });
        assert_eq!(kept, [0, 2], "one digit");
        assert!(note.unwrap().contains("trial-0001.json: changed since this run wrote it"));

        let (kept, note) = after(|folder| {
            let at = |name: &str| folder.join(name);
            fs::rename(at("trial-0001.json"), at("other")).unwrap();
            fs::rename(at("trial-0000.json"), at("trial-0001.json")).unwrap();
            fs::rename(at("other"), at("trial-0000.json")).unwrap();
        });
        assert_eq!(kept, [2], "two exchanged");
        assert!(note.unwrap().contains(
            "trial-0000.json: changed since this run wrote it, or another run's, and 1 more"
        ));

        let (kept, _) = after(|folder| {
            let path = folder.join("trial-0002.json");
            let text = fs::read(&path).unwrap();
            fs::write(&path, &text[..text.len() / 2]).unwrap();
        });
        assert_eq!(kept, [0, 1], "half a file");

        let (kept, note) = after(|folder| fs::write(folder.join(RUN), "{").unwrap());
        assert_eq!(kept, [0; 0]);
        assert!(note.unwrap().contains("run.json: changed"));
    }

    #[test]
    fn what_another_run_kept_counts_as_none() {
        let (kept, note) = after(|folder| {
            let other = tempfile::tempdir().unwrap();
            let journal = DiskJournal::create(other.path(), &json!({"run": 2})).unwrap();
            journal.keep_trial(1, &trial());
            fs::copy(other.path().join("trial-0001.json"), folder.join("trial-0001.json")).unwrap();
        });
        assert_eq!(kept, [0, 2]);
        assert!(note.is_some());
    }

    #[test]
    fn what_cannot_be_kept_stops_the_run() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("journal");
        let journal = DiskJournal::create(&path, &json!({})).unwrap();
        assert!(!journal.is_failing());
        fs::remove_dir_all(&path).unwrap();
        journal.keep_trial(0, &trial());
        assert!(journal.is_failing());
        let message = journal.into_whole().unwrap_err().to_string();
        assert!(message.contains("trial-0000.json: cannot be written"), "{message}");
        assert!(message.contains("continue it with --resume"), "{message}");
    }
}
