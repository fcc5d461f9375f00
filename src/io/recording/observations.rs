//! The masks and points of a recording: which frames have some, and each frame's when it is asked for.

use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};

use serde::{Deserialize, Serialize};

use super::layout::elsewhere;
use super::layout::numbered_files::NumberedFiles;
use super::manifest::{Beginning, CameraFiles};
use super::mask_image::Painted;
use super::masks::{self, MaskFiles};
use super::points::PointFiles;
use super::{DetectionFiles, Note, Recording, RecordingError, mask_image};
use crate::camera::{CameraId, Rig};
use crate::image::{Mask, Plane};
use crate::pipeline::{Frames, MaskSource};
use crate::silhouette::{
    self, FrameIndex, FrameObservations, FramePeople, Keypoint, SilhouetteOptions,
};

/// Calibrated masks and points of one person, frame by frame.
///
/// Nothing is kept of a frame that was loaded, so frames can be streamed, and loaded by many threads.
#[derive(Clone, Debug)]
pub struct ObservationFiles {
    /// Frames per second.
    pub fps: f64,
    /// The cameras that have masks, in the order of the manifest; where none has, all, or without points those that have detections.
    pub rig: Rig,
    /// The frames that have points or a mask from at least one camera, or, without any mask, detections; ascending.
    pub frames: Vec<FrameIndex>,
    /// The masks that are not there.
    pub missing: Vec<Missing>,
    /// By how many frames each camera of the rig began after the recording, as its files were numbered.
    pub(crate) beginnings: Vec<Beginning>,
    /// What the user should know.
    pub notes: Vec<Note>,
    /// The folder that the manifest's paths are relative to.
    pub(super) folder: PathBuf,
    /// Manifest and calibration.
    pub(super) descriptions: Vec<PathBuf>,
    /// Frame → mask, for each camera of the rig.
    pub(super) masks: Vec<BTreeMap<FrameIndex, PathBuf>>,
    pub(super) points: PointFiles,
    pub(super) detections: DetectionFiles,
    /// What masks or points were made of: each camera's pictures.
    pub(super) pictures: Vec<(String, Vec<PathBuf>)>,
}

/// Frames in which one camera has no mask and another has.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Missing {
    /// Name of the camera.
    pub camera: String,
    /// The frames, ascending.
    pub frames: Vec<FrameIndex>,
}

/// Which points of a recording are wanted.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum WantedPoints {
    /// Those of the manifest or the folder.
    Given,
    /// Those that were measured in the recording's own pictures, of the frames that were asked for.
    Measured,
    /// None.
    Ignored,
}

impl ObservationFiles {
    /// Lists the masks and points of a recording; no mask is read but the first header of each camera, for calibrations
    /// without image size.
    pub(super) fn list(
        recording: &Recording,
        wanted: WantedPoints,
    ) -> Result<Self, RecordingError> {
        let mut notes = Vec::new();

        // cameras and their masks
        let MaskFiles { rig, cameras } = MaskFiles::list(recording, &mut notes)?;
        notes.extend(recording.calibration_notes().into_iter().map(Note::from));
        // the pictures of one instant need no clock
        let of_one_instant = |(_, files): &(_, NumberedFiles)| files.of_number.len() == 1;
        let is_instant = !cameras.is_empty() && cameras.iter().all(of_one_instant);
        let fps = recording.frame_rate(is_instant.then_some(1.0))?;
        let is_masked = !cameras.is_empty();
        let mut masks: Vec<_> = cameras
            .iter()
            .map(|(camera, files)| masks::by_frame(camera, files, fps, &mut notes))
            .collect();
        masks.resize_with(rig.cameras.len(), BTreeMap::new);
        let files: Vec<CameraFiles> = match is_masked {
            true => cameras.into_iter().map(|(camera, _)| camera).collect(),
            false => recording.stated(&rig),
        };
        let mut beginnings: Vec<Beginning> =
            files.iter().map(|camera| camera.beginning(fps)).collect();
        beginnings.resize(rig.cameras.len(), Beginning::default());
        recording.check_offsets(fps)?;

        // detections
        let detections = match wanted {
            WantedPoints::Ignored => DetectionFiles::default(),
            _ => DetectionFiles::find(recording, &rig, &files, fps)?,
        };

        // points
        let points = match wanted {
            WantedPoints::Ignored => PointFiles::default(),
            _ => PointFiles::find(&recording.folder, &recording.manifest, &rig, &mut notes)?,
        };

        // frames
        let alone = if is_masked { &[] } else { detections.of_cameras() };
        let (frames, missing) = frames_and_missing(&rig, &masks, &points, alone);
        if frames.is_empty() && !is_masked && wanted == WantedPoints::Given {
            let (path, hint) = (recording.path.clone(), elsewhere::hint(&recording.folder));
            return Err(RecordingError::NoMasks { path, hint });
        }
        if wanted != WantedPoints::Measured {
            notes.extend(points.missing(frames.len()));
        }
        let views = |frame: &FrameIndex| masks.iter().filter(|m| m.contains_key(frame)).count();
        if masks.iter().any(|m| !m.is_empty()) && !frames.iter().any(|frame| views(frame) > 1) {
            notes.push(Note::NoCommonFrame);
        } else {
            notes.extend(never_together(&rig, &masks));
        }

        Ok(Self {
            fps,
            rig,
            frames,
            missing,
            notes,
            beginnings,
            folder: recording.folder.clone(),
            descriptions: recording.descriptions().chain(recording.calibration_files()).collect(),
            masks,
            points,
            detections,
            pictures: Vec::new(),
        })
    }

