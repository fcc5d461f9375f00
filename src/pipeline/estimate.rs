//! The most probable shape and motion: the joint optimum that is reached from the winner of Algorithm 1.

use super::camera_found::CameraFound;
use super::joint_stage::JointStage;
use super::measures::Measures;
use super::{EstimateOptions, Progress};
use crate::body::{BodyModel, Layout, Motion, Shape};
use crate::camera::Rig;
use crate::inference::SequenceState;
use crate::inference::camera_offset::{CameraOffset, CameraPrior};
use crate::inference::covariance::Uncertainty;
use crate::inference::frame::FrameFit;
use crate::inference::joint::JointOptimum;
use crate::inference::noise::Noise;
use crate::inference::search::Trial;
use crate::inference::step::between;
use crate::inference::{Evidence, Sequence};
use crate::likelihood::Measure;

/// What the last stage of a fit is given.
pub(super) struct LastStage<'a> {
    /// The body before the cameras as they are calibrated.
    pub(super) evidence: &'a Evidence<'a>,
    pub(super) sequence: Sequence<'a>,
    pub(super) measures: Measures,
    pub(super) options: &'a EstimateOptions,
    /// By how many frames the pictures of each camera seem ahead.
    pub(super) ahead_frames: &'a [isize],
    pub(super) progress: &'a dyn Progress,
}

impl LastStage<'_> {
    /// The joint optimum, or the winner where none is asked for, and what it was compared by.
    pub(super) fn run(&self, winner: &Trial) -> (Estimate, Measure) {
        let Evidence { model, rig, .. } = *self.evidence;
        let Some(joint) = &self.options.joint else {
            return (Estimate::tracked(winner, rig), self.measures.search);
        };

        let measure = self.measures.joint;
        let stage = JointStage {
            model,
            calibrated: rig,
            measure,
            sequence: self.sequence,
            options: self.options,
            joint,
            ahead_frames: self.ahead_frames,
            progress: self.progress,
        };
        let (optimum, camera_prior) = stage.run(state_of(model, self.sequence, winner));
        (Estimate::joint(optimum, &camera_prior, rig, winner), measure)
    }
}

/// The most probable shape and motion, of the last stage.
pub(super) struct Estimate {
    pub(super) shape: Shape,
    pub(super) frames: Vec<FrameFit>,
    pub(super) noise: Option<Noise>,
    pub(super) uncertainty: Option<Uncertainty>,
    /// The cameras where they were found to be.
    pub(super) rig: Rig,
    /// By how much each is off.
    pub(super) cameras: Vec<CameraFound>,
}

impl Estimate {
    /// How often the data's cost counts.
    pub(super) fn data_weight(&self) -> f64 {
        self.noise.map_or(1.0, |noise| noise.data_weight())
    }

    /// The winner as it was tracked.
    fn tracked(winner: &Trial, rig: &Rig) -> Self {
        Self {
            shape: winner.hypothesis.shape.clone(),
            frames: winner.frames.iter().flatten().cloned().collect(),
            noise: None,
            uncertainty: None,
            rig: rig.clone(),
            cameras: vec![CameraFound::default(); rig.cameras.len()],
        }
    }

    /// The joint optimum that is reached from the winner.
    fn joint(
        joint: JointOptimum,
        camera_prior: &CameraPrior,
        calibrated: &Rig,
        winner: &Trial,
    ) -> Self {
        let found = |camera: usize| {
            let sd = joint.uncertainty.as_ref().and_then(|u| u.cameras.get(camera));
            let offset = joint.cameras.get(camera);
            let found = |offset| CameraFound::new(offset, camera_prior.free(camera), sd);
            offset.map(found).unwrap_or_default()
        };
        let cameras: Vec<CameraFound> = (0..calibrated.cameras.len()).map(found).collect();

        // what Algorithm 1 had to search anew is still told
        let frames = joint.frames.into_iter().zip(winner.frames.iter().flatten());
        let frames = frames.map(|(fit, tracked)| FrameFit { recovered: tracked.recovered, ..fit });
        Self {
            shape: joint.shape,
            frames: frames.collect(),
            noise: Some(joint.noise),
            uncertainty: joint.uncertainty,
            rig: CameraOffset::applied(calibrated, cameras.iter().map(CameraFound::offset)),
            cameras,
        }
    }
}

/// The winner as it was tracked, and evenly from one pose to the next where nothing was seen between.
fn state_of(model: &BodyModel, sequence: Sequence<'_>, winner: &Trial) -> SequenceState {
    let tracked = winner.frames.iter().flatten();
    let mut motions: Vec<Motion> = tracked.map(|fit| fit.motion.clone()).collect();

    let seen = |i: &usize| sequence.frames[*i].is_observed();
    let seen: Vec<usize> = (0..motions.len()).filter(seen).collect();
    for ends in seen.windows(2) {
        let (from, to) = (ends[0], ends[1]);
        for i in from + 1..to {
            let part = sequence.frames_between(from, i) / sequence.frames_between(from, to);
            motions[i] = between(Layout::new(model), &motions[from], &motions[to], part);
        }
    }
    SequenceState::new(winner.hypothesis.shape.clone(), motions)
}
