//! Vicon's lens: a polynomial that corrects the distorted image.

use super::{
    monotone::{increases_up_to, solve_increasing},
    polynomial,
};
use nalgebra::Vector2;

/// No lens moves a point farther from the centre than by this factor.
const LARGEST_MAGNIFICATION: f64 = 4.0;

/// Centre of distortion and coefficients k₁..k₃.
pub(super) struct RadialCorrection {
    pub(super) centre: Vector2<f64>,
    pub(super) k: [f64; 3],
}

impl RadialCorrection {
    /// The corrected point; `None` beyond the fold.
    pub(super) fn undistort(&self, distorted: &Vector2<f64>) -> Option<Vector2<f64>> {
        let w = distorted - self.centre;
        let s = w.norm_squared();
        if !s.is_finite() || !increases_up_to(w.norm(), |radius| self.radius(radius).1) {
            return None;
        }
        let (factor, _) = polynomial(&self.k, s);
        Some(self.centre + w * factor)
    }

    /// The point whose correction is `undistorted`, by Newton's iteration on the radius.
    pub(super) fn distort(&self, undistorted: &Vector2<f64>) -> Option<Vector2<f64>> {
        let w = undistorted - self.centre;
        let corrected = w.norm();
        if corrected <= f64::MIN_POSITIVE {
            return Some(*undistorted);
        }
        let limit = LARGEST_MAGNIFICATION * corrected;
        let radius = solve_increasing(|radius| self.radius(radius), corrected, limit)?;
        Some(self.centre + w * (radius / corrected))
    }

    /// ρ(1+k₁ρ²+k₂ρ⁴+k₃ρ⁶) and its slope.
    fn radius(&self, radius: f64) -> (f64, f64) {
        let s = radius * radius;
        let (value, slope) = polynomial(&self.k, s);
        (radius * value, value + 2.0 * s * slope)
    }
}
