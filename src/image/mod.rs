//! Pictures and masks, and what can be measured in them without knowing the camera.
//!
//! Nothing here reads a file or knows a lens. Pixel (0, 0) is the *centre* of the top-left pixel, so a mask of
//! w × h pixels covers [−½, w − ½] × [−½, h − ½]; x runs right, y runs down.
//!
//! | file           | holds                                                                  |
//! |----------------|------------------------------------------------------------------------|
//! | `plane.rs`     | [`Plane`]: a rectangle of values, row by row                            |
//! | `picture.rs`   | [`Picture`], [`luma`]: colours, and how bright they are                 |
//! | `mask.rs`      | [`Mask`]: foreground or not, for each pixel                             |
//! | `mixture/`     | [`Mixture`]: an adaptive background, Gaussians in every pixel            |
//! | `background.rs`| [`Background`]: how probable a colour is where nobody stands, shadows too  |
//! | `colours.rs`   | [`Colours`]: how often a colour occurs                                   |
//! | `labels.rs`    | [`relax`]: from evidence to probability, smooth where the picture is     |
//! | `border.rs`    | [`sharpen`]: the border of a mask, exact to the pixel                     |
//! | `shrink.rs`    | [`shrink`], [`enlarge`], [`box_mean`]                                     |
//! | `runs.rs`      | [`Runs`]: a mask as the runs of its rows, and its connected components   |
//! | `components.rs`| [`clean`]: a mask without specks and small holes                        |
//! | `contour.rs`   | [`trace`], [`resample`]: the sub-pixel border as closed polylines        |
//! | `scanlines.rs` | [`Scanlines`]: which points of a row lie inside polygons                 |
//! | `distance.rs`  | [`NearestPoints`]: the nearest of many points, for a whole row at once   |
//! | `edges.rs`     | [`Gradient`]: where colours change, at a scale, with hysteresis           |
//! | `morphology.rs`| [`opened`], [`closed`], [`widened`] with a disk                           |

mod background;
mod border;
mod colours;
mod components;
mod contour;
mod distance;
mod edges;
mod labels;
mod mask;
mod mixture;
mod morphology;
mod picture;
mod plane;
mod runs;
mod scanlines;
mod shrink;

pub use background::{Background, BackgroundPixel, ShadowOptions};
pub use border::{BorderOptions, sharpen};
pub use colours::{ColourCount, Colours};
pub use components::{CleanOptions, clean};
pub use contour::{resample, trace};
pub use distance::NearestPoints;
pub use edges::Gradient;
pub use labels::{RelaxOptions, relax};
pub use mask::Mask;
pub use mixture::{Mixture, MixtureOptions, Mode};
pub use morphology::{closed, opened, widened};
pub use picture::{Picture, luma};
pub use plane::Plane;
pub use runs::{Component, Connectivity, Region, Runs};
pub use scanlines::{EvenSteps, Scanlines};
pub use shrink::{box_mean, enlarge, shrink};
