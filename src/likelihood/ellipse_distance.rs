//! From a point to the outline of an ellipse, negative inside.
//!
//! With y = x − c, W = Σ⁻¹, u = W y, q = yᵀu, ρ = √q and g = ‖u‖ (so that ∇ρ = u/ρ):
//!
//! | variant    | d(x)                                       | exact for            |
//! |------------|--------------------------------------------|----------------------|
//! | published  | ‖y‖ (1 − 1/ρ)                              | circles              |
//! | gradient   | (ρ − 1)/‖∇ρ‖ = (q − ρ)/g                   | circles, the outline |
//! | orthogonal | ±‖x − f‖, f the nearest point of the outline | every ellipse      |
//!
//! The published one is radial, to c + y/ρ: never less than the true distance, and beside the outline too large
//! by ‖y‖‖u‖ ≤ (a² + b²)/(2ab). `docs/ellipse-distance.md` derives it, with a figure. The orthogonal one iterates on the foot point f. Its derivative needs no differentiated iteration:
//! at f the outline moves by −∂q(f)/‖∇q(f)‖ along its normal, so ∂d = ∂q(f)/‖∇q(f)‖ with f held fixed.

use nalgebra::{Matrix2, SVector, Vector2};

use crate::math::quadric::Ellipse;

/// Which distance.
#[derive(Debug, Clone, Copy, PartialEq, Eq, serde::Serialize, serde::Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum EllipseDistance {
    /// Radial, after ZS06 App. C, whose own reference is the report CTU–CMP–2005–23.
    ///
    /// **Differs**: the report was not at hand; this is the one formula that does what its abstract says in words
    /// (`docs/ellipse-distance.md`). It is signed, because |d| has no slope on the ellipse.
    Published,
    /// First order.
    Gradient,
    /// True distance, by Newton steps on the foot point.
    Orthogonal,
}

/// An ellipse prepared for many distances.
#[derive(Debug, Clone, Copy)]
pub(super) struct OutlineEllipse {
    /// c.
    pub(super) centre: Vector2<f64>,
    /// W = Σ⁻¹.
    inverse: Matrix2<f64>,
    /// Largest semi-axis, px.
    reach: f64,
    /// Lower Cholesky factor L of Σ.
    pub(super) root: Matrix2<f64>,
}

impl OutlineEllipse {
    /// Prepares an ellipse.
    pub(super) fn new(ellipse: &Ellipse) -> Self {
        let s = &ellipse.shape;
        let determinant = s[(0, 0)] * s[(1, 1)] - s[(0, 1)] * s[(0, 1)];
        let inverse = Matrix2::new(s[(1, 1)], -s[(0, 1)], -s[(0, 1)], s[(0, 0)]) / determinant;
        let half = 0.5 * (s[(0, 0)] + s[(1, 1)]);
        let spread = (half * half - determinant).max(0.0).sqrt();

        let l00 = s[(0, 0)].sqrt();
        let l10 = s[(0, 1)] / l00;
        let l11 = (s[(1, 1)] - l10 * l10).max(0.0).sqrt();
        let root = Matrix2::new(l00, 0.0, l10, l11);

        Self { centre: ellipse.centre, inverse, reach: (half + spread).sqrt(), root }
    }

    /// Whether every point of the ellipse is farther from x than `distance` (true at once for most).
    #[inline]
    pub(super) fn is_farther_than(&self, distance: f64, x: &Vector2<f64>) -> bool {
        let limit = distance + self.reach;
        limit < 0.0 || (x - self.centre).norm_squared() > limit * limit
    }

    /// d and ∂d/∂(cx, cy, Σxx, Σxy, Σyy).
    #[inline]
    pub(super) fn distance(
        &self,
        x: &Vector2<f64>,
        kind: EllipseDistance,
    ) -> (f64, SVector<f64, 5>) {
        match kind {
            EllipseDistance::Published => self.published(x),
            EllipseDistance::Gradient => self.gradient(x),
            EllipseDistance::Orthogonal => self.orthogonal(x),
        }
    }

    fn published(&self, x: &Vector2<f64>) -> (f64, SVector<f64, 5>) {
        let y = x - self.centre;
        let u = self.inverse * y;
        let rho = y.dot(&u).max(TINY).sqrt();
        let norm = y.norm().max(TINY);
        // ∂d = (1 − 1/ρ) ∂‖y‖ + ‖y‖/ρ² ∂ρ, ∂ρ = (−2uᵀ∂c − uᵀ∂Σu)/(2ρ)
        let d_centre = -y / norm * (1.0 - 1.0 / rho) - u * (norm / rho.powi(3));
        let slope = -0.5 * norm / rho.powi(3);
        (norm * (1.0 - 1.0 / rho), with_outer(&d_centre, &u, &u, slope))
    }

