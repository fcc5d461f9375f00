//! θ of a sequence.

use crate::body::{BodyModel, Motion, Shape};

/// θ: the shape and every motion.
#[derive(Debug, Clone, PartialEq)]
pub struct SequenceState {
    /// s.
    pub shape: Shape,
    /// m₁..ₙ.
    pub motions: Vec<Motion>,
}

impl SequenceState {
    /// The same motions with a shape of all of a model's coefficients: those that the shape has not are 0.
    pub fn detailed(self, model: &BodyModel) -> Self {
        Self { shape: Shape(self.shape.0.resize_vertically(model.coefficients.len(), 0.0)), ..self }
    }
}
