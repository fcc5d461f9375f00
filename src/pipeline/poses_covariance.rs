//! How sure the turns and displacements of all cameras are together.
//!
//! A turn and a displacement of one camera look alike, and a motion of all cameras together does not show: what several recordings
//! say of one rig can be put together only with the covariance of all its cameras. It is the block of H⁻¹ that belongs to them,
//! with H of the sequence posterior at the joint optimum, whose noise, body, motions and clocks it leaves free.
//!
//! The shape's prior is the model's here, and the joint optimum's has the spread of the surface that it found; so only the correlations
//! are taken from this block, and the standard deviations from the joint optimum:
//!
//! Σ_ij = sd_i sd_j (H⁻¹)_ij/√((H⁻¹)_ii (H⁻¹)_jj).

use nalgebra::DMatrix;

use crate::inference::camera_offset::COMPONENTS;
use crate::inference::chain::ChainPrior;
use crate::inference::contrasts::Contrasts;
use crate::inference::joint::{JointOptimum, JointOptions};
use crate::inference::sequence_posterior::SequencePosterior;
use crate::inference::{Evidence, Look, SequenceTerms};
use crate::solver::Problem;

/// Components of a camera's pose: ω, δt.
pub const POSE: usize = 6;

/// Covariance of the turns (rad) and displacements (m) of the cameras whose poses were unknown, in the order of the rig; `None` where
/// there are none, or they are not known.
pub(super) fn poses_covariance(
    evidence: &Evidence<'_>,
    terms: &SequenceTerms<'_>,
    seconds: &[f64],
    options: &JointOptions,
    optimum: &JointOptimum,
) -> Option<DMatrix<f64>> {
    let free = |camera: &usize| terms.camera_prior.free(*camera).pose;
    let cameras: Vec<usize> = (0..optimum.cameras.len()).filter(free).collect();
    let uncertainty = optimum.uncertainty.as_ref().filter(|_| !cameras.is_empty())?;

    // H at the optimum
    let looks: Vec<Vec<&Look<'_>>> = terms.all.iter().map(|looks| looks.iter().collect()).collect();
    let posterior = SequencePosterior {
        model: evidence.model,
        rig: evidence.rig,
        camera_prior: &terms.camera_prior,
        shape_prior: &evidence.shape_prior,
        pose_prior: &evidence.pose_prior,
        chain_prior: &ChainPrior::new(evidence.model, options.motion_model),
        seconds,
        looks: &looks,
        data_weight: optimum.noise.data_weight(),
        contrasts: &Contrasts::none(looks.len()),
    };
    let state = optimum.state();
    let mut chain = posterior.empty_model();
    posterior.linearize(&state, &mut chain);
    let shared = chain.shared_covariance()?;

    // its block of the poses, with the standard deviations of the optimum
    let shape = state.shape.0.len();
    let place = |i: usize| (cameras[i / POSE], i % POSE);
    let at = |i: usize| shape + COMPONENTS * place(i).0 + place(i).1;
    let sd = |i: usize| uncertainty.cameras[place(i).0][place(i).1];
    let of = |i: usize, j: usize| {
        let by = shared[(at(i), at(i))] * shared[(at(j), at(j))];
        if by > 0.0 { sd(i) * sd(j) * shared[(at(i), at(j))] / by.sqrt() } else { 0.0 }
    };
    Some(DMatrix::from_fn(POSE * cameras.len(), POSE * cameras.len(), of))
}
