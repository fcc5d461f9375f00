//! What a frame shows of the person: silhouettes in undistorted pixels, one for each camera.
//!
//! [`extract`] makes a [`Silhouette`] of a mask, without its specks and small holes; [`from_curves`] makes one of the active
//! contours that a [`snake::Snake`] leaves. It holds the sub-pixel border as points with outward normals, what lies inside,
//! and a [`DistanceMap`] of what lies outside; it knows neither the body nor any other camera. [`FrameObservations`] are all
//! that one frame shows, with the [`Keypoint`]s that another program has found. A [`Support`] sums, before there are masks, the other cameras' evidence along each line of sight.

mod distance_map;
mod extract;
mod frame;
mod keypoints;
mod options;
mod outline;
mod overlap;
mod rods;
mod share;
pub mod snake;
mod support;

pub use distance_map::DistanceMap;
pub use extract::{BorderPoint, Rejected, extract, from_curves};
pub use frame::{FrameIndex, FrameObservations, numbered_anew};
pub use keypoints::{Detection, FramePeople, Keypoint, distances_px};
pub use options::{InvalidOption, SilhouetteOptions};
pub use outline::{ContourPoint, Silhouette};
pub use overlap::{Overlap, OverlapGrid};
pub(crate) use rods::CellMask;
pub use support::{ShrunkSize, Support, SupportOptions, Volume};