    /// Whether a camera has masks.
    pub fn has_masks(&self) -> bool {
        self.masks.iter().any(|masks| !masks.is_empty())
    }

    /// Whether a camera has detections.
    pub fn has_detections(&self) -> bool {
        !self.detections.is_empty()
    }

    /// All people whom other programs see in the frame at `position` in [`ObservationFiles::frames`], in undistorted pixels.
    ///
    /// # Errors
    /// [`RecordingError::Detections`] for the first file that cannot be read, and [`RecordingError::NoFrame`].
    pub fn load_people(&self, position: usize) -> Result<FramePeople, RecordingError> {
        let frame = self.frames.get(position).copied();
        let frame = frame.ok_or(RecordingError::NoFrame { position, count: self.frames.len() })?;
        self.detections.people(&self.rig, frame)
    }

    /// All people whom a camera's detections show in a frame, in undistorted pixels.
    ///
    /// # Errors
    /// [`RecordingError::Detections`] for a file that cannot be read.
    pub fn people(
        &self,
        camera: CameraId,
        frame: FrameIndex,
    ) -> Result<Vec<Vec<Keypoint>>, RecordingError> {
        let known = self.rig.camera(camera);
        known.map_or(Ok(Vec::new()), |known| self.detections.load((camera, known), frame))
    }

    /// Whether a frame has points.
    pub fn has_points(&self) -> bool {
        self.points.frames().next().is_some()
    }

    /// The silhouettes and points of the frame at `position` in [`ObservationFiles::frames`].
    ///
    /// Of more than [`MOST_POINTS`](super::MOST_POINTS) points as many are taken, evenly; [`ObservationFiles::notes_on`] says so.
    ///
    /// # Errors
    /// [`RecordingError::Mask`] for the first mask that cannot be used, in the order of the rig,
    /// [`RecordingError::Cloud`], [`RecordingError::PointsFar`] and [`RecordingError::PointsTogether`] for points that
    /// cannot, and [`RecordingError::NoFrame`]. A mask that is read and shows no silhouette is no error: it is listed as rejected.
    pub fn load_frame(
        &self,
        position: usize,
        options: &SilhouetteOptions,
    ) -> Result<FrameObservations, RecordingError> {
        let frame = self.frames.get(position).copied();
        let frame = frame.ok_or(RecordingError::NoFrame { position, count: self.frames.len() })?;
        let mut observations = FrameObservations::nothing(frame);

        for (id, camera) in self.rig.iter() {
            let Some(mask) = self.load_mask(id, frame)? else {
                continue;
            };
            match silhouette::extract(&mask, camera, options) {
                Ok(silhouette) => {
                    let people = self.detections.load((id, camera), frame)?;
                    let own = silhouette.detection(people).map(|detection| (id, detection));
                    observations.detections.extend(own);
                    observations.views.push((id, silhouette));
                }
                Err(reason) => observations.rejected.push((id, reason)),
            }
        }

        self.load_points(&mut observations)?;
        Ok(observations)
    }

    /// Adds a frame's points to its observations.
    ///
    /// # Errors
    /// As [`ObservationFiles::load_frame`] of points.
    pub fn load_points(&self, observed: &mut FrameObservations) -> Result<(), RecordingError> {
        let cloud = self.points.load(observed.frame)?;
        observed.points.extend(cloud.points);
        observed.points_left_out = cloud.left_out;
        Ok(())
    }

