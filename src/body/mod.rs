//! The body: a tree of single-axis joints that carries ellipsoids and metaballs.
//!
//! [`BodyModel`] is what never changes (topology, static transforms, primitives, limits, statistics);
//! a state is a [`Shape`] and one [`Motion`] per frame; [`Posed`] is what kinematics makes of the
//! three, computed once per evaluation and lent to every likelihood term.

mod bones;
mod check;
mod jacobian;
mod keypoints;
mod limbs;
pub mod metaball;
mod model;
mod offset_grid;
mod offsets;
mod places;
mod posed;
mod scaled;
mod side;
mod state;

pub use check::check_kinematics;
pub use jacobian::EllipsoidJacobians;
pub use keypoints::{KEYPOINT_SD_M, PointSlopes};
pub(crate) use limbs::towards_root;
pub use model::{
    BodyModel, CoefficientId, FrameId, Joint, JointId, Limbs, ModelError, NamedPoint, Part, PartId,
    Pose, Primitive, Root, ShapeStatistics, Turn,
};
pub use offsets::{Offset, SurfaceOffsets};
pub(crate) use places::Displacements;
pub use posed::Posed;
pub use scaled::{Scale, ScaledVector, Shift};
pub use side::Side;
pub use state::{Layout, Motion, Shape, State};
