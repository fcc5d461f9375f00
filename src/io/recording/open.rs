//! From a folder to a list of frames.

use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};

use super::points::PointFiles;
use super::{Missing, Note, Points, Recording, RecordingError, Sources, mask_image};
use crate::camera::{CameraId, Rig};
use crate::io::calibration::{self, CalibrationOptions};
use crate::io::recording::layout;
use crate::io::recording::layout::numbered_files::{self, NumberedFiles, Wanted};
use crate::io::recording::manifest::{CameraFiles, Manifest};
use crate::io::unknown_key::nearest;
use crate::silhouette::FrameIndex;

pub(super) fn open(
    path: &Path,
    fps: Option<f64>,
    elsewhere: &Sources,
) -> Result<Recording, RecordingError> {
    let (folder, manifest_path) = layout::locate(path)?;
    let mut manifest = match &manifest_path {
        Some(path) => Manifest::read(path)?,
        None => Manifest::default(),
    };
    take(&mut manifest, elsewhere);
    let mut notes = Vec::new();
    let sources = layout::calibration_paths(&folder, manifest.calibration.as_ref());
    let masks = masks_of_cameras(path, &folder, &manifest, &mut notes)?;
    let (rig, masks) = calibrate(path, &manifest, masks, &sources, &mut notes)?;
    let fps = layout::frame_rate(fps.or(manifest.fps), path)?;
    let is_masked = !masks.is_empty();
    let mut masks: Vec<_> = masks
        .iter()
        .map(|(camera, files)| by_frame(camera, files, fps, &mut notes))
        .collect();
    masks.resize_with(rig.cameras.len(), BTreeMap::new);
    let made = matches!(elsewhere.points, Points::Folder(_));
    let points = match elsewhere.points {
        Points::None => PointFiles::default(),
        _ => PointFiles::find(&folder, &manifest, &rig, &mut notes)?,
    };
    let (frames, missing) = frames_and_missing(&masks, &points);
    if frames.is_empty() && !is_masked && matches!(elsewhere.points, Points::Manifest) {
        return Err(RecordingError::NoMasks { path: path.into() });
    }
    // those that were made are of the frames that were asked for
    notes.extend(points.missing(frames.len()).filter(|_| !made));
    let views = |frame: &FrameIndex| masks.iter().filter(|m| m.contains_key(frame)).count();
    if masks.iter().any(|m| !m.is_empty()) && !frames.iter().any(|frame| views(frame) > 1) {
        notes.push(Note::NoCommonFrame);
    }
    let sources = sources
        .iter()
        .flat_map(|(_, source)| layout::files_behind(source));
    Ok(Recording {
        fps,
        rig,
        frames,
        missing,
        notes,
        body: manifest.body,
        folder,
        descriptions: manifest_path.iter().cloned().chain(sources).collect(),
        masks,
        points,
        pictures: Vec::new(),
    })
}

/// Puts what lies elsewhere into the manifest.
fn take(manifest: &mut Manifest, elsewhere: &Sources) {
    if let Some(cameras) = &elsewhere.cameras {
        manifest.cameras.clone_from(cameras);
    }
    if let Points::Folder(folder) = &elsewhere.points {
        manifest.points = Some(folder.display().to_string());
        manifest.points_unit = None;
        // the pictures are used: points were made of them
        for camera in &mut manifest.cameras {
            (camera.images, camera.video, camera.background) = (None, None, None);
        }
    }
}