    /// Notes on the masks and the points of the frames that were loaded.
    pub fn notes_on(&self, observations: &[FrameObservations]) -> Vec<Note> {
        let is_loaded = |frame: &FrameIndex| {
            let known = observations.binary_search_by_key(frame, |observed| observed.frame);
            known.is_ok()
        };
        let missing = self.missing.iter().filter_map(|missing| {
            let frames = missing.frames.iter().copied().filter(is_loaded).collect();
            let frames = Some(Frames(frames)).filter(|frames| !frames.0.is_empty())?;
            let camera = missing.camera.clone();
            Some(Note::MasksMissing { camera, frames, of: observations.len() })
        });
        missing.chain(self.points.notes(observations)).collect()
    }

    /// The mask of a camera in a frame; `None` if it is missing.
    pub fn mask_path(&self, camera: CameraId, frame: FrameIndex) -> Option<&Path> {
        let path = self.masks.get(camera.0)?.get(&frame)?;
        Some(path)
    }

    /// The mask of a camera in a frame as it was read, of everybody whom it shows; `None` if it is missing.
    ///
    /// # Errors
    /// [`RecordingError::Mask`] if it cannot be used.
    pub fn load_mask(
        &self,
        camera: CameraId,
        frame: FrameIndex,
    ) -> Result<Option<Mask>, RecordingError> {
        Ok(self.load_painted(camera, frame)?.map(Painted::everybody))
    }

    /// The value of each person in a mask, 0 for nobody; `None` if it is missing, or black and white.
    ///
    /// # Errors
    /// As [`ObservationFiles::load_mask`].
    pub fn load_labels(
        &self,
        camera: CameraId,
        frame: FrameIndex,
    ) -> Result<Option<Plane<u16>>, RecordingError> {
        Ok(match self.load_painted(camera, frame)? {
            Some(Painted::Labels(labels)) => Some(labels),
            Some(Painted::White(_)) | None => None,
        })
    }

    fn load_painted(
        &self,
        camera: CameraId,
        frame: FrameIndex,
    ) -> Result<Option<Painted>, RecordingError> {
        let (Some(path), Some(known)) = (self.mask_path(camera, frame), self.rig.camera(camera))
        else {
            return Ok(None);
        };
        let painted = mask_image::read(path, [known.width_px, known.height_px]);
        painted.map(Some).map_err(|fault| RecordingError::Mask {
            path: path.into(),
            camera: known.name.clone(),
            frame,
            fault: Box::new(fault),
        })
    }
}

impl MaskSource for ObservationFiles {
    fn has_masks_of(&self, camera: &str) -> bool {
        self.rig.by_name(camera).is_some()
    }

    fn mask(&self, camera: &str, frame: FrameIndex) -> Result<Option<Mask>, String> {
        match self.rig.by_name(camera) {
            Some((id, _)) => self.load_mask(id, frame).map_err(|fault| fault.to_string()),
            None => Ok(None),
        }
    }
}

/// The cameras that have masks, but in no frame that another has.
fn never_together(rig: &Rig, masks: &[BTreeMap<FrameIndex, PathBuf>]) -> Vec<Note> {
    let note = |(i, name): (usize, &str)| {
        let own = &masks[i];
        let others = || masks.iter().enumerate().filter(|(j, _)| *j != i).map(|(_, m)| m);
        let is_alone = |frame: &FrameIndex| !others().any(|m| m.contains_key(frame));
        let all = || others().flat_map(|m| m.keys());
        let is_noted = own.keys().all(is_alone);
        Some(Note::NeverTogether {
            camera: name.into(),
            first: own.keys().next().filter(|_| is_noted)?.0,
            last: own.keys().next_back()?.0,
            others_first: all().min()?.0,
            others_last: all().max()?.0,
        })
    };
    rig.names().enumerate().filter_map(note).collect()
}

/// The frames that have a mask, a cloud or detections that stand alone, and the masks that are missing.
fn frames_and_missing(
    rig: &Rig,
    masks: &[BTreeMap<FrameIndex, PathBuf>],
    points: &PointFiles,
    detections: &[BTreeMap<FrameIndex, PathBuf>],
) -> (Vec<FrameIndex>, Vec<Missing>) {
    let shown = masks.iter().chain(detections).flat_map(|m| m.keys().copied());
    let frames: BTreeSet<FrameIndex> = shown.chain(points.frames()).collect();
    let frames: Vec<FrameIndex> = frames.into_iter().collect();

    let with_masks = rig.names().zip(masks).filter(|(_, m)| !m.is_empty());
    let missing = with_masks.filter_map(|(camera, masks)| {
        let lacking = frames.iter().copied().filter(|frame| !masks.contains_key(frame));
        let frames: Vec<FrameIndex> = lacking.collect();
        (!frames.is_empty()).then(|| Missing { camera: camera.into(), frames })
    });

    let missing = missing.collect();
    (frames, missing)
}
