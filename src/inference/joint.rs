//! The joint optimum: every motion and the shape at once, and how sure each number is.
//!
//! ZS06 call the optimum of all of θ "technically intractable". With the shape as border, the Gauss–Newton
//! matrix of eq. 1 is block-tridiagonal (block-pentadiagonal with constant velocity), and a step is one pass
//! forwards and one backwards: O(n). Algorithm 1's winner is its start.

use nalgebra::{Cholesky, DMatrix, DVector, Dyn, Matrix3, Vector3};
use rayon::prelude::*;

use super::Evidence;
use super::chain::ChainPrior;
use super::noise::Noise;
use super::propagate::{FrameFit, Sequence};
use super::sequence::{SequencePosterior, SequenceState};
use super::start::Detail;
use super::step::MotionModel;
use crate::body::{BodyModel, Layout, Motion, PartId, Posed, Shape};
use crate::likelihood::{PlacedResidual, Term};
use crate::solver::{
    BorderedChain, Marginal, Options, Problem, QuadraticModel, Report, levenberg_marquardt,
};

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
    /// Of the root's origin, world axes; 0 if it is fixed.
    pub position_sd_m: Vector3<f64>,
    /// Of the orientation in the world of each part, about its own axes; 0 of one that nothing turns.
    pub parts_sd: Vec<Vector3<f64>>,
    /// Of the angles between the bones: the flesh's, with what the places of the joints in it leave open, see
    /// [`Posed::angle_spread`].
    pub angles_sd: DVector<f64>,
    /// Of the same angles as the flesh has them, which is what is seen.
    pub flesh_angles_sd: DVector<f64>,
    /// Covariance of each exported point, square metres: the estimate's, and of where it lies in the flesh.
    pub points: Vec<Matrix3<f64>>,
    /// Covariance of the way from the left to the right point of each of [`BodyModel::point_pairs`], square metres.
    pub apart: Vec<Matrix3<f64>>,
}

/// The fraction of E below which a step's decrease ends the optimisation.
///
/// E of n frames of m components errs by √(nm/2) about its optimum under its own posterior, 65 for 200 frames of a
/// body; this fraction of it is a few units.
const TOLERANCE: f64 = 1e-4;

/// What one frame shows, as terms of −log p(Zᵢ | mᵢ, s).
pub type Terms<'a> = Vec<Box<dyn Term + 'a>>;

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
    chain.clear();
    sharp.linearize(&solution.state, &mut chain);
    let uncertainty = uncertainty(evidence.model, &solution.state, &chain, noise.over_time);
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
    let mut factor = None;
    let complete = chain.marginals(|i, marginal| {
        // the same in every frame
        let factor = factor.get_or_insert_with(|| {
            shape = marginal.shared * tau;
            marginal.shared.clone().cholesky()
        });
        let body = Posed::new(model, &state.shape, &state.motions[i]);
        frames.extend(frame_uncertainty(&body, marginal, factor.as_ref(), tau));
    });
    frames.reverse();
    (complete && frames.len() == state.motions.len()).then_some(Uncertainty { shape, frames })
}

fn frame_uncertainty(
    body: &Posed<'_>,
    marginal: &Marginal<'_>,
    shared: Option<&Cholesky<f64, Dyn>>,
    tau: f64,
) -> Option<FrameUncertainty> {
    let layout = Layout::of(body.model);
    let (m, p) = (layout.motion(), layout.total() - layout.motion());
    let mut motion = marginal.frame.clone();
    if p > 0 {
        let depends = shared?.solve(marginal.cross);
        motion += marginal.cross.tr_mul(&depends) * (tau - 1.0);
    }
    let mut all = DMatrix::zeros(m + p, m + p);
    all.view_mut((0, 0), (m, m)).copy_from(&motion);
    all.view_mut((m, 0), (p, m))
        .copy_from(&(marginal.cross * tau));
    all.view_mut((m, m), (p, p))
        .copy_from(&(marginal.shared * tau));
    all.fill_upper_triangle_with_lower_triangle();
    let variances = motion.diagonal().map(|v| v.max(0.0));
    let of_flesh = variances.rows(layout.root(), m - layout.root());
    let angles_sd = (of_flesh + body.angle_spread()).map(f64::sqrt);
    let position_sd_m = match layout.root() {
        6 => Vector3::from(variances.fixed_rows::<3>(0)).map(f64::sqrt),
        _ => Vector3::zeros(),
    };
    let carried = |jacobian: &DMatrix<f64>| {
        let covariance = jacobian * &all * jacobian.transpose();
        Matrix3::from(covariance.fixed_view::<3, 3>(0, 0))
    };
    let point = |index: usize| carried(&body.point_jacobian(index)) + body.point_spread(index);
    let apart = |(right, left): (usize, usize)| {
        let moved = body.point_jacobian(right) - body.point_jacobian(left);
        carried(&moved) + body.way_spread(right, left)
    };
    let turned = |part: usize| carried(&body.rotation_jacobian(PartId(part))).diagonal();
    let parts = (0..body.model.parts.len()).map(turned);
    Some(FrameUncertainty {
        position_sd_m,
        parts_sd: parts.map(|v| v.map(|v| v.max(0.0).sqrt())).collect(),
        angles_sd,
        flesh_angles_sd: of_flesh.map(f64::sqrt),
        points: (0..body.model.points.len()).map(point).collect(),
        apart: body.model.point_pairs().into_iter().map(apart).collect(),
    })
}
