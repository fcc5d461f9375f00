//! p(mᵢ | mᵢ₋₁), p(mᵢ | mᵢ₋₁, mᵢ₋₂): how one motion follows the others.

use nalgebra::{DVector, Matrix3};

use crate::body::{BodyModel, Layout, Motion, Root};
use crate::math::rotation::right_jacobian_inverse;
use crate::solver::NormalEquations;

/// What the next motion is expected to be.
#[derive(Debug, Clone, Copy, PartialEq, Eq, serde::Serialize, serde::Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum MotionModel {
    /// mᵢ about mᵢ₋₁ (ZS06, eq. 3).
    ConstantPosition,
    /// mᵢ about mᵢ₋₁ ⊞ (mᵢ₋₁ ⊟ mᵢ₋₂).
    ConstantVelocity,
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
        Self {
            layout: Layout::new(model),
            precision: speeds(model).map(|v| (v * interval_s).powi(-2)),
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

        // every component depends on its own alone, …
        for i in (0..delta.len()).filter(|i| self.layout.root() == 0 || !(3..6).contains(i)) {
            equations.add_single(i, 1.0, delta[i], self.precision[i]);
        }

        // … but for the root's rotation φ: ∂φ/∂δ = J_r⁻¹(φ)
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

/// Standard deviation of each component's velocity, m/s or rad/s.
pub(super) fn speeds(model: &BodyModel) -> DVector<f64> {
    let root = match model.root {
        Root::Free { speed, turn } => vec![speed, speed, speed, turn, turn, turn],
        Root::Fixed => Vec::new(),
    };
    let all: Vec<f64> = root.into_iter().chain(model.joints.iter().map(|j| j.speed)).collect();
    DVector::from_vec(all)
}

/// The motion a part of the way from one to another: m₀ ⊞ (m₁ ⊟ m₀)·part.
pub fn between(layout: Layout, from: &Motion, to: &Motion, part: f64) -> Motion {
    layout.retract_motion(from, &(layout.motion_difference(from, to) * part))
}

/// The motion that follows two others at constant velocity: m₁ ⊞ (m₁ ⊟ m₀)·ratio.
pub(super) fn extrapolate(layout: Layout, before: &Motion, last: &Motion, ratio: f64) -> Motion {
    layout.retract_motion(last, &(layout.motion_difference(before, last) * ratio))
}
