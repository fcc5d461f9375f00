//! The folder that a result is written into: nothing in it is lost, nothing in it is ever half written.

mod files;
mod film;
pub mod journal;
pub mod jpeg;
mod lock;
pub mod origin;
pub mod overlays;
pub mod pdf;
mod people;
pub(super) mod png;
pub mod segmented;
pub mod silhouettes;
pub mod stereo;
mod table;

use std::fs;
use std::io;
use std::path::{Path, PathBuf};

pub(crate) use files::make_folder;
pub use files::write_atomically;
use files::{UNFINISHED, remove_unfinished, sync_folder};
pub(super) use files::{file_name, parent_of, write_encoded};
use lock::FolderLock;
use serde::{Deserialize, Serialize};
use serde_json::Value;
use tempfile::TempDir;

/// Why a result cannot be written.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum OutError {
    /// The folder holds something already.
    #[error(
        "{}: this folder is not empty: give --overwrite to replace a result in it, --resume to continue one, or another --out",
        path.display()
    )]
    NotEmpty {
        /// The folder.
        path: PathBuf,
    },
    /// A file stands where the folder should be.
    #[error("{}: this is a file: expected a folder, or a name that is free", path.display())]
    NotAFolder {
        /// The file.
        path: PathBuf,
    },
    /// A folder that another run writes into.
    #[error(
        "{}: another run writes into this folder ({holder}): wait until it has ended, or give another --out",
        path.display()
    )]
    Locked {
        /// The folder.
        path: PathBuf,
        /// Who writes: its process and its command.
        holder: String,
    },
    /// A file or folder that cannot be written.
    #[error("{}: cannot be written: {source}", path.display())]
    Write {
        /// The file or folder.
        path: PathBuf,
        /// Why.
        source: io::Error,
    },
}

impl OutError {
    pub(super) fn write(path: &Path, source: io::Error) -> Self {
        Self::Write { path: path.into(), source }
    }
}

/// What to do with a folder that holds something.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Existing {
    /// Leave it alone.
    Refuse,
    /// Continue the run that was begun there.
    Resume,
    /// Replace the result; the old one stays until the new one is complete.
    Overwrite,
}

/// Whether a result may be written into a folder; nothing is written yet.
///
/// # Errors
/// [`OutError`] if it is a file, lies below a file, is being written by another run, or is not empty and must be left alone.
pub fn check_out(folder: &Path, existing: Existing) -> Result<(), OutError> {
    let standing = folder.ancestors().find(|path| path.exists() || path.as_os_str().is_empty());
    if let Some(path) = standing.filter(|path| path.is_file()) {
        return Err(OutError::NotAFolder { path: path.into() });
    }
    lock::check_free(folder)?;

    // the lock of a run that was killed is nobody's
    let is_something = |entry: fs::DirEntry| entry.file_name() != lock::NAME;
    let is_full = || fs::read_dir(folder).into_iter().flatten().flatten().any(is_something);
    if existing == Existing::Refuse && is_full() {
        return Err(OutError::NotEmpty { path: folder.into() });
    }
    Ok(())
}

/// Everything that a run writes into the folder but its journal, and the skins made of it, in the order in which it is
/// replaced: the result last, so that where it stands all of it stands.
const RESULTS: [&str; 5] = ["overlays", "skin", "joints.trc", origin::ORIGIN, "result.json"];

/// What is kept beside a finished run's files.
#[derive(Serialize, Deserialize)]
struct Kept {
    /// What the run was told.
    told: Value,
    /// What was odd about its inputs.
    notes: Vec<String>,
}

/// A folder that results are written into, by nobody else as long as this value lives.
#[derive(Debug)]
pub struct OutFolder {
    path: PathBuf,
    _lock: FolderLock,
}

impl OutFolder {
    /// Makes the folder, if it is not there, and locks it. A folder that was made and is left empty is removed again.
    ///
    /// # Errors
    /// [`OutError::Write`] if it cannot be made, [`OutError::Locked`] if another run writes into it.
    pub fn open(path: &Path) -> Result<Self, OutError> {
        Ok(Self { path: path.into(), _lock: FolderLock::take(path)? })
    }

