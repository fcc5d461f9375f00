//! How sure the turns, displacements, focal lengths and clocks of all cameras are together.
//!
//! A turn and a displacement of one camera look alike, and a motion of all cameras together does not show: what several recordings
//! say of one rig can be put together only with the covariance of all its cameras. In the same way a time that all clocks are ahead does not
//! show, and how far one is ahead of another is known better than either. Both are blocks of the joint optimum's H⁻¹.

use nalgebra::DMatrix;

use crate::inference::camera_offset::{AHEAD, COMPONENTS, ZOOM};
use crate::inference::camera_prior::CameraPrior;
use crate::inference::joint::JointOptimum;

/// Components of a camera's pose: ω, δt, δζ.
pub const POSE: usize = AHEAD;

/// Covariances of all cameras together.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct CameraCovariances {
    /// Of the turns (rad), displacements (m) and logarithms of the focal lengths of the cameras whose poses were unknown, in the order of
    /// the rig; `None` where there are none, or they are not known.
    pub poses: Option<DMatrix<f64>>,
    /// The same of the times (s) by which those are ahead whose clocks were unknown.
    pub clocks: Option<DMatrix<f64>>,
}

/// Of turns and displacements alone: the covariance of poses without the focal lengths.
pub fn without_lenses(poses: &DMatrix<f64>) -> DMatrix<f64> {
    let kept: Vec<usize> = (0..poses.nrows()).filter(|k| k % POSE != ZOOM).collect();
    DMatrix::from_fn(kept.len(), kept.len(), |i, j| poses[(kept[i], kept[j])])
}

impl CameraCovariances {
    /// At the joint optimum.
    pub(super) fn new(prior: &CameraPrior, optimum: &JointOptimum) -> Self {
        let Some(uncertainty) = &optimum.uncertainty else {
            return Self::default();
        };
        let cameras = 0..optimum.cameras.len();
        let of_pose = |camera: usize| (0..POSE).map(move |k| COMPONENTS * camera + k);
        let with_pose = cameras.clone().filter(|camera| prior.free(*camera).pose);
        let poses: Vec<usize> = with_pose.flat_map(of_pose).collect();
        let with_clock = cameras.filter(|camera| prior.free(*camera).clock);
        let clocks: Vec<usize> = with_clock.map(|camera| COMPONENTS * camera + AHEAD).collect();

        let block = |components: &[usize]| {
            let of = |i: usize, j: usize| uncertainty.cameras[(components[i], components[j])];
            let n = components.len();
            (n > 0).then(|| DMatrix::from_fn(n, n, of))
        };
        Self { poses: block(&poses), clocks: block(&clocks) }
    }
}
