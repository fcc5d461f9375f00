//! A result of one trial of a session: what it was found to be alone, and its search beside what all trials found.

use nalgebra::{DMatrix, DVector};

use super::ResultFile;
use crate::body::{BodyModel, Shape};
use crate::inference::ShapeConfidence;
use crate::pipeline::AloneFit;

impl ResultFile {
    /// What the trial was found to be alone, with all coefficients of the detailed `model`; `None` of a fit of no joint optimum.
    pub fn alone_fit(&self, model: &BodyModel) -> Option<AloneFit> {
        let coefficients = &self.shape.coefficients;
        if coefficients.len() != model.detailed().coefficients.len() {
            return None;
        }
        let of_keyframes = coefficients.iter().filter_map(|c| c.confidence.clone());
        Some(AloneFit {
            shape: Shape(DVector::from_iterator(
                coefficients.len(),
                coefficients.iter().map(|c| c.value),
            )),
            covariance: self.shape_covariance(),
            motions: self.motion.frames.iter().map(|frame| frame.motion()).collect(),
            recovered: self.motion.frames.iter().map(|frame| frame.recovered).collect(),
            cameras: self.quality.cameras.iter().map(|camera| camera.found).collect(),
            confidence: ShapeConfidence {
                coefficients: of_keyframes.collect(),
                lengths: self.shape.lengths.iter().map(|l| l.confidence.clone()).collect(),
                all_coefficients: self.shape.all_coefficients.clone(),
                all_lengths: self.shape.all_lengths.clone(),
            },
        })
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
