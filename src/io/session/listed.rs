//! The trials of folders that a person names, or that lie side by side in one folder.

use std::fs;
use std::path::{Path, PathBuf};

use super::SessionFileError;
use super::manifest::{MANIFEST, SessionManifest, TrialEntry};
use crate::io::calibration::natural_order::natural;

/// What a recording has in its folder, one of it.
const OF_A_RECORDING: [&str; 7] =
    ["sequence.toml", "masks", "videos", "images", "points", "pose", "synchronized_videos"];

/// The session that some paths are: one `session.toml` or the folder that it is in, one folder of recordings, or recordings. Of
/// several folders of recordings each is a condition, and its trials are named after it.
///
/// # Errors
/// [`SessionFileError`] if there is nothing to fit, two trials have one name, or one of several folders is a session of its own.
pub fn session_of(paths: &[PathBuf]) -> Result<SessionManifest, SessionFileError> {
    if let [path] = paths {
        let manifest = if path.is_dir() { path.join(MANIFEST) } else { path.clone() };
        if manifest.is_file() && manifest.file_name().is_some_and(|name| name == MANIFEST) {
            return SessionManifest::read(&manifest);
        }
        if path.is_dir() && !is_recording(path) {
            return of_trials(of_folder(path)?);
        }
    }
    let trials: Vec<Vec<TrialEntry>> =
        paths.iter().map(|path| of_path(path)).collect::<Result<_, _>>()?;
    of_trials(trials.concat())
}

fn of_trials(trials: Vec<TrialEntry>) -> Result<SessionManifest, SessionFileError> {
    SessionManifest { trials, ..SessionManifest::default() }.with_distinct_names()
}

/// A recording, or the recordings of a condition.
fn of_path(path: &Path) -> Result<Vec<TrialEntry>, SessionFileError> {
    if !path.is_dir() || is_recording(path) {
        return Ok(vec![TrialEntry::of(path)]);
    }
    if path.join(MANIFEST).is_file() {
        return Err(SessionFileError::OneOfSeveral { path: path.join(MANIFEST) });
    }
    let condition = TrialEntry::of(path).name;
    let of_condition = |trial: TrialEntry| TrialEntry {
        name: format!("{condition}_{}", trial.name),
        condition: Some(condition.clone()),
        ..trial
    };
    Ok(of_folder(path)?.into_iter().map(of_condition).collect())
}

/// The recordings in a folder, in the order in which people count.
fn of_folder(path: &Path) -> Result<Vec<TrialEntry>, SessionFileError> {
    let entries = fs::read_dir(path)
        .map_err(|source| SessionFileError::Read { path: path.into(), source })?;
    let folders = entries.flatten().map(|entry| entry.path());
    let mut found: Vec<PathBuf> = folders.filter(|path| is_recording(path)).collect();
    let name = |path: &PathBuf| path.file_name().unwrap_or_default().to_string_lossy().into_owned();
    found.sort_by(|a, b| natural(&name(a), &name(b)));
    match found.is_empty() {
        true => Err(SessionFileError::NoRecordings { path: path.into() }),
        false => Ok(found.iter().map(|path| TrialEntry::of(path)).collect()),
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
        // several folders of recordings are conditions
        let walks = folder.path().to_path_buf();
        let other = folder.path().join("notes");
        fs::create_dir_all(other.join("walk1/masks")).unwrap();
        let session = session_of(&[other.clone(), walks.join("walk2")]).unwrap();
        let trials = session.trials.iter();
        let trials: Vec<_> = trials.map(|t| (t.name.as_str(), t.condition.as_deref())).collect();
        assert_eq!(trials, [("notes_walk1", Some("notes")), ("walk2", None)]);
        fs::write(other.join(MANIFEST), "").unwrap();
        let refused = session_of(&[other.clone(), walks.join("walk2")]).unwrap_err().to_string();
        assert!(refused.contains("notes/session.toml: "), "{refused}");
        fs::remove_dir_all(&other).unwrap();
        fs::create_dir_all(&other).unwrap();

        let nothing = session_of(&[folder.path().join("notes")]).unwrap_err().to_string();
        assert!(nothing.contains("notes: no recordings there"), "{nothing}");
    }
}
