//! The exponential coordinates of SO(3).

use nalgebra::{Matrix3, Vector3};

/// J_r⁻¹(φ): log(exp(φ)·exp(δ)) = φ + J_r⁻¹(φ)·δ + O(δ²).
///
/// J_r⁻¹ = I + ½\[φ\] + c·\[φ\]², c = 1/θ² − (1 + cos θ)/(2θ sin θ) → 1/12 at θ = ‖φ‖ → 0; |φ| < π.
///
/// # Source
/// Solà, Deray, Atchuthan 2018, *A micro Lie theory*, eq. 144.
pub fn right_jacobian_inverse(phi: &Vector3<f64>) -> Matrix3<f64> {
    let theta = phi.norm();
    let c = if theta < 1e-3 {
        1.0 / 12.0 + theta * theta / 720.0
    } else {
        (1.0 - 0.5 * theta * (0.5 * theta).cos() / (0.5 * theta).sin()) / (theta * theta)
    };
    let cross = phi.cross_matrix();
    Matrix3::identity() + cross * 0.5 + cross * cross * c
}

#[cfg(test)]
mod tests {
    use nalgebra::{DVector, Rotation3};

    use super::*;
    use crate::math::central_differences;

    #[test]
    fn it_is_the_derivative_of_the_logarithm() {
        for phi in [
            Vector3::new(0.3, -1.2, 0.7),
            Vector3::new(1e-8, 0.0, 2e-8),
            Vector3::new(0.0, 2.9, 0.3),
        ] {
            let numeric = central_differences(3, 1e-3, |d| {
                let delta = Vector3::new(d[0], d[1], d[2]);
                let moved = Rotation3::from_scaled_axis(phi) * Rotation3::from_scaled_axis(delta);
                DVector::from_column_slice(moved.scaled_axis().as_slice())
            });
            for (a, n) in right_jacobian_inverse(&phi).iter().zip(numeric.iter()) {
                approx::assert_abs_diff_eq!(a, n, epsilon = 1e-6);
            }
        }
    }
}
