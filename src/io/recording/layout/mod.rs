//! Where the files of a recording are, in a folder without manifest or where the manifest does not say.

pub(super) mod elsewhere;
pub(in crate::io) mod numbered_files;

use std::fs;
use std::path::{Path, PathBuf};

use crate::camera::Rig;
use crate::io::calibration::{self, CalibrationError, CalibrationOptions};
use crate::io::frame_rate;
use crate::io::recording::RecordingError;
use crate::io::recording::manifest::{CalibrationFiles, CameraFiles};

const MANIFEST: &str = "sequence.toml";
const MASKS: &str = "masks";

/// The folder of a recording and its manifest, if it has one.
pub(super) fn locate(path: &Path) -> Result<(PathBuf, Option<PathBuf>), RecordingError> {
    if path.is_dir() {
        let manifest = path.join(MANIFEST);
        let manifest = manifest.exists().then_some(manifest);
        Ok((path.into(), manifest))
    } else if path.is_file() {
        let folder = path.parent().unwrap_or(Path::new("")).to_owned();
        Ok((folder, Some(path.into())))
    } else {
        Err(RecordingError::NotFound { path: path.into() })
    }
}

/// A frame rate that was given or found; the recording at `path` needs one.
pub(super) fn frame_rate(fps: Option<f64>, path: &Path) -> Result<f64, RecordingError> {
    match fps {
        Some(fps) if frame_rate::is_one(fps) => Ok(fps),
        Some(fps) => Err(RecordingError::Fps { fps }),
        None => Err(RecordingError::NoFps { path: path.into() }),
    }
}

/// One camera for each folder `masks/<camera>`, by name.
pub(super) fn conventional_cameras(folder: &Path) -> Result<Vec<CameraFiles>, RecordingError> {
    let folders = visible(&folder.join(MASKS))?.into_iter();
    let camera = |path: PathBuf| {
        let name = path.file_name()?.to_string_lossy().into_owned();
        Some(CameraFiles { masks: Some(format!("{MASKS}/{name}")), name, ..CameraFiles::default() })
    };
    Ok(folders.filter(|path| path.is_dir()).filter_map(camera).collect())
}

/// The files or folders that the calibration is read from.
pub(super) fn calibration_paths(
    folder: &Path,
    files: Option<&CalibrationFiles>,
) -> Vec<(Option<String>, PathBuf)> {
    match files {
        Some(CalibrationFiles::One(path)) => vec![(None, folder.join(path))],
        Some(CalibrationFiles::PerCamera(files)) => {
            files.iter().map(|(camera, path)| (Some(camera.clone()), folder.join(path))).collect()
        }
        None => vec![(None, conventional_calibration(folder))],
    }
}

/// Reads what [`calibration_paths`] found.
pub(super) fn read_calibration(
    paths: &[(Option<String>, PathBuf)],
    options: &CalibrationOptions,
) -> Result<Rig, CalibrationError> {
    match paths {
        [(None, path)] => calibration::read(path, options),
        paths => {
            let named =
                paths.iter().filter_map(|(camera, path)| Some((camera.clone()?, path.clone())));
            calibration::read_per_camera(&named.collect::<Vec<_>>(), options)
        }
    }
}

/// `calibration.toml`, else another `calibration.*`, else a folder `calib…`, else the recording's folder itself; in a
/// folder the reader looks for its formats.
fn conventional_calibration(folder: &Path) -> PathBuf {
    let mut candidates: Vec<(u8, PathBuf)> = contents(folder)
        .unwrap_or_default()
        .into_iter()
        .filter_map(|path| Some((calibration_rank(&path)?, path)))
        .collect();
    candidates.sort();
    let best = candidates.into_iter().next();
    let best = best.map(|(_, path)| path);
    best.or_else(|| calibration_above(folder)).unwrap_or_else(|| folder.into())
}

/// Above a trial of Pose2Sim's session its folder `calibration`, above a recording of caliscope `camera_array.toml`; `None`
/// where the folder itself holds a calibration, or neither of the two folders above it.
fn calibration_above(folder: &Path) -> Option<PathBuf> {
    if calibration::find(folder).is_ok() {
        return None;
    }

    // Pose2Sim's sessions have it one or two folders above the trial
    let whole = folder.canonicalize().ok()?;
    whole.ancestors().skip(1).take(2).find_map(|above| {
        let held = contents(above).ok()?;
        let name =
            |path: &PathBuf| path.file_name().unwrap_or_default().to_string_lossy().to_lowercase();
        let array = held.iter().find(|path| name(path) == "camera_array.toml");
        let session = held.iter().find(|path| path.is_dir() && name(path).starts_with("calib"));
        array.or(session).cloned()
    })
}

fn calibration_rank(path: &Path) -> Option<u8> {
    let stem = path.file_stem()?.to_string_lossy().to_lowercase();
    match (path.is_dir(), stem == "calibration") {
        (false, true) if path.extension().is_some_and(|e| e == "toml") => Some(0),
        (false, true) => Some(1),
        (true, _) if stem.starts_with("calib") => Some(2),
        _ => None,
    }
}

/// What a folder holds, by name.
fn contents(folder: &Path) -> Result<Vec<PathBuf>, RecordingError> {
    let unreadable = |source| RecordingError::Folder { path: folder.into(), source };
    let mut paths = Vec::new();
    for entry in fs::read_dir(folder).map_err(unreadable)? {
        paths.push(entry.map_err(unreadable)?.path());
    }
    paths.sort();
    Ok(paths)
}

/// The visible contents of a folder, by name; empty if there is no such folder.
pub(super) fn visible(folder: &Path) -> Result<Vec<PathBuf>, RecordingError> {
    if !folder.is_dir() {
        return Ok(Vec::new());
    }
    let mut paths = contents(folder)?;
    paths.retain(|path| !is_hidden(path));
    Ok(paths)
}

fn is_hidden(path: &Path) -> bool {
    let name = path.file_name();
    name.is_some_and(|name| name.to_string_lossy().starts_with('.'))
}
