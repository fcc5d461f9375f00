//! The factors between neighbouring motions, for all frames at once: a process in continuous time.
//!
//! An angle θ about its rest, of spread S and speed v, is a stationary process whose acceleration is white noise but for what
//! draws it back (Matérn 3/2): with λ = v/S,
//!
//! θ̈ + 2λθ̇ + λ²θ = w,  E w(t)w(t′) = q δ(t − t′),  q = 4λ³S² = 4v³/S
//!
//! Its standard deviation is S, that of its velocity is v. −log p of a path is ∫ (θ̈ + 2λθ̇ + λ²θ)²/2q dt; the products of two
//! different derivatives are derivatives again or add to the squares, which leaves, but for the ends,
//!
//! | per second                    | here                                    | where              |
//! |-------------------------------|-----------------------------------------|--------------------|
//! | θ̈²/2q, q = 4v³/S               | e = θ̇ᵢ − θ̇ᵢ₋₁, variance qΔ̄               | constant velocity   |
//! | 2λ²θ̇²/2q = θ̇²/(4Sv)            | e = (θᵢ − θᵢ₋₁)/Δ, variance 2Sv/Δ         | both models         |
//! | λ⁴θ²/2q = vθ²/8S³              | [`PosePrior`](super::prior::PosePrior)   | the frame's own     |
//!
//! The first frame has p(m) whole. So a second counts as much at 25 as at 100 frames, and a step after a gap is what its time
//! says.
//!
//! The root has no rest. Its velocity is that of the way, of speed v, and what a stride adds, u, which is renewed 2πf times a second. An acceleration
//! of standard deviation a at f has u = a/2πf, so q = 2u²·2πf = a²/πf; the velocity's own part is 2πf·ẋ²/4v². For a runner:
//!
//! - Along an axis a = 1 g. Feet that press as half a sine for .3 of a stride each press with π/1.2 = 2.6 times the weight at most; about its mean, the weight, this
//!   is √(2.6²·.6/2 − 1) = 1.03 g.
//! - About an axis a = 13.3 rad/s²: 6.8° to either side (the pelvis in running: Perpiñá-Martínez et al. 2023) f times a second,
//!   (2πf)²·6.8°/√2.
//!
//! These are the published densities, q₀. The joint optimum estimates those of the recording (`accelerations.rs`).
//!
//! # Several trials
//! Trials of one person lie end to end in one chain. Of a process that forgets, p(mᵢ | mᵢ₋₁) → p(mᵢ) as Δᵢ → ∞, so Δᵢ = ∞ says that
//! frame i begins another trial: no factor reaches across, the frame has p(m) whole as the first one has, and the blocks of H that
//! couple it to the frames before are 0. What is left between the trials is the border: s, and cameras that did not move.
//!
//! Every component of e depends on its own component of the motions alone, but for the three of the root's rotation
//! φ = log(RₐᵀR_b): ∂φ/∂δ_b = J_r⁻¹(φ), ∂φ/∂δₐ = −J_r⁻¹(φ)ᵀ.
//!
//! # Source
//! Särkkä & Solin 2019, *Applied Stochastic Differential Equations*, ch. 12 (Matérn processes as state spaces). Alexander 1989, *Optimization and gaits in the
//! locomotion of vertebrates*, Physiological Reviews 69 (feet that press as half a sine; shares of a stride). Perpiñá-Martínez et al. 2023, *Differences between sexes and
//! speed levels in pelvic 3D kinematic patterns during running using an inertial measurement unit*, IJERPH 20(4), 3631.

use nalgebra::{DMatrix, DVector, Matrix3};

use super::step::{MotionModel, speeds};
use crate::body::{BodyModel, Layout, Motion};
use crate::math::rotation::right_jacobian_inverse;
use crate::solver::Link;

/// f: gait's limbs swing at one to two strides a second and seldom faster than twice that.
pub const SWING_HZ: f64 = 2.0;
/// a of the root along an axis, m/s².
pub const ROOT_ACCELERATION: f64 = 9.81;
/// a of the root about an axis, rad/s².
pub const ROOT_TURN_ACCELERATION: f64 = 13.3;

