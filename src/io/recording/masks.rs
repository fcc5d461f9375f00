//! The mask files of each camera, by frame.

use std::collections::BTreeMap;
use std::path::PathBuf;

use super::cameras::CalibratedCameras;
use super::layout::elsewhere;
use super::layout::numbered_files::{self, NumberedFiles, Wanted};
use super::manifest::{CameraFiles, Manifest};
use super::points::PointFiles;
use super::{DetectionFiles, Note, Recording, RecordingError, layout, mask_image};
use crate::camera::Rig;
use crate::silhouette::FrameIndex;

/// The cameras that are used, each with its masks.
pub(super) struct MaskFiles {
    /// The cameras that have masks; where none has, all, or without points those that have detections.
    pub(super) rig: Rig,
    /// Those that have masks, in the order of the rig.
    pub(super) cameras: Vec<(CameraFiles, NumberedFiles)>,
}

impl MaskFiles {
    /// Finds the masks of the manifest's cameras, or of the folder's, and calibrates the cameras.
    pub(super) fn list(
        recording: &Recording,
        notes: &mut Vec<Note>,
    ) -> Result<Self, RecordingError> {
        let masks = masks_of_cameras(recording, notes)?;
        if masks.is_empty() {
            let rig = recording.all_cameras()?;
            let has_points = PointFiles::are_promised(&recording.folder, &recording.manifest);
            let rig = if has_points { rig } else { DetectionFiles::detected(recording, &rig)? };
            return Ok(Self { rig, cameras: Vec::new() });
        }

        let size = |files: &NumberedFiles| {
            let first = files.of_number.values().next()?;
            mask_image::size_of(first).ok()
        };
        let CalibratedCameras { rig, cameras, uncalibrated, without_files } =
            recording.calibrate(masks, size)?;

        notes.extend(
            uncalibrated.into_iter().map(|unknown| Note::Uncalibrated {
                camera: unknown.name,
                nearest: unknown.nearest,
            }),
        );
        if !without_files.is_empty() {
            notes.push(Note::Unmasked { cameras: without_files });
        }

        match cameras.as_slice() {
            [(camera, _)] => Err(RecordingError::OneCamera {
                path: recording.path.clone(),
                camera: camera.name.clone(),
            }),
            _ => Ok(Self { rig, cameras }),
        }
    }
}

/// The cameras with masks, of the manifest or, where it lists none, of the folder; none if there are only points or detections.
fn cameras_with_masks(
    recording: &Recording,
    notes: &mut Vec<Note>,
) -> Result<Vec<CameraFiles>, RecordingError> {
    let Recording { folder, manifest, .. } = recording;

    let cameras = if manifest.cameras.is_empty() {
        layout::conventional_cameras(folder)?
    } else {
        manifest.cameras.clone()
    };
    let (with, without): (Vec<_>, Vec<_>) =
        cameras.into_iter().partition(|camera| camera.masks.is_some());

    let is_promised =
        PointFiles::are_promised(folder, manifest) || DetectionFiles::are_promised(recording);
    if with.is_empty() && is_promised {
        return Ok(Vec::new());
    }
    if with.is_empty() {
        let hint = elsewhere::hint(&recording.folder);
        return Err(RecordingError::NoMasks { path: recording.path.clone(), hint });
    }

    let keys = ignored_keys(manifest);
    if !keys.is_empty() {
        notes.push(Note::Ignored { keys });
    }
    notes.extend(without.into_iter().map(|camera| Note::WithoutMasks { camera: camera.name }));
    Ok(with)
}

fn ignored_keys(manifest: &Manifest) -> Vec<&'static str> {
    let any = |has: fn(&CameraFiles) -> bool| manifest.cameras.iter().any(has);
    [
        ("images", any(|camera| camera.images.is_some())),
        ("video", any(|camera| camera.video.is_some())),
        ("background", any(|camera| camera.background.is_some())),
        ("start", manifest.start.is_some()),
    ]
    .into_iter()
    .filter_map(|(key, is_given)| is_given.then_some(key))
    .collect()
}

fn masks_of_cameras(
    recording: &Recording,
    notes: &mut Vec<Note>,
) -> Result<Vec<(CameraFiles, NumberedFiles)>, RecordingError> {
    let list = |camera: CameraFiles| {
        let pattern = camera.masks.as_deref().unwrap_or_default();
        let wanted = Wanted {
            key: &format!("camera {}: masks", camera.name),
            is_kind: numbered_files::is_image,
        };
        let files = numbered_files::list(&recording.folder, pattern, &wanted)?;
        if files.of_number.is_empty() {
            return Err(RecordingError::MissingMasks {
                pattern: recording.folder.join(pattern),
                camera: camera.name,
            });
        }
        Ok((camera, files))
    };

    let cameras = cameras_with_masks(recording, notes)?;
    cameras.into_iter().map(list).collect()
}

/// The masks by frame: number + `offset_frames` + `start_s` · fps.
pub(super) fn by_frame(
    camera: &CameraFiles,
    files: &NumberedFiles,
    fps: f64,
    notes: &mut Vec<Note>,
) -> BTreeMap<FrameIndex, PathBuf> {
    let frame = |number: u64| {
        let shifted = number.checked_add_signed(camera.beginning(fps).whole())?;
        Some(FrameIndex(usize::try_from(shifted).ok()?))
    };
    let masks: BTreeMap<_, _> = files
        .of_number
        .iter()
        .filter_map(|(number, path)| Some((frame(*number)?, path.clone())))
        .collect();

    let (camera, unnumbered) = (camera.name.clone(), files.unnumbered);
    let before = files.of_number.len() - masks.len();
    if before > 0 {
        let camera = camera.clone();
        notes.push(Note::BeforeFirst { camera, files: before });
    }
    if unnumbered > 0 {
        notes.push(Note::Unnumbered { camera, files: unnumbered });
    }
    masks
}