    #[inline]
    fn gradient(&self, x: &Vector2<f64>) -> (f64, SVector<f64, 5>) {
        let y = x - self.centre;
        let u = self.inverse * y;
        let v = self.inverse * u;
        let q = y.dot(&u).max(TINY);
        let (rho, g) = (q.sqrt(), u.norm().max(TINY));
        let d = (q - rho) / g;
        // ∂d = (1 − 1/(2ρ)) ∂q/g − d ∂g/g;  ∂q = −2uᵀ∂c − uᵀ∂Σu;  g∂g = −vᵀ∂c − vᵀ∂Σu
        let (a, b) = ((1.0 - 0.5 / rho) / g, d / (g * g));
        let d_centre = u * (-2.0 * a) + v * b;
        (d, with_outer(&d_centre, &(v * b - u * a), &u, 1.0))
    }

    fn orthogonal(&self, x: &Vector2<f64>) -> (f64, SVector<f64, 5>) {
        let foot = self.foot(x);
        let u = self.inverse * (foot - self.centre);
        let g = u.norm().max(TINY);
        let d = (x - foot).dot(&u) / g;
        // ∂d = ∂q(f)/(2g): ∂q = −2uᵀ∂c − uᵀ∂Σu
        (d, with_outer(&(-u / g), &u, &u, -0.5 / g))
    }

    /// The nearest point of the outline.
    ///
    /// In the ellipse's own axes, with y ≥ 0 and e = a² − b², it is (a²y₀/(t + e), b²y₁/t) at the largest
    /// root t of F(t) = (a·y₀/(t + e))² + (b·y₁/t)² − 1. F falls and is convex there, so that Newton's steps
    /// from the left, where one term alone is 1, rise to the root and never pass it.
    ///
    /// # Source
    /// Eberly 2013, *Distance from a Point to an Ellipse*; Newton instead of his bisection.
    fn foot(&self, x: &Vector2<f64>) -> Vector2<f64> {
        let (axes, a, b) = self.principal_axes();
        let y = axes.tr_mul(&(x - self.centre));
        let (y0, y1) = (y[0].abs(), y[1].abs().max(TINY * b));
        let e = a * a - b * b;

        let mut t = (a * y0 - e).max(b * y1);
        for _ in 0..60 {
            let (u, v) = (a * y0 / (t + e), b * y1 / t);
            let slope = -2.0 * (u * u / (t + e) + v * v / t);
            let step = (1.0 - u * u - v * v) / slope;
            t += step;
            if step <= 1e-14 * t {
                break;
            }
        }

        let foot = Vector2::new(a * a * y0 / (t + e), b * b * y1 / t);
        let sign = |v: f64| if v < 0.0 { -1.0 } else { 1.0 };
        self.centre + axes * Vector2::new(foot[0] * sign(y[0]), foot[1] * sign(y[1]))
    }

    /// Unit axes as columns, the longer one first, and the semi-axes a ≥ b.
    fn principal_axes(&self) -> (Matrix2<f64>, f64, f64) {
        let shape = self.root * self.root.transpose();
        let half = 0.5 * (shape[(0, 0)] - shape[(1, 1)]);
        let angle = 0.5 * shape[(0, 1)].atan2(half);
        let (sin, cos) = angle.sin_cos();
        let b = self.root[(0, 0)] * self.root[(1, 1)] / self.reach;
        (Matrix2::new(cos, -sin, sin, cos), self.reach, b)
    }
}

const TINY: f64 = 1e-12;

/// (∂c, factor·aᵀ∂Σb) as five numbers.
#[inline]
fn with_outer(
    d_centre: &Vector2<f64>,
    a: &Vector2<f64>,
    b: &Vector2<f64>,
    factor: f64,
) -> SVector<f64, 5> {
    SVector::from([[
        d_centre[0],
        d_centre[1],
        factor * a[0] * b[0],
        factor * (a[0] * b[1] + a[1] * b[0]),
        factor * a[1] * b[1],
    ]])
}

#[cfg(test)]
mod tests {
    use nalgebra::DVector;

    use super::*;
    use crate::math::central_differences;

    const KINDS: [EllipseDistance; 3] =
        [EllipseDistance::Published, EllipseDistance::Gradient, EllipseDistance::Orthogonal];

    fn ellipse(n: &[f64]) -> Ellipse {
        Ellipse { centre: Vector2::new(n[0], n[1]), shape: Matrix2::new(n[2], n[3], n[3], n[4]) }
    }

