//! Points as PLY.

use crate::stereo::{CloudPoint, Spread};

/// A binary PLY, little endian, of doubles: x y z, and `sigma` or the covariance where every point states it.
pub fn ply(points: &[CloudPoint]) -> Vec<u8> {
    let all = |states: fn(&Spread) -> bool| points.iter().all(|point| states(&point.spread));
    let spread: &[&str] = if all(|spread| matches!(spread, Spread::Full(_))) {
        &["cov_xx", "cov_xy", "cov_xz", "cov_yy", "cov_yz", "cov_zz"]
    } else if all(|spread| matches!(spread, Spread::Isotropic(_))) {
        &["sigma"]
    } else {
        &[]
    };

    let mut header = format!(
        "ply\nformat binary_little_endian 1.0\ncomment metres, world\nelement vertex {}\n",
        points.len()
    );
    for name in ["x", "y", "z"].iter().chain(spread) {
        header.push_str(&format!("property double {name}\n"));
    }

    let mut bytes = (header + "end_header\n").into_bytes();
    for point in points {
        let p = point.position_world;
        let numbers = match (point.spread, spread.len()) {
            (Spread::Full(c), 6) => [c.m11, c.m12, c.m13, c.m22, c.m23, c.m33],
            (Spread::Isotropic(sigma), 1) => [sigma, 0.0, 0.0, 0.0, 0.0, 0.0],
            _ => [0.0; 6],
        };
        let written = p.iter().chain(&numbers[..spread.len()]);
        bytes.extend(written.flat_map(|v| v.to_le_bytes()));
    }
    bytes
}
