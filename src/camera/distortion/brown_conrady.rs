//! OpenCV's standard lens: rational radial and tangential terms.

use super::{monotone::increases_up_to, polynomial};
use nalgebra::{Matrix2, Vector2};

/// Newton's iteration converges quadratically: only at the fold does it take more.
const MAX_ITERATIONS: u32 = 60;
/// Halvings of a step that would leave the view or raise the residual.
const MAX_HALVINGS: u32 = 30;
/// Residual of a solution, relative to 1 + |distorted|: some 1e-9 px with any real focal length.
const CONVERGED: f64 = 1e-12;

/// Coefficients k₁..k₃, k₄..k₆ and p₁, p₂.
pub(super) struct BrownConrady {
    pub(super) numerator: [f64; 3],
    pub(super) denominator: [f64; 3],
    pub(super) tangential: [f64; 2],
}

impl BrownConrady {
    /// The distorted point and its Jacobian.
    pub(super) fn distort(&self, point: &Vector2<f64>) -> (Vector2<f64>, Matrix2<f64>) {
        let (x, y) = (point.x, point.y);
        let s = point.norm_squared();
        let [p1, p2] = self.tangential;

        // radial factor a(s) = N/D and a′(s)
        let (n, n_slope) = polynomial(&self.numerator, s);
        let (d, d_slope) = polynomial(&self.denominator, s);
        let a = n / d;
        let a_slope = (n_slope - a * d_slope) / d;

        let value = Vector2::new(
            x * a + 2.0 * p1 * x * y + p2 * (s + 2.0 * x * x),
            y * a + p1 * (s + 2.0 * y * y) + 2.0 * p2 * x * y,
        );

        // ∂s/∂x = 2x, ∂s/∂y = 2y
        let mixed = 2.0 * x * y * a_slope + 2.0 * p1 * x + 2.0 * p2 * y;
        let jacobian = Matrix2::new(
            a + 2.0 * x * x * a_slope + 2.0 * p1 * y + 6.0 * p2 * x,
            mixed,
            mixed,
            a + 2.0 * y * y * a_slope + 6.0 * p1 * y + 2.0 * p2 * x,
        );
        (value, jacobian)
    }

    /// Whether the lens is still one-to-one from the centre out to `point`.
    pub(super) fn in_view(&self, point: &Vector2<f64>) -> bool {
        let s = point.norm_squared();
        self.radius_increases_up_to(s) && self.distort(point).1.determinant() > 0.0
    }

    /// Newton's iteration on distort(x) = `distorted`, from the image towards the centre, staying in view.
    pub(super) fn undistort(&self, distorted: &Vector2<f64>) -> Option<Vector2<f64>> {
        let mut point = self.start(distorted)?;
        let (mut value, mut jacobian) = self.distort(&point);
        for _ in 0..MAX_ITERATIONS {
            let residual = value - distorted;
            let step = solve(&jacobian, &residual)?;
            let Some(better) = self.better(&point, &step, residual.norm(), distorted) else {
                break;
            };
            point = better;
            (value, jacobian) = self.distort(&point);
        }
        ((value - distorted).norm() <= CONVERGED * (1.0 + distorted.norm())).then_some(point)
    }

    /// The distorted point itself, or the first of its halvings that is in view.
    fn start(&self, distorted: &Vector2<f64>) -> Option<Vector2<f64>> {
        (0..MAX_HALVINGS)
            .map(|halving| distorted * 0.5_f64.powi(halving.cast_signed()))
            .find(|point| self.in_view(point))
    }

    /// The longest of the halved steps that stays in view and lowers the residual.
    fn better(
        &self,
        point: &Vector2<f64>,
        step: &Vector2<f64>,
        residual: f64,
        distorted: &Vector2<f64>,
    ) -> Option<Vector2<f64>> {
        (0..MAX_HALVINGS)
            .map(|halving| point - step * 0.5_f64.powi(halving.cast_signed()))
            .take_while(|next| next != point)
            .find(|next| (self.distort(next).0 - distorted).norm() < residual && self.in_view(next))
    }

    /// Whether r·N(r²)/D(r²) increases, and D > 0, for all r² up to `s`.
    fn radius_increases_up_to(&self, s: f64) -> bool {
        let [k1, k2, k3] = self.numerator.map(f64::abs);
        let polynomial_only = self.denominator.iter().all(|&k| k.abs() <= 0.0);
        // 1 − 3|k₁|s − 5|k₂|s² − 7|k₃|s³ bounds the slope from below: true for most lenses, and cheap
        if polynomial_only && s * (3.0 * k1 + s * (5.0 * k2 + s * 7.0 * k3)) < 1.0 {
            return true;
        }

        s.is_finite()
            && increases_up_to(s, |s| {
                let (n, n_slope) = polynomial(&self.numerator, s);
                let (d, d_slope) = polynomial(&self.denominator, s);
                if d > 0.0 { (n + 2.0 * s * n_slope) * d - 2.0 * s * n * d_slope } else { -1.0 }
            })
    }
}

/// J⁻¹r by Cramer's rule.
fn solve(j: &Matrix2<f64>, r: &Vector2<f64>) -> Option<Vector2<f64>> {
    let determinant = j.determinant();
    (determinant > 0.0).then(|| {
        Vector2::new(
            (j.m22 * r.x - j.m12 * r.y) / determinant,
            (j.m11 * r.y - j.m21 * r.x) / determinant,
        )
    })
}
