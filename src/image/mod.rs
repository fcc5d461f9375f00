//! Pictures as numbers: planes, masks, and what is measured on a mask before any camera is known.
//!
//! Nothing here reads a file or knows a lens. Pixel (0, 0) is the *centre* of the top-left pixel, so a mask of
//! w × h pixels covers [−½, w − ½] × [−½, h − ½]; x runs right, y runs down.
//!
//! | file           | holds                                                                  |
//! |----------------|------------------------------------------------------------------------|
//! | `plane.rs`     | [`Plane`]: a rectangle of values, row by row                            |
//! | `picture.rs`   | [`Picture`], [`luma`]: colours, and how bright they are                 |
//! | `mask.rs`      | [`Mask`]: foreground or not, for each pixel                             |
//! | `runs.rs`      | [`Runs`]: the same by the runs of each row, and its connected components |
//! | `components.rs`| [`clean`]: specks away, small holes filled                              |
//! | `contour.rs`   | [`trace`], [`resample`]: the sub-pixel border as closed polylines        |
//! | `scanlines.rs` | [`Scanlines`]: which points of a row lie inside polygons                 |
//! | `distance.rs`  | [`NearestPoints`]: the nearest of many points, for a whole row at once   |

mod components;
mod contour;
mod distance;
mod mask;
mod picture;
mod plane;
mod runs;
mod scanlines;

pub use components::{CleanOptions, clean};
pub use contour::{resample, trace};
pub use distance::NearestPoints;
pub use mask::Mask;
pub use picture::{Picture, luma};
pub use plane::Plane;
pub use runs::{Component, Connectivity, Region, Runs};
pub use scanlines::Scanlines;