/// The cameras of the manifest, or of the folder where it lists none, that have masks; none where there are points alone.
fn cameras_with_masks(
    path: &Path,
    folder: &Path,
    manifest: &Manifest,
    notes: &mut Vec<Note>,
) -> Result<Vec<CameraFiles>, RecordingError> {
    let cameras = if manifest.cameras.is_empty() {
        layout::conventional_cameras(folder)?
    } else {
        manifest.cameras.clone()
    };
    let (with, without): (Vec<_>, Vec<_>) = cameras
        .into_iter()
        .partition(|camera| camera.masks.is_some());
    if with.is_empty() && PointFiles::are_promised(folder, manifest) {
        return Ok(Vec::new());
    }
    if with.is_empty() {
        return Err(RecordingError::NoMasks { path: path.into() });
    }
    let keys = ignored_keys(manifest);
    if !keys.is_empty() {
        notes.push(Note::Ignored { keys });
    }
    notes.extend(without.into_iter().map(|camera| Note::WithoutMasks {
        camera: camera.name,
    }));
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

/// The cameras that are used, each with its files.
type CameraMasks = Vec<(CameraFiles, NumberedFiles)>;

fn masks_of_cameras(
    path: &Path,
    folder: &Path,
    manifest: &Manifest,
    notes: &mut Vec<Note>,
) -> Result<CameraMasks, RecordingError> {
    let list = |camera: CameraFiles| {
        let pattern = camera.masks.as_deref().unwrap_or_default();
        let wanted = Wanted {
            key: &format!("camera {}: masks", camera.name),
            is_kind: numbered_files::is_image,
        };
        let files = numbered_files::list(folder, pattern, &wanted)?;
        if files.of_number.is_empty() {
            return Err(RecordingError::MissingMasks {
                pattern: folder.join(pattern),
                camera: camera.name,
            });
        }
        Ok((camera, files))
    };
    let cameras = cameras_with_masks(path, folder, manifest, notes)?;
    cameras.into_iter().map(list).collect()
}

/// Reads the calibration of the cameras; those of a manifest must all be in it.
fn calibrate(
    path: &Path,
    manifest: &Manifest,
    masks: CameraMasks,
    sources: &[(Option<String>, PathBuf)],
    notes: &mut Vec<Note>,
) -> Result<(Rig, CameraMasks), RecordingError> {
    let options = CalibrationOptions {
        unit: manifest.unit,
        up: manifest.up,
        image_sizes_px: image_sizes(&masks),
    };
    let calibrated = layout::read_calibration(sources, &options)?;
    let masks = if manifest.cameras.is_empty() {
        only_calibrated(masks, &calibrated, notes)
    } else {
        masks
    };
    let source = match sources {
        [(_, source)] => source,
        _ => path,
    };
    if masks.is_empty() {
        return Ok((all_cameras(&calibrated, manifest, source)?, masks));
    }
    let names: Vec<&str> = masks
        .iter()
        .map(|(camera, _)| camera.name.as_str())
        .collect();
    let rig = calibration::select(&calibrated, source, &names)?;
    match names.as_slice() {
        [camera] => Err(RecordingError::OneCamera {
            path: path.into(),
            camera: (*camera).into(),
        }),
        _ => Ok((rig, masks)),
    }
}

/// The cameras of the manifest, or of the calibration where it lists none: what looks at points without masks.
fn all_cameras(
    calibrated: &Rig,
    manifest: &Manifest,
    source: &Path,
) -> Result<Rig, RecordingError> {
    let names: Vec<&str> = match manifest.cameras.as_slice() {
        [] => calibrated.names().collect(),
        cameras => cameras.iter().map(|camera| camera.name.as_str()).collect(),
    };
    Ok(calibration::select(calibrated, source, &names)?)
}

/// Width and height of each camera's first mask, where that can be read.
fn image_sizes(masks: &CameraMasks) -> BTreeMap<String, [u32; 2]> {
    let size = |files: &NumberedFiles| mask_image::size_of(files.of_number.values().next()?).ok();
    masks
        .iter()
        .filter_map(|(camera, files)| Some((camera.name.clone(), size(files)?)))
        .collect()
}

/// In the order of the calibration, those that it has; a note of each that it has not, and of what has no masks.
///
/// Where it has none at all they are left as they are, to be refused.
fn only_calibrated(masks: CameraMasks, calibrated: &Rig, notes: &mut Vec<Note>) -> CameraMasks {
    let position = |name: &str| calibrated.by_name(name).map(|(id, _)| id);
    let names: Vec<&str> = calibrated.names().collect();
    let (mut known, unknown): (CameraMasks, CameraMasks) = masks
        .into_iter()
        .partition(|(camera, _)| position(&camera.name).is_some());
    if known.is_empty() {
        return unknown;
    }
    notes.extend(unknown.into_iter().map(|(camera, _)| Note::Uncalibrated {
        nearest: nearest(&camera.name, &names).unwrap_or_default().into(),
        camera: camera.name,
    }));
    let is_masked = |name: &&str| known.iter().any(|(camera, _)| camera.name == **name);
    let cameras: Vec<String> = names
        .iter()
        .filter(|name| !is_masked(name))
        .map(|name| (*name).into())
        .collect();
    if !cameras.is_empty() {
        notes.push(Note::Unmasked { cameras });
    }
    known.sort_by_key(|(camera, _)| position(&camera.name));
    known
}

/// The masks by frame: number + `offset_frames` + `start_s` · fps.
fn by_frame(
    camera: &CameraFiles,
    files: &NumberedFiles,
    fps: f64,
    notes: &mut Vec<Note>,
) -> BTreeMap<FrameIndex, PathBuf> {
    let frame = |number: u64| {
        let shifted = number.checked_add_signed(camera.shift(fps))?;
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
        notes.push(Note::BeforeFirst {
            camera,
            files: before,
        });
    }
    if unnumbered > 0 {
        notes.push(Note::Unnumbered {
            camera,
            files: unnumbered,
        });
    }
    masks
}

/// The frames of which there is a mask or a cloud, and the masks that are lacking.
fn frames_and_missing(
    masks: &[BTreeMap<FrameIndex, PathBuf>],
    points: &PointFiles,
) -> (Vec<FrameIndex>, Vec<Missing>) {
    let masked = masks.iter().flat_map(|m| m.keys().copied());
    let frames: BTreeSet<FrameIndex> = masked.chain(points.frames()).collect();
    let frames: Vec<FrameIndex> = frames.into_iter().collect();
    let with_masks = masks.iter().enumerate().filter(|(_, m)| !m.is_empty());
    let missing = with_masks.filter_map(|(i, masks)| {
        let lacking = frames
            .iter()
            .copied()
            .filter(|frame| !masks.contains_key(frame));
        let frames: Vec<FrameIndex> = lacking.collect();
        let camera = CameraId(i);
        (!frames.is_empty()).then_some(Missing { camera, frames })
    });
    let missing = missing.collect();
    (frames, missing)
}
