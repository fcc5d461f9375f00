//! From a path to a rig: which reader a file is for.

use super::{
    CalibrationError, CalibrationOptions,
    error::one_line,
    found::{self, EASYMOCAP},
    opencv, opencv_storage, pose2sim, projection_matrix, qualisys,
    unchecked::{UncheckedCamera, check},
    vicon,
};
use crate::camera::Rig;
use crate::io::input::{self, MOST_OF_A_TEXT, shortened};
use std::path::{Path, PathBuf};

/// Similarity (Jaro–Winkler) from which a name is offered instead of an unknown one.
const ALIKE: f64 = 0.8;

/// Reads a calibration file, or the calibration in a folder, into a rig in metres with Z up.
///
/// The format follows from the file's name and content. Of a folder it is the last `*.toml` in natural order of names
/// (manifests aside), else `intri.yml` with `extri.yml`, else the last `*.qca.txt`, else the last `*.xcp`. The camera of
/// a file that names none is called after the file.
///
/// # Errors
/// [`CalibrationError`], naming the path as given, the line and the camera where known.
pub fn read(path: &Path, options: &CalibrationOptions) -> Result<Rig, CalibrationError> {
    check(path, &unchecked(path)?, options)
}

/// Reads one file for each camera, of any format; the names given count, in the order given.
///
/// Of a file that describes several cameras the one of that name is taken.
///
/// # Errors
/// [`CalibrationError`], naming the file of the camera that is wrong.
pub fn read_per_camera(
    files: &[(String, PathBuf)],
    options: &CalibrationOptions,
) -> Result<Rig, CalibrationError> {
    let mut cameras = Vec::new();
    for (name, path) in files {
        let found = unchecked(path)?;

        // a file with a single camera is that camera's, under any name
        let count = found.len();
        let named = |camera: &UncheckedCamera| count == 1 || camera.name == *name;
        let mut camera = found.into_iter().find(named).ok_or_else(|| match count {
            0 => CalibrationError::NoCameras { path: path.clone() },
            found => {
                CalibrationError::SeveralCameras { path: path.clone(), camera: name.clone(), found }
            }
        })?;

        camera.name.clone_from(name);
        cameras.push(camera);
    }

    let path = files.first().map_or(Path::new("calibration"), |(_, path)| path);
    check(path, &cameras, options)
}

/// The cameras of these names, in this order; `path` is what the rig was read from, for the message.
///
/// # Errors
/// [`CalibrationError::UnknownCamera`] with the names that are there, [`CalibrationError::Duplicate`] for a name asked twice.
pub fn select(rig: &Rig, path: &Path, names: &[&str]) -> Result<Rig, CalibrationError> {
    let mut cameras = Vec::new();
    for (index, name) in names.iter().enumerate() {
        if names[..index].contains(name) {
            return Err(CalibrationError::Duplicate {
                place: super::Place::new(path, None, Some(name)),
            });
        }
        let (_, camera) = rig.by_name(name).ok_or_else(|| unknown_camera(rig, path, name))?;
        cameras.push(camera.clone());
    }
    Ok(Rig { cameras })
}

fn unknown_camera(rig: &Rig, path: &Path, name: &str) -> CalibrationError {
    let likeness = |known: &&str| strsim::jaro_winkler(known, name);
    let nearest = rig
        .names()
        .max_by(|a, b| likeness(a).total_cmp(&likeness(b)))
        .filter(|known| likeness(known) >= ALIKE);
    CalibrationError::UnknownCamera {
        path: path.into(),
        camera: name.into(),
        known: one_line(&rig.names().collect::<Vec<_>>().join(", ")),
        hint: nearest.map_or(String::new(), |near| format!("; did you mean {near:?}?")),
    }
}

fn unchecked(path: &Path) -> Result<Vec<UncheckedCamera>, CalibrationError> {
    if path.is_dir() { file(&found::find(path)?) } else { file(path) }
}

