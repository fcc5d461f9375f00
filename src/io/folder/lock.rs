//! A folder that one run at a time writes into.

use std::fs::{self, File, TryLockError};
use std::io::{self, Read, Seek, Write};
use std::path::{Path, PathBuf};

use super::OutError;

/// Name of the file that is locked. It says who holds it.
pub(super) const NAME: &str = ".lock";

/// The most of it that is read.
const MOST_BYTES: u64 = 4096;

/// The lock of a folder. It ends with this value, or with the process.
#[derive(Debug)]
pub(super) struct FolderLock {
    folder: PathBuf,
    /// The folders that were made for it, deepest first.
    made: Vec<PathBuf>,
    /// Locked as long as it is open.
    _file: File,
}

impl FolderLock {
    /// Makes the folder, if it is not there, and locks it.
    ///
    /// # Errors
    /// [`OutError::Locked`] says who holds it, [`OutError::Write`] that the folder cannot be written.
    pub(super) fn take(folder: &Path) -> Result<Self, OutError> {
        let is_lacking = |path: &&Path| !path.as_os_str().is_empty() && !path.exists();
        let made = folder.ancestors().take_while(is_lacking).map(Path::to_path_buf).collect();

        let file = fs::create_dir_all(folder).and_then(|()| lock(&folder.join(NAME)));
        match file.map_err(|source| OutError::write(folder, source))? {
            Some(file) => Ok(Self { folder: folder.into(), made, _file: file }),
            None => Err(OutError::Locked { path: folder.into(), holder: holder(folder) }),
        }
    }
}

impl Drop for FolderLock {
    /// Leaves nothing behind but what was written; what cannot be removed does no harm.
    fn drop(&mut self) {
        let _ = fs::remove_file(self.folder.join(NAME));
        for made in &self.made {
            let _ = fs::remove_dir(made);
        }
    }
}

/// Whether a run holds the lock of a folder now.
///
/// # Errors
/// [`OutError::Locked`] says who.
pub(super) fn check_free(folder: &Path) -> Result<(), OutError> {
    let Ok(file) = File::open(folder.join(NAME)) else {
        return Ok(());
    };
    match file.try_lock_shared() {
        Err(TryLockError::WouldBlock) => {
            Err(OutError::Locked { path: folder.into(), holder: holder(folder) })
        }
        _ => Ok(()),
    }
}

/// The locked file, which says who holds it; `None` if somebody else does.
fn lock(path: &Path) -> io::Result<Option<File>> {
    loop {
        let mut options = File::options();
        let mut file = options.read(true).write(true).create(true).truncate(false).open(path)?;
        match file.try_lock() {
            Ok(()) => {}
            Err(TryLockError::WouldBlock) => return Ok(None),
            // a file system without locks
            Err(TryLockError::Error(fault)) if fault.kind() == io::ErrorKind::Unsupported => {}
            Err(TryLockError::Error(fault)) => return Err(fault),
        }

        // whoever held it before may have removed it meanwhile
        if is_at(&file, path) {
            file.set_len(0)?;
            file.rewind()?;
            file.write_all(this_run().as_bytes())?;
            return Ok(Some(file));
        }
    }
}

#[cfg(unix)]
fn is_at(file: &File, path: &Path) -> bool {
    use std::os::unix::fs::MetadataExt;
    let identity = |metadata: fs::Metadata| (metadata.dev(), metadata.ino());
    let found = fs::metadata(path).map(identity).ok();
    found.is_some() && found == file.metadata().map(identity).ok()
}

#[cfg(not(unix))]
fn is_at(_: &File, path: &Path) -> bool {
    path.exists()
}

/// Process and command.
fn this_run() -> String {
    let words = std::env::args_os().map(|word| word.to_string_lossy().into_owned());
    let command = words.collect::<Vec<_>>().join(" ");
    format!("process {}: {command}", std::process::id())
}

/// What the run that holds the lock of a folder says of itself.
fn holder(folder: &Path) -> String {
    let mut text = Vec::new();
    let read = File::open(folder.join(NAME));
    let read = read.and_then(|file| file.take(MOST_BYTES).read_to_end(&mut text));
    match read {
        Ok(1..) => String::from_utf8_lossy(&text).into_owned(),
        _ => "a process that does not say which".into(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_folder_has_one_run_at_a_time_and_the_second_hears_of_the_first() {
        let folder = tempfile::tempdir().unwrap();
        let out = folder.path().join("a/b");
        let first = FolderLock::take(&out).unwrap();
        for refused in [FolderLock::take(&out).map(drop), check_free(&out)] {
            let message = refused.unwrap_err().to_string();
            let first = format!("process {}: ", std::process::id());
            assert!(message.contains(&first), "{message}");
        }
        drop(first);
        assert!(check_free(&out).is_ok() && FolderLock::take(&out).is_ok());
        assert!(!folder.path().join("a").exists(), "made for the lock alone");
    }

    #[test]
    fn a_lock_whose_process_has_died_holds_nobody_up_and_what_is_written_stays() {
        let folder = tempfile::tempdir().unwrap();
        fs::write(folder.path().join(NAME), "process 1: left by a kill").unwrap();
        let lock = FolderLock::take(folder.path()).unwrap();
        fs::write(folder.path().join("result.json"), "").unwrap();
        drop(lock);
        let left = fs::read_dir(folder.path()).unwrap().flatten().map(|entry| entry.file_name());
        assert_eq!(left.collect::<Vec<_>>(), ["result.json"]);
    }
}
