//! θ of a sequence.

use super::camera_offset::CameraOffset;
use crate::body::{BodyModel, Motion, Shape};

/// θ: the shape, every motion, and the cameras where they are unknowns.
#[derive(Debug, Clone, PartialEq)]
pub struct SequenceState {
    /// s.
    pub shape: Shape,
    /// m₁..ₙ.
    pub motions: Vec<Motion>,
    /// By how much each camera is off, in the order of the rig; empty where they are trusted.
    pub cameras: Vec<CameraOffset>,
}

impl SequenceState {
    /// Before cameras that are trusted.
    pub fn new(shape: Shape, motions: Vec<Motion>) -> Self {
        Self { shape, motions, cameras: Vec::new() }
    }

    /// The same motions with a shape of all of a model's coefficients: those that the shape has not are 0.
    pub fn detailed(self, model: &BodyModel) -> Self {
        Self { shape: Shape(self.shape.0.resize_vertically(model.coefficients.len(), 0.0)), ..self }
    }
}
