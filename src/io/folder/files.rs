//! Files that appear whole or not at all, and their names.

use std::fs::{self, File};
use std::io::{self, Write};
use std::path::Path;

use super::OutError;

/// Prefix of the names of unfinished files and folders.
pub(super) const UNFINISHED: &str = ".writing-";

/// Removes what a run that was stopped was writing; what cannot be removed does no harm.
pub(super) fn remove_unfinished(folder: &Path) {
    for entry in fs::read_dir(folder).into_iter().flatten().flatten() {
        let path = entry.path();
        if entry.file_name().to_string_lossy().starts_with(UNFINISHED) {
            let removed =
                if path.is_dir() { fs::remove_dir_all(path) } else { fs::remove_file(path) };
            drop(removed);
        }
    }
}

/// Writes a file beside its place and moves it there, so that it is whole or absent.
///
/// # Errors
/// [`OutError::Write`] names the file.
pub fn write_atomically(path: &Path, bytes: &[u8]) -> Result<(), OutError> {
    let write = || {
        let mut builder = tempfile::Builder::new();
        builder.prefix(UNFINISHED);
        // as any new file, for others to read as the user's mask allows
        #[cfg(unix)]
        builder.permissions(std::os::unix::fs::PermissionsExt::from_mode(0o666));
        let mut file = builder.tempfile_in(parent_of(path))?;
        file.write_all(bytes)?;
        file.as_file().sync_all()?;
        file.persist(path).map_err(|error| error.error)?;
        sync_folder(parent_of(path));
        Ok(())
    };
    write().map_err(|source| OutError::write(path, source))
}

/// Brings the names in a folder to the disk; a file system that cannot do so keeps an order of its own.
pub(super) fn sync_folder(folder: &Path) {
    let _ = File::open(folder).and_then(|folder| folder.sync_all());
}

/// Makes a folder within one that is written into.
pub(crate) fn make_folder(path: &Path) -> Result<(), OutError> {
    fs::create_dir_all(path).map_err(|source| OutError::write(path, source))
}

/// The folder that a file or folder is in.
pub(in crate::io) fn parent_of(path: &Path) -> &Path {
    match path.parent() {
        Some(parent) if !parent.as_os_str().is_empty() => parent,
        _ => Path::new("."),
    }
}

/// Writes a file, if it could be encoded.
pub(in crate::io) fn write_encoded(path: &Path, file: io::Result<Vec<u8>>) -> Result<(), OutError> {
    file.and_then(|bytes| fs::write(path, bytes)).map_err(|source| OutError::write(path, source))
}

/// A camera's name as the name of a folder, without characters that a folder's name cannot have.
pub(in crate::io) fn file_name(camera: &str) -> String {
    let plain = |c: char| {
        if c.is_alphanumeric() || "-_. ".contains(c) { c } else { '_' }
    };
    let name: String = camera.chars().map(plain).collect();
    match name.trim_matches(['.', ' ']) {
        "" => "camera".into(),
        name => name.into(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[cfg(unix)]
    #[test]
    fn a_file_can_be_read_by_whom_the_users_mask_allows() {
        use std::os::unix::fs::PermissionsExt;
        let folder = tempfile::tempdir().unwrap();
        let mode = |path: &Path| fs::metadata(path).unwrap().permissions().mode();
        let (plain, ours) = (folder.path().join("plain"), folder.path().join("ours"));
        fs::write(&plain, "a").unwrap();
        write_atomically(&ours, b"a").unwrap();
        assert_eq!(mode(&ours), mode(&plain));
    }

    #[test]
    fn a_file_appears_whole_and_leaves_nothing_beside_it() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("result.json");
        write_atomically(&path, b"old").unwrap();
        write_atomically(&path, b"new").unwrap();
        assert_eq!(fs::read(&path).unwrap(), b"new");
        assert_eq!(fs::read_dir(folder.path()).unwrap().count(), 1);
        let nowhere = folder.path().join("no/where");
        let message = write_atomically(&nowhere, b"").unwrap_err().to_string();
        assert!(message.contains("no/where: cannot be written"), "{message}");
    }

    #[test]
    fn no_camera_can_be_named_out_of_its_folder() {
        assert_eq!(file_name("cam_01"), "cam_01");
        assert_eq!(file_name("../../left"), "_.._left");
        assert_eq!(file_name("a/b\\c:d"), "a_b_c_d");
        assert_eq!(file_name(".."), "camera");
    }
}
