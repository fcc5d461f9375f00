//! The joint optimum: every motion and the shape at once, and how sure each number is.
//!
//! ZS06 call the optimum of all of θ "technically intractable". With the shape as border, the Gauss–Newton
//! matrix of eq. 1 is block-tridiagonal (block-pentadiagonal with constant velocity), and a step is one pass
//! forwards and one backwards: O(n). Algorithm 1's winner is its start.

use rayon::prelude::*;

use super::chain::ChainPrior;
use super::considered::Considered;
use super::covariance::Uncertainty;
use super::frame::FrameFit;
use super::noise::Noise;
use super::sequence_posterior::{SequencePosterior, SequenceState};
use super::step::MotionModel;
use super::{Evidence, Sequence, Terms};
use crate::body::{BodyModel, Posed, Shape};
use crate::likelihood::PlacedResidual;
use crate::solver::{Options, Problem, QuadraticModel, Report, levenberg_marquardt};

/// Settings of the joint optimum.
#[derive(Debug, Clone, Copy, PartialEq, serde::Serialize, serde::Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct JointOptions {
    /// Steps at most.
    pub iterations: usize,
    /// How a motion follows the others.
    pub motion_model: MotionModel,
}

impl Default for JointOptions {
    fn default() -> Self {
        Self { iterations: 25, motion_model: MotionModel::ConstantVelocity }
    }
}

/// The joint optimum.
#[derive(Debug, Clone)]
pub struct JointOptimum {
    /// s.
    pub shape: Shape,
    /// m₁..ₙ and what each costs.
    pub frames: Vec<FrameFit>,
    /// How the residuals err.
    pub noise: Noise,
    /// How sure they are; `None` where the matrix is singular.
    pub uncertainty: Option<Uncertainty>,
    /// How the optimisation went.
    pub report: Report,
}

impl JointOptimum {
    /// s and m₁..ₙ.
    pub fn state(&self) -> SequenceState {
        SequenceState {
            shape: self.shape.clone(),
            motions: self.frames.iter().map(|f| f.motion.clone()).collect(),
        }
    }
}

/// The fraction of E below which a step's decrease ends the optimisation.
///
/// Under its own posterior, E of n frames of m components has a standard deviation of √(nm/2), 65 for 200 frames of a
/// body; this fraction of E is a few units.
const TOLERANCE: f64 = 1e-4;

/// The joint optimum of a sequence, from a first shape and motion.
pub fn joint_optimum(
    evidence: &Evidence<'_>,
    sequence: Sequence<'_>,
    start: SequenceState,
    options: &JointOptions,
) -> JointOptimum {
    let terms = evidence.sequence_terms(sequence);
    joint_optimum_from_terms(evidence, &terms, &sequence.intervals_s(), start, options)
}

/// The joint optimum of what each frame shows; `seconds[i]` lie between frames i − 1 and i.
pub fn joint_optimum_from_terms<'a>(
    evidence: &Evidence<'_>,
    terms: &[Terms<'a>],
    seconds: &[f64],
    start: SequenceState,
    options: &JointOptions,
) -> JointOptimum {
    let model = evidence.model;
    let chain_prior = ChainPrior::new(model, options.motion_model);
    let posterior = |noise: &Noise| SequencePosterior {
        model,
        shape_prior: &evidence.shape_prior,
        shape_weight: noise.over_time,
        pose_prior: &evidence.pose_prior,
        chain_prior: &chain_prior,
        seconds,
        terms,
        data_weight: noise.data_weight(),
    };

    // 1. the optimum, with every row's σ and weight as stated
    let solver =
        Options { max_iterations: options.iterations, damping: 1e-4, relative_decrease: TOLERANCE };
    let stated = posterior(&Noise::stated(terms.len()));
    let solution = levenberg_marquardt(&stated, start, &solver);
    let (optimum, mut chain) = (solution.state, solution.model);

    // 2. how the residuals err there
    let residuals = residuals(model, terms, &optimum);
    let noise = Noise::from_residuals(&residuals, &times(seconds), &model.part_pairs());

    // 3. how sure the optimum is, with residuals that err so
    let weighed = posterior(&noise);
    let considered = Considered::new(model, terms, &optimum, &chain);
    chain.clear();
    weighed.linearize(&optimum, &mut chain);
    let uncertainty =
        considered.and_then(|c| Uncertainty::new(model, &optimum, &chain, noise.over_time, &c));

    JointOptimum {
        frames: weighed.frame_fits(&optimum),
        shape: optimum.shape,
        noise,
        uncertainty,
        report: solution.report,
    }
}

/// Seconds from the start, frame by frame.
fn times(seconds: &[f64]) -> Vec<f64> {
    let sums = seconds.iter().scan(0.0, |time, interval| {
        *time += interval;
        Some(*time)
    });
    sums.collect()
}

/// The residuals of every frame at a state.
pub fn residuals(
    model: &BodyModel,
    terms: &[Terms<'_>],
    state: &SequenceState,
) -> Vec<Vec<PlacedResidual>> {
    let frames = terms.par_iter().zip(&state.motions);
    let residuals = frames.map(|(terms, motion)| {
        let body = Posed::new(model, &state.shape, motion);
        let residuals = terms.iter().flat_map(|t| t.placed_residuals(&body));
        residuals.collect()
    });
    residuals.collect()
}
