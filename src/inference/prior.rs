//! p(s) and p(mᵢ | mᵢ₋₁): the factors that know no image.

use nalgebra::{Cholesky, DMatrix, DVector, Dyn, Matrix3};

use crate::body::{BodyModel, Layout, Motion, Root, Shape};
use crate::math::rotation::right_jacobian_inverse;
use crate::solver::NormalEquations;

/// −log p(s) = ½ (s − μ)ᵀ Σ⁻¹ (s − μ): Gaussian on the logarithmic coefficients.
#[derive(Debug, Clone)]
pub struct ShapePrior {
    mean: DVector<f64>,
    precision: DMatrix<f64>,
}

impl ShapePrior {
    /// The prior of a model; its covariance was checked when the model was made.
    pub fn of(model: &BodyModel) -> Self {
        let statistics = &model.statistics;
        let n = statistics.mean.len();
        let precision = Cholesky::<f64, Dyn>::new(statistics.covariance.clone())
            .map_or_else(|| DMatrix::zeros(n, n), |c| c.inverse());
        Self {
            mean: statistics.mean.clone(),
            precision,
        }
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

/// What the next motion is expected to be.
#[derive(Debug, Clone, Copy, PartialEq, Eq, serde::Serialize, serde::Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum MotionModel {
    /// mᵢ about mᵢ₋₁ (ZS06).
    ConstantPosition,
    /// mᵢ about mᵢ₋₁ ⊞ (mᵢ₋₁ ⊟ mᵢ₋₂).
    ConstantVelocity,
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
    pub fn of(model: &BodyModel) -> Self {
        let n = model.joints.len();
        Self {
            rest: DVector::from_iterator(n, model.joints.iter().map(|j| j.rest)),
            precision: DVector::from_iterator(n, model.joints.iter().map(|j| j.spread.powi(-2))),
            limits: model.joints.iter().map(|j| j.limits).collect(),
            first: Layout::of(model).root(),
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

/// p(mᵢ | mᵢ₋₁): Gaussian of the displacement mᵢ ⊟ mean, with the model's speeds times the frame interval.
#[derive(Debug, Clone)]
pub struct StepPrior {
    layout: Layout,
    precision: DVector<f64>,
}

impl StepPrior {
    /// The prior of a step of `interval_s` seconds.
    pub fn new(model: &BodyModel, interval_s: f64) -> Self {
        let layout = Layout::of(model);
        let mut speeds = Vec::with_capacity(layout.motion());
        if let Root::Free { speed, turn } = model.root {
            speeds.extend([speed, speed, speed, turn, turn, turn]);
        }
        speeds.extend(model.joints.iter().map(|j| j.speed));
        let precision = speeds.into_iter().map(|v| (v * interval_s).powi(-2));
        Self {
            layout,
            precision: DVector::from_iterator(layout.motion(), precision),
        }
    }

    /// −log p(mᵢ | mean), 0 at the mean.
    pub fn cost(&self, mean: &Motion, motion: &Motion) -> f64 {
        let delta = self.layout.motion_difference(mean, motion);
        0.5 * delta.component_mul(&delta).dot(&self.precision)
    }

    /// Adds gradient and Hessian with respect to mᵢ.
    pub fn linearize(
        &self,
        mean: &Motion,
        motion: &Motion,
        equations: &mut NormalEquations,
    ) -> f64 {
        let delta = self.layout.motion_difference(mean, motion);
        for i in (0..delta.len()).filter(|i| self.layout.root() == 0 || !(3..6).contains(i)) {
            equations.add_single(i, 1.0, delta[i], self.precision[i]);
        }
        if self.layout.root() == 6 {
            let phi = delta.fixed_rows::<3>(3).into_owned();
            let jacobian = right_jacobian_inverse(&phi);
            let weight = Matrix3::from_diagonal(&self.precision.fixed_rows::<3>(3).into_owned());
            let mut gradient = equations.gradient.fixed_rows_mut::<3>(3);
            gradient += jacobian.transpose() * weight * phi;
            let mut hessian = equations.hessian.fixed_view_mut::<3, 3>(3, 3);
            hessian += jacobian.transpose() * weight * jacobian;
        }
        0.5 * delta.component_mul(&delta).dot(&self.precision)
    }
}

/// The motion that follows two others at constant velocity: m₁ ⊞ (m₁ ⊟ m₀)·ratio.
pub fn extrapolate(layout: Layout, before: &Motion, last: &Motion, ratio: f64) -> Motion {
    layout.retract_motion(last, &(layout.motion_difference(before, last) * ratio))
}
