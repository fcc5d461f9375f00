//! Points on the surface of the body, as stereo sees them: places in the world and how far they err.
//!
//! A [`Cloud`] is what one frame has of them, from any source. It knows neither cameras nor body.

mod bicubic;
mod choice;
mod cloud;
pub mod correlation;
mod depth;
mod intersection;
pub mod matching;
mod rectify;
pub mod tracking;
mod view;

pub use choice::{NoneSideBySide, SideBySide};
pub use cloud::{Cloud, CloudPoint, LeftOut, Spread};
pub use depth::{DepthError, DepthMap, depth_map};
pub use intersection::{Intersection, Sighting, intersect};
pub use rectify::{RectifiedPair, RectifyError, rectify};
pub use view::{View, ViewError};
