//! Mathematics that knows nothing of cameras or bodies: the lowest layer, which all others may use.

mod differences;
pub(crate) mod exponential;
pub mod parabola;
pub mod quadric;
pub mod random_field;
pub mod rotation;
pub mod stats;

pub use differences::{DerivativeFault, central_differences, compare_derivatives};

/// Rigid motion in three dimensions, named by both frames: `camera_from_world * point_world` is a point in the camera frame.
pub type Rigid3 = nalgebra::Isometry3<f64>;
