//! The world of files that are Y up: (X, Y, Z) of our Z-up world stands there as (Y, Z, X).
//!
//! A rotation: nothing is mirrored, and who faces our X faces the file's Z.

use nalgebra::{Matrix3, Vector3};

/// A vector of our world in the file's.
pub(super) fn in_file(v: &Vector3<f64>) -> Vector3<f64> {
    Vector3::new(v.y, v.z, v.x)
}

/// A vector of the file's world in ours.
pub(super) fn in_world(v: &Vector3<f64>) -> Vector3<f64> {
    Vector3::new(v.z, v.x, v.y)
}

/// [`in_file`] as a matrix.
pub(super) fn file_from_world() -> Matrix3<f64> {
    Matrix3::new(0.0, 1.0, 0.0, 0.0, 0.0, 1.0, 1.0, 0.0, 0.0)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn all_three_are_one_rotation() {
        let v = Vector3::new(1.0, 2.0, 3.0);
        assert_eq!(in_file(&v), Vector3::new(2.0, 3.0, 1.0));
        assert_eq!(file_from_world() * v, in_file(&v));
        assert_eq!(in_world(&in_file(&v)), v);
        approx::assert_relative_eq!(file_from_world().determinant(), 1.0);
    }
}
