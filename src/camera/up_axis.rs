//! Which way is up in a file.

use std::f64::consts::{FRAC_PI_2, PI};
use std::fmt;

use nalgebra::{Matrix3, Vector3};
use serde::{Deserialize, Serialize};

use crate::math::Rigid3;

/// The axis of a file's world that points up; in our world it is z.
///
/// An axis leaves open which way x goes, and there are two customs:
///
/// | files | (x, y, z) of our world stands in a file with Y up as | functions |
/// |---|---|---|
/// | a recording's: calibrations, points | (x, z, −y): x stays | [`file_from_world`](Self::file_from_world), [`world_from_file`](Self::world_from_file) |
/// | of results: TRC, C3D, BVH, glTF, meshes … | (y, z, x): who faces our x faces the file's Z | [`export_from_world`](Self::export_from_world), [`to_export`](Self::to_export), [`from_export`](Self::from_export) |
///
/// All are rotations: nothing is mirrored.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
pub enum UpAxis {
    /// Z, as here.
    #[default]
    #[serde(rename = "z")]
    Z,
    /// −Z: a recording's (x, y, z) is (x, −y, −z) here, half a turn about x.
    #[serde(rename = "-z")]
    MinusZ,
    /// Y: a recording's (x, y, z) is (x, −z, y) here, a quarter turn about x.
    #[serde(rename = "y")]
    Y,
    /// −Y, as in the frame of an upright camera: a recording's (x, y, z) is (x, z, −y) here, a quarter turn back about x.
    #[serde(rename = "-y")]
    MinusY,
}

impl UpAxis {
    /// The rotation about x that takes points of a recording's file to our world.
    pub fn world_from_file(self) -> Rigid3 {
        let angle = match self {
            Self::Z => 0.0,
            Self::MinusZ => PI,
            Self::Y => FRAC_PI_2,
            Self::MinusY => -FRAC_PI_2,
        };
        Rigid3::rotation(Vector3::x() * angle)
    }

    /// The inverse of [`world_from_file`](Self::world_from_file).
    pub fn file_from_world(self) -> Rigid3 {
        self.world_from_file().inverse()
    }

    /// A vector of our world as a file of results has it.
    pub fn to_export(self, v: &Vector3<f64>) -> Vector3<f64> {
        match self {
            Self::Z => *v,
            Self::MinusZ => Vector3::new(v.x, -v.y, -v.z),
            Self::Y => Vector3::new(v.y, v.z, v.x),
            Self::MinusY => Vector3::new(-v.y, -v.z, v.x),
        }
    }

    /// The inverse of [`to_export`](Self::to_export).
    pub fn from_export(self, v: &Vector3<f64>) -> Vector3<f64> {
        match self {
            Self::Z => *v,
            Self::MinusZ => Vector3::new(v.x, -v.y, -v.z),
            Self::Y => Vector3::new(v.z, v.x, v.y),
            Self::MinusY => Vector3::new(v.z, -v.x, -v.y),
        }
    }

    /// [`to_export`](Self::to_export) as a matrix.
    pub fn export_from_world(self) -> Matrix3<f64> {
        let column = |axis: Vector3<f64>| self.to_export(&axis);
        Matrix3::from_columns(&[column(Vector3::x()), column(Vector3::y()), column(Vector3::z())])
    }
}

impl fmt::Display for UpAxis {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Z => "Z",
            Self::MinusZ => "-Z",
            Self::Y => "Y",
            Self::MinusY => "-Y",
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use nalgebra::Point3;

    fn each() -> [(UpAxis, Vector3<f64>); 4] {
        [
            (UpAxis::Z, Vector3::z()),
            (UpAxis::MinusZ, -Vector3::z()),
            (UpAxis::Y, Vector3::y()),
            (UpAxis::MinusY, -Vector3::y()),
        ]
    }

    #[test]
    fn the_axis_of_a_recording_that_points_up_becomes_z_and_x_stays() {
        for (up, axis) in each() {
            let world_from_file = up.world_from_file();
            approx::assert_relative_eq!(world_from_file * axis, Vector3::z(), epsilon = 1e-15);
            approx::assert_relative_eq!(world_from_file * Vector3::x(), Vector3::x());
            let both = up.file_from_world() * world_from_file;
            approx::assert_relative_eq!(both, Rigid3::identity(), epsilon = 1e-15);
        }
        let y_up = UpAxis::Y.world_from_file() * Point3::new(1.0, 2.0, 3.0);
        approx::assert_relative_eq!(y_up, Point3::new(1.0, -3.0, 2.0), epsilon = 1e-15);
    }

    #[test]
    fn z_becomes_the_axis_of_an_export_that_points_up_and_nothing_is_mirrored() {
        let v = Vector3::new(1.0, 2.0, 3.0);
        for (up, axis) in each() {
            assert_eq!(up.to_export(&Vector3::z()), axis + Vector3::zeros());
            assert_eq!(up.from_export(&up.to_export(&v)), v);
            assert_eq!(up.export_from_world() * v, up.to_export(&v));
            approx::assert_relative_eq!(up.export_from_world().determinant(), 1.0);
        }
        assert_eq!(UpAxis::Y.to_export(&v), Vector3::new(2.0, 3.0, 1.0));
    }
}
