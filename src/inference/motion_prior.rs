//! p(m₁..ₙ): what is known of a motion before any data, and how often it counts beside data that repeat.
//!
//! −log p(m₁..ₙ) = Σᵢ of limits and rest ([`PosePrior`]) and of how each motion follows the ones before ([`ChainPrior`]), a process in
//! continuous time: every second adds the same.
//!
//! # Long recordings, and many of them
//! What a surface has that the model has not stays at its place, so T seconds of outlines are worth little more than those of a
//! second: they count 1/(κ²λτ), τ ∝ T ([`Noise`](super::noise::Noise)). A prior that counts every second would in the end be all that the
//! motion follows, and angles would be drawn to rest. But what a frame shows of its motion does not depend on how long it was recorded. So the prior
//! counts ω = τ_W/τ, τ_W the looks of W seconds at one place that are worth one:
//!
//! E = −log p(s) − log p(c) + Σᵢ Dᵢ/(κ²λτ) − ω log p(m₁..ₙ),  τ_W = τ₁ + (τ − τ₁) W/T
//!
//! for T > W, and ω = 1 otherwise. Divided by ω, a motion is weighed as in a recording of W seconds; what is known of s counts once. T is the time of all
//! trials of a session.
//!
//! *Accelerations count τ₁/τ.* What errs alike in all frames does not accelerate. What is left of the data's errors is what passes, κ²λτ₁, and the
//! data count τ₁/τ of that. So, divided by τ₁/τ, accelerations and what is seen of them are weighed as they are, and the density of
//! accelerations can be told from the recording (`accelerations.rs`).
//!
//! # Source
//! Weights of what repeats: Varin, Reid & Firth 2011, *An overview of composite likelihood methods*, § 2.

use nalgebra::DMatrix;

use super::accelerations;
use super::chain::ChainPrior;
use super::prior::PosePrior;
use super::step::MotionModel;
use crate::body::{BodyModel, Layout, Motion};
use crate::solver::{BorderedChain, Link, NormalEquations};

/// W: two strides. Simulated persons of other makes err alike with two to six seconds, and more with one (docs/decisions, 0033).
const REPEATS_AFTER_S: f64 = 2.0;

/// −log p(m₁..ₙ).
#[derive(Debug, Clone)]
pub struct MotionPrior {
    pose: PosePrior,
    chain: ChainPrior,
    layout: Layout,
    /// ω.
    counts: f64,
}

impl MotionPrior {
    /// Of a model's motions; it counts once.
    pub fn new(model: &BodyModel, motion_model: MotionModel) -> Self {
        Self {
            pose: PosePrior::new(model),
            chain: ChainPrior::new(model, motion_model),
            layout: Layout::new(model),
            counts: 1.0,
        }
    }

    /// The same beside data of which a share stays from frame to frame ([`Noise::staying_share`](super::noise::Noise::staying_share)); `seconds[i]`
    /// lie between frames i − 1 and i.
    #[must_use]
    pub fn beside(&self, staying_share: f64, seconds: &[f64]) -> Self {
        // T, in which a pause counts W at most
        let between = seconds.iter().skip(1).filter(|interval_s| interval_s.is_finite());
        let lasts_s: f64 = between.map(|interval_s| interval_s.min(REPEATS_AFTER_S)).sum();
        let of_window = REPEATS_AFTER_S / lasts_s.max(REPEATS_AFTER_S);
        let counts = 1.0 - staying_share * (1.0 - of_window);
        Self { counts, chain: self.chain.counting(1.0 - staying_share, counts), ..self.clone() }
    }

    /// The same with the densities of accelerations that a recording tells.
    ///
    /// `used` is the prior of its optimum, this one has the published densities, and `given` is the optimum's H.
    #[must_use]
    pub(super) fn with_accelerations_of(
        &self,
        used: &Self,
        (motions, seconds): (&[Motion], &[f64]),
        given: &BorderedChain,
    ) -> Self {
        let chains = [&given.of_frames(), &used.alone(motions, seconds)];
        let priors = [&self.chain, &used.chain];
        let found = accelerations::densities(priors, (motions, seconds), chains);
        let chain = found.map(|densities| self.chain.with_densities(&densities));
        Self { chain: chain.unwrap_or_else(|| self.chain.clone()), ..self.clone() }
    }

    /// How many frames before it a frame is coupled to.
    pub fn reach(&self) -> usize {
        self.chain.reach()
    }

    /// −log p(m₁..ₙ), `seconds[i]` from the frame before, infinitely many where another trial begins.
    pub fn cost(&self, motions: &[Motion], seconds: &[f64]) -> f64 {
        let of_frame = |i| {
            let (pose, step) = self.costs(motions, seconds, i);
            pose + step
        };
        (0..motions.len()).map(of_frame).sum()
    }

    /// What one motion costs, and how it follows the ones before.
    pub fn costs(&self, motions: &[Motion], seconds: &[f64], i: usize) -> (f64, f64) {
        let pose = self.counts * self.pose.cost_lasting(&motions[i], lasts_s(seconds, i));
        (pose, self.chain.cost(motions, seconds, i))
    }

    /// Adds gradient and Hessian of all motions.
    pub fn linearize(&self, motions: &[Motion], seconds: &[f64], links: &mut [Link]) -> f64 {
        let m = self.layout.motion();
        let mut equations = NormalEquations::zeros(m);
        let mut cost = 0.0;
        for (i, motion) in motions.iter().enumerate() {
            // limits and rest
            equations.hessian.fill(0.0);
            equations.gradient.fill(0.0);
            let pose = self.pose.linearize_lasting(motion, lasts_s(seconds, i), &mut equations);
            cost += self.counts * pose;
            links[i].diagonal += self.counts * &equations.hessian;
            links[i].gradient += self.counts * &equations.gradient;
            // how it follows the ones before
            cost += self.chain.linearize(motions, seconds, i, links);
        }
        cost
    }

    /// H of the priors alone. Nothing but data holds the root, so it is held here: no angle depends on it in the priors.
    pub fn alone(&self, motions: &[Motion], seconds: &[f64]) -> BorderedChain {
        let mut chain = BorderedChain::zeros(motions.len(), self.layout.motion(), 0, self.reach());
        self.linearize(motions, seconds, &mut chain.links);
        for link in &mut chain.links {
            (0..self.layout.root()).for_each(|k| link.diagonal[(k, k)] += 1.0);
        }
        chain
    }

    /// The precision of one motion about a pose: limits and rest, once.
    pub(super) fn precision(&self, motion: &Motion) -> DMatrix<f64> {
        let mut equations = NormalEquations::zeros(self.layout.motion());
        self.pose.linearize(motion, &mut equations);
        equations.hessian
    }
}

/// How long a frame lasts; the first frame's pose is drawn from all.
fn lasts_s(seconds: &[f64], i: usize) -> f64 {
    if i == 0 { f64::INFINITY } else { seconds[i] }
}
