//! What the reader of a calibration must be told.

use crate::math::Rigid3;
use nalgebra::Vector3;
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;
use std::f64::consts::{FRAC_PI_2, PI};

/// What a calibration file does not say about itself.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct CalibrationOptions {
    /// Unit of the file's translations; `None` (the default) for the format's own.
    pub unit: Option<Unit>,
    /// The axis of the file's world that points up; Z by default.
    pub up: Up,
    /// Width and height in pixels by camera name, from masks, images or video.
    ///
    /// Used where the file states none; empty by default. For a Vicon file it is the part of the sensor that was
    /// recorded, in its middle; without it the whole sensor is taken.
    pub image_sizes_px: BTreeMap<String, [u32; 2]>,
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

/// Which axis of the file's world points up.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
pub enum Up {
    /// Z, as here: nothing to convert.
    #[default]
    #[serde(rename = "z")]
    Z,
    /// −Z: the file's (x, y, z) is (x, −y, −z) here, half a turn about x.
    #[serde(rename = "-z")]
    MinusZ,
    /// Y: the file's (x, y, z) is (x, −z, y) here, a quarter turn about x.
    #[serde(rename = "y")]
    Y,
    /// −Y, as in the frame of an upright camera: the file's (x, y, z) is (x, z, −y) here, a quarter turn back about x.
    #[serde(rename = "-y")]
    MinusY,
}

impl Up {
    /// The rotation that takes points of the file's world to the world with Z up.
    ///
    /// All four turn about x only, so they are proper (nothing is mirrored) and x stays x.
    pub fn world_from_file(self) -> Rigid3 {
        let angle = match self {
            Self::Z => 0.0,
            Self::MinusZ => PI,
            Self::Y => FRAC_PI_2,
            Self::MinusY => -FRAC_PI_2,
        };
        Rigid3::rotation(Vector3::x() * angle)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use nalgebra::Point3;

    #[test]
    fn the_axis_that_points_up_becomes_z_and_x_stays() {
        let ups = [
            (Up::Z, Vector3::z()),
            (Up::MinusZ, -Vector3::z()),
            (Up::Y, Vector3::y()),
            (Up::MinusY, -Vector3::y()),
        ];
        for (up, axis) in ups {
            let world_from_file = up.world_from_file();
            approx::assert_relative_eq!(world_from_file * axis, Vector3::z(), epsilon = 1e-15);
            approx::assert_relative_eq!(world_from_file * Vector3::x(), Vector3::x());
        }
        let y_up = Up::Y.world_from_file() * Point3::new(1.0, 2.0, 3.0);
        approx::assert_relative_eq!(y_up, Point3::new(1.0, -3.0, 2.0), epsilon = 1e-15);
    }

    #[test]
    fn options_are_written_as_in_a_manifest() {
        let read: CalibrationOptions = toml::from_str("unit = \"mm\"\nup = \"-z\"").unwrap();
        assert_eq!(read.unit, Some(Unit::Millimetre));
        assert_eq!(read.up, Up::MinusZ);
        assert!(toml::from_str::<CalibrationOptions>("up = \"x\"").is_err());
    }
}
