//! Calibrations as files: every format that is read and holds what a [`Camera`](crate::camera::Camera) knows.
//!
//! | file | format |
//! |---|---|
//! | `*.toml` | Pose2Sim, aniposelib, caliscope |
//! | `intri.yml` or `extri.yml` | EasyMocap's pair, both |
//! | `*.yml`, `*.yaml`, `*.xml` | OpenCV's file storage, all cameras in one file |
//! | the same with `{camera}` in the name | one file for each camera |
//! | `*.qca.txt` | Qualisys |
//!
//! A number is written with as many digits as give the same number back. The world and the unit are those that a reader expects who
//! is told the same [`CalibrationOptions`]; but Qualisys' is always in millimetres, for no other program asks which unit it has.
//!
//! **Differs** from the readers: Vicon's `.xcp` and projection matrices are not written. The first has one focal length and a lens
//! that corrects; the second has no lens.

mod opencv;
mod qualisys;
mod toml;

use std::path::{Path, PathBuf};

use super::{CalibrationOptions, Unit};
use crate::camera::{Camera, Rig};
use crate::io::calibration::found::EASYMOCAP;
use opencv::Syntax;

pub use self::toml::write_toml;

/// By how much a camera's pose and focal length were changed, and how sure that is; world axes.
#[derive(Debug, Clone, PartialEq)]
pub struct Refined {
    /// Its name.
    pub camera: String,
    /// Axis times angle of the turn about its own centre, degrees.
    pub turn_deg: [f64; 3],
    /// Its standard deviations.
    pub turn_sd_deg: [f64; 3],
    /// The displacement, metres.
    pub displacement_m: [f64; 3],
    /// Its standard deviations.
    pub displacement_sd_m: [f64; 3],
    /// The focal length over the one before.
    pub zoom: f64,
    /// Its standard deviation.
    pub zoom_sd: f64,
}

/// What is known of a camera of a calibration that was estimated.
#[derive(Debug, Clone, PartialEq)]
pub enum CameraEstimate {
    /// One that was calibrated before.
    Refined(Refined),
    /// One of which the lens alone was known; standard deviations relative to the rig, over all axes.
    Placed {
        /// Its name.
        camera: String,
        /// Of its turn.
        turn_sd_deg: f64,
        /// Of its place.
        place_sd_m: f64,
    },
}

/// A file to be written.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct CalibrationFile {
    /// Where.
    pub path: PathBuf,
    /// What.
    pub text: String,
}

/// Why a rig cannot be written in a format.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum CalibrationWriteError {
    /// A name that says no format.
    #[error(
        "{}: expected *.toml, intri.yml, *.yml, *.xml, {{camera}}.yml, {{camera}}.xml or *.qca.txt",
        path.display()
    )]
    UnknownFormat {
        /// As given.
        path: PathBuf,
    },
    /// A lens that the format has no numbers for.
    #[error("{}: camera {camera}: {lens} cannot be written in this format: use *.toml", path.display())]
    Lens {
        /// The file.
        path: PathBuf,
        /// The camera.
        camera: String,
        /// What it has.
        lens: &'static str,
    },
    /// A name that is no part of a key or of a file's name.
    #[error(
        "{}: camera {camera:?}: expected a name of letters, digits, - and _ for this format: use *.toml", path.display()
    )]
    Name {
        /// The file.
        path: PathBuf,
        /// The camera.
        camera: String,
    },
}

/// What a file is to be, by its name.
enum Format {
    Toml,
    EasyMocap,
    OpenCv(Syntax),
    OpenCvEach(Syntax),
    Qualisys,
}

/// In the place of a camera's name.
const NAME: &str = "{camera}";

/// The texts of the files that hold a rig, for a reader with these options; the format follows from the name. `known` is written where the
/// format has a place for it.
///
/// # Errors
/// [`CalibrationWriteError`] for a name that says no format, and for a camera that the format cannot hold.
pub fn write(
    rig: &Rig,
    path: &Path,
    options: &CalibrationOptions,
    known: &[CameraEstimate],
) -> Result<Vec<CalibrationFile>, CalibrationWriteError> {
    let format = format(path)?;
    let of_world = options.up.world_from_file();
    let in_file = |camera: &Camera| Camera {
        camera_from_world: camera.camera_from_world * of_world,
        ..camera.clone()
    };
    let rig = Rig { cameras: rig.cameras.iter().map(in_file).collect() };
    let in_metres = options.unit.unwrap_or(Unit::Metre).in_metres();

    let one = |text: String| vec![CalibrationFile { path: path.into(), text }];
    Ok(match format {
        Format::Toml => one(toml::text(&rig, in_metres, known)),
        Format::Qualisys => one(qualisys::text(&rig, path)?),
        Format::OpenCv(syntax) => {
            let values = opencv::values(&rig, in_metres, path)?;
            one(opencv::text(syntax, &values))
        }
        Format::EasyMocap => {
            let (inner, outer) = opencv::halves(&rig, in_metres, path)?;
            let file = |name: &str, values: &[opencv::Value]| CalibrationFile {
                path: path.with_file_name(name),
                text: opencv::text(Syntax::Yaml, values),
            };
            vec![file(EASYMOCAP[0], &inner), file(EASYMOCAP[1], &outer)]
        }
        Format::OpenCvEach(syntax) => {
            let file = |camera: &Camera| {
                let values = opencv::alone(camera, in_metres, path)?;
                let name = path.to_string_lossy().replace(NAME, &camera.name);
                Ok(CalibrationFile { path: name.into(), text: opencv::text(syntax, &values) })
            };
            rig.cameras.iter().map(file).collect::<Result<_, _>>()?
        }
    })
}

fn format(path: &Path) -> Result<Format, CalibrationWriteError> {
    let name = path.file_name().unwrap_or_default().to_string_lossy().to_lowercase();
    let ends = |endings: &[&str]| endings.iter().any(|ending| name.ends_with(ending));
    let is_each = path.to_string_lossy().contains(NAME);
    let syntax = match ends(&[".xml"]) {
        true => Some(Syntax::Xml),
        false => ends(&[".yml", ".yaml"]).then_some(Syntax::Yaml),
    };
    match syntax {
        _ if EASYMOCAP.contains(&name.as_str()) => Ok(Format::EasyMocap),
        Some(syntax) if is_each => Ok(Format::OpenCvEach(syntax)),
        Some(syntax) => Ok(Format::OpenCv(syntax)),
        None if !is_each && ends(&[".toml"]) => Ok(Format::Toml),
        None if !is_each && ends(&[".qca.txt"]) => Ok(Format::Qualisys),
        None => Err(CalibrationWriteError::UnknownFormat { path: path.into() }),
    }
}

/// Whether a file's name says how a calibration is to be written.
///
/// # Errors
/// [`CalibrationWriteError::UnknownFormat`].
pub fn check_name(path: &Path) -> Result<(), CalibrationWriteError> {
    format(path).map(|_| ())
}
