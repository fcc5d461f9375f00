//! An ellipse, and how far points and lines are from its border.

use maquette::likelihood::Residual;
use maquette::math::central_differences;
use maquette::solver::{NormalEquations, Options, Problem, Solution, levenberg_marquardt};
use nalgebra::{DVector, Matrix2, Rotation2, Vector2};

/// Components of the state: centre (2), logarithms of the two semi-axes, angle.
pub(crate) const DIMENSION: usize = 5;
/// Slope of the published residual at the border of a limb of this radius is 1, metres.
const FIELD_RADIUS: f64 = 0.05;

/// One ellipse.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Ellipse {
    pub(crate) centre: Vector2<f64>,
    /// Logarithms of the semi-axes in metres.
    pub(crate) log_axes: Vector2<f64>,
    pub(crate) angle: f64,
}

impl Ellipse {
    /// Σ: the border is where (x − c)ᵀ Σ⁻¹ (x − c) = 1.
    fn shape(&self) -> Matrix2<f64> {
        let turn = Rotation2::new(self.angle);
        let squared = self.log_axes.map(|a| (2.0 * a).exp());
        turn.matrix() * Matrix2::from_diagonal(&squared) * turn.matrix().transpose()
    }

    /// A point of the border; `turn` from 0 to 2π.
    pub(crate) fn border(&self, turn: f64) -> Vector2<f64> {
        let axes = self.log_axes.map(f64::exp);
        let (sin, cos) = turn.sin_cos();
        self.centre + Rotation2::new(self.angle) * Vector2::new(axes.x * cos, axes.y * sin)
    }

    /// Half of its extent in the direction of a unit vector.
    pub(crate) fn half_extent(&self, direction: &Vector2<f64>) -> f64 {
        direction.dot(&(self.shape() * direction)).sqrt()
    }

    pub(crate) fn area(&self) -> f64 {
        std::f64::consts::PI * self.log_axes.sum().exp()
    }

    /// ρ and ‖∇ρ‖ of a point: 1 on the border.
    fn of_point(&self, point: &Vector2<f64>) -> (f64, f64) {
        let turn = Rotation2::new(-self.angle);
        let squared = self.log_axes.map(|a| (2.0 * a).exp());
        let local = turn * (point - self.centre);
        let pull = local.component_div(&squared);
        let rho = local.dot(&pull).sqrt();
        (rho, pull.norm() / rho)
    }
}

/// A straight line n·x = offset that touches the ellipse, n pointing away from it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Tangent {
    pub(crate) normal: Vector2<f64>,
    pub(crate) offset: f64,
}

/// What is seen of an ellipse, with standard deviations in metres.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Seen {
    pub(crate) points: Vec<Vector2<f64>>,
    pub(crate) tangents: Vec<Tangent>,
    pub(crate) point_sd: f64,
    pub(crate) tangent_sd: f64,
}

/// The fit of an ellipse to what is seen, with a residual of the papers.
pub(crate) struct Fit<'a> {
    pub(crate) seen: &'a Seen,
    pub(crate) residual: Residual,
    /// Standard deviation of the logarithms of the semi-axes about those of a circle of 5 cm: wide.
    pub(crate) axes_sd: f64,
}

impl Fit<'_> {
    /// Minimum from a start.
    pub(crate) fn solve(&self, start: Ellipse) -> Solution<Ellipse, NormalEquations> {
        let options =
            Options { max_iterations: 300, relative_decrease: 1e-10, ..Options::default() };
        levenberg_marquardt(self, start, &options)
    }

    /// In metres at the border: PF02's T − F with F = exp(−ρ² ln 2), or the distance.
    fn distance(&self, rho: f64, slope: f64) -> f64 {
        match self.residual {
            Residual::Field => {
                let field = (-std::f64::consts::LN_2 * rho * rho).exp();
                (0.5 - field) * FIELD_RADIUS / std::f64::consts::LN_2
            }
            Residual::Metric => (rho - 1.0) / slope,
        }
    }

    /// Every residual over its standard deviation.
    fn residuals(&self, ellipse: &Ellipse) -> DVector<f64> {
        let of_point = |p: &Vector2<f64>| {
            let (rho, slope) = ellipse.of_point(p);
            self.distance(rho, slope) / self.seen.point_sd
        };
        // the point of the line where F is largest has ρ = offset over half extent
        let of_tangent = |t: &Tangent| {
            let half = ellipse.half_extent(&t.normal);
            let rho = (t.offset - t.normal.dot(&ellipse.centre)) / half;
            self.distance(rho, 1.0 / half) / self.seen.tangent_sd
        };
        let axis = |a: &f64| (a - 0.05_f64.ln()) / self.axes_sd;
        let points = self.seen.points.iter().map(of_point);
        let tangents = self.seen.tangents.iter().map(of_tangent);
        let axes = ellipse.log_axes.iter().map(axis);
        DVector::from_vec(points.chain(tangents).chain(axes).collect())
    }
}

impl Problem for Fit<'_> {
    type State = Ellipse;
    type Model = NormalEquations;

    fn empty_model(&self) -> NormalEquations {
        NormalEquations::zeros(DIMENSION)
    }

    fn cost(&self, x: &Ellipse) -> f64 {
        0.5 * self.residuals(x).norm_squared()
    }

    fn linearize(&self, x: &Ellipse, equations: &mut NormalEquations) -> f64 {
        let residuals = self.residuals(x);
        let jacobian =
            central_differences(DIMENSION, 1e-6, |d| self.residuals(&self.retract(x, d)));
        equations.gradient += jacobian.transpose() * &residuals;
        equations.hessian += jacobian.transpose() * &jacobian;
        0.5 * residuals.norm_squared()
    }

    fn retract(&self, x: &Ellipse, delta: &DVector<f64>) -> Ellipse {
        Ellipse {
            centre: x.centre + Vector2::new(delta[0], delta[1]),
            log_axes: x.log_axes + Vector2::new(delta[2], delta[3]),
            angle: x.angle + delta[4],
        }
    }
}
