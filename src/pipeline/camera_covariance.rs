//! How sure the turns, displacements and clocks of all cameras are together.
//!
//! A turn and a displacement of one camera look alike, and a motion of all cameras together does not show: what several recordings
//! say of one rig can be put together only with the covariance of all its cameras. In the same way a time that all clocks are ahead does not
//! show, and how far one is ahead of another is known better than either. It is the block of H⁻¹ that belongs to them,
//! with H of the sequence posterior at the joint optimum, whose noise, body, motions and clocks it leaves free.
//!
//! The shape's prior is the model's here, and the joint optimum's has the spread of the surface that it found; so only the correlations
//! are taken from this block, and the standard deviations from the joint optimum:
//!
//! Σ_ij = sd_i sd_j (H⁻¹)_ij/√((H⁻¹)_ii (H⁻¹)_jj).

use nalgebra::DMatrix;

use crate::inference::camera_offset::{AHEAD, COMPONENTS};
use crate::inference::chain::ChainPrior;
use crate::inference::contrasts::Contrasts;
use crate::inference::joint::{JointOptimum, JointOptions};
use crate::inference::sequence_posterior::SequencePosterior;
use crate::inference::{Evidence, Look, SequenceTerms};
use crate::solver::Problem;

/// Components of a camera's pose: ω, δt.
pub const POSE: usize = 6;

/// Covariances of all cameras together.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct CameraCovariances {
    /// Of the turns (rad) and displacements (m) of the cameras whose poses were unknown, in the order of the rig; `None` where there are
    /// none, or they are not known.
    pub poses: Option<DMatrix<f64>>,
    /// The same of the times (s) by which those are ahead whose clocks were unknown.
    pub clocks: Option<DMatrix<f64>>,
}

impl CameraCovariances {
    /// At the joint optimum.
    pub(super) fn new(
        evidence: &Evidence<'_>,
        terms: &SequenceTerms<'_>,
        seconds: &[f64],
        options: &JointOptions,
        optimum: &JointOptimum,
    ) -> Self {
        let prior = &terms.camera_prior;
        let cameras = 0..optimum.cameras.len();
        let of_pose = |camera: usize| (0..POSE).map(move |k| (camera, k));
        let with_pose = cameras.clone().filter(|camera| prior.free(*camera).pose);
        let poses: Vec<(usize, usize)> = with_pose.flat_map(of_pose).collect();
        let with_clock = cameras.filter(|camera| prior.free(*camera).clock);
        let clocks: Vec<(usize, usize)> = with_clock.map(|camera| (camera, AHEAD)).collect();
        let is_known = !prior.is_trusting() && optimum.uncertainty.is_some();
        let shared = is_known.then(|| shared(evidence, terms, seconds, options, optimum));

        let shape = optimum.shape.0.len();
        let block = |components: &[(usize, usize)]| {
            let shared = shared.as_ref()?.as_ref()?;
            let sd = |(camera, k): (usize, usize)| {
                Some(optimum.uncertainty.as_ref()?.cameras[camera][k])
            };
            let sds: Option<Vec<f64>> = components.iter().copied().map(sd).collect();
            let at = |i: usize| shape + COMPONENTS * components[i].0 + components[i].1;
            let sds = sds.filter(|sds| !sds.is_empty())?;
            let of = |i: usize, j: usize| {
                let by = shared[(at(i), at(i))] * shared[(at(j), at(j))];
                if by > 0.0 { sds[i] * sds[j] * shared[(at(i), at(j))] / by.sqrt() } else { 0.0 }
            };
            Some(DMatrix::from_fn(sds.len(), sds.len(), of))
        };
        Self { poses: block(&poses), clocks: block(&clocks) }
    }
}

/// The block of H⁻¹ that the frames share, at the optimum; `None` where H is singular.
fn shared(
    evidence: &Evidence<'_>,
    terms: &SequenceTerms<'_>,
    seconds: &[f64],
    options: &JointOptions,
    optimum: &JointOptimum,
) -> Option<DMatrix<f64>> {
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
    let mut chain = posterior.empty_model();
    posterior.linearize(&optimum.state(), &mut chain);
    chain.shared_covariance()
}
