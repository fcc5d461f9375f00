//! Left and right: a model file describes one side, the other is its mirror image.

use nalgebra::{Rotation3, Vector3};
use serde::Deserialize;

/// Whether a part or coefficient in the file means one thing, or a right and a left one.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Deserialize)]
#[serde(from = "bool")]
pub(super) enum Sides {
    #[default]
    One,
    Both,
}

impl From<bool> for Sides {
    fn from(both: bool) -> Self {
        if both { Self::Both } else { Self::One }
    }
}

impl Sides {
    pub(super) fn each(self) -> &'static [Side] {
        match self {
            Self::One => &[Side::Middle],
            Self::Both => &[Side::Right, Side::Left],
        }
    }
}

/// The plane of symmetry is y = 0: the file describes the right side, the left is its mirror image.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum Side {
    Middle,
    Right,
    Left,
}

impl Side {
    pub(super) fn suffix(self, name: &str) -> String {
        match self {
            Self::Middle => name.to_owned(),
            Self::Right => format!("{name}_r"),
            Self::Left => format!("{name}_l"),
        }
    }

    pub(super) fn place(self, v: [f64; 3]) -> Vector3<f64> {
        Vector3::new(v[0], if self == Self::Left { -v[1] } else { v[1] }, v[2])
    }

    /// Axes of rotation mirror the other way round.
    pub(super) fn axis(self, v: Vector3<f64>) -> Vector3<f64> {
        if self == Self::Left { Vector3::new(-v[0], v[1], -v[2]) } else { v }
    }

    pub(super) fn turn(self, degrees: [f64; 3]) -> Rotation3<f64> {
        Rotation3::from_scaled_axis(self.axis(Vector3::from(degrees).map(f64::to_radians)))
    }
}
