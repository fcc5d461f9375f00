//! What a camera would see of a body, and pictures for people to look at.
//!
//! | file         | holds                                                             |
//! |--------------|-------------------------------------------------------------------|
//! | `raycast.rs` | [`silhouette`]: the mask of a metaball body, by casting rays       |
//! | `covered.rs` | [`covered`]: the mask of a mesh                                  |
//! | `profile.rs` | the field along one ray, as a sum of bumps                          |
//! | `canvas.rs`  | [`Canvas`]: smooth lines and dots in a picture                      |
//! | `raster.rs`  | [`Raster`]: which triangle of a mesh each sample of a picture sees  |
//! | `shade.rs`   | [`shade`]: a shaded picture of a metaball body                      |
//! | `outline.rs` | [`outline`]: its visible contours, the inner ones apart, with part and depth |
//! | `overlay.rs` | [`overlay`]: a mask with the fitted outline and joints over it      |
//! | [`stereo`]   | pictures of disparities, clouds and motions                         |
//!
//! Nothing here is shared with the likelihoods: they are tested on what is rendered here.

mod canvas;
mod covered;
mod outline;
mod overlay;
mod profile;
mod raster;
mod raycast;
mod shade;
pub mod stereo;

pub use canvas::{Canvas, Pen, Rgb};
pub use covered::covered;
pub use outline::{ModelOutline, OutlinePoint, outline};
pub use overlay::overlay;
pub use raster::{Fragment, Raster};
pub use raycast::silhouette;
pub use shade::{portrait_camera, shade};
