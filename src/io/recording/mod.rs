//! A recording on disk: calibrated cameras, and what they saw of one person as masks, pictures, videos or points.
//!
//! [`Recording::open`] reads the manifest, if there is one, and finds where things are; nothing else is read.
//! [`Recording::observations`] lists the masks and points that a body is fitted to, [`Recording::footage`] the pictures
//! that masks and points are made of. Each reads one frame after another, when it is asked for.
//!
//! | file or folder   | holds                                                                 |
//! |------------------|-----------------------------------------------------------------------|
//! | `manifest/`      | `sequence.toml`                                                        |
//! | `offsets.rs`     | `offsets.toml`: when each camera began, as it was found                |
//! | `layout/`        | where a folder without manifest has its files                          |
//! | `cameras.rs`     | cameras that have files, matched with the calibrated ones              |
//! | `observations.rs`, `masks.rs`, `points.rs`, `detections.rs` | [`ObservationFiles`]: masks, points and detections |
//! | `footage/`       | [`footage::Footage`]: images and videos, decoded ahead                 |
//! | `image_decoder.rs` | image files, within limits                                           |
//! | `checksum.rs`    | fingerprints of the inputs                                             |
//! | `synthetic.rs`, `filmed.rs` | a synthetic recording as a folder                           |

mod cameras;
mod checksum;
mod detections;
mod error;
pub mod filmed;
pub mod footage;
mod image_decoder;
pub(super) mod layout;
pub(super) mod manifest;
mod mask_image;
mod masks;
mod note;
mod observations;
pub mod offsets;
mod points;
pub mod synthetic;

use std::path::{Path, PathBuf};

use crate::camera::Rig;
use crate::io::folder::file_name;
use footage::Footage;
use manifest::{Beginning, CameraFiles, Manifest};
use observations::WantedPoints;
use offsets::Offsets;

pub use checksum::InputChecksum;
use detections::DetectionFiles;
pub use error::RecordingError;
pub use mask_image::MaskFault;
pub use note::{CalibrationNote, Note};
pub use observations::{Missing, ObservationFiles};
pub use points::MOST_POINTS;

/// A folder with a calibration and with masks, pictures, videos or points of one person; or the manifest of one.
///
/// ```no_run
/// # fn main() -> Result<(), maquette::io::recording::RecordingError> {
/// let recording = maquette::Recording::open("my-recording")?.with_fps(50.0);
/// let masks = recording.observations()?;
/// println!("{} frames of {} cameras", masks.frames.len(), masks.rig.cameras.len());
/// # Ok(())
/// # }
/// ```
#[derive(Clone, Debug)]
pub struct Recording {
    /// As it was given, for messages.
    path: PathBuf,
    /// The folder that the manifest's paths are relative to.
    folder: PathBuf,
    manifest_path: Option<PathBuf>,
    manifest: Manifest,
    /// When each camera began, in the place of what the manifest says, and the file that says so.
    offsets: Option<(PathBuf, Offsets)>,
    /// Replaces the manifest's frame rate.
    fps: Option<f64>,
    /// Where the cameras are.
    stand: Stand,
}

/// Where the cameras of a recording are.
#[derive(Clone, Debug, Default)]
enum Stand {
    /// Where the calibration says.
    #[default]
    Calibrated,
    /// Nobody knows: the calibration is read for its lenses.
    Unknown,
    /// Elsewhere than the calibration says.
    Found(Rig),
}

/// What was made of a recording's pictures, in a folder of its own.
#[derive(Clone, Copy, Debug)]
pub struct DerivedFiles<'a> {
    /// The pictures.
    pub footage: &'a Footage,
    /// Where masks and points were written to.
    pub folder: &'a Path,
    /// Whether the masks are in `masks/<camera>/` of that folder.
    pub has_masks: bool,
    /// Whether the points are in `points/` of that folder.
    pub has_points: bool,
}

impl Recording {
    /// Opens a folder or a manifest.
    ///
    /// A folder with a `sequence.toml` is read by it. One without needs a `calibration.*` (or another calibration that
    /// [`crate::io::calibration::read`] finds in the folder), and `masks/<camera>/`, `videos/<camera>.*`,
    /// `images/<camera>/` or `points/`.
    ///
    /// # Errors
    /// [`RecordingError`] if there is no such folder, or the manifest is wrong.
    pub fn open(path: impl AsRef<Path>) -> Result<Self, RecordingError> {
        let path = path.as_ref();
        let (folder, manifest_path) = layout::locate(path)?;
        let manifest = match &manifest_path {
            Some(path) => Manifest::read(path)?,
            None => Manifest::default(),
        };
        let offsets = Offsets::find(&folder)?;
        let (fps, stand) = (None, Stand::default());
        Ok(Self { path: path.into(), folder, manifest_path, manifest, offsets, fps, stand })
    }

    /// The same recording at this frame rate, Hz, which overrides its manifest and its videos; `None` leaves the rate to them.
    #[must_use]
    pub fn with_fps(self, fps: impl Into<Option<f64>>) -> Self {
        Self { fps: fps.into(), ..self }
    }