    /// The true distance, by bisection to rounding: the oracle that the others are tested against.
    ///
    /// # Source
    /// Eberly, *Distance from a Point to an Ellipse* (2013): the root of
    /// F(t) = (a·y₀/(t+a²))² + (b·y₁/(t+b²))² − 1 on t > −b².
    fn exact_distance(ellipse: &Ellipse, x: &Vector2<f64>) -> f64 {
        let eigen = ellipse.shape.symmetric_eigen();
        let major = if eigen.eigenvalues[0] >= eigen.eigenvalues[1] { 0 } else { 1 };
        let (a, b) = (eigen.eigenvalues[major].sqrt(), eigen.eigenvalues[1 - major].sqrt());

        // the point in the first quadrant of the ellipse's axes, and its foot there
        let y = eigen.eigenvectors.transpose() * (x - ellipse.centre);
        let y = Vector2::new(y[major].abs(), y[1 - major].abs());
        let foot = if y[1] > 0.0 {
            let f =
                |t: f64| (a * y[0] / (t + a * a)).powi(2) + (b * y[1] / (t + b * b)).powi(2) - 1.0;
            let (mut low, mut high) =
                (-b * b + b * y[1], -b * b + (a * a * y[0] * y[0] + b * b * y[1] * y[1]).sqrt());
            for _ in 0..200 {
                let middle = 0.5 * (low + high);
                if f(middle) > 0.0 { low = middle } else { high = middle }
            }
            let t = 0.5 * (low + high);
            Vector2::new(a * a * y[0] / (t + a * a), b * b * y[1] / (t + b * b))
        } else if a * y[0] < a * a - b * b {
            let x0 = a * a * y[0] / (a * a - b * b);
            Vector2::new(x0, b * (1.0 - (x0 / a).powi(2)).max(0.0).sqrt())
        } else {
            Vector2::new(a, 0.0)
        };

        let inside = (y[0] / a).powi(2) + (y[1] / b).powi(2) < 1.0;
        (y - foot).norm() * if inside { -1.0 } else { 1.0 }
    }

    const LONG: [f64; 5] = [10.0, -4.0, 900.0, 300.0, 250.0];

    #[test]
    fn a_point_on_the_outline_has_zero_distance() {
        let e = OutlineEllipse::new(&ellipse(&LONG));
        for k in 0..20 {
            let (sin, cos) = (f64::from(k) * 0.314).sin_cos();
            let x = e.centre + e.root * Vector2::new(cos, sin);
            for kind in KINDS {
                approx::assert_abs_diff_eq!(e.distance(&x, kind).0, 0.0, epsilon = 1e-9);
            }
        }
    }

    #[test]
    fn all_agree_on_a_circle() {
        let e = OutlineEllipse::new(&ellipse(&[0.0, 0.0, 25.0, 0.0, 25.0]));
        for kind in KINDS {
            approx::assert_relative_eq!(
                e.distance(&Vector2::new(6.0, 8.0), kind).0,
                5.0,
                epsilon = 1e-9
            );
            approx::assert_relative_eq!(
                e.distance(&Vector2::new(0.0, 3.0), kind).0,
                -2.0,
                epsilon = 1e-9
            );
        }
    }

    #[test]
    fn the_orthogonal_distance_is_the_exact_one_everywhere() {
        let raw = ellipse(&LONG);
        let e = OutlineEllipse::new(&raw);
        for i in -12..=12 {
            for j in -12..=12 {
                let x = Vector2::new(10.0 + 6.0 * f64::from(i), -4.0 + 6.0 * f64::from(j));
                let exact = exact_distance(&raw, &x);
                let d = e.distance(&x, EllipseDistance::Orthogonal).0;
                approx::assert_abs_diff_eq!(d, exact, epsilon = 1e-9);
            }
        }
    }

    #[test]
    fn the_radial_distance_overstates_along_the_flank_and_the_first_order_one_hardly() {
        let raw = ellipse(&[0.0, 0.0, 2500.0, 0.0, 100.0]);
        let e = OutlineEllipse::new(&raw);
        let x = Vector2::new(40.0, 8.0);
        let exact = exact_distance(&raw, &x);
        assert!(e.distance(&x, EllipseDistance::Published).0 > 2.0 * exact);
        approx::assert_relative_eq!(
            e.distance(&x, EllipseDistance::Gradient).0,
            exact,
            max_relative = 0.1
        );
    }

    #[test]
    fn the_radial_distance_is_that_from_the_unit_circle_brought_back_whatever_maps_the_circle() {
        let e = OutlineEllipse::new(&ellipse(&LONG));
        for turn in [0.0, 0.7, 2.9] {
            let root = e.root * *nalgebra::Rotation2::new(turn).matrix();
            for x in [Vector2::new(50.0, 20.0), Vector2::new(14.0, 9.0), Vector2::new(12.0, -2.0)] {
                let v = root.lu().solve(&(x - e.centre)).unwrap();
                let back = (root * (v - v / v.norm())).norm() * (v.norm() - 1.0).signum();
                let d = e.distance(&x, EllipseDistance::Published).0;
                approx::assert_abs_diff_eq!(d, back, epsilon = 1e-9);
            }
        }
    }