/// −log of the factors between neighbouring motions.
#[derive(Debug, Clone)]
pub struct ChainPrior {
    layout: Layout,
    /// What e² of an acceleration counts for each second, 1/q.
    acceleration: DVector<f64>,
    /// What e² of a velocity counts for each second.
    velocity: DVector<f64>,
    /// How many times each factor of accelerations counts.
    accelerations_count: f64,
    /// The same of velocities.
    velocities_count: f64,
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
        let layout = Layout::new(model);
        let speeds = speeds(model);
        // λ
        let renewal = |k: usize| match k.checked_sub(layout.root()) {
            Some(joint) => speeds[k] / model.joints[joint].spread,
            None => std::f64::consts::TAU * SWING_HZ,
        };
        let of_root = |acceleration: f64| acceleration.powi(2) / (std::f64::consts::PI * SWING_HZ);
        let density = |k: usize| match k.checked_sub(layout.root()) {
            Some(_) => 4.0 * renewal(k) * speeds[k].powi(2),
            None if k < 3 => of_root(ROOT_ACCELERATION),
            None => of_root(ROOT_TURN_ACCELERATION),
        };
        let n = speeds.len();
        Self {
            acceleration: DVector::from_fn(n, |k, _| 1.0 / density(k)),
            velocity: DVector::from_fn(n, |k, _| 0.5 * renewal(k) / speeds[k].powi(2)),
            accelerations_count: 1.0,
            velocities_count: 1.0,
            layout,
            motion_model,
        }
    }

    /// The same with factors that count so many times.
    pub(super) fn counting(&self, accelerations: f64, velocities: f64) -> Self {
        let (accelerations_count, velocities_count) = (accelerations, velocities);
        Self { accelerations_count, velocities_count, ..self.clone() }
    }

    /// How many times each factor of accelerations counts.
    pub(super) fn accelerations_count(&self) -> f64 {
        self.accelerations_count
    }

    /// q of each component.
    pub(super) fn densities(&self) -> DVector<f64> {
        self.acceleration.map(f64::recip)
    }

    /// The same with other densities of accelerations.
    pub(super) fn with_densities(&self, densities: &DVector<f64>) -> Self {
        Self { acceleration: densities.map(f64::recip), ..self.clone() }
    }

    /// How many frames before it a frame is coupled to.
    pub fn reach(&self) -> usize {
        match self.motion_model {
            MotionModel::ConstantPosition => 1,
            MotionModel::ConstantVelocity => 2,
        }
    }

    /// Sum of the factors whose last motion is that of frame `i`; `seconds[i]` lie between frames i − 1 and i,
    /// infinitely many where another trial begins.
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
        if i == 0 || seconds[i].is_infinite() {
            return Vec::new();
        }
        let last = self.velocity(&motions[i - 1], &motions[i], seconds[i]);
        let mut factors = Vec::with_capacity(2);
        if self.has_acceleration(seconds, i) {
            let before = self.velocity(&motions[i - 2], &motions[i - 1], seconds[i - 1]);
            let precision = &self.acceleration * (self.accelerations_count / between_s(seconds, i));
            factors.push(last.minus(&before, precision));
        }
        let precision = &self.velocity * (self.velocities_count * seconds[i]);
        factors.push(Factor { precision, ..last });
        factors
    }

    /// e of the acceleration whose last motion is that of frame `i`, and its Δ̄; `None` where there is none.
    pub(super) fn acceleration(
        &self,
        motions: &[Motion],
        seconds: &[f64],
        i: usize,
    ) -> Option<(DVector<f64>, f64)> {
        let velocity = |i: usize| self.velocity(&motions[i - 1], &motions[i], seconds[i]).residual;
        let has_one = self.has_acceleration(seconds, i);
        has_one.then(|| (velocity(i) - velocity(i - 1), between_s(seconds, i)))
    }

    fn has_acceleration(&self, seconds: &[f64], i: usize) -> bool {
        self.motion_model == MotionModel::ConstantVelocity
            && i > 1
            && seconds[i].is_finite()
            && seconds[i - 1].is_finite()
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

/// Δ̄, from the middle of one interval to that of the next.
fn between_s(seconds: &[f64], i: usize) -> f64 {
    0.5 * (seconds[i] + seconds[i - 1])
}

/// The components that are no rotation of the root.
fn straight(layout: Layout) -> impl Iterator<Item = usize> {
    (0..layout.motion()).filter(move |k| layout.root() == 0 || !(3..6).contains(k))
}