    /// The same recording, of whose calibration the lenses alone are read: every camera stands in the origin.
    #[must_use]
    pub fn with_lenses_alone(self) -> Self {
        Self { stand: Stand::Unknown, ..self }
    }

    /// The same recording with these cameras in the place of its calibration.
    #[must_use]
    pub fn with_rig(self, rig: Rig) -> Self {
        Self { stand: Stand::Found(rig), ..self }
    }

    /// The path that it was opened by.
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// The body model that the manifest names.
    pub fn body(&self) -> Option<&str> {
        self.manifest.body.as_deref()
    }

    /// The person's height without shoes that the manifest states, metres.
    pub fn height_m(&self) -> Option<f64> {
        self.manifest.height_m
    }

    /// The folder that the paths of the manifest are relative to.
    pub fn folder(&self) -> &Path {
        &self.folder
    }

    /// Lists the masks and points.
    ///
    /// # Errors
    /// [`RecordingError`] if something is missing, contradictory, or cannot be read; [`RecordingError::NoMasks`] if there
    /// are neither masks nor points.
    pub fn observations(&self) -> Result<ObservationFiles, RecordingError> {
        ObservationFiles::list(self, WantedPoints::Given)
    }

    /// Lists the masks, without any points.
    ///
    /// # Errors
    /// As [`Recording::observations`].
    pub fn masks(&self) -> Result<ObservationFiles, RecordingError> {
        ObservationFiles::list(self, WantedPoints::Ignored)
    }

    /// Lists masks and points, some of them made from the recording's pictures.
    ///
    /// # Errors
    /// As [`Recording::observations`].
    pub fn with_derived(
        &self,
        derived: DerivedFiles<'_>,
    ) -> Result<ObservationFiles, RecordingError> {
        // the other paths of a recording are relative to its own folder
        let folder = std::path::absolute(derived.folder).unwrap_or_else(|_| derived.folder.into());
        let names = || derived.footage.rig.names();
        let mut recording = self.clone();
        recording.fps = Some(derived.footage.fps);
        recording.offsets = None;
        let beginnings: Vec<Beginning> =
            derived.footage.cameras.iter().map(|camera| camera.beginning).collect();
        let manifest = &mut recording.manifest;

        // the masks and points of that folder stand in the place of the manifest's
        if derived.has_masks {
            let masks = |name: &str| folder.join("masks").join(file_name(name));
            let stated = std::mem::take(&mut manifest.cameras);
            let detections =
                |name: &str| stated.iter().find(|c| c.name == name)?.detections.clone();
            // they are numbered by frame already
            let camera = |(name, beginning): (&str, &Beginning)| CameraFiles {
                name: name.into(),
                masks: Some(masks(name).display().to_string()),
                detections: detections(name),
                offset_frames: beginning.ahead_frames(),
                ..CameraFiles::default()
            };
            manifest.cameras = names().zip(&beginnings).map(camera).collect();
        }
        if derived.has_points {
            manifest.points = Some(folder.join("points").display().to_string());
            manifest.points_unit = None;
            // the pictures are used: points were made of them
            for camera in &mut manifest.cameras {
                (camera.images, camera.video, camera.background) = (None, None, None);
            }
        }

        let wanted = match derived.has_points {
            true => WantedPoints::Measured,
            false => WantedPoints::Given,
        };
        let mut files = ObservationFiles::list(&recording, wanted)?;
        if derived.has_masks {
            files.beginnings = beginnings;
        }
        let pictures = names().zip(&derived.footage.cameras);
        files.pictures = pictures
            .map(|(name, camera)| (name.into(), camera.paths().into_iter().cloned().collect()))
            .collect();
        Ok(files)
    }

    /// Finds the pictures: images or videos of each camera, and those of the empty scene.
    ///
    /// A folder without manifest has `videos/<camera>.*` or `images/<camera>/*`, and `background/<camera>.*` if there are
    /// pictures of the empty scene.
    ///
    /// # Errors
    /// [`RecordingError`] if something is missing, contradictory, or cannot be read.
    pub fn footage(&self) -> Result<Footage, RecordingError> {
        footage::open(self)
    }

    /// The files that say what the recording consists of, but for its calibration.
    fn descriptions(&self) -> impl Iterator<Item = PathBuf> {
        let offsets = self.offsets.iter().map(|(path, _)| path.clone());
        self.manifest_path.iter().cloned().chain(offsets)
    }

    /// Whether the offsets that stand beside the manifest are of this frame rate.
    fn check_offsets(&self, fps: f64) -> Result<(), RecordingError> {
        self.offsets.iter().try_for_each(|(path, offsets)| offsets.check(path, fps))
    }

    /// The frame rate that was given, or that of the manifest, or that of the files.
    fn frame_rate(&self, of_files: Option<f64>) -> Result<f64, RecordingError> {
        let fps = self.fps.or(self.manifest.fps).or(of_files);
        layout::frame_rate(fps, &self.path)
    }
}
