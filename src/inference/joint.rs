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
use super::propagate::Sequence;
use super::sequence::{SequencePosterior, SequenceState};
use super::start::Detail;
use super::step::MotionModel;
use super::{Evidence, Terms};
use crate::body::{BodyModel, Motion, Posed, Shape};
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
        Self {
            iterations: 25,
            motion_model: MotionModel::ConstantVelocity,
        }
    }
}

/// The joint optimum.
#[derive(Debug, Clone)]
pub struct Joint {
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

impl Joint {
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
/// E of n frames of m components errs by √(nm/2) about its optimum under its own posterior, 65 for 200 frames of a
/// body; this fraction of it is a few units.
const TOLERANCE: f64 = 1e-4;

/// The joint optimum of a sequence, from a first shape and motion.
pub fn joint_optimum(
    evidence: &Evidence<'_>,
    sequence: Sequence<'_>,
    start: SequenceState,
    options: &JointOptions,
) -> Joint {
    let terms = terms(evidence, sequence);
    joint_optimum_of(evidence, &terms, &intervals(sequence), start, options)
}

/// What each frame of a sequence shows.
pub fn terms<'f>(evidence: &Evidence<'_>, sequence: Sequence<'f>) -> Vec<Terms<'f>> {
    let frames = sequence.frames.par_iter();
    frames.map(|f| evidence.terms(f, Detail::Fine)).collect()
}

/// The joint optimum of what each frame shows; `seconds[i]` lie between frames i − 1 and i.
pub fn joint_optimum_of<'a>(
    evidence: &Evidence<'_>,
    terms: &[Terms<'a>],
    seconds: &[f64],
    start: SequenceState,
    options: &JointOptions,
) -> Joint {
    let times: Vec<f64> = seconds
        .iter()
        .scan(0.0, |t, s| {
            *t += s;
            Some(*t)
        })
        .collect();
    let chain_prior = ChainPrior::new(evidence.model, options.motion_model);
    let solver = Options {
        max_iterations: options.iterations,
        damping: 1e-4,
        relative_decrease: TOLERANCE,
    };
    let posterior = |noise: &Noise| SequencePosterior {
        model: evidence.model,
        shape_prior: &evidence.shape_prior,
        shape_weight: noise.over_time,
        pose_prior: &evidence.pose_prior,
        chain_prior: &chain_prior,
        seconds,
        terms,
        data_weight: noise.data_weight(),
    };
    // 1. the optimum, every row as it is stated
    let stated = Noise::stated(terms.len());
    let solution = levenberg_marquardt(&posterior(&stated), start, &solver);
    // 2. how the residuals err there
    let residuals = residuals(evidence.model, terms, &solution.state);
    let noise = Noise::of(&residuals, &times, &evidence.model.part_pairs());
    // 3. how sure the optimum is, with rows that err so
    let sharp = posterior(&noise);
    let mut chain = solution.model;
    let considered = Considered::of(evidence.model, terms, &solution.state, &chain);
    chain.clear();
    sharp.linearize(&solution.state, &mut chain);
    let uncertainty = considered.and_then(|c| {
        Uncertainty::of(evidence.model, &solution.state, &chain, noise.over_time, &c)
    });
    let frames = sharp.taken_apart(&solution.state);
    Joint {
        shape: solution.state.shape,
        frames,
        noise,
        uncertainty,
        report: solution.report,
    }
}

/// The residuals of every frame at a state.
pub fn residuals(
    model: &BodyModel,
    terms: &[Terms<'_>],
    state: &SequenceState,
) -> Vec<Vec<PlacedResidual>> {
    let frames = terms.par_iter().zip(&state.motions);
    let of_frame = |(terms, motion): (&Terms<'_>, &Motion)| {
        let body = Posed::new(model, &state.shape, motion);
        terms
            .iter()
            .flat_map(|t| t.placed_residuals(&body))
            .collect()
    };
    frames.map(of_frame).collect()
}

/// Seconds from each frame's predecessor.
pub fn intervals(sequence: Sequence<'_>) -> Vec<f64> {
    let number = |i: usize| sequence.frames[i].frame.0;
    let before = |i: usize| number(i) - number(i.saturating_sub(1));
    (0..sequence.frames.len())
        .map(|i| before(i).max(1) as f64 / sequence.fps)
        .collect()
}
