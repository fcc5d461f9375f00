//! A recording on disk: which cameras, which frames, and each frame's silhouettes and points when they are asked for.
//!
//! [`Recording::open`] reads the manifest and the calibration and lists the masks and point clouds;
//! [`Recording::load_frame`] reads those of one frame. Nothing is kept in between, so frames can be streamed, and loaded by many threads.

mod error;
pub mod filmed;
pub mod footage;
pub(super) mod layout;
pub(super) mod manifest;
mod mask_image;
mod note;
mod open;
mod points;
pub mod synthetic;

use std::collections::BTreeMap;
use std::fs;
use std::path::{Path, PathBuf};

use crate::camera::{Camera, CameraId, Rig};
use crate::image::Mask;
use crate::io::folder::file_name;
use crate::io::recording::footage::Footage;
use crate::io::recording::manifest::CameraFiles;
use crate::silhouette::{self, FrameIndex, FrameObservations, SilhouetteOptions};

pub use error::RecordingError;
pub use layout::LayoutError;
pub use manifest::ManifestError;
pub use mask_image::MaskFault;
pub use note::Note;
pub use points::{MOST_POINTS, ScaleFault};

/// Calibrated masks of one person, frame by frame.
#[derive(Clone, Debug)]
pub struct Recording {
    /// Frames per second.
    pub fps: f64,
    /// The cameras that have masks, or all where none has, in the order of the manifest.
    pub rig: Rig,
    /// The frames of which at least one camera has a mask, or that have points, ascending.
    pub frames: Vec<FrameIndex>,
    /// The masks that are not there.
    pub missing: Vec<Missing>,
    /// What the user should know.
    pub notes: Vec<Note>,
    /// The body model that the manifest names.
    pub body: Option<String>,
    /// The folder that the manifest's paths are relative to.
    pub folder: PathBuf,
    /// Manifest and calibration.
    descriptions: Vec<PathBuf>,
    /// Frame → mask, for each camera of the rig.
    masks: Vec<BTreeMap<FrameIndex, PathBuf>>,
    points: points::PointFiles,
    /// What masks or points were made of: each camera's pictures.
    pictures: Vec<(String, Vec<PathBuf>)>,
}

/// What was made of a recording's pictures.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Made {
    /// Its masks.
    pub masks: bool,
    /// Its points.
    pub points: bool,
}

/// Where a recording's files are.
#[derive(Clone, Debug, Default)]
struct Sources {
    /// The cameras; where `None` as the manifest or the folder has them.
    cameras: Option<Vec<CameraFiles>>,
    points: Points,
}

/// Where a recording's points are.
#[derive(Clone, Debug, Default)]
enum Points {
    /// Where the manifest or the folder has them.
    #[default]
    Manifest,
    /// In this folder, in metres.
    Folder(PathBuf),
    /// Not wanted.
    None,
}

/// Frames of which one camera has no mask, others have.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Missing {
    /// The camera.
    pub camera: CameraId,
    /// The frames, ascending.
    pub frames: Vec<FrameIndex>,
}

/// Fingerprint of one input: a file, all masks or pictures of a camera, or all points.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct InputChecksum {
    /// Path of the file relative to the recording's folder (of a file elsewhere its name and that of its folder), `masks of <camera>`, `points`, or `pictures of <camera>`, the empty scene included.
    pub input: String,
    /// Number of files.
    pub files: usize,
    /// BLAKE3 of the file; of several, of their BLAKE3 sums one after another, in the order of the frames. Hexadecimal.
    pub blake3: String,
}

impl InputChecksum {
    /// The fingerprint of a text.
    pub fn of_text(input: String, text: &str) -> Self {
        Self {
            input,
            files: 1,
            blake3: blake3::hash(text.as_bytes()).to_string(),
        }
    }
}

impl Recording {
    /// Opens a folder or a manifest; `fps` overrides the manifest's frame rate.
    ///
    /// A folder with a `sequence.toml` is read by it. One without needs a `calibration.*` (or another calibration that
    /// [`crate::io::calibration::read`] finds in the folder) and the masks in `masks/<camera>/`, and the frame rate
    /// from outside. No mask is read but the first header of each camera, for calibrations without image size.
    ///
    /// # Errors
    /// [`RecordingError`] if something is missing, contradictory, or cannot be read.
    pub fn open(path: &Path, fps: Option<f64>) -> Result<Self, RecordingError> {
        open::open(path, fps, &Sources::default())
    }

    /// Opens a recording without its points.
    ///
    /// # Errors
    /// As [`Recording::open`].
    pub fn open_masks(path: &Path, fps: Option<f64>) -> Result<Self, RecordingError> {
        let sources = Sources {
            points: Points::None,
            ..Sources::default()
        };
        open::open(path, fps, &sources)
    }

