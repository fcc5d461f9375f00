//! The most probable shape and motion: the joint optimum that is reached from the winner of Algorithm 1.

use rayon::prelude::*;

use super::camera_covariance::CameraCovariances;
use super::camera_found::{CameraFound, PoseFound};
use super::detected::detection_qualities;
use super::diagnosis::CameraFaults;
use super::fitted::FittedFrame;
use super::joint_stage::{Joined, JointStage};
use super::measures::Measures;
use super::{CameraQuality, EstimateOptions, Progress, points, quality};
use crate::body::{BodyModel, Layout, Motion, Posed, Shape};
use crate::camera::{Camera, CameraId, Rig};
use crate::inference::SequenceState;
use crate::inference::camera_offset::CameraOffset;
use crate::inference::camera_prior::Free;
use crate::inference::covariance::Uncertainty;
use crate::inference::frame::FrameFit;
use crate::inference::instant::times_s;
use crate::inference::joint::JointOptions;
use crate::inference::motion_prior::MotionPrior;
use crate::inference::noise::Noise;
use crate::inference::search::Trial;
use crate::inference::step::between;
use crate::inference::{Evidence, Sequence};
use crate::likelihood::Measure;
use crate::silhouette::FrameObservations;

/// What the last stage of a fit is given.
#[derive(Clone, Copy)]
pub(super) struct LastStage<'a> {
    /// The body before the cameras as they are calibrated.
    pub(super) evidence: &'a Evidence<'a>,
    pub(super) sequence: Sequence<'a>,
    pub(super) measures: Measures,
    pub(super) options: &'a EstimateOptions,
    /// What silhouettes alone say of the cameras.
    pub(super) faults: &'a CameraFaults,
    pub(super) progress: &'a dyn Progress,
}

/// Where the joint optimum is sought from.
#[derive(Debug, Clone)]
pub(super) struct Start {
    state: SequenceState,
    /// The frames that Algorithm 1 lost and found again.
    recovered: Vec<bool>,
}

impl Start {
    /// The winner as it was tracked.
    pub(super) fn of_winner(stage: &LastStage<'_>, winner: &Trial) -> Self {
        let tracked = winner.frames.iter().flatten();
        let recovered = tracked.map(|tracked| tracked.recovered).collect();
        Self { state: state_of(stage.evidence.model, stage.sequence, winner), recovered }
    }

    /// The same with the motion of another optimum.
    pub(super) fn moving_as(&self, estimate: &Estimate) -> Self {
        let motions = estimate.frames.iter().map(|fit| fit.motion.clone()).collect();
        let state = SequenceState::new(self.state.shape.clone(), motions);
        Self { state, recovered: self.recovered.clone() }
    }
}

impl LastStage<'_> {
    /// The joint optimum, or the winner where none is asked for, and what it was compared by.
    pub(super) fn run(&self, winner: &Trial) -> (Estimate, Measure) {
        match &self.options.joint {
            None => (Estimate::tracked(winner, self.evidence.rig), self.measures.search),
            Some(joint) => self.run_from(&Start::of_winner(self, winner), joint),
        }
    }

    /// The same, and how well it covers what was seen, frame by frame.
    pub(super) fn covered(&self, winner: &Trial) -> (Estimate, Vec<FittedFrame>) {
        let (estimate, measure) = self.run(winner);
        let frames = estimate.frames(self.evidence.model, self.sequence, self.options, measure);
        (estimate, frames)
    }

    /// The joint optimum, from elsewhere.
    pub(super) fn run_from(&self, start: &Start, joint: &JointOptions) -> (Estimate, Measure) {
        let Evidence { model, rig, .. } = *self.evidence;
        let measure = self.measures.joint;
        let stage = |free: Free| JointStage {
            model,
            calibrated: rig,
            measure,
            sequence: self.sequence,
            options: self.options,
            joint,
            free,
            faults: self.faults,
            progress: self.progress,
        };
        let estimate = |free: Free| {
            let joined = stage(free).run(start.state.clone());
            Estimate::joint(joined, rig, &start.recovered)
        };
        let (free, asked) = (self.options.free(), self.options.asked());
        if asked == free {
            return (estimate(free), measure);
        }

        // what is asked for and not used is estimated by the side
        let (told, mut used) = (estimate(asked), estimate(free));
        used.tell_poses(told);
        (used, measure)
    }
}

/// The most probable shape and motion, of the last stage.
pub(super) struct Estimate {
    pub(super) shape: Shape,
    pub(super) frames: Vec<FrameFit>,
    pub(super) noise: Option<Noise>,
    /// p(m₁..ₙ), with accelerations as they are in this recording.
    pub(super) motion_prior: Option<MotionPrior>,
    pub(super) uncertainty: Option<Uncertainty>,
    /// The cameras where they were found to be.
    pub(super) rig: Rig,
    /// By how much each is off.
    pub(super) cameras: Vec<CameraFound>,
    /// How sure they are together.
    pub(super) covariances: CameraCovariances,
}

