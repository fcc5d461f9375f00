//! TRC: trajectories of named points, as Pose2Sim and OpenSim exchange them.
//!
//! Tab-separated text; three header lines, one with the names, one with X1 Y1 Z1 …, then a row per frame. The file's
//! world is Y up (see [`UpAxis`](crate::camera::UpAxis)).

mod clock;
mod read;
mod write;

use nalgebra::Point3;

pub(crate) use read::read_with_rate;
pub use read::{TrcError, read_trc};
pub use write::write_trc;

/// Points over time.
#[derive(Debug, Clone, PartialEq)]
pub struct Trajectories {
    /// Frames per second.
    pub rate_hz: f64,
    /// Number of the first frame, from 0; its time is `first_frame / rate_hz`.
    pub first_frame: usize,
    /// Names of the points.
    pub names: Vec<String>,
    /// For each frame one place for each name, in the world (Z up, metres); `None` where a point is missing.
    pub frames: Vec<Vec<Option<Point3<f64>>>>,
}
