//! Numbered files: masks, images or point clouds, by frame.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use image::ImageFormat;

use super::{contents, is_hidden};
use crate::io::recording::RecordingError;

/// The masks of one camera, or the point clouds.
#[derive(Clone, Debug, Default, PartialEq)]
pub(in crate::io) struct NumberedFiles {
    /// Number in the file's name → file.
    pub(in crate::io) of_number: BTreeMap<u64, PathBuf>,
    /// Files of the kind without a number.
    pub(in crate::io) unnumbered: usize,
}

/// What is looked for.
pub(in crate::io) struct Wanted<'a> {
    /// Whose it is, for messages: `camera left: masks` or `points`.
    pub(in crate::io) key: &'a str,
    /// Whether a file's name is of the wanted kind; not asked of the files of a printf pattern.
    pub(in crate::io) is_kind: fn(&Path) -> bool,
}

/// The files that `pattern` names, relative to `folder`: a printf pattern, a glob, a folder, or one file.
///
/// The number is the one at `%d`, or else the last group of digits in the name before its extension.
/// Hidden files and files of another kind are skipped.
pub(in crate::io) fn list(
    folder: &Path,
    pattern: &str,
    wanted: &Wanted<'_>,
) -> Result<NumberedFiles, RecordingError> {
    let whole = folder.join(pattern);
    let bad_pattern = |expected| RecordingError::Pattern {
        key: wanted.key.into(),
        pattern: pattern.into(),
        expected,
    };

    let numbered: Vec<(Option<u64>, PathBuf)> = if pattern.contains('%') && !whole.is_dir() {
        let printf = Printf::parse(&whole).ok_or_else(|| {
            bad_pattern("one %d or %06d in the file's name and no other % in the path")
        })?;
        let files = contents(printf.folder)?.into_iter();
        files.filter_map(|path| Some((Some(printf.number(&path)?), path))).collect()
    } else {
        let files = if whole.is_dir() {
            wanted_of(contents(&whole)?, wanted)
        } else if whole.is_file() {
            vec![whole]
        } else if pattern.contains(['*', '?', '[']) {
            let escaped = glob::Pattern::escape(&folder.to_string_lossy());
            let found = glob::glob(&format!("{escaped}/{pattern}")).map_err(|_| {
                bad_pattern("a glob with balanced brackets and ** alone in its place")
            })?;
            wanted_of(found.filter_map(Result::ok).collect(), wanted)
        } else {
            Vec::new()
        };
        files.into_iter().map(|path| (last_number(&path), path)).collect()
    };

    collect(numbered, wanted)
}

fn collect(
    numbered: Vec<(Option<u64>, PathBuf)>,
    wanted: &Wanted<'_>,
) -> Result<NumberedFiles, RecordingError> {
    let mut files = NumberedFiles::default();
    for (number, path) in numbered {
        let Some(number) = number else {
            files.unnumbered += 1;
            continue;
        };

        if let Some(first) = files.of_number.insert(number, path.clone()) {
            return Err(RecordingError::DuplicateFrame {
                key: wanted.key.into(),
                number,
                first,
                second: path,
            });
        }
    }
    Ok(files)
}

fn wanted_of(mut files: Vec<PathBuf>, wanted: &Wanted<'_>) -> Vec<PathBuf> {
    files.retain(|path| !is_hidden(path) && (wanted.is_kind)(path));
    files
}

/// Whether a file's name is that of an image that can be read.
pub(in crate::io) fn is_image(path: &Path) -> bool {
    ImageFormat::from_path(path).is_ok_and(|format| format.reading_enabled())
}

/// `prefix%06dsuffix` in one folder.
struct Printf<'a> {
    folder: &'a Path,
    prefix: &'a str,
    least_digits: usize,
    suffix: &'a str,
}

impl<'a> Printf<'a> {
    fn parse(whole: &'a Path) -> Option<Self> {
        let (prefix, rest) = whole.file_name()?.to_str()?.split_once('%')?;
        let (digits, suffix) = rest.split_once('d')?;
        let folder = whole.parent()?;
        // a folder may have such a sign in its name, but is no pattern itself
        let is_folder = folder.is_dir() || !folder.to_string_lossy().contains('%');
        let is_plain = !suffix.contains('%') && is_folder;
        let least_digits = match digits {
            "" => 1,
            digits => digits.strip_prefix('0').unwrap_or(digits).parse().ok()?,
        };
        is_plain.then_some(Self { folder, prefix, least_digits, suffix })
    }

    fn number(&self, path: &Path) -> Option<u64> {
        let name = path.file_name()?.to_str()?;
        let digits = name.strip_prefix(self.prefix)?.strip_suffix(self.suffix)?;
        let is_number = digits.bytes().all(|byte| byte.is_ascii_digit());
        (is_number && digits.len() >= self.least_digits).then(|| digits.parse().ok()).flatten()
    }
}

/// The last group of digits in a file's name before the extension; `None` if there is none that fits 64 bits.
fn last_number(path: &Path) -> Option<u64> {
    let stem = path.file_stem()?.to_str()?;
    let end = stem.rfind(|c: char| c.is_ascii_digit())? + 1;
    let before = stem[..end].trim_end_matches(|c: char| c.is_ascii_digit());
    stem[before.len()..end].parse().ok()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_number_is_the_last_group_of_digits_before_the_extension() {
        for (name, number) in [
            ("000123.png", Some(123)),
            ("cam01_0007.png", Some(7)),
            ("cam01_0007_mask.png", Some(7)),
            ("frame12.v3.png", Some(3)),
            ("mask.png", None),
            ("99999999999999999999999.png", None),
            ("é5ü.png", Some(5)),
        ] {
            assert_eq!(last_number(Path::new(name)), number, "{name}");
        }
    }

    #[test]
    fn a_printf_pattern_asks_for_its_digits() {
        let printf = Printf::parse(Path::new("masks/a_%04d.png")).unwrap();
        let number = |name: &str| printf.number(&Path::new("masks").join(name));
        assert_eq!(number("a_0012.png"), Some(12));
        assert_eq!(number("a_12345.png"), Some(12345));
        assert_eq!(number("a_012.png"), None);
        assert_eq!(number("a_-012.png"), None);
        assert_eq!(number("b_0012.png"), None);
        assert_eq!(number("a_0012.jpg"), None);
        for bad in ["%06.png", "%d_%d.png", "%03d/%03d.png", "%x.png", "%0d%.png"] {
            assert!(Printf::parse(Path::new(bad)).is_none(), "{bad}");
        }
        assert_eq!(Printf::parse(Path::new("%d.png")).unwrap().least_digits, 1);
    }
}
