//! A result of one trial of a session: what it was found to be alone, and its search beside what all trials found.

use nalgebra::{DMatrix, DVector};

use super::ResultFile;
use super::schema::{HypothesisPart, OriginPart};
use crate::body::{BodyModel, Shape};
use crate::inference::best_readings;
use crate::pipeline::AloneFit;

impl ResultFile {
    /// What the trial was found to be alone, with all coefficients of the detailed `model`; `None` of a fit of no joint optimum.
    pub fn alone_fit(&self, model: &BodyModel) -> Option<AloneFit> {
        let coefficients = &self.shape.coefficients;
        if coefficients.len() != model.detailed().coefficients.len() {
            return None;
        }
        Some(AloneFit {
            shape: Shape(DVector::from_iterator(
                coefficients.len(),
                coefficients.iter().map(|c| c.value),
            )),
            covariance: self.shape_covariance(),
            motions: self.motion.frames.iter().map(|frame| frame.motion()).collect(),
            recovered: self.motion.frames.iter().map(|frame| frame.recovered).collect(),
            cameras: self.quality.cameras.iter().map(|camera| camera.found).collect(),
            keyframes: self.keyframe_shapes(),
            jumps: self.verdict.jumps().cloned().collect(),
            worn: self.verdict.worn().cloned(),
        })
    }

    /// What each keyframe found of the shape: its most probable reading, in the order of the keyframes.
    fn keyframe_shapes(&self) -> Vec<Shape> {
        let of_keyframes = self.hypotheses.iter().filter(|h| h.origin == OriginPart::Keyframe);
        let best = best_readings(of_keyframes, |h| (h.keyframe, h.keyframe_cost));
        let shape = |part: &HypothesisPart| Shape(DVector::from_column_slice(&part.coefficients));
        best.into_iter().map(shape).collect()
    }

    /// The covariance of the shape's coefficients; `None` where it is not known, or withheld.
    pub fn shape_covariance(&self) -> Option<DMatrix<f64>> {
        let rows = self.shape.covariance.as_ref()?;
        Some(DMatrix::from_fn(rows.len(), rows.len(), |i, j| rows[i][j]))
    }

    /// With the hypotheses of another result: those of the trial alone, from which this one was reached.
    #[must_use]
    pub fn with_search_of(self, alone: &Self) -> Self {
        Self { hypotheses: alone.hypotheses.clone(), winner: alone.winner, ..self }
    }
}
