//! OpenCV's fisheye lens: a polynomial in the angle from the optical axis.

use super::{
    monotone::{increases_up_to, solve_increasing},
    polynomial,
};
use nalgebra::Vector2;
use std::f64::consts::FRAC_PI_2;

/// Coefficients k₁..k₄.
pub(super) struct Fisheye(pub(super) [f64; 4]);

impl Fisheye {
    /// The distorted point.
    pub(super) fn distort(&self, point: &Vector2<f64>) -> Vector2<f64> {
        let r = point.norm();
        if r <= f64::MIN_POSITIVE {
            return *point;
        }
        let (theta_d, _) = self.angle(r.atan());
        point * (theta_d / r)
    }

    /// Whether the distorted angle still increases from the axis out to `point`.
    pub(super) fn in_view(&self, point: &Vector2<f64>) -> bool {
        let theta = point.norm().atan();
        increases_up_to(theta, |theta| self.angle(theta).1)
    }

    /// Newton's iteration on the angle; `None` at 90° and beyond, where no undistorted pixel exists.
    pub(super) fn undistort(&self, distorted: &Vector2<f64>) -> Option<Vector2<f64>> {
        let theta_d = distorted.norm();
        if theta_d <= f64::MIN_POSITIVE {
            return Some(*distorted);
        }
        let theta = solve_increasing(|theta| self.angle(theta), theta_d, FRAC_PI_2)?;
        (theta < FRAC_PI_2).then(|| distorted * (theta.tan() / theta_d))
    }

    /// θ_d = θ(1+k₁θ²+k₂θ⁴+k₃θ⁶+k₄θ⁸) and its slope.
    fn angle(&self, theta: f64) -> (f64, f64) {
        let s = theta * theta;
        let (value, slope) = polynomial(&self.0, s);
        (theta * value, value + 2.0 * s * slope)
    }
}
