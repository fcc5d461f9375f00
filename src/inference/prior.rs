//! p(s) and p(m): the factors of one shape and one motion that know no image.

use nalgebra::{Cholesky, DMatrix, DVector, Dyn};

use crate::body::{BodyModel, Layout, Motion, Shape};
use crate::solver::NormalEquations;

/// −log p(s) = ½ (s − μ)ᵀ Λ (s − μ) + ½ Σ ((|cᵢ| − 3)₊/0.3)², Λ = Σ⁻¹: Gaussian on the logarithmic coefficients, with limits.
///
/// c = diag(Λ)^(−½) Λ (s − μ): how far, in its standard deviations, each coefficient lies from what all the others
/// predict. A child is small in everything, and its c are ordinary. A hand twice as broad as its arm is more likely a wrong
/// mask than a body, but thousands of border points would outvote the Gaussian alone.
#[derive(Debug, Clone)]
pub struct ShapePrior {
    mean: DVector<f64>,
    precision: DMatrix<f64>,
    /// Row i is ∂cᵢ.
    apart: DMatrix<f64>,
}

/// |c| beyond which a size is improbable for a body: one in 400.
const LIMIT: f64 = 3.0;
/// How soft that limit is, standard deviations.
const LIMIT_SOFT: f64 = 0.3;

impl ShapePrior {
    /// The prior of a model; its covariance was checked when the model was made.
    pub fn new(model: &BodyModel) -> Self {
        let statistics = &model.statistics;
        let n = statistics.mean.len();
        let precision = Cholesky::<f64, Dyn>::new(statistics.covariance.clone())
            .map_or_else(|| DMatrix::zeros(n, n), |c| c.inverse());
        let mut apart = precision.clone();
        for (i, mut row) in apart.row_iter_mut().enumerate() {
            row /= precision[(i, i)].sqrt().max(f64::MIN_POSITIVE);
        }
        Self { mean: statistics.mean.clone(), precision, apart }
    }

    /// (cᵢ beyond ±3)/0.3, coefficient by coefficient.
    fn beyond(&self, offset: &DVector<f64>) -> DVector<f64> {
        let beyond = |c: f64| (c - c.clamp(-LIMIT, LIMIT)) / LIMIT_SOFT;
        (&self.apart * offset).map(beyond)
    }

    /// μ, the most probable shape.
    pub fn mean(&self) -> Shape {
        Shape(self.mean.clone())
    }

    /// −log p(s), 0 at the mean.
    pub fn cost(&self, shape: &Shape) -> f64 {
        let offset = &shape.0 - &self.mean;
        let beyond = self.beyond(&offset);
        0.5 * (offset.dot(&(&self.precision * &offset)) + beyond.norm_squared())
    }

    /// Adds gradient and Hessian to the components from `first` on.
    pub fn linearize(&self, shape: &Shape, first: usize, equations: &mut NormalEquations) -> f64 {
        let offset = &shape.0 - &self.mean;
        let n = offset.len();

        // the Gaussian
        let pull = &self.precision * &offset;
        let mut gradient = equations.gradient.rows_mut(first, n);
        gradient += &pull;
        let mut hessian = equations.hessian.view_mut((first, first), (n, n));
        hessian += &self.precision;

        // the limits
        let beyond = self.beyond(&offset);
        for (i, b) in beyond.iter().enumerate().filter(|(_, b)| **b != 0.0) {
            let slope = self.apart.row(i).transpose() / LIMIT_SOFT;
            gradient += &slope * *b;
            hessian += &slope * slope.transpose();
        }

        0.5 * (offset.dot(&pull) + beyond.norm_squared())
    }
}

/// p(m): joint limits as a smooth barrier, and a wide Gaussian about rest where nothing is seen.
///
/// Barrier: ½((θ − limit)/σ)² beyond a limit, σ = 3°; once differentiable.
#[derive(Debug, Clone)]
pub struct PosePrior {
    rest: DVector<f64>,
    precision: DVector<f64>,
    limits: Vec<(f64, f64)>,
    first: usize,
}

const LIMIT_SIGMA: f64 = 3.0 * std::f64::consts::PI / 180.0;

impl PosePrior {
    /// The prior of a model's angles.
    pub fn new(model: &BodyModel) -> Self {
        let n = model.joints.len();
        Self {
            rest: DVector::from_iterator(n, model.joints.iter().map(|j| j.rest)),
            precision: DVector::from_iterator(n, model.joints.iter().map(|j| j.spread.powi(-2))),
            limits: model.joints.iter().map(|j| j.limits).collect(),
            first: Layout::new(model).root(),
        }
    }

    fn beyond(&self, joint: usize, angle: f64) -> f64 {
        let (low, high) = self.limits[joint];
        ((angle - high).max(0.0) + (angle - low).min(0.0)) / LIMIT_SIGMA
    }

    /// −log p(m), 0 at rest.
    pub fn cost(&self, motion: &Motion) -> f64 {
        let one = |(j, angle): (usize, &f64)| {
            self.precision[j] * (angle - self.rest[j]).powi(2) + self.beyond(j, *angle).powi(2)
        };
        0.5 * motion.angles.iter().enumerate().map(one).sum::<f64>()
    }

    /// Adds gradient and Hessian.
    pub fn linearize(&self, motion: &Motion, equations: &mut NormalEquations) -> f64 {
        for (j, angle) in motion.angles.iter().enumerate() {
            let row = self.first + j;
            equations.add_single(row, 1.0, angle - self.rest[j], self.precision[j]);
            let beyond = self.beyond(j, *angle);
            if beyond != 0.0 {
                equations.add_single(row, 1.0 / LIMIT_SIGMA, beyond, 1.0);
            }
        }
        self.cost(motion)
    }
}
