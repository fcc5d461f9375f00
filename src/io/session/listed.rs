//! The trials of folders that a person names, or that lie side by side in one folder.

use std::fs;
use std::path::{Path, PathBuf};

use super::SessionFileError;
use super::manifest::{MANIFEST, SessionManifest, TrialEntry};
use crate::io::calibration::natural_order::natural;

/// What a recording has in its folder, one of it.
const OF_A_RECORDING: [&str; 7] =
    ["sequence.toml", "masks", "videos", "images", "points", "pose", "synchronized_videos"];

/// The session that some paths are: one `session.toml` or the folder that it is in, one folder of recordings, or recordings.
///
/// # Errors
/// [`SessionFileError`] if there is nothing to fit, or two trials have one name.
pub fn session_of(paths: &[PathBuf]) -> Result<SessionManifest, SessionFileError> {
    if let [path] = paths {
        let manifest = if path.is_dir() { path.join(MANIFEST) } else { path.clone() };
        if manifest.is_file() && manifest.file_name().is_some_and(|name| name == MANIFEST) {
            return SessionManifest::read(&manifest);
        }
        if path.is_dir() && !is_recording(path) {
            return of_folder(path);
        }
    }
    of_recordings(paths)
}

fn of_recordings(paths: &[PathBuf]) -> Result<SessionManifest, SessionFileError> {
    let trials = paths.iter().map(|path| TrialEntry::of(path)).collect();
    SessionManifest { trials, ..SessionManifest::default() }.with_distinct_names()
}

/// The recordings in a folder, in the order in which people count.
fn of_folder(path: &Path) -> Result<SessionManifest, SessionFileError> {
    let entries = fs::read_dir(path)
        .map_err(|source| SessionFileError::Read { path: path.into(), source })?;
    let folders = entries.flatten().map(|entry| entry.path());
    let mut found: Vec<PathBuf> = folders.filter(|path| is_recording(path)).collect();
    let name = |path: &PathBuf| path.file_name().unwrap_or_default().to_string_lossy().into_owned();
    found.sort_by(|a, b| natural(&name(a), &name(b)));
    match found.is_empty() {
        true => Err(SessionFileError::NoRecordings { path: path.into() }),
        false => of_recordings(&found),
    }
}

/// Whether a folder is one recording: it says so, or has footage of its own.
fn is_recording(folder: &Path) -> bool {
    let has_films = || {
        let files = fs::read_dir(folder).into_iter().flatten().flatten();
        files.map(|entry| entry.path()).any(|path| path.extension().is_some_and(|e| e == "mp4"))
    };
    folder.is_dir() && (OF_A_RECORDING.iter().any(|name| folder.join(name).exists()) || has_films())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_folder_of_walks_is_a_session_in_the_order_of_their_numbers() {
        let folder = tempfile::tempdir().unwrap();
        for name in ["walk10/masks", "walk2/videos", "notes", "walk1/masks"] {
            fs::create_dir_all(folder.path().join(name)).unwrap();
        }
        let names = |paths: &[PathBuf]| -> Vec<String> {
            let session = session_of(paths).unwrap();
            session.trials.into_iter().map(|trial| trial.name).collect()
        };
        assert_eq!(names(&[folder.path().into()]), ["walk1", "walk2", "walk10"]);
        // one recording is a session of one trial
        assert_eq!(names(&[folder.path().join("walk2")]), ["walk2"]);
        let nothing = session_of(&[folder.path().join("notes")]).unwrap_err().to_string();
        assert!(nothing.contains("notes: no recordings there"), "{nothing}");
    }
}