fn file(path: &Path) -> Result<Vec<UncheckedCamera>, CalibrationError> {
    let name = path.file_name().unwrap_or_default().to_string_lossy();
    if name.to_lowercase().ends_with(".pickle") {
        return Err(CalibrationError::Pickle { path: path.into() });
    }
    let text = text(path)?;
    let stem = path.file_stem().unwrap_or_default().to_string_lossy();
    match kind(&name, text.trim_start()) {
        Kind::Toml => pose2sim::parse(path, &text),
        Kind::Xml => xml(path, &text, &stem),
        Kind::Yaml if found::is_half(path) => pair(path),
        Kind::Yaml => {
            let storage = opencv_storage::parse_yaml(path, &text)?;
            opencv::cameras(&[storage], &stem)
        }
        Kind::Matrices => projection_matrix::parse(path, &text, &stem),
        Kind::Unknown => Err(CalibrationError::UnknownFormat { path: path.into() }),
    }
}

/// The syntax of a file.
enum Kind {
    Toml,
    Xml,
    Yaml,
    Matrices,
    Unknown,
}

/// By the ending of the name; a text, or a file without known ending, by its first characters.
fn kind(name: &str, start: &str) -> Kind {
    let name = name.to_lowercase();
    let ends = |endings: &[&str]| endings.iter().any(|ending| name.ends_with(ending));
    if start.starts_with('<') || ends(&[".xml", ".xcp", ".qca.txt", ".qca"]) {
        Kind::Xml
    } else if ends(&[".toml"]) {
        Kind::Toml
    } else if start.starts_with("%YAML") || ends(&[".yml", ".yaml"]) {
        Kind::Yaml
    } else if ends(&[".txt", ".p", ".proj"]) {
        Kind::Matrices
    } else {
        Kind::Unknown
    }
}

/// XML by its root element: OpenCV's storage, Vicon's `Cameras`, Qualisys' `calibration`.
fn xml(path: &Path, text: &str, stem: &str) -> Result<Vec<UncheckedCamera>, CalibrationError> {
    let root = super::xml::document(path, text)?.root_element().tag_name().name().to_owned();
    match root.as_str() {
        "opencv_storage" => opencv::cameras(&[opencv_storage::parse_xml(path, text)?], stem),
        "Cameras" => vicon::parse(path, text),
        "calibration" => qualisys::parse(path, text),
        _ => Err(CalibrationError::Syntax {
            place: super::Place::new(path, None, None),
            expected: "<opencv_storage>, <Cameras> or <calibration>",
            found: format!("<{}>", shortened(&root)),
        }),
    }
}

fn pair(path: &Path) -> Result<Vec<UncheckedCamera>, CalibrationError> {
    opencv::cameras(&halves(path)?, "camera")
}

/// The cameras that only one of EasyMocap's two files describes, which are therefore left out; none of any other calibration.
pub(in crate::io) fn unpaired(path: &Path) -> Vec<String> {
    let files = found::files(path);
    let pair = files.first().filter(|file| found::is_half(file));
    let halves = pair.and_then(|half| halves(half).ok());
    halves.map(|storages| opencv::paired(&storages).1).unwrap_or_default()
}

fn halves(path: &Path) -> Result<Vec<opencv_storage::Storage>, CalibrationError> {
    let mut storages = Vec::new();
    for half in EASYMOCAP {
        let beside = path.with_file_name(half);
        if !beside.exists() {
            return Err(CalibrationError::MissingHalf { path: path.into(), expected: half });
        }
        storages.push(opencv_storage::parse_yaml(&beside, &text(&beside)?)?);
    }
    Ok(storages)
}

/// The file's text without byte-order mark; what is not UTF-8, as in remarks of older systems, is replaced.
fn text(path: &Path) -> Result<String, CalibrationError> {
    let bytes = input::read(path, MOST_OF_A_TEXT).map_err(|reason| unreadable(path, reason))?;
    let bytes = bytes.strip_prefix(b"\xef\xbb\xbf").unwrap_or(&bytes);
    Ok(String::from_utf8_lossy(bytes).into_owned())
}

fn unreadable(path: &Path, reason: std::io::Error) -> CalibrationError {
    CalibrationError::Read { path: path.into(), reason }
}
