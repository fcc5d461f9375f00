//! Which numbers of a point a file has.

use nalgebra::{Matrix3, Point3};

use crate::stereo::{CloudPoint, Spread};

/// The columns that a file of points can have.
const NAMES: [&str; 10] =
    ["x", "y", "z", "sigma", "cov_xx", "cov_xy", "cov_xz", "cov_yy", "cov_yz", "cov_zz"];

/// What a file must have, for messages.
pub(super) const EXPECTED: &str = "x, y and z, and for the spread nothing, or sigma, or all of cov_xx cov_xy cov_xz cov_yy cov_yz cov_zz";

/// The place of a column in [`Numbers`]; `None` if it is not used.
pub(super) fn slot(name: &str) -> Option<usize> {
    NAMES.iter().position(|known| known.eq_ignore_ascii_case(name))
}

/// The numbers of one point, in the order of [`NAMES`].
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub(super) struct Numbers(pub(super) [f64; 10]);

/// How a file states the spread.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Stated {
    Nothing,
    Sigma,
    Covariance,
}

impl Stated {
    /// Which of these a file with such columns states; `None` if a coordinate or a part of the covariance is missing.
    pub(super) fn by<'a>(names: impl IntoIterator<Item = &'a str>) -> Option<Self> {
        let mut has = [false; 10];
        for slot in names.into_iter().filter_map(slot) {
            has[slot] = true;
        }
        let covariances = has[4..].iter().filter(|has| **has).count();
        match (has[..3] == [true; 3], covariances, has[3]) {
            (true, 6, _) => Some(Self::Covariance),
            (true, 0, true) => Some(Self::Sigma),
            (true, 0, false) => Some(Self::Nothing),
            _ => None,
        }
    }

    /// The point that the numbers make.
    pub(super) fn point(self, numbers: &Numbers) -> CloudPoint {
        let [x, y, z, sigma, xx, xy, xz, yy, yz, zz] = numbers.0;
        CloudPoint {
            position_world: Point3::new(x, y, z),
            spread: match self {
                Self::Nothing => Spread::Unknown,
                Self::Sigma => Spread::Isotropic(sigma),
                Self::Covariance => Spread::Full(Matrix3::new(xx, xy, xz, xy, yy, yz, xz, yz, zz)),
            },
        }
    }
}
