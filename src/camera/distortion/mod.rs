//! Lens distortion in normalised coordinates (x, y) = (X/Z, Y/Z): OpenCV's models and Vicon's.

mod brown_conrady;
mod fisheye;
mod monotone;
mod radial_correction;

use brown_conrady::BrownConrady;
use fisheye::Fisheye;
use nalgebra::Vector2;
use radial_correction::RadialCorrection;
use serde::{Deserialize, Serialize};

/// How a lens moves the image of a point, on normalised coordinates.
///
/// The three lens models are invertible only within a radius around their centre. Beyond it the polynomial folds back
/// and would show a point far outside the view inside the image. [`Distortion::undistort`] gives `None` there, as does
/// [`Camera::project`](crate::camera::Camera::project).
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Distortion {
    /// An ideal lens.
    None,
    /// OpenCV's standard model: with r² = x² + y²,
    /// x_d = x·(1+k₁r²+k₂r⁴+k₃r⁶)/(1+k₄r²+k₅r⁴+k₆r⁶) + 2p₁xy + p₂(r²+2x²), and
    /// y_d = y·(1+k₁r²+k₂r⁴+k₃r⁶)/(1+k₄r²+k₅r⁴+k₆r⁶) + p₁(r²+2y²) + 2p₂xy.
    #[allow(missing_docs, reason = "the symbols of the formula above")]
    BrownConrady { k1: f64, k2: f64, p1: f64, p2: f64, k3: f64, k4: f64, k5: f64, k6: f64 },
    /// OpenCV's fisheye (Kannala–Brandt): with r = √(x²+y²), θ = atan r,
    /// (x_d, y_d) = (x, y)·θ(1+k₁θ²+k₂θ⁴+k₃θ⁶+k₄θ⁸)/r.
    #[allow(missing_docs, reason = "the symbols of the formula above")]
    Fisheye { k1: f64, k2: f64, k3: f64, k4: f64 },
    /// Vicon's radial model, which corrects instead of distorting: with w = (x_d, y_d) − c and ρ = |w|,
    /// (x, y) = c + w·(1+k₁ρ²+k₂ρ⁴+k₃ρ⁶); c = (`centre_x`, `centre_y`).
    #[allow(missing_docs, reason = "the symbols of the formula above")]
    RadialCorrection { centre_x: f64, centre_y: f64, k1: f64, k2: f64, k3: f64 },
}

impl Distortion {
    /// OpenCV's coefficients in OpenCV's order, k₁ k₂ p₁ p₂ \[k₃ \[k₄ k₅ k₆\]\].
    ///
    /// `None` unless there are 0, 4, 5 or 8 of them, or 12 or 14 of which those after the eighth are zero (OpenCV
    /// writes that many although the thin-prism and tilt terms were not calibrated). All zero is [`Distortion::None`].
    pub fn brown_conrady(coefficients: &[f64]) -> Option<Self> {
        let (used, unused) = coefficients.split_at(coefficients.len().min(8));
        let known_length = matches!(coefficients.len(), 0 | 4 | 5 | 8 | 12 | 14);
        if !known_length || unused.iter().any(|c| c.abs() > 0.0 || c.is_nan()) {
            return None;
        }

        if used.iter().all(|&c| c.abs() <= 0.0) {
            return Some(Self::None);
        }

        // coefficients that are not given are zero
        let at = |i: usize| used.get(i).copied().unwrap_or(0.0);
        Some(Self::BrownConrady {
            k1: at(0),
            k2: at(1),
            p1: at(2),
            p2: at(3),
            k3: at(4),
            k4: at(5),
            k5: at(6),
            k6: at(7),
        })
    }

    /// OpenCV's fisheye coefficients k₁ k₂ k₃ k₄; none at all mean four zeros, which is *not* an ideal lens.
    ///
    /// `None` of any other number of coefficients.
    pub fn fisheye(coefficients: &[f64]) -> Option<Self> {
        match *coefficients {
            [] => Self::fisheye(&[0.0; 4]),
            [k1, k2, k3, k4] => Some(Self::Fisheye { k1, k2, k3, k4 }),
            _ => None,
        }
    }

