#![doc = include_str!("../README.md")]
//!
//! # The posterior
//!
//! E(s, m₁..ₙ) = −log p(s) + Σᵢ \[−log p(Zᵢ | mᵢ, s)\] + Σᵢ \[−log p(mᵢ | mᵢ₋₁)\]
//!
//! | factor                       | room                                                    |
//! |------------------------------|---------------------------------------------------------|
//! | s, mᵢ: the body              | [`body`]                                                |
//! | Zᵢ: what the cameras show    | [`camera`], [`image`], [`silhouette`], [`stereo`]       |
//! | p(Zᵢ given mᵢ, s)            | [`likelihood`]                                          |
//! | p(s), p(mᵢ given mᵢ₋₁), argmax | [`inference`]                                         |
//! | least squares                | [`solver`]                                              |
//! | the skin as a mesh           | [`skin`]                                                |
//! | recordings with truth        | [`synth`], [`render`]                                   |
//! | how a person walks           | [`gait`]                                                |
//! | the order of the stages      | [`pipeline`]                                            |
//! | files                        | [`io`]                                                  |
//! | what a clinician reads       | [`report`]                                              |

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

pub use io::recording::Recording;
pub use workflow::{Error, FitOptions, FittedRecording, GaitStudy};
