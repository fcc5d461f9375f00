//! The most probable shape and motion: the joint optimum that is reached from the winner of Algorithm 1.

use nalgebra::Vector2;

use super::aim::{AimedOptimum, JointStage};
use super::measures::Measures;
use super::{EstimateOptions, Progress};
use crate::body::{BodyModel, Layout, Motion, Shape};
use crate::camera::Rig;
use crate::inference::SequenceState;
use crate::inference::covariance::Uncertainty;
use crate::inference::frame::FrameFit;
use crate::inference::noise::Noise;
use crate::inference::search::Trial;
use crate::inference::step::between;
use crate::inference::{Evidence, Sequence};
use crate::likelihood::Measure;

/// The joint optimum, or the winner where none is asked for, and what it was compared by.
pub(super) fn estimate(
    evidence: &Evidence<'_>,
    sequence: Sequence<'_>,
    winner: &Trial,
    measures: Measures,
    options: &EstimateOptions,
    progress: &dyn Progress,
) -> (Estimate, Measure) {
    let Evidence { model, rig, .. } = *evidence;
    let Some(joint) = &options.joint else {
        return (Estimate::tracked(winner, rig), measures.search);
    };

    let stage = JointStage {
        model,
        calibrated: rig,
        likelihood: options.likelihood,
        measure: measures.joint,
        sequence,
        options: joint,
        aim: options.aim && sequence.frames.iter().all(|frame| frame.points.is_empty()),
        progress,
    };
    let aimed = stage.run(&state_of(model, sequence, winner));
    (Estimate::joint(aimed, winner), measures.joint)
}

/// The most probable shape and motion, of the last stage.
pub(super) struct Estimate {
    pub(super) shape: Shape,
    pub(super) frames: Vec<FrameFit>,
    pub(super) noise: Option<Noise>,
    pub(super) uncertainty: Option<Uncertainty>,
    pub(super) rig: Rig,
    pub(super) aims_px: Vec<Vector2<f64>>,
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
            aims_px: vec![Vector2::zeros(); rig.cameras.len()],
        }
    }

    /// The joint optimum that is reached from the winner.
    fn joint(aimed: AimedOptimum, winner: &Trial) -> Self {
        let AimedOptimum { joint, rig, aims_px } = aimed;

        // what Algorithm 1 had to search anew is still told
        let frames = joint.frames.into_iter().zip(winner.frames.iter().flatten());
        let frames = frames.map(|(fit, tracked)| FrameFit { recovered: tracked.recovered, ..fit });
        Self {
            shape: joint.shape,
            frames: frames.collect(),
            noise: Some(joint.noise),
            uncertainty: joint.uncertainty,
            rig,
            aims_px,
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
    SequenceState { shape: winner.hypothesis.shape.clone(), motions }
}
