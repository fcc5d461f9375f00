//! Calibration files of the field, read into a [`Rig`] in metres with Z up.
//!
//! | format | files | own unit |
//! |---|---|---|
//! | Pose2Sim, aniposelib, caliscope | `*.toml` | m |
//! | FreeMoCap | `*.toml` whose metadata name its charuco board | mm |
//! | EasyMocap, OpenCV YAML | `intri.yml` with `extri.yml`, or one `*.yml` | m |
//! | OpenCV XML | `*.xml`, all cameras or one per file | m |
//! | Qualisys | `*.qca.txt` | mm |
//! | Vicon | `*.xcp` | mm |
//! | 3 × 4 projection matrices | `*.txt`, all cameras or one per file | m |
//!
//! [`read`] takes a file or a folder, [`read_per_camera`] one file for each camera, and [`select`] puts the cameras in
//! the order in which a manifest names them. [`write()`] writes the formats that hold all of a camera.
//!
//! Every reader only finds the numbers in its file; the module `unchecked` checks them all alike and converts unit and
//! world. A wrong number is a [`CalibrationError`] that names file, line and camera.

mod dispatch;
mod error;
mod found;
pub(super) mod natural_order;
mod opencv;
mod opencv_storage;
mod options;
mod pose2sim;
mod projection_matrix;
mod qualisys;
mod unchecked;
mod vicon;
mod write;
mod xml;

pub(in crate::io) use dispatch::unpaired;
pub use dispatch::{read, read_per_camera, select};
pub use error::{CalibrationError, Place};
pub(in crate::io) use found::{files, find};
pub use options::{CalibrationOptions, Poses, Unit};
pub use write::{
    CalibrationFile, CalibrationWriteError, CameraEstimate, Refined, check_name, write, write_toml,
};

#[cfg(doc)]
use crate::camera::Rig;
