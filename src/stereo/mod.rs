//! Points on the surface of the body: where they are and how sure that is, measured in images of cameras side by side.
//!
//! A [`Cloud`] holds the points of one frame, from any source. Nothing here knows a body, or its points would not be
//! independent data.
//!
//! | file               | holds                                                                       |
//! |--------------------|-----------------------------------------------------------------------------|
//! | `cloud.rs`         | [`Cloud`], [`CloudPoint`], [`Spread`]                                         |
//! | `choice.rs`        | [`SideBySide`]: which cameras are matched                                     |
//! | `view.rs`          | [`StereoView`]: an image without its lens                                     |
//! | `bicubic.rs`       | brightness between the pixels                                                 |
//! | `intersection.rs`  | [`intersect`]: where lines of sight meet, with covariance                     |
//! | `rectify.rs`       | [`rectify`]: a pair whose rows correspond                                     |
//! | `rows.rs`          | [`known_by_rows`]: whether the rows of two pictures correspond                |
//! | [`correlation`]    | dense disparity of such a pair                                                |
//! | `depth.rs`         | [`depth_map`]: its points                                                     |
//! | [`matching`]       | least-squares matching in several images at once (PFD99 § 2.1)                |
//! | [`tracking`]       | following points from frame to frame (PFD99 § 2.2)                            |

mod bicubic;
mod choice;
mod cloud;
pub mod correlation;
mod depth;
mod depth_error;
mod intersection;
pub mod matching;
mod rectify;
mod rows;
pub mod tracking;
mod view;

pub use choice::{NoneSideBySide, SideBySide, neighbour};
pub use cloud::{Cloud, CloudPoint, LeftOut, Spread};
pub use depth::{DepthMap, depth_map};
pub use depth_error::DepthError;
pub use intersection::{Intersection, Sighting, intersect};
pub use rectify::{RectifiedPair, rectify};
pub use rows::{MOST_ROWS, known_by_rows};
pub use view::{StereoView, StereoViewError};
