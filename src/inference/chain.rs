//! The factors between neighbouring motions, for all frames at once.
//!
//! | model             | factor                                     | residual e                        | standard deviation |
//! |-------------------|--------------------------------------------|-----------------------------------|--------------------|
//! | constant position | p(mᵢ given mᵢ₋₁)                           | (mᵢ ⊟ mᵢ₋₁)/Δ                     | v, the model's speed |
//! | constant velocity | the same, and p(mᵢ given mᵢ₋₁, mᵢ₋₂)       | (mᵢ ⊟ mᵢ₋₁)/Δᵢ − (mᵢ₋₁ ⊟ mᵢ₋₂)/Δᵢ₋₁ | 2πf·v·(Δᵢ + Δᵢ₋₁)/2 |
//!
//! A limb that swings with speed v at frequency f accelerates by 2πf·v. With Δ in seconds, e is a velocity.
//! Every component of e depends on its own component of the motions alone, but for the three of the root's
//! rotation φ = log(RₐᵀR_b): ∂φ/∂δ_b = J_r⁻¹(φ), ∂φ/∂δₐ = −J_r⁻¹(φ)ᵀ.

use nalgebra::{DMatrix, DVector, Matrix3};

use super::step::{MotionModel, speeds};
use crate::body::{BodyModel, Layout, Motion};
use crate::math::rotation::right_jacobian_inverse;
use crate::solver::Link;

/// f: gait's limbs swing at one to two strides a second and seldom faster than twice that.
pub const SWING_HZ: f64 = 2.0;

/// −log of the factors between neighbouring motions.
#[derive(Debug, Clone)]
pub struct ChainPrior {
    layout: Layout,
    speeds: DVector<f64>,
    motion_model: MotionModel,
}

/// ∂e/∂δ of one motion: a multiple of the identity, but for the root's rotation.
#[derive(Debug, Clone, Copy)]
struct Slope {
    along: f64,
    turn: Matrix3<f64>,
}

/// One factor ½ eᵀWe and its slopes with respect to the last motion, the one before, …
struct Factor {
    residual: DVector<f64>,
    precision: DVector<f64>,
    slopes: Vec<Slope>,
}

impl ChainPrior {
    /// The factors of a model's motions.
    pub fn new(model: &BodyModel, motion_model: MotionModel) -> Self {
        Self { layout: Layout::new(model), speeds: speeds(model), motion_model }
    }

    /// How many frames before it a frame is coupled to.
    pub fn reach(&self) -> usize {
        match self.motion_model {
            MotionModel::ConstantPosition => 1,
            MotionModel::ConstantVelocity => 2,
        }
    }

    /// Sum of the factors whose last motion is that of frame `i`; `seconds[i]` lie between frames i − 1 and i.
    pub fn cost(&self, motions: &[Motion], seconds: &[f64], i: usize) -> f64 {
        self.factors(motions, seconds, i).iter().map(Factor::cost).sum()
    }

    /// Adds the factors whose last motion is that of frame `i`.
    pub fn linearize(
        &self,
        motions: &[Motion],
        seconds: &[f64],
        i: usize,
        links: &mut [Link],
    ) -> f64 {
        let factors = self.factors(motions, seconds, i);
        factors.iter().map(|factor| factor.add_to(self.layout, i, links)).sum()
    }

    fn factors(&self, motions: &[Motion], seconds: &[f64], i: usize) -> Vec<Factor> {
        if i == 0 {
            return Vec::new();
        }
        let last = self.velocity(&motions[i - 1], &motions[i], seconds[i]);
        let mut factors = Vec::with_capacity(2);
        if self.motion_model == MotionModel::ConstantVelocity && i > 1 {
            let before = self.velocity(&motions[i - 2], &motions[i - 1], seconds[i - 1]);
            let acceleration =
                std::f64::consts::TAU * SWING_HZ * 0.5 * (seconds[i] + seconds[i - 1]);
            let precision = self.speeds.map(|v| (v * acceleration).powi(-2));
            factors.push(last.minus(&before, precision));
        }
        let precision = self.speeds.map(|v| v.powi(-2));
        factors.push(Factor { precision, ..last });
        factors
    }

    /// (to ⊟ from)/Δ, without a precision yet.
    fn velocity(&self, from: &Motion, to: &Motion, seconds: f64) -> Factor {
        let difference = self.layout.motion_difference(from, to);
        let turn = if self.layout.root() == 6 {
            right_jacobian_inverse(&difference.fixed_rows::<3>(3).into_owned())
        } else {
            Matrix3::identity()
        };
        let slope =
            |along: f64, turn: Matrix3<f64>| Slope { along: along / seconds, turn: turn / seconds };
        Factor {
            residual: difference / seconds,
            precision: DVector::zeros(0),
            slopes: vec![slope(1.0, turn), slope(-1.0, -turn.transpose())],
        }
    }
}

impl Factor {
    /// This velocity minus the one before it.
    fn minus(&self, before: &Self, precision: DVector<f64>) -> Self {
        let [to, from] = [self.slopes[0], self.slopes[1]];
        let [before_to, before_from] = [before.slopes[0], before.slopes[1]];
        let less = |a: Slope, b: Slope| Slope { along: a.along - b.along, turn: a.turn - b.turn };
        let none = Slope { along: 0.0, turn: Matrix3::zeros() };
        Self {
            residual: &self.residual - &before.residual,
            precision,
            slopes: vec![to, less(from, before_to), less(none, before_from)],
        }
    }

    fn cost(&self) -> f64 {
        0.5 * self.residual.component_mul(&self.residual).dot(&self.precision)
    }

    fn add_to(&self, layout: Layout, i: usize, links: &mut [Link]) -> f64 {
        let pull = self.residual.component_mul(&self.precision);
        for (a, slope) in self.slopes.iter().enumerate() {
            slope.add_gradient(layout, &pull, &mut links[i - a].gradient);
            for (b, other) in self.slopes.iter().enumerate().skip(a) {
                let link = &mut links[i - a];
                let block =
                    if a == b { &mut link.diagonal } else { &mut link.couplings[b - a - 1] };
                slope.add_product(layout, &self.precision, other, block);
            }
        }
        self.cost()
    }
}

impl Slope {
    /// Adds slopeᵀ·pull.
    fn add_gradient(&self, layout: Layout, pull: &DVector<f64>, gradient: &mut DVector<f64>) {
        for k in straight(layout) {
            gradient[k] += self.along * pull[k];
        }
        if layout.root() == 6 {
            let mut turn = gradient.fixed_rows_mut::<3>(3);
            turn += self.turn.transpose() * pull.fixed_rows::<3>(3);
        }
    }

    /// Adds slopeᵀ·W·other.
    fn add_product(
        &self,
        layout: Layout,
        precision: &DVector<f64>,
        other: &Self,
        block: &mut DMatrix<f64>,
    ) {
        for k in straight(layout) {
            block[(k, k)] += self.along * precision[k] * other.along;
        }
        if layout.root() == 6 {
            let weight = Matrix3::from_diagonal(&precision.fixed_rows::<3>(3).into_owned());
            let mut turn = block.fixed_view_mut::<3, 3>(3, 3);
            turn += self.turn.transpose() * weight * other.turn;
        }
    }
}

/// The components that are no rotation of the root.
fn straight(layout: Layout) -> impl Iterator<Item = usize> {
    (0..layout.motion()).filter(move |k| layout.root() == 0 || !(3..6).contains(k))
}
