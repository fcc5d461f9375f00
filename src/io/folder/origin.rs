//! Which recording a result is of: `recording.toml` in the folder of the result.
//!
//! `result.json` names no place on a machine, so that it can be handed on; this file does. It may be deleted.

use std::path::{Component, Path, PathBuf};

use serde::{Deserialize, Serialize};

use crate::io::input;

/// The name of the file.
pub const ORIGIN: &str = "recording.toml";

#[derive(Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct OriginFile {
    /// The recording, relative to the folder of the result where both are on one tree.
    path: String,
}

/// The text of the file for a result in `out`; `None` where the place of the recording is no text or not there any more.
pub fn text(recording: &Path, out: &Path) -> Option<String> {
    let (recording, out) = (recording.canonicalize().ok()?, out.canonicalize().ok()?);
    let path = relative(&recording, &out);
    let file = OriginFile { path: path.to_str()?.to_owned() };
    let file = toml::to_string(&file).ok()?;
    Some(format!("# The recording that this result was fitted to, seen from this folder.\n{file}"))
}

/// The recording that the folder of a result names; `None` if it names none.
pub fn read(out: &Path) -> Option<PathBuf> {
    let text = input::read_text(&out.join(ORIGIN)).ok()?;
    let file: OriginFile = toml::from_str(&text).ok()?;
    Some(out.join(file.path))
}

/// A path as seen from a folder; as it is where the two have nothing but the root in common.
fn relative(path: &Path, from: &Path) -> PathBuf {
    let common = path.components().zip(from.components()).take_while(|(a, b)| a == b);
    let common: Vec<Component<'_>> = common.map(|(a, _)| a).collect();
    if !common.iter().any(|c| matches!(c, Component::Normal(_))) {
        return path.into();
    }
    let up = from.components().skip(common.len()).map(|_| Component::ParentDir);
    let seen: PathBuf = up.chain(path.components().skip(common.len())).collect();
    if seen.as_os_str().is_empty() { ".".into() } else { seen }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_result_finds_its_recording_also_after_both_have_moved() {
        let folder = tempfile::tempdir().unwrap();
        let (old, new) = (folder.path().join("old"), folder.path().join("new"));
        for name in ["walk", "out/walk"] {
            std::fs::create_dir_all(old.join(name)).unwrap();
        }
        let out = old.join("out/walk");
        let text = text(&old.join("walk"), &out).unwrap();
        assert!(text.ends_with("path = \"../../walk\"\n"), "{text}");
        std::fs::write(out.join(ORIGIN), text).unwrap();
        std::fs::rename(&old, &new).unwrap();
        let found = read(&new.join("out/walk")).unwrap();
        assert_eq!(found.canonicalize().unwrap(), new.join("walk").canonicalize().unwrap());
        assert_eq!(read(&new), None);
    }

    #[test]
    fn without_a_common_folder_the_whole_path_is_kept() {
        let seen = relative(Path::new("/data/walk"), Path::new("/results/out"));
        assert_eq!(seen, Path::new("/data/walk"));
        assert_eq!(relative(Path::new("/a/b"), Path::new("/a/b")), Path::new("."));
    }
}