    /// Of a lens with so many times the focal length that puts the same undistorted pixels where this one does: D′(x) = D(λx)/λ. A
    /// fisheye's polynomial has no such counterpart, and stays.
    #[must_use]
    pub fn zoomed(&self, factor: f64) -> Self {
        let square = factor * factor;
        let (fourth, sixth) = (square.powi(2), square.powi(3));
        match *self {
            Self::BrownConrady { k1, k2, p1, p2, k3, k4, k5, k6 } => Self::BrownConrady {
                k1: k1 * square,
                k2: k2 * fourth,
                p1: p1 * factor,
                p2: p2 * factor,
                k3: k3 * sixth,
                k4: k4 * square,
                k5: k5 * fourth,
                k6: k6 * sixth,
            },
            Self::RadialCorrection { centre_x, centre_y, k1, k2, k3 } => Self::RadialCorrection {
                centre_x: centre_x / factor,
                centre_y: centre_y / factor,
                k1: k1 * square,
                k2: k2 * fourth,
                k3: k3 * sixth,
            },
            Self::None | Self::Fisheye { .. } => *self,
        }
    }

    /// Distorted coordinates of an undistorted point, by the formula alone, whether the lens can see it or not.
    ///
    /// NaN where [`Distortion::RadialCorrection`] has no solution.
    pub fn distort(&self, undistorted: &Vector2<f64>) -> Vector2<f64> {
        match self.lens() {
            Lens::Ideal => *undistorted,
            Lens::BrownConrady(lens) => lens.distort(undistorted).0,
            Lens::Fisheye(lens) => lens.distort(undistorted),
            Lens::RadialCorrection(lens) => {
                lens.distort(undistorted).unwrap_or(Vector2::repeat(f64::NAN))
            }
        }
    }

    /// Distorted coordinates of an undistorted point; `None` beyond the radius at which the lens model folds.
    pub(crate) fn distort_in_view(&self, undistorted: &Vector2<f64>) -> Option<Vector2<f64>> {
        match self.lens() {
            Lens::Ideal => Some(*undistorted),
            Lens::BrownConrady(lens) => {
                lens.in_view(undistorted).then(|| lens.distort(undistorted).0)
            }
            Lens::Fisheye(lens) => lens.in_view(undistorted).then(|| lens.distort(undistorted)),
            Lens::RadialCorrection(lens) => lens.distort(undistorted),
        }
    }

    /// The undistorted point whose image is `distorted`.
    ///
    /// By Newton's iteration with the analytic Jacobian (closed form for [`Distortion::RadialCorrection`]), to
    /// rounding. `None` if no point within the lens model's view has this image.
    pub fn undistort(&self, distorted: &Vector2<f64>) -> Option<Vector2<f64>> {
        match self.lens() {
            Lens::Ideal => Some(*distorted),
            Lens::BrownConrady(lens) => lens.undistort(distorted),
            Lens::Fisheye(lens) => lens.undistort(distorted),
            Lens::RadialCorrection(lens) => lens.undistort(distorted),
        }
    }

    fn lens(&self) -> Lens {
        match *self {
            Self::None => Lens::Ideal,

            Self::BrownConrady { k1, k2, p1, p2, k3, k4, k5, k6 } => {
                Lens::BrownConrady(BrownConrady {
                    numerator: [k1, k2, k3],
                    denominator: [k4, k5, k6],
                    tangential: [p1, p2],
                })
            }

            Self::Fisheye { k1, k2, k3, k4 } => Lens::Fisheye(Fisheye([k1, k2, k3, k4])),

            Self::RadialCorrection { centre_x, centre_y, k1, k2, k3 } => {
                Lens::RadialCorrection(RadialCorrection {
                    centre: Vector2::new(centre_x, centre_y),
                    k: [k1, k2, k3],
                })
            }
        }
    }
}

/// The models with their coefficients grouped as their formulas need them.
enum Lens {
    Ideal,
    BrownConrady(BrownConrady),
    Fisheye(Fisheye),
    RadialCorrection(RadialCorrection),
}

/// Value and slope of 1 + k₁s + k₂s² + … at s.
fn polynomial(k: &[f64], s: f64) -> (f64, f64) {
    let (value, slope) =
        k.iter().rev().fold((0.0, 0.0), |(value, slope), &k| (k + s * value, value + s * slope));
    (1.0 + s * value, value + s * slope)
}

#[cfg(test)]
mod tests;
