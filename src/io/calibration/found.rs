//! Which files of a folder are its calibration.

use std::fs;
use std::path::{Path, PathBuf};

use super::CalibrationError;
use super::natural_order::natural;

/// How the names of calibrations end that are found in a folder, in any case; the first kind that is there counts.
const ENDINGS: [&str; 4] = [".toml", EASYMOCAP[0], ".qca.txt", ".xcp"];

/// The two files of EasyMocap's calibration.
pub(super) const EASYMOCAP: [&str; 2] = ["intri.yml", "extri.yml"];

/// Descriptions of something else.
const MANIFESTS: [&str; 3] = ["sequence.toml", "config.toml", "cargo.toml"];

/// The calibration that a folder is read from: of the first of the kinds that it holds, the last by name.
///
/// # Errors
/// [`CalibrationError::Read`] and [`CalibrationError::EmptyFolder`].
pub(in crate::io) fn find(folder: &Path) -> Result<PathBuf, CalibrationError> {
    let unreadable = |reason| CalibrationError::Read { path: folder.into(), reason };
    let mut names = Vec::new();
    for entry in fs::read_dir(folder).map_err(unreadable)? {
        names.extend(entry.map_err(unreadable)?.file_name().into_string());
    }

    names.sort_by(|a, b| natural(a, b));
    let last = |ending: &&str| {
        let of_kind = |name: &&String| {
            let name = name.to_lowercase();
            name.ends_with(ending) && !MANIFESTS.contains(&name.as_str())
        };
        names.iter().rfind(of_kind)
    };
    let found = ENDINGS.iter().find_map(last).map(|name| folder.join(name));
    found.ok_or_else(|| CalibrationError::EmptyFolder { path: folder.into() })
}

/// The files that a calibration is read from, by name: itself, both of EasyMocap's, or what a folder holds.
pub(in crate::io) fn files(path: &Path) -> Vec<PathBuf> {
    let found = if path.is_dir() { find(path).ok() } else { Some(path.into()) };
    match found {
        Some(half) if is_half(&half) => {
            let mut both = EASYMOCAP.map(|name| half.with_file_name(name));
            both.sort();
            both.into()
        }
        found => found.into_iter().collect(),
    }
}

/// Whether a file is one of EasyMocap's two.
pub(super) fn is_half(path: &Path) -> bool {
    path.file_name().is_some_and(|name| EASYMOCAP.iter().any(|half| name == *half))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The names of the files that a folder of such files is read from.
    fn read(names: &[&str]) -> Vec<String> {
        let folder = tempfile::tempdir().unwrap();
        names.iter().for_each(|name| fs::write(folder.path().join(name), "").unwrap());
        let name = |path: &PathBuf| path.file_name().unwrap().to_string_lossy().into_owned();
        files(folder.path()).iter().map(name).collect()
    }

    #[test]
    fn the_last_of_the_first_kind_is_read_and_nothing_else() {
        let others = ["Config.toml", "sequence.toml", "notes.txt", "a.xcp"];
        assert_eq!(read(&[&others[..], &["Cam2.toml", "cam10.TOML"]].concat()), ["cam10.TOML"]);
        assert_eq!(
            read(&[&others[..], &["intri.yml", "extri.yml"]].concat()),
            ["extri.yml", "intri.yml"]
        );
        assert_eq!(read(&[&others[..], &["b.qca.txt"]].concat()), ["b.qca.txt"]);
        assert_eq!(read(&others), ["a.xcp"]);
        assert_eq!(read(&others[..3]), [""; 0]);
    }
}