    /// Opens a recording of which some was made of its pictures: that lies in `masks/<camera>/` and
    /// `points/` of another folder.
    ///
    /// # Errors
    /// As [`Recording::open`].
    pub fn open_made(
        path: &Path,
        footage: &Footage,
        folder: &Path,
        made: Made,
    ) -> Result<Self, RecordingError> {
        // the other paths of a recording are relative to its own folder
        let folder = std::path::absolute(folder).unwrap_or_else(|_| folder.into());
        let masks = |name: &str| folder.join("masks").join(file_name(name));
        let camera = |name: &str| CameraFiles {
            name: name.into(),
            masks: Some(masks(name).display().to_string()),
            ..CameraFiles::default()
        };
        let sources = Sources {
            cameras: made
                .masks
                .then(|| footage.rig.names().map(camera).collect()),
            points: match made.points {
                true => Points::Folder(folder.join("points")),
                false => Points::Manifest,
            },
        };
        let mut recording = open::open(path, Some(footage.fps), &sources)?;
        let pictures = footage.rig.names().zip(&footage.cameras);
        recording.pictures = pictures
            .map(|(name, camera)| (name.into(), camera.paths().into_iter().cloned().collect()))
            .collect();
        Ok(recording)
    }

    /// Whether a camera has masks.
    pub fn has_masks(&self) -> bool {
        self.masks.iter().any(|masks| !masks.is_empty())
    }

    /// Whether a frame has points.
    pub fn has_points(&self) -> bool {
        self.points.frames().next().is_some()
    }

    /// The silhouettes and points of the frame at `position` in [`Recording::frames`].
    ///
    /// Of more than [`MOST_POINTS`] points as many are taken, evenly; [`Recording::notes_of_points`] says so.
    ///
    /// # Errors
    /// [`RecordingError::Mask`] for the first mask that cannot be used, in the order of the rig,
    /// [`RecordingError::Cloud`] and [`RecordingError::PointsScale`] for points that cannot, and
    /// [`RecordingError::NoFrame`]. A mask that is read and shows no silhouette is no error: it is listed as rejected.
    pub fn load_frame(
        &self,
        position: usize,
        options: &SilhouetteOptions,
    ) -> Result<FrameObservations, RecordingError> {
        let frame = self.frames.get(position).copied();
        let frame = frame.ok_or(RecordingError::NoFrame {
            position,
            count: self.frames.len(),
        })?;
        let mut observations = FrameObservations::nothing(frame);
        for (id, camera) in self.rig.iter() {
            let Some(mask) = self.load_mask(id, frame)? else {
                continue;
            };
            match silhouette::extract(&mask, camera, options) {
                Ok(silhouette) => observations.views.push((id, silhouette)),
                Err(reason) => observations.rejected.push((id, reason)),
            }
        }
        self.load_points(&mut observations)?;
        Ok(observations)
    }

    /// Puts a frame's points beside those that were observed of it.
    ///
    /// # Errors
    /// As [`Recording::load_frame`] of points.
    pub fn load_points(&self, observed: &mut FrameObservations) -> Result<(), RecordingError> {
        let cloud = self.points.load(observed.frame)?;
        observed.points.extend(cloud.points);
        observed.points_left_out = cloud.left_out;
        Ok(())
    }

    /// What the user should know of the points of the frames that were loaded.
    pub fn notes_of_points(&self, observations: &[FrameObservations]) -> Vec<Note> {
        self.points.notes(observations)
    }

    /// The mask of a camera in a frame; `None` if it is missing.
    pub fn mask_path(&self, camera: CameraId, frame: FrameIndex) -> Option<&Path> {
        let path = self.masks.get(camera.0)?.get(&frame)?;
        Some(path)
    }

    /// The mask of a camera in a frame as it was read; `None` if it is missing.
    ///
    /// # Errors
    /// [`RecordingError::Mask`] if it cannot be used.
    pub fn load_mask(
        &self,
        camera: CameraId,
        frame: FrameIndex,
    ) -> Result<Option<Mask>, RecordingError> {
        let (Some(path), Some(known)) = (self.mask_path(camera, frame), self.rig.camera(camera))
        else {
            return Ok(None);
        };
        let mask = mask_image::read(path, [known.width_px, known.height_px]);
        let mask = mask.map_err(|fault| mask_error(path, known, frame, fault))?;
        Ok(Some(mask))
    }

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
    /// points, and the pictures that these were made of.
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

fn mask_error(path: &Path, camera: &Camera, frame: FrameIndex, fault: MaskFault) -> RecordingError {
    RecordingError::Mask {
        path: path.into(),
        camera: camera.name.clone(),
        frame,
        fault: Box::new(fault),
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
    Ok(InputChecksum {
        input,
        files,
        blake3: all.finalize().to_string(),
    })
}

fn checksum(path: &Path) -> Result<blake3::Hash, RecordingError> {
    let bytes = fs::read(path).map_err(|source| RecordingError::Checksum {
        path: path.into(),
        source,
    })?;
    Ok(blake3::hash(&bytes))
}