    #[test]
    fn the_radial_distance_is_never_less_than_the_true_one() {
        let raw = ellipse(&LONG);
        let e = OutlineEllipse::new(&raw);
        for i in -12..=12 {
            for j in -12..=12 {
                let x = Vector2::new(10.3 + 6.0 * f64::from(i), -4.2 + 6.0 * f64::from(j));
                let d = e.distance(&x, EllipseDistance::Published).0;
                assert!(d.abs() >= exact_distance(&raw, &x).abs() - 1e-9);
            }
        }
    }

    #[test]
    fn beside_the_outline_the_radial_distance_is_too_large_by_kantorovichs_bound_at_most() {
        let (a, b) = (50.0, 10.0);
        let e = OutlineEllipse::new(&ellipse(&[0.0, 0.0, a * a, 0.0, b * b]));
        let ratio = |turn: f64| {
            let (sin, cos) = turn.sin_cos();
            let foot = Vector2::new(a * cos, b * sin);
            let normal = Vector2::new(cos / a, sin / b).try_normalize(1e-9).unwrap();
            e.distance(&(foot + normal * 1e-4), EllipseDistance::Published).0 / 1e-4
        };
        let bound = (a * a + b * b) / (2.0 * a * b);
        approx::assert_relative_eq!(ratio(std::f64::consts::FRAC_PI_4), bound, max_relative = 1e-4);
        approx::assert_relative_eq!(ratio(0.0), 1.0, max_relative = 1e-4);
        assert!((0..100).all(|k| ratio(0.0628 * f64::from(k)) < bound * (1.0 + 1e-4)));
    }

    #[test]
    fn through_the_projection_derivatives_are_those_by_the_ellipsoid() {
        use crate::math::quadric::{Ellipsoid, project, project_with_jacobian};
        const NUMBERS: [f64; 9] = [0.1, -0.3, 4.2, 0.02, 0.003, -0.002, 0.05, 0.004, 0.03];
        let camera = nalgebra::Matrix3x4::new(
            760.0, 0.3, 399.5, 20.0, 0.0, 755.0, 299.5, -30.0, 0.0, 0.05, 1.0, 0.1,
        );
        let ellipsoid = |n: &[f64]| Ellipsoid {
            centre: nalgebra::Vector3::new(n[0], n[1], n[2]),
            shape: nalgebra::Matrix3::new(n[3], n[4], n[5], n[4], n[6], n[7], n[5], n[7], n[8]),
        };
        let (seen, slopes) = project_with_jacobian(&camera, &ellipsoid(&NUMBERS)).unwrap();
        for away in [Vector2::new(60.0, 20.0), Vector2::new(-9.0, 12.0)] {
            let x = seen.centre + away;
            for kind in KINDS {
                let analytic = slopes.tr_mul(&OutlineEllipse::new(&seen).distance(&x, kind).1);
                let numeric = central_differences(9, 1e-5, |delta| {
                    let n: Vec<f64> =
                        NUMBERS.iter().zip(delta.iter()).map(|(a, b)| a + b).collect();
                    let seen = project(&camera, &ellipsoid(&n)).unwrap();
                    DVector::from_element(1, OutlineEllipse::new(&seen).distance(&x, kind).0)
                });
                for (analytic, numeric) in analytic.iter().zip(numeric.iter()) {
                    approx::assert_relative_eq!(
                        analytic,
                        numeric,
                        max_relative = 1e-5,
                        epsilon = 1e-4
                    );
                }
            }
        }
    }

    #[test]
    fn derivatives_are_those_of_the_distance() {
        for kind in KINDS {
            for x in [Vector2::new(50.0, 20.0), Vector2::new(14.0, 9.0), Vector2::new(12.0, 14.0)] {
                let analytic = OutlineEllipse::new(&ellipse(&LONG)).distance(&x, kind).1;
                let numeric = central_differences(5, 1e-2, |delta| {
                    let n: Vec<f64> = LONG.iter().zip(delta.iter()).map(|(a, b)| a + b).collect();
                    DVector::from_element(1, OutlineEllipse::new(&ellipse(&n)).distance(&x, kind).0)
                });
                for i in 0..5 {
                    approx::assert_abs_diff_eq!(analytic[i], numeric[(0, i)], epsilon = 1e-8);
                }
            }
        }
    }
}