    /// Where it is.
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// Writes a file into it, whole or not at all.
    ///
    /// # Errors
    /// [`OutError::Write`] names the file.
    pub fn write(&self, name: &str, bytes: &[u8]) -> Result<(), OutError> {
        write_atomically(&self.path.join(name), bytes)
    }

    /// Begins a run that writes `mark` last. Removes what an older run wrote, finished or not; where no run was begun
    /// nothing is removed, for it may be the user's.
    ///
    /// # Errors
    /// [`OutError::Write`] names what could not be removed or written.
    pub fn begin(&self, mark: &str, others: &[&str]) -> Result<(), OutError> {
        let begun = self.begun(mark);
        if self.path.join(mark).is_file() || begun.is_file() {
            let nothing = self.path.join(UNFINISHED);
            let notes = notes_of(mark);
            let all = others.iter().copied().chain([mark, &notes]);
            for place in all.map(|name| self.path.join(name)) {
                replace(&nothing, &place).map_err(|source| OutError::write(&place, source))?;
            }
        }
        fs::write(&begun, "").map_err(|source| OutError::write(&begun, source))
    }

    /// Ends the run that was begun with this mark: writes it.
    ///
    /// # Errors
    /// [`OutError::Write`] names it.
    pub fn finish(&self, mark: &str, bytes: io::Result<Vec<u8>>) -> Result<(), OutError> {
        let place = self.path.join(mark);
        let bytes = bytes.map_err(|source| OutError::write(&place, source))?;
        write_atomically(&place, &bytes)?;
        // what cannot be removed makes the next run clear what this one wrote, which it does anyway
        let _ = fs::remove_file(self.begun(mark));
        Ok(())
    }

    /// Keeps what was odd about the inputs of a finished run, and what it was told, for whoever continues from its files.
    ///
    /// # Errors
    /// [`OutError::Write`] names the file.
    pub fn keep_notes(&self, mark: &str, told: &Value, notes: &[String]) -> Result<(), OutError> {
        let kept = Kept { told: told.clone(), notes: notes.to_vec() };
        let bytes = serde_json::to_vec(&kept).map_err(io::Error::from);
        let bytes = bytes.map_err(|source| OutError::write(&self.path, source))?;
        self.write(&notes_of(mark), &bytes)
    }

    /// The notes of the run of a mark, if it was finished and told the same.
    pub fn kept_notes(&self, mark: &str, told: &Value) -> Option<Vec<String>> {
        if !self.path.join(mark).is_file() {
            return None;
        }
        let bytes = fs::read(self.path.join(notes_of(mark))).ok()?;
        let kept: Kept = serde_json::from_slice(&bytes).ok()?;
        (kept.told == *told).then_some(kept.notes)
    }

    /// Stands while the run of a mark is not finished.
    fn begun(&self, mark: &str) -> PathBuf {
        self.path.join(format!(".begun-{mark}"))
    }

    /// Where the journal of a run is.
    pub fn journal(&self) -> PathBuf {
        self.path.join(".journal")
    }

    /// Takes back the journal that was begun.
    pub fn abandon(&self) {
        // what cannot be removed does no harm
        let _ = fs::remove_dir_all(self.journal());
    }

    /// A folder within it to write a result into, before it is published.
    ///
    /// # Errors
    /// [`OutError::Write`] if it cannot be made.
    pub fn scratch(&self) -> Result<TempDir, OutError> {
        let scratch = tempfile::Builder::new().prefix(UNFINISHED).tempdir_in(&self.path);
        scratch.map_err(|source| OutError::write(&self.path, source))
    }

    /// Puts what was written into a scratch folder into the places of an older result, and removes what that had more.
    ///
    /// Where there is no older result, nothing is removed that is not replaced.
    ///
    /// # Errors
    /// [`OutError::Write`] names what could not be replaced.
    pub fn publish(&self, scratch: TempDir) -> Result<(), OutError> {
        let had_result = self.path.join("result.json").exists();
        for name in RESULTS {
            let (new, place) = (scratch.path().join(name), self.path.join(name));
            if !new.exists() && !had_result {
                continue;
            }
            // whoever finds the new result finds all of it, also after a loss of power
            sync_folder(&self.path);
            replace(&new, &place).map_err(|source| OutError::write(&place, source))?;
        }
        sync_folder(&self.path);
        drop(scratch);
        remove_unfinished(&self.path);
        remove_unfinished(&self.journal());
        Ok(())
    }
}

