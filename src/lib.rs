#![doc = include_str!("../docs/crate.md")]

pub mod body;
pub mod camera;
pub mod gait;
pub mod image;
pub mod inference;
pub mod io;
pub mod likelihood;
pub mod math;
pub mod pipeline;
pub mod render;
#[cfg(feature = "report")]
pub mod report;
pub mod silhouette;
pub mod skin;
pub mod solver;
pub mod stereo;
pub mod synth;
pub mod workflow;

pub use gait::Side;
pub use io::recording::Recording;
pub use workflow::{Error, FitOptions, FittedRecording, GaitStudy};
