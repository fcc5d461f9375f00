//! Why a calibration could not be used.

use std::fmt;
use std::io;
use std::path::{Path, PathBuf};

/// Where in a calibration file something is: `file:line: camera name`, as far as known.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Place {
    /// The file, as it was given.
    pub path: PathBuf,
    /// Its line, from 1.
    pub line: Option<usize>,
    /// The camera it concerns.
    pub camera: Option<String>,
}

impl Place {
    pub(super) fn new(path: &Path, line: Option<usize>, camera: Option<&str>) -> Self {
        Self { path: path.to_owned(), line, camera: camera.map(one_line) }
    }
}

impl fmt::Display for Place {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}", self.path.display())?;
        if let Some(line) = self.line {
            write!(f, ":{line}")?;
        }
        if let Some(camera) = &self.camera {
            write!(f, ": camera {camera}")?;
        }
        Ok(())
    }
}

/// A text from a file, in one line.
pub(super) fn one_line(text: &str) -> String {
    let printable = |c: char| if c.is_control() { ' ' } else { c };
    text.chars().map(printable).collect()
}

/// Why a calibration could not be used, in one line for a person.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
#[allow(missing_docs, reason = "the messages name the fields")]
pub enum CalibrationError {
    /// The file cannot be opened or is not text.
    #[error("cannot read {}: {reason}", path.display())]
    Read { path: PathBuf, reason: io::Error },
    /// A folder that holds no calibration.
    #[error("{}: no calibration in this folder: expected {EXPECTED_FILES}", path.display())]
    EmptyFolder { path: PathBuf },
    /// Neither name nor content tell the format.
    #[error("{}: unknown calibration format: expected {EXPECTED_FILES}", path.display())]
    UnknownFormat { path: PathBuf },
    /// A format that cannot be read safely.
    #[error("{}: a Python pickle can run any program and is not read: convert it to TOML with Pose2Sim", path.display())]
    Pickle { path: PathBuf },
    /// `intri.yml` without `extri.yml`, or the other way round.
    #[error("{}: expected {expected} beside it", path.display())]
    MissingHalf { path: PathBuf, expected: &'static str },
    /// The file does not follow its format.
    #[error("{place}: expected {expected}, found {found}")]
    Syntax { place: Place, expected: &'static str, found: String },
    /// A value that must be there is not.
    #[error("{place}: {key} is missing")]
    MissingKey { place: Place, key: String },
    /// A camera whose lens alone is known.
    #[error(
        "{place}: rotation and translation are missing: `maquette calibrate --from lenses` finds them by a person who moves"
    )]
    NoPose { place: Place },
    /// Text where a number must be.
    #[error("{place}: {key}: expected a number, found {found:?}")]
    NotANumber { place: Place, key: String, found: String },
    /// NaN or infinity.
    #[error("{place}: {key}: expected a finite number, found {found}")]
    NotFinite { place: Place, key: String, found: f64 },
    /// Too many or too few numbers.
    #[error("{place}: {key}: expected {expected} numbers, found {found}")]
    Count { place: Place, key: String, expected: &'static str, found: usize },
    /// A focal length that is zero or negative.
    #[error("{place}: focal length {focal_px} px is not positive")]
    Focal { place: Place, focal_px: f64 },
    /// A camera matrix that is not upper triangular with 1 in its corner.
    #[error("{place}: {key}: expected 0 below the diagonal and 1 in the corner, found {found}")]
    Intrinsics { place: Place, key: String, found: f64 },
    /// A rotation that is none.
    #[error("{place}: {key} is not a rotation: |RᵀR − I| = {defect:.1e}")]
    Rotation { place: Place, key: String, defect: f64 },
    /// A rotation matrix with determinant −1.
    #[error("{place}: {key} is a reflection, not a rotation: its determinant is −1")]
    Reflection { place: Place, key: String },
    /// A projection matrix without a camera.
    #[error("{place}: the projection matrix is singular: its left 3 × 3 block has no inverse")]
    Projection { place: Place },
    /// An image size that no image has.
    #[error("{place}: image size {width} × {height} is not between 1 × 1 and 65535 × 65535")]
    Size { place: Place, width: f64, height: f64 },
    /// A recorded image that does not fit on its sensor.
    #[error("{place}: the image, {} × {}, is larger than the sensor, {} × {}", image[0], image[1], sensor[0], sensor[1])]
    LargerThanSensor { place: Place, image: [u32; 2], sensor: [u32; 2] },
    /// A format without image size, and none given.
    #[error(
        "{place}: the file does not state the image size, and this camera has no masks, images or video to take it from"
    )]
    MissingSize { place: Place },
    /// Two cameras of one name.
    #[error("{place}: another camera has the same name")]
    Duplicate { place: Place },
    /// A file without a usable camera.
    #[error("{}: no calibrated camera in this file", path.display())]
    NoCameras { path: PathBuf },
    /// A camera was asked for that is not there.
    #[error("{}: no camera {camera:?}: it has {known}{hint}", path.display())]
    UnknownCamera {
        path: PathBuf,
        camera: String,
        /// The names that are there, for reading.
        known: String,
        /// `; did you mean …?`, or nothing.
        hint: String,
    },
    /// A file for one camera that holds several, none of the name asked for.
    #[error("{}: expected one camera, for {camera:?}, found {found}", path.display())]
    SeveralCameras { path: PathBuf, camera: String, found: usize },
    /// A camera that moves during the recording.
    #[error("{place}: expected a fixed camera, found {key_frames} key frames")]
    MovingCamera { place: Place, key_frames: usize },
}

const EXPECTED_FILES: &str = "*.toml, intri.yml with extri.yml, OpenCV *.yml or *.xml, *.qca.txt, *.xcp, or a text file of projection matrices";
