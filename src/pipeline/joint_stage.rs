//! The joint optimum, and where and when the cameras are.

use std::collections::BTreeSet;

use super::camera_covariance::CameraCovariances;
use super::{EstimateOptions, Progress};
use crate::body::{BodyModel, Root};
use crate::camera::Rig;
use crate::inference::camera_offset::{CameraOffset, CameraPrior, Free};
use crate::inference::joint::{JointOptimum, JointOptions, joint_optimum_from_terms};
use crate::inference::{Evidence, Sequence, SequenceState};
use crate::likelihood::Measure;

/// What the last stage of a fit is given.
pub(super) struct JointStage<'a> {
    pub(super) model: &'a BodyModel,
    /// The cameras as they were calibrated.
    pub(super) calibrated: &'a Rig,
    pub(super) measure: Measure,
    pub(super) sequence: Sequence<'a>,
    pub(super) options: &'a EstimateOptions,
    pub(super) joint: &'a JointOptions,
    /// What of the cameras may be an unknown.
    pub(super) free: Free,
    /// By how many frames the pictures of each camera seem ahead.
    pub(super) ahead_frames: &'a [isize],
    pub(super) progress: &'a dyn Progress,
}

/// What the last stage found.
pub(super) struct Joined {
    pub(super) optimum: JointOptimum,
    /// What of the cameras was unknown.
    pub(super) prior: CameraPrior,
    /// How sure the cameras are together.
    pub(super) covariances: CameraCovariances,
}

impl JointStage<'_> {
    /// The optimum, and where and when the cameras are.
    ///
    /// Where there are detections, what their detector means by each joint is an unknown too; it is left out of what is returned.
    pub(super) fn run(&self, mut start: SequenceState) -> Joined {
        let Self { model, calibrated, measure, sequence, options, joint, .. } = *self;
        let detected = model.with_keypoints(&detected_names(sequence));
        let evidence = Evidence::new(&detected, calibrated, options.likelihood, measure);
        let prior = self.camera_prior(&start);
        if !prior.is_trusting() {
            let from = |camera: usize| CameraOffset {
                ahead_s: self.first_ahead_frames(&prior, camera) / sequence.fps,
                ..CameraOffset::none()
            };
            start.cameras = (0..self.ahead_frames.len()).map(from).collect();
        }

        let terms = evidence.sequence_terms(sequence, prior.clone());
        self.progress.begin("joint optimum", joint.most_steps());
        let step = || self.progress.step();
        let seconds = sequence.intervals_s();
        let optimum = joint_optimum_from_terms(&evidence, &terms, &seconds, start, joint, &step);
        let covariances = CameraCovariances::new(&prior, &optimum);
        self.progress.end();
        let optimum = optimum.of_first(model.coefficients.len());
        Joined { optimum, prior, covariances }
    }

    /// Where the estimate of a clock starts: whole frames, if the silhouettes tell them, or else what is known before.
    fn first_ahead_frames(&self, prior: &CameraPrior, camera: usize) -> f64 {
        let name = &self.calibrated.cameras[camera].name;
        let known = self.options.ahead_frames.get(name).copied().unwrap_or(0.0);
        match self.ahead_frames[camera] {
            frames if frames != 0 && prior.free(camera).clock => frames as f64,
            _ => known,
        }
    }

    /// What of the cameras is estimated; nothing where points were measured with them.
    fn camera_prior(&self, start: &SequenceState) -> CameraPrior {
        let has_points = self.sequence.frames.iter().any(|frame| !frame.points.is_empty());
        if has_points || self.model.root == Root::Fixed {
            return CameraPrior::trusting();
        }
        let interval_s = 1.0 / self.sequence.fps;
        CameraPrior::new(self.calibrated, start, self.free, interval_s)
    }
}

/// The names of all keypoints of a sequence.
fn detected_names(sequence: Sequence<'_>) -> Vec<&'static str> {
    let detections = sequence.frames.iter().flat_map(|frame| &frame.detections);
    let names = detections.flat_map(|(_, detection)| detection.keypoints.iter().map(|k| k.name));
    names.collect::<BTreeSet<_>>().into_iter().collect()
}
