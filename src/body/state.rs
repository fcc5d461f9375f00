//! The unknowns, and where each stands in a displacement.

use nalgebra::{DVector, Rotation3, UnitQuaternion, Vector3};

use super::{BodyModel, CoefficientId, JointId, Root};

/// s: logarithmic shape coefficients, constant over a recording.
#[derive(Debug, Clone, PartialEq, serde::Serialize, serde::Deserialize)]
pub struct Shape(pub DVector<f64>);

impl Shape {
    /// The first so many coefficients.
    pub fn first(&self, count: usize) -> Self {
        Self(self.0.rows(0, count).into_owned())
    }
}

/// mᵢ: where the body is and how it is bent in one frame.
#[derive(Debug, Clone, PartialEq, serde::Serialize, serde::Deserialize)]
pub struct Motion {
    /// The root's origin, metres.
    pub position_world: Vector3<f64>,
    /// The root's orientation R, updated R ← R·exp(δ).
    pub world_from_root: Rotation3<f64>,
    /// θ, one per joint, radians.
    pub angles: DVector<f64>,
}

impl Motion {
    /// The rest pose at the world's origin.
    pub fn rest(model: &BodyModel) -> Self {
        Self {
            position_world: Vector3::zeros(),
            world_from_root: Rotation3::identity(),
            angles: DVector::from_iterator(model.joints.len(), model.joints.iter().map(|j| j.rest)),
        }
    }

    /// All angles 0 at the world's origin.
    pub fn straight(model: &BodyModel) -> Self {
        Self { angles: DVector::zeros(model.joints.len()), ..Self::rest(model) }
    }

    /// The direction of the root's x axis, in which the body faces, in the world.
    pub fn forwards_world(&self) -> Vector3<f64> {
        self.world_from_root * Vector3::x()
    }
}

/// θ of one frame: motion and shape.
#[derive(Debug, Clone, PartialEq)]
pub struct State {
    /// m.
    pub motion: Motion,
    /// s.
    pub shape: Shape,
}

/// What each component of a displacement δ stands for: root (6 or 0), then angles, then shape.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Layout {
    root: usize,
    joints: usize,
    coefficients: usize,
}

impl Layout {
    /// The layout of a model's state.
    pub fn new(model: &BodyModel) -> Self {
        Self {
            root: if model.root == Root::Fixed { 0 } else { 6 },
            joints: model.joints.len(),
            coefficients: model.coefficients.len(),
        }
    }

    /// Components of the root: position 0..3 (world axes), rotation 3..6 (root axes); 0 if it is fixed.
    pub fn root(self) -> usize {
        self.root
    }

    /// Components of the motion, which come first.
    pub fn motion(self) -> usize {
        self.root + self.joints
    }

    /// All components.
    pub fn total(self) -> usize {
        self.motion() + self.coefficients
    }

    /// Component of a joint's angle.
    pub fn angle(self, joint: JointId) -> usize {
        self.root + joint.0
    }

    /// Component of a shape coefficient.
    pub fn coefficient(self, coefficient: CoefficientId) -> usize {
        self.motion() + coefficient.0
    }

    /// m ⊞ δ from the first [`Layout::motion`] components of `delta`.
    pub fn retract_motion(self, motion: &Motion, delta: &DVector<f64>) -> Motion {
        let mut moved = motion.clone();
        if self.root == 6 {
            moved.position_world += Vector3::new(delta[0], delta[1], delta[2]);
            let turn = Rotation3::from_scaled_axis(Vector3::new(delta[3], delta[4], delta[5]));
            moved.world_from_root = motion.world_from_root * turn;
            moved.world_from_root.renormalize();
        }
        moved.angles += delta.rows(self.root, self.joints);
        moved
    }

    /// x ⊞ δ for motion and shape.
    pub fn retract(self, state: &State, delta: &DVector<f64>) -> State {
        let shape = Shape(&state.shape.0 + delta.rows(self.motion(), self.coefficients));
        State { motion: self.retract_motion(&state.motion, delta), shape }
    }

    /// The displacement δ with from ⊞ δ = to, in the components of the motion.
    pub fn motion_difference(self, from: &Motion, to: &Motion) -> DVector<f64> {
        let mut delta = DVector::zeros(self.motion());

        if self.root == 6 {
            delta.rows_mut(0, 3).copy_from(&(to.position_world - from.position_world));
            // through a quaternion: the angle from a trace loses half its digits near 0
            let turn = from.world_from_root.inverse() * to.world_from_root;
            let turn = UnitQuaternion::from_rotation_matrix(&turn).scaled_axis();
            delta.rows_mut(3, 3).copy_from(&turn);
        }

        delta.rows_mut(self.root, self.joints).copy_from(&(&to.angles - &from.angles));
        delta
    }
}