impl Estimate {
    /// How well it covers what was seen, frame by frame.
    pub(super) fn frames(
        &self,
        body: &BodyModel,
        sequence: Sequence<'_>,
        options: &EstimateOptions,
        measure: Measure,
    ) -> Vec<FittedFrame> {
        let evidence = Evidence::new(body, &self.rig, options.likelihood, measure);
        let (layout, times_s) = (Layout::new(body), times_s(&sequence.intervals_s()));
        let motions: Vec<Motion> = self.frames.iter().map(|fit| fit.motion.clone()).collect();
        let posed = |motion: &Motion| Posed::new(body, &self.shape, motion);
        let fitted = |(i, (observed, fit)): (usize, (&FrameObservations, &FrameFit))| {
            let body = posed(&fit.motion);
            let shown =
                |id: CameraId| posed(&self.cameras[id.0].shown(layout, &motions, &times_s, i));
            let bodies: Vec<Posed<'_>> = observed.views.iter().map(|(id, _)| shown(*id)).collect();
            let detected: Vec<_> = observed.detections.iter().map(|(id, _)| shown(*id)).collect();
            FittedFrame {
                frame: observed.frame,
                points_world: body.points(),
                views: quality::view_qualities(&evidence, observed, &bodies),
                points: points::point_quality(&evidence, observed, &body),
                detections: detection_qualities(&evidence, observed, &detected),
                uncertainty: self.uncertainty.as_ref().map(|u| u.frames[i].clone()),
                fit: fit.clone(),
            }
        };

        sequence.frames.par_iter().zip(&self.frames).enumerate().map(fitted).collect()
    }

    /// How well it covers what each camera saw; `frames` are its own.
    pub(super) fn qualities(&self, frames: &[FittedFrame]) -> Vec<CameraQuality> {
        let of = |(camera, found): (&Camera, &CameraFound)| {
            let views = frames.iter().flat_map(|frame| &frame.views);
            let views: Vec<_> = views.filter(|view| view.camera == camera.name).collect();
            let detected = frames.iter().flat_map(|frame| &frame.detections);
            let detected: Vec<_> = detected.filter(|seen| seen.camera == camera.name).collect();
            CameraQuality::new(camera, *found, &views, &detected)
        };
        self.rig.cameras.iter().zip(&self.cameras).map(of).collect()
    }

    /// How often the cost of the data that chose between hypotheses counts.
    pub(super) fn data_weight(&self) -> f64 {
        self.noise.map_or(1.0, |noise| noise.data_weight())
    }

    /// The winner as it was tracked.
    fn tracked(winner: &Trial, rig: &Rig) -> Self {
        Self {
            shape: winner.hypothesis.shape.clone(),
            frames: winner.frames.iter().flatten().cloned().collect(),
            noise: None,
            motion_prior: None,
            uncertainty: None,
            rig: rig.clone(),
            cameras: vec![CameraFound::default(); rig.cameras.len()],
            covariances: CameraCovariances::default(),
        }
    }

    /// The joint optimum. What Algorithm 1 had to search anew is still told: `recovered`, frame by frame.
    pub(super) fn joint(joined: Joined, calibrated: &Rig, recovered: &[bool]) -> Self {
        let Joined { optimum: joint, prior: camera_prior, covariances } = joined;
        let found = |camera: usize| {
            let sd = joint.uncertainty.as_ref().and_then(|u| u.camera_sd(camera));
            let offset = joint.cameras.get(camera);
            let found = |offset| CameraFound::new(offset, camera_prior.free(camera), sd.as_ref());
            offset.map(found).unwrap_or_default()
        };
        let cameras: Vec<CameraFound> = (0..calibrated.cameras.len()).map(found).collect();

        let frames = joint.frames.into_iter().zip(recovered);
        let frames = frames.map(|(fit, recovered)| FrameFit { recovered: *recovered, ..fit });
        Self {
            shape: joint.shape,
            frames: frames.collect(),
            noise: Some(joint.noise),
            motion_prior: Some(joint.motion_prior),
            uncertainty: joint.uncertainty,
            rig: CameraOffset::applied(calibrated, cameras.iter().map(CameraFound::offset)),
            cameras,
            covariances,
        }
    }

    /// Takes over where the cameras were found to be, without using it.
    fn tell_poses(&mut self, told: Self) {
        for (camera, told) in self.cameras.iter_mut().zip(told.cameras) {
            camera.pose = told.pose.map(|pose| PoseFound { used: false, ..pose });
        }
        self.covariances.poses = told.covariances.poses;
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
