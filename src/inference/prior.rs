//! p(s) and p(m): the factors of one shape and one motion that know no image.

use nalgebra::{Cholesky, DMatrix, DVector, Dyn};

use crate::body::{BodyModel, Layout, Motion, Shape, ShapeStatistics};
use crate::solver::NormalEquations;

/// −log p(s) = ½ (s − μ)ᵀ Λ (s − μ), Λ = Σ⁻¹: Gaussian on the logarithmic coefficients.
#[derive(Debug, Clone)]
pub struct ShapePrior {
    mean: DVector<f64>,
    precision: DMatrix<f64>,
}

impl ShapePrior {
    /// The prior of a model; its covariance was checked when the model was made.
    pub fn new(model: &BodyModel) -> Self {
        Self::from_statistics(&model.statistics)
    }

    /// The prior of such coefficients; their covariance has an inverse.
    pub(super) fn from_statistics(statistics: &ShapeStatistics) -> Self {
        let n = statistics.mean.len();
        let precision = Cholesky::<f64, Dyn>::new(statistics.covariance.clone())
            .map_or_else(|| DMatrix::zeros(n, n), |c| c.inverse());
        Self { mean: statistics.mean.clone(), precision }
    }

    /// μ, the most probable shape.
    pub fn mean(&self) -> Shape {
        Shape(self.mean.clone())
    }

    /// −log p(s), 0 at the mean.
    pub fn cost(&self, shape: &Shape) -> f64 {
        let offset = &shape.0 - &self.mean;
        0.5 * offset.dot(&(&self.precision * &offset))
    }

    /// Adds gradient and Hessian to the components from `first` on.
    pub fn linearize(&self, shape: &Shape, first: usize, equations: &mut NormalEquations) -> f64 {
        let offset = &shape.0 - &self.mean;
        let n = offset.len();
        let pull = &self.precision * &offset;
        let mut gradient = equations.gradient.rows_mut(first, n);
        gradient += &pull;
        let mut hessian = equations.hessian.view_mut((first, first), (n, n));
        hessian += &self.precision;
        0.5 * offset.dot(&pull)
    }
}

/// p(m): joint limits as a smooth barrier, and a wide Gaussian about rest where nothing is seen.
///
/// Barrier: ½((θ − limit)/σ)² beyond a limit, σ = 3°; once differentiable.
///
/// That is of one motion. Along a chain the frames of a moment are not so many independent poses: an angle of spread S that
/// moves at the speed v is a new one about every S/v seconds. In a frame that lasts Δ seconds the Gaussian counts vΔ/4S
/// times ([`ChainPrior`](super::chain::ChainPrior)) and the barrier vΔ/S times, never more than once.
#[derive(Debug, Clone)]
pub struct PosePrior {
    rest: DVector<f64>,
    precision: DVector<f64>,
    limits: Vec<(f64, f64)>,
    /// v/S, 1/s.
    renewal: DVector<f64>,
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
            renewal: DVector::from_iterator(n, model.joints.iter().map(|j| j.speed / j.spread)),
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
        self.linearize_lasting(motion, f64::INFINITY, equations)
    }

    /// How often Gaussian and barrier of an angle count in a frame that lasts `seconds`.
    fn counts(&self, joint: usize, seconds: f64) -> (f64, f64) {
        let renewed = self.renewal[joint] * seconds;
        ((0.25 * renewed).min(1.0), renewed.min(1.0))
    }

    /// −log p(m) of a frame that lasts `seconds`.
    pub fn cost_lasting(&self, motion: &Motion, seconds: f64) -> f64 {
        let one = |(j, angle): (usize, &f64)| {
            let (rest, limit) = self.counts(j, seconds);
            rest * self.precision[j] * (angle - self.rest[j]).powi(2)
                + limit * self.beyond(j, *angle).powi(2)
        };
        0.5 * motion.angles.iter().enumerate().map(one).sum::<f64>()
    }

    /// Adds gradient and Hessian of a frame that lasts `seconds`.
    pub fn linearize_lasting(
        &self,
        motion: &Motion,
        seconds: f64,
        equations: &mut NormalEquations,
    ) -> f64 {
        for (j, angle) in motion.angles.iter().enumerate() {
            let row = self.first + j;
            let (rest, limit) = self.counts(j, seconds);
            equations.add_single(row, 1.0, angle - self.rest[j], rest * self.precision[j]);
            let beyond = self.beyond(j, *angle);
            if beyond != 0.0 {
                equations.add_single(row, 1.0 / LIMIT_SIGMA, beyond, limit);
            }
        }
        self.cost_lasting(motion, seconds)
    }
}
