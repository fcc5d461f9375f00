//! p(θ | Z): ZS06's probability model (eqs. 1–3) and Algorithm 1.
//!
//! E(s, m₁..ₙ) = −log p(s) + Σᵢ \[−log p(Zᵢ | mᵢ, s)\] + Σᵢ \[−log p(mᵢ | mᵢ₋₁)\] (eq. 1, in logarithms).
//!
//! | factor, step                      | where            |
//! |-----------------------------------|------------------|
//! | p(s), p(m), p(mᵢ given mᵢ₋₁)      | [`prior`], [`chain`], `accelerations`, [`motion_prior`] |
//! | eq. 2 and 3 as problems           | [`frame`]        |
//! | a pose from nothing               | [`hull`], [`joints`], [`start`] |
//! | one hypothesis along the chain    | [`propagate`]    |
//! | Algorithm 1                       | [`search`]       |
//! | what the winner lost              | `relay`          |
//! | eq. 1 as a problem of all frames  | [`sequence_posterior`] |
//! | its optimum, how sure it is       | [`joint`], [`noise`], [`contrasts`], `spread`, `repeated_error`, [`covariance`] |
//! | cameras and clocks as unknowns    | [`camera_offset`], [`camera_prior`], [`rig_motion`], [`instant`] |
//! | p_ε,σ(K)                          | [`confidence`], [`ShapeConfidence`] |

mod accelerations;
pub mod camera_offset;
pub mod camera_prior;
pub mod chain;
pub mod confidence;
pub mod contrasts;
pub mod covariance;
mod detail;
mod evidence;
pub mod facing;
pub mod frame;
pub mod hull;
mod hypothesis;
pub mod instant;
pub mod joint;
pub mod joints;
mod journal;
mod keyframe;
pub mod lens_prior;
mod look_sum;
mod looks;
pub mod motion_prior;
pub mod noise;
pub mod prior;
pub mod propagate;
mod relay;
mod repeated_error;
pub mod rig_motion;
pub mod search;
mod sequence;
pub mod sequence_posterior;
mod sequence_state;
mod shape_confidence;
mod spread;
pub mod start;
pub mod step;

pub use detail::Detail;
pub use evidence::{Evidence, Terms};
pub use looks::{Kind, Look, SequenceTerms};
pub use sequence::Sequence;
pub use sequence_state::SequenceState;
pub use shape_confidence::{ConfidenceOptions, ShapeConfidence};
pub(crate) use shape_confidence::{best_readings, keyframe_shapes};
