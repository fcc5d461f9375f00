//! Fingerprints of everything that a recording is read from.

use std::fs::File;
use std::io;
use std::path::{Path, PathBuf};

use serde::{Deserialize, Serialize};

use super::footage::Footage;
use super::{ObservationFiles, Recording, RecordingError};
use crate::io::input;

/// Fingerprint of one input: a file, all masks, detections or pictures of a camera, or all points.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct InputChecksum {
    /// Path of the file relative to the recording's folder (of a file elsewhere its name and that of its folder),
    /// `masks of <camera>`, `detections of <camera>`, `points`, or `pictures of <camera>`, the empty scene included.
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
    /// Fingerprints of everything that the recording is read from: manifest, calibration, each camera's masks, the
    /// points, and the pictures that these were made from.
    ///
    /// # Errors
    /// [`RecordingError::Read`] for a file that cannot be read.
    pub fn checksums(&self) -> Result<Vec<InputChecksum>, RecordingError> {
        self.inputs().iter().map(Input::checksum).collect()
    }

    /// Checks that this is the recording of which fingerprints were taken; the first difference is named. Names and
    /// numbers of files are compared before any file is read.
    ///
    /// # Errors
    /// [`RecordingError::Another`], and [`RecordingError::Read`] for a file that cannot be read.
    pub fn check(&self, known: &[InputChecksum]) -> Result<(), RecordingError> {
        let another =
            |reason: String| RecordingError::Another { path: self.folder.clone(), reason };
        let inputs = self.inputs();
        // the body's files are no part of the recording
        let known: Vec<_> = known.iter().filter(|k| !k.input.starts_with(BODY)).collect();

        for input in &inputs {
            let files = input.paths.len();
            match known.iter().find(|k| k.input == input.name) {
                None => return Err(another(format!("{} was not fitted", input.name))),
                Some(k) if k.files != files => {
                    let reason =
                        format!("{}: {} files were fitted, found {files}", k.input, k.files);
                    return Err(another(reason));
                }
                Some(_) => {}
            }
        }
        if let Some(k) = known.iter().find(|k| !inputs.iter().any(|input| input.name == k.input)) {
            return Err(another(format!("{} is not there", k.input)));
        }

        for input in &inputs {
            let found = input.checksum()?;
            // two files elsewhere may have one name
            if !known.contains(&&found) {
                return Err(another(format!("{} is not what was fitted", input.name)));
            }
        }
        Ok(())
    }

    /// All inputs, in the order in which the result lists them.
    fn inputs(&self) -> Vec<Input<'_>> {
        let descriptions =
            self.descriptions.iter().map(|path| Input::description(&self.folder, path));
        let with_masks = self.rig.cameras.iter().zip(&self.masks);
        let with_masks = with_masks.filter(|(_, masks)| !masks.is_empty());
        let masks =
            with_masks.map(|(camera, masks)| Input::several("masks", &camera.name, masks.values()));
        let detected = self.rig.cameras.iter().zip(self.detections.of_cameras());
        let detected = detected.filter(|(_, files)| !files.is_empty());
        let detected = detected
            .map(|(camera, files)| Input::several("detections", &camera.name, files.values()));
        let points = self.has_points().then(|| Input {
            name: "points".into(),
            paths: self.points.paths().collect(),
            is_single: false,
        });
        let pictures = self.pictures.iter();
        let pictures = pictures.map(|(camera, all)| Input::several("pictures", camera, all.iter()));
        descriptions.chain(masks).chain(detected).chain(points).chain(pictures).collect()
    }
}

impl Recording {
    /// Fingerprints of a recording's pictures, and of the files that say what it consists of.
    ///
    /// # Errors
    /// [`RecordingError::Read`] for a file that cannot be read.
    pub fn picture_checksums(
        &self,
        footage: &Footage,
    ) -> Result<Vec<InputChecksum>, RecordingError> {
        let descriptions: Vec<PathBuf> =
            self.descriptions().chain(self.calibration_files()).collect();
        let descriptions = descriptions.iter().map(|path| Input::description(self.folder(), path));
        let pictures = footage.rig.names().zip(&footage.cameras);
        let pictures = pictures
            .map(|(name, camera)| Input::several("pictures", name, camera.paths().into_iter()));
        descriptions.chain(pictures).map(|input| input.checksum()).collect()
    }
}

/// A file's path relative to the recording's folder; of a file elsewhere its name and that of its folder.
fn name_of(folder: &Path, path: &Path) -> String {
    if let Ok(relative) = path.strip_prefix(folder) {
        return relative.display().to_string();
    }
    let folder = path.parent().and_then(Path::file_name);
    let name = folder.into_iter().chain(path.file_name());
    name.collect::<PathBuf>().display().to_string()
}

/// What the names of a body's files begin with.
const BODY: &str = "body ";

/// A file, or files that are one input.
struct Input<'a> {
    name: String,
    paths: Vec<&'a PathBuf>,
    /// A file by itself.
    is_single: bool,
}

impl<'a> Input<'a> {
    fn description(folder: &Path, path: &'a PathBuf) -> Self {
        Self { name: name_of(folder, path), paths: vec![path], is_single: true }
    }

    fn several(kind: &str, camera: &str, paths: impl Iterator<Item = &'a PathBuf>) -> Self {
        // a file may hold all frames
        let mut paths: Vec<&PathBuf> = paths.collect();
        paths.dedup();
        Self { name: format!("{kind} of {camera}"), paths, is_single: false }
    }

    fn checksum(&self) -> Result<InputChecksum, RecordingError> {
        let sums = self.paths.iter().map(|path| checksum(path));
        let sums: Vec<blake3::Hash> = sums.collect::<Result<_, _>>()?;
        let sum = match (self.is_single, sums.as_slice()) {
            (true, [only]) => *only,
            _ => {
                let mut all = blake3::Hasher::new();
                sums.iter().for_each(|sum| {
                    all.update(sum.as_bytes());
                });
                all.finalize()
            }
        };
        let (input, files) = (self.name.clone(), self.paths.len());
        Ok(InputChecksum { input, files, blake3: sum.to_string() })
    }
}

fn checksum(path: &Path) -> Result<blake3::Hash, RecordingError> {
    let sum = || -> io::Result<blake3::Hash> {
        input::check_kind(path)?;
        let mut hasher = blake3::Hasher::new();
        hasher.update_reader(File::open(path)?)?;
        Ok(hasher.finalize())
    };
    sum().map_err(|source| RecordingError::Read { path: path.into(), source })
}
