//! The joint optimum and the pointing errors of the cameras, by turns.

use nalgebra::Vector2;

use crate::body::BodyModel;
use crate::camera::Rig;
use crate::inference::SequenceState;
use crate::inference::aim::estimate_aims_px;
use crate::inference::joint::{JointOptimum, JointOptions, joint_optimum_from_terms, residuals};
use crate::inference::{Evidence, Sequence};
use crate::likelihood::{LikelihoodOptions, Measure};
use crate::pipeline::Progress;

/// A turn that moves no camera's image by this much is the last, and a smaller pointing error is not worth a warning. Pixels.
pub(super) const LEAST_PX: f64 = 1.0;
/// Turns at most.
const TURNS: usize = 6;

/// What the last stage of a fit is given.
pub(super) struct JointStage<'a> {
    pub(super) model: &'a BodyModel,
    /// The cameras as they were calibrated.
    pub(super) calibrated: &'a Rig,
    pub(super) likelihood: LikelihoodOptions,
    pub(super) measure: Measure,
    pub(super) sequence: Sequence<'a>,
    pub(super) options: &'a JointOptions,
    /// Whether the cameras' pointing errors are estimated; otherwise they are 0.
    pub(super) aim: bool,
    pub(super) progress: &'a dyn Progress,
}

/// The joint optimum, and the cameras with the pointing errors that were found.
pub(super) struct AimedOptimum {
    pub(super) joint: JointOptimum,
    pub(super) rig: Rig,
    /// By how much each image is displaced from where the calibration puts it, px.
    pub(super) aims_px: Vec<Vector2<f64>>,
}

impl JointStage<'_> {
    /// Improves body and pointing errors by turns.
    pub(super) fn run(&self, start: &SequenceState) -> AimedOptimum {
        let seconds = self.sequence.intervals_s();
        let mut aims_px = vec![Vector2::zeros(); self.calibrated.cameras.len()];
        let mut turn = 1;
        loop {
            // the body; always from the same start, because wrong pointing bends bodies
            let rig = self.calibrated.aimed(&aims_px);
            let evidence = Evidence::new(self.model, &rig, self.likelihood, self.measure);
            let terms = evidence.sequence_terms(self.sequence);
            let (start, options) = (start.clone(), self.options);
            self.progress.begin("joint optimum", options.most_steps());
            let step = || self.progress.step();
            let joint =
                joint_optimum_from_terms(&evidence, &terms, &seconds, start, options, &step);

            // the pointing errors, given that body
            let mut next_px = aims_px.clone();
            if self.aim && turn < TURNS {
                let residuals = residuals(self.model, &terms.all, &joint.state());
                let frames = self.sequence.frames;
                let noise = &joint.noise;
                next_px = estimate_aims_px(self.calibrated, &aims_px, frames, &residuals, noise);
            }

            self.progress.end();

            let moved_px = next_px.iter().zip(&aims_px).map(|(a, b)| (a - b).norm());
            if moved_px.fold(0.0, f64::max) < LEAST_PX {
                return AimedOptimum { joint, rig, aims_px };
            }
            aims_px = next_px;
            turn += 1;
        }
    }
}