/// Name of the file of a run's notes.
fn notes_of(mark: &str) -> String {
    format!(".notes-{mark}.json")
}

fn replace(new: &Path, place: &Path) -> io::Result<()> {
    if place.is_dir() {
        fs::remove_dir_all(place)?;
    }
    match (new.exists(), place.exists()) {
        (true, _) => fs::rename(new, place),
        (false, true) => fs::remove_file(place),
        (false, false) => Ok(()),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_folder_that_holds_something_is_left_alone_unless_told_otherwise() {
        let folder = tempfile::tempdir().unwrap();
        assert!(check_out(folder.path(), Existing::Refuse).is_ok());
        assert!(check_out(&folder.path().join("a/b"), Existing::Refuse).is_ok());
        fs::write(folder.path().join("notes.txt"), "mine").unwrap();
        let refused = check_out(folder.path(), Existing::Refuse);
        assert!(matches!(refused, Err(OutError::NotEmpty { .. })));
        for existing in [Existing::Resume, Existing::Overwrite] {
            assert!(check_out(folder.path(), existing).is_ok());
        }
    }

    #[test]
    fn a_file_is_no_folder_and_nothing_can_lie_below_it() {
        let folder = tempfile::tempdir().unwrap();
        let file = folder.path().join("file");
        fs::write(&file, "").unwrap();
        for path in [file.clone(), file.join("out")] {
            let refused = check_out(&path, Existing::Overwrite);
            assert!(matches!(refused, Err(OutError::NotAFolder { .. })));
        }
    }

    #[test]
    fn what_a_stopped_run_wrote_is_removed_by_the_next_and_what_was_there_before_stays() {
        let folder = tempfile::tempdir().unwrap();
        let at = |name: &str| folder.path().join(name);
        let out = OutFolder::open(folder.path()).unwrap();
        fs::write(at("notes.txt"), "mine").unwrap();
        fs::create_dir(at("masks")).unwrap();
        out.begin("quality.csv", &["masks"]).unwrap();
        assert!(at("masks").exists(), "no run made it");
        // the first run is stopped here
        out.begin("quality.csv", &["masks"]).unwrap();
        assert!(!at("masks").exists());
        out.finish("quality.csv", Ok(b"frame".to_vec())).unwrap();
        drop(out);
        let mut left: Vec<_> =
            fs::read_dir(folder.path()).unwrap().flatten().map(|e| e.file_name()).collect();
        left.sort();
        assert_eq!(left, ["notes.txt", "quality.csv"]);
    }

    #[test]
    fn what_a_finished_run_found_odd_is_kept_for_whoever_tells_the_same() {
        let folder = tempfile::tempdir().unwrap();
        let out = OutFolder::open(folder.path()).unwrap();
        let told = Value::from("masks of frames 3 to 9");
        let notes = ["dark".to_owned()];
        out.keep_notes("quality.csv", &told, &notes).unwrap();
        assert_eq!(out.kept_notes("quality.csv", &told), None, "not finished");
        out.finish("quality.csv", Ok(b"frame".to_vec())).unwrap();
        assert_eq!(out.kept_notes("quality.csv", &told), Some(notes.to_vec()));
        assert_eq!(out.kept_notes("quality.csv", &Value::from("other frames")), None);
    }

    #[test]
    fn a_published_result_replaces_the_older_one_and_nothing_else() {
        let folder = tempfile::tempdir().unwrap();
        let at = |name: &str| folder.path().join(name);
        fs::create_dir_all(at("overlays/cam")).unwrap();
        for (name, text) in
            [("result.json", "old"), ("notes.txt", "mine"), (".writing-abc", "left by a kill")]
        {
            fs::write(at(name), text).unwrap();
        }
        let out = OutFolder::open(folder.path()).unwrap();
        let scratch = out.scratch().unwrap();
        fs::write(scratch.path().join("result.json"), "new").unwrap();
        assert_eq!(fs::read(at("result.json")).unwrap(), b"old");
        out.publish(scratch).unwrap();
        assert_eq!(fs::read(at("result.json")).unwrap(), b"new");
        assert_eq!(fs::read(at("notes.txt")).unwrap(), b"mine");
        assert!(!at("overlays").exists() && !at(".writing-abc").exists());
    }
}
