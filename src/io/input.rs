//! A file that somebody names: read only if it is a file, and of a size that its kind can have.

use std::fs::{self, File, FileType};
use std::io::{self, Read};
use std::path::Path;

const MIB: u64 = 1 << 20;

/// The most bytes of a text that a person writes: a calibration, a `sequence.toml`, a body, a norm.
pub(crate) const MOST_OF_A_TEXT: u64 = 64 * MIB;
/// The most bytes of an image.
pub(crate) const MOST_OF_AN_IMAGE: u64 = 1024 * MIB;
/// The most bytes of a table of points over time, and of a result.
pub(crate) const MOST_OF_A_TABLE: u64 = 4096 * MIB;

/// The bytes of a file.
///
/// # Errors
/// As reading does, and [`io::ErrorKind::InvalidInput`] of a folder, a pipe, a device, or more than `most_bytes`.
pub(crate) fn read(path: &Path, most_bytes: u64) -> io::Result<Vec<u8>> {
    check_kind(path)?;
    let too_large = || {
        let most = most_bytes / MIB;
        refused(format!("expected a file of at most {most} MiB, found a larger one"))
    };

    let file = File::open(path)?;
    let stated_bytes = file.metadata()?.len();
    if stated_bytes > most_bytes {
        return Err(too_large());
    }
    let mut bytes = Vec::with_capacity(usize::try_from(stated_bytes).unwrap_or(0));
    let read_bytes = file.take(most_bytes + 1).read_to_end(&mut bytes)?;
    if read_bytes as u64 > most_bytes { Err(too_large()) } else { Ok(bytes) }
}

/// The text of a file that a person writes.
///
/// # Errors
/// As [`read`], and [`io::ErrorKind::InvalidData`] of a file that is not UTF-8.
pub(crate) fn read_text(path: &Path) -> io::Result<String> {
    let bytes = read(path, MOST_OF_A_TEXT)?;
    String::from_utf8(bytes).map_err(|fault| io::Error::new(io::ErrorKind::InvalidData, fault))
}

/// Whether something is a file, which ends and does not wait.
///
/// # Errors
/// [`io::ErrorKind::InvalidInput`] says what it is instead.
pub(crate) fn check_kind(path: &Path) -> io::Result<()> {
    match kind(fs::metadata(path)?.file_type()) {
        None => Ok(()),
        Some(kind) => Err(refused(format!("expected a file, found {kind}"))),
    }
}

fn refused(why: String) -> io::Error {
    io::Error::new(io::ErrorKind::InvalidInput, why)
}

/// What is no file.
fn kind(found: FileType) -> Option<&'static str> {
    #[cfg(unix)]
    {
        use std::os::unix::fs::FileTypeExt;
        if found.is_fifo() {
            return Some("a pipe");
        }
        if found.is_socket() {
            return Some("a socket");
        }
    }
    match (found.is_file(), found.is_dir()) {
        (true, _) => None,
        (_, true) => Some("a folder"),
        _ => Some("a device"),
    }
}

/// The most characters of a file that an error repeats.
const MOST_QUOTED: usize = 80;

/// A text as an error repeats it: its beginning, if it is long.
pub(crate) fn shortened(text: &str) -> String {
    match text.char_indices().nth(MOST_QUOTED) {
        Some((end, _)) => format!("{}…", &text[..end]),
        None => text.to_owned(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_file_is_read_up_to_its_limit() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("file");
        fs::write(&path, "12345").unwrap();
        assert_eq!(read(&path, 5).unwrap(), b"12345");
        let message = read(&path, 4).unwrap_err().to_string();
        assert!(message.contains("a larger one"), "{message}");
        let message = read(folder.path(), 5).unwrap_err().to_string();
        assert_eq!(message, "expected a file, found a folder");
    }

    #[cfg(unix)]
    #[test]
    fn what_never_ends_is_not_begun() {
        let folder = tempfile::tempdir().unwrap();
        let message = |path: &Path| read(path, 1 << 30).unwrap_err().to_string();
        assert_eq!(message(Path::new("/dev/zero")), "expected a file, found a device");
        let link = folder.path().join("000000.png");
        std::os::unix::fs::symlink("/dev/zero", &link).unwrap();
        assert_eq!(message(&link), "expected a file, found a device");

        let pipe = folder.path().join("pipe");
        let made = std::process::Command::new("mkfifo").arg(&pipe).status();
        assert!(made.is_ok_and(|status| status.success()), "no mkfifo");
        assert_eq!(message(&pipe), "expected a file, found a pipe");
    }

    #[test]
    fn a_long_text_is_repeated_by_its_beginning() {
        assert_eq!(shortened("50 Hz"), "50 Hz");
        assert_eq!(shortened(&"ä".repeat(1000)).chars().count(), MOST_QUOTED + 1);
    }
}
