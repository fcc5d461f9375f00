//! What the reader of a calibration must be told.

use crate::camera::{PoseForm, UpAxis};
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;

/// What a calibration file does not say about itself.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct CalibrationOptions {
    /// Unit of the file's translations; `None` (the default) for the format's own.
    pub unit: Option<Unit>,
    /// The axis of the file's world that points up; Z by default.
    pub up: UpAxis,
    /// What the file's rotations and translations mean; from the world to the camera by default.
    pub pose_form: PoseForm,
    /// Width and height in pixels by camera name, from masks, images or video.
    ///
    /// Used where the file states none; empty by default. For a Vicon file it is the part of the sensor that was
    /// recorded, in its middle; without it the whole sensor is taken.
    pub image_sizes_px: BTreeMap<String, [u32; 2]>,
    /// Whether the poses of the cameras are read; they are by default.
    #[serde(skip)]
    pub poses: Poses,
}

/// Whether the poses in a calibration are read.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Poses {
    /// They are, and must be there.
    #[default]
    Read,
    /// They are not, and need not be there: every camera stands in the origin. Lenses alone are wanted.
    Ignored,
}

/// Unit of length.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub enum Unit {
    /// Metre.
    #[serde(rename = "m")]
    Metre,
    /// Millimetre.
    #[serde(rename = "mm")]
    Millimetre,
}

impl Unit {
    /// Length of the unit in metres.
    pub fn in_metres(self) -> f64 {
        match self {
            Self::Metre => 1.0,
            Self::Millimetre => 1e-3,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn options_are_written_as_in_a_manifest() {
        let read: CalibrationOptions = toml::from_str("unit = \"mm\"\nup = \"-z\"").unwrap();
        assert_eq!(read.unit, Some(Unit::Millimetre));
        assert_eq!(read.up, UpAxis::MinusZ);
        assert!(toml::from_str::<CalibrationOptions>("up = \"x\"").is_err());
    }
}
