//! The joint optimum: every motion and the shape at once, and how sure each number is.
//!
//! ZS06 call the optimum of all of θ "technically intractable". With the shape as border, the Gauss–Newton
//! matrix of eq. 1 is block-tridiagonal (block-pentadiagonal with constant velocity), and a step is one pass
//! forwards and one backwards: O(n). Algorithm 1's winner is its start.

use nalgebra::{DMatrix, DVector, Matrix3};

use super::Evidence;
use super::chain::ChainPrior;
use super::propagate::Sequence;
use super::sequence::{SequencePosterior, SequenceState};
use super::start::Detail;
use super::step::MotionModel;
use crate::body::{BodyModel, Layout, Motion, Posed, Shape};
use crate::likelihood::Term;
use crate::solver::{BorderedChain, Marginal, Options, Report, levenberg_marquardt};

/// Settings of the joint optimum.
#[derive(Debug, Clone, Copy, PartialEq, serde::Serialize, serde::Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct JointOptions {
    /// Steps at most.
    pub iterations: usize,
    /// How a motion follows the others.
    pub motion_model: MotionModel,
    /// τ: how many times p(s) counts.
    pub shape_weight: f64,
}

impl Default for JointOptions {
    fn default() -> Self {
        Self {
            iterations: 25,
            motion_model: MotionModel::ConstantVelocity,
            shape_weight: 8.0,
        }
    }
}

/// The joint optimum.
#[derive(Debug, Clone)]
pub struct Joint {
    /// s.
    pub shape: Shape,
    /// m₁..ₙ.
    pub motions: Vec<Motion>,
    /// How sure they are; `None` where the matrix is singular.
    pub uncertainty: Option<Uncertainty>,
    /// How the optimisation went.
    pub report: Report,
}

/// Covariances of the joint optimum.
#[derive(Debug, Clone, PartialEq)]
pub struct Uncertainty {
    /// Covariance of s.
    pub shape: DMatrix<f64>,
    /// Frame by frame.
    pub frames: Vec<FrameUncertainty>,
}

/// Standard deviations of one frame.
#[derive(Debug, Clone, PartialEq)]
pub struct FrameUncertainty {
    /// Of the motion's components, in the order of [`Layout`].
    pub motion_sd: DVector<f64>,
    /// Covariance of each exported point, square metres.
    pub points: Vec<Matrix3<f64>>,
}

/// The joint optimum of a sequence, from a first shape and motion.
pub fn joint_optimum(
    evidence: &Evidence<'_>,
    sequence: Sequence<'_>,
    start: SequenceState,
    options: &JointOptions,
) -> Joint {
    let terms: Vec<Vec<Box<dyn Term + '_>>> = sequence
        .frames
        .iter()
        .map(|f| evidence.terms(f, Detail::Fine))
        .collect();
    let seconds = intervals(sequence);
    let posterior = SequencePosterior {
        model: evidence.model,
        shape_prior: &evidence.shape_prior,
        shape_weight: options.shape_weight,
        pose_prior: &evidence.pose_prior,
        chain_prior: &ChainPrior::new(evidence.model, options.motion_model),
        seconds: &seconds,
        terms: &terms,
        data_weight: 1.0,
    };
    let solver = Options {
        max_iterations: options.iterations,
        damping: 1e-4,
        relative_decrease: 1e-5,
    };
    let solution = levenberg_marquardt(&posterior, start, &solver);
    let uncertainty = uncertainty(
        evidence.model,
        &solution.state,
        &solution.model,
        options.shape_weight,
    );
    Joint {
        shape: solution.state.shape,
        motions: solution.state.motions,
        uncertainty,
        report: solution.report,
    }
}

/// Seconds from each frame's predecessor.
pub fn intervals(sequence: Sequence<'_>) -> Vec<f64> {
    let number = |i: usize| sequence.frames[i].frame.0;
    let before = |i: usize| number(i) - number(i.saturating_sub(1));
    (0..sequence.frames.len())
        .map(|i| before(i).max(1) as f64 / sequence.fps)
        .collect()
}

/// Covariances from H⁻¹, with the shape's widened τ times:
/// cov(s) = τ Σ_ss, and as m depends on s through G = Σ_ms Σ_ss⁻¹, cov(m) = Σ_mm + (τ − 1)·G Σ_ss Gᵀ.
fn uncertainty(
    model: &BodyModel,
    state: &SequenceState,
    chain: &BorderedChain,
    tau: f64,
) -> Option<Uncertainty> {
    let mut frames = Vec::new();
    let mut shape = DMatrix::zeros(0, 0);
    let complete = chain.marginals(|i, marginal| {
        shape = marginal.shared * tau;
        let body = Posed::new(model, &state.shape, &state.motions[i]);
        frames.extend(frame_uncertainty(&body, marginal, tau));
    });
    frames.reverse();
    (complete && frames.len() == state.motions.len()).then_some(Uncertainty { shape, frames })
}

fn frame_uncertainty(
    body: &Posed<'_>,
    marginal: &Marginal<'_>,
    tau: f64,
) -> Option<FrameUncertainty> {
    let layout = Layout::of(body.model);
    let (m, p) = (layout.motion(), layout.total() - layout.motion());
    let mut motion = marginal.frame.clone();
    if p > 0 {
        let depends = marginal.shared.clone().cholesky()?.solve(marginal.cross);
        motion += marginal.cross.tr_mul(&depends) * (tau - 1.0);
    }
    let mut all = DMatrix::zeros(m + p, m + p);
    all.view_mut((0, 0), (m, m)).copy_from(&motion);
    all.view_mut((m, 0), (p, m))
        .copy_from(&(marginal.cross * tau));
    all.view_mut((m, m), (p, p))
        .copy_from(&(marginal.shared * tau));
    all.fill_upper_triangle_with_lower_triangle();
    let point = |index: usize| {
        let jacobian = body.point_jacobian(index);
        let covariance = &jacobian * &all * jacobian.transpose();
        covariance.fixed_view::<3, 3>(0, 0).into_owned()
    };
    Some(FrameUncertainty {
        motion_sd: motion.diagonal().map(|v| v.max(0.0).sqrt()),
        points: (0..body.model.points.len()).map(point).collect(),
    })
}
