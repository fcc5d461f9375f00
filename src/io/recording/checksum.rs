//! Fingerprints of everything that a recording is read from.

use std::fs::File;
use std::io;
use std::path::{Path, PathBuf};

use serde::{Deserialize, Serialize};

use super::{ObservationFiles, RecordingError};
use crate::io::input;

/// Fingerprint of one input: a file, all masks or pictures of a camera, or all points.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct InputChecksum {
    /// Path of the file relative to the recording's folder (of a file elsewhere its name and that of its folder),
    /// `masks of <camera>`, `points`, or `pictures of <camera>`, the empty scene included.
    pub input: String,
    /// Number of files.
    pub files: usize,
    /// BLAKE3 of the file, hexadecimal; of several files, BLAKE3 of their sums one after another, in the order of the frames.
    pub blake3: String,
}

impl InputChecksum {
    /// The fingerprint of a text.
    pub fn from_text(input: String, text: &str) -> Self {
        Self { input, files: 1, blake3: blake3::hash(text.as_bytes()).to_string() }
    }
}

impl ObservationFiles {
    /// A file's path relative to the recording's folder; of a file elsewhere its name and that of its folder.
    fn name_of(&self, path: &Path) -> String {
        if let Ok(relative) = path.strip_prefix(&self.folder) {
            return relative.display().to_string();
        }
        let folder = path.parent().and_then(Path::file_name);
        let name = folder.into_iter().chain(path.file_name());
        name.collect::<PathBuf>().display().to_string()
    }

    /// Fingerprints of everything that the recording is read from: manifest, calibration, each camera's masks, the
    /// points, and the pictures that these were made from.
    ///
    /// # Errors
    /// [`RecordingError::Checksum`] for a file that cannot be read.
    pub fn checksums(&self) -> Result<Vec<InputChecksum>, RecordingError> {
        let mut checksums = Vec::new();
        for path in &self.descriptions {
            checksums.push(InputChecksum {
                input: self.name_of(path),
                files: 1,
                blake3: checksum(path)?.to_string(),
            });
        }

        let with_masks = self.rig.cameras.iter().zip(&self.masks);
        for (camera, masks) in with_masks.filter(|(_, masks)| !masks.is_empty()) {
            let input = format!("masks of {}", camera.name);
            checksums.push(checksum_of_all(input, masks.values())?);
        }

        if self.has_points() {
            checksums.push(checksum_of_all("points".into(), self.points.paths())?);
        }

        for (camera, pictures) in &self.pictures {
            let input = format!("pictures of {camera}");
            checksums.push(checksum_of_all(input, pictures.iter())?);
        }

        Ok(checksums)
    }
}

fn checksum_of_all<'a>(
    input: String,
    paths: impl Iterator<Item = &'a PathBuf>,
) -> Result<InputChecksum, RecordingError> {
    let (mut all, mut files) = (blake3::Hasher::new(), 0);
    for path in paths {
        all.update(checksum(path)?.as_bytes());
        files += 1;
    }
    Ok(InputChecksum { input, files, blake3: all.finalize().to_string() })
}

fn checksum(path: &Path) -> Result<blake3::Hash, RecordingError> {
    let sum = || -> io::Result<blake3::Hash> {
        input::check_kind(path)?;
        let mut hasher = blake3::Hasher::new();
        hasher.update_reader(File::open(path)?)?;
        Ok(hasher.finalize())
    };
    sum().map_err(|source| RecordingError::Checksum { path: path.into(), source })
}
