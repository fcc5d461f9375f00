//! Silhouettes in clutter, from a model that predicts where to look (PF02 § 4): no background is subtracted.
//!
//! | stage (PF02 § 4)                                | where                                       |
//! |-------------------------------------------------|---------------------------------------------|
//! | pictures without lenses, their depths           | [`UndistortedFrame`]                              |
//! | before there is a model: what moves, by depth   | `moving.rs`, thing by thing `followed.rs`   |
//! | the gradient, filtered by disparity (§ 4.2)     | [`Edges`], [`disparity_mask`], [`FilteredEdges`] |
//! | the outline that is expected                    | [`crate::render::outline`]                  |
//! | active contours                                 | [`ViewContours`]                            |
//! | and, beside them, where the person's colours end | `colours.rs`                               |
//! | limbs that depth sees through                   | `absent.rs`                                 |
//! | the first fit (§ 4.1)                           | [`StartingFit`]                             |
//! | the simple pipeline (§ 4.1), the joint one (§ 4.3) | [`SilhouetteSearch`]                     |
//! | the joint one as published                      | `frame_after_frame.rs`                      |
//! | what is amiss where contours lie on no edges    | [`rows_apart`]                              |
//!
//! A contour point counts in the likelihood by its reliability. Lengths are given in metres at the person and become pixels by
//! the camera and the depth, so that they mean the same in every recording.

mod abreast;
mod absent;
mod backing;
mod colours;
mod contour;
mod ends;
mod error;
mod filter;
mod followed;
mod frame_after_frame;
mod moving;
mod pieces;
mod rows_apart;
mod run;
mod scene;
mod seen_depths;
mod starting_fit;
mod staying;
mod still;
mod undistorted;

use crate::silhouette::snake::SnakeOptions;

pub use contour::{FoundPoint, ViewContours};
pub(super) use ends::nearness;
pub use error::SilhouetteError;
pub use filter::{Edges, FilteredEdges, disparity_mask};
pub use rows_apart::{RowsApart, rows_apart};
pub use run::{
    FoundSilhouettes, FrameSilhouettes, SilhouettePipeline, SilhouetteSearch, UNSURE_BACKING,
    UNSURE_RELIABILITY,
};
pub use scene::{FrameSighting, Scene};
pub use starting_fit::StartingFit;
pub use still::StillScenes;
pub use undistorted::{UndistortedFrame, UndistortedView};

/// What was found in one view, and through which edges.
#[derive(Debug, Clone)]
pub struct ViewSighting {
    /// The contours.
    pub contours: ViewContours,
    /// The edges that they were drawn to.
    pub filtered: FilteredEdges,
    /// How far depth backs them, 0 to 1; `None` where no depth is seen.
    pub backing: Option<f64>,
}

/// Settings of the contours.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ContourOptions {
    /// σ of the scale at which edges are seen from afar, px. Default 2.5.
    pub wide_px: f64,
    /// σ of the scale at which they are measured, px. Default 1.2: noise of one pixel is gone.
    pub narrow_px: f64,
    /// Edges stronger than this share of those on the mask are strong (hysteresis). Default 0.5.
    pub strong: f64,
    /// Edges of this share of a strong one count beside one. Default 0.4, as Canny's two to three to one.
    pub weak: f32,
    /// Weaker changes than this are no edge in any picture, grey levels per pixel. Default 2.
    pub flattest: f32,
    /// How far the working volume reaches beyond the body, m. Default 0.15.
    pub volume_m: f64,
    /// Radius of the disk that closes and opens the disparity mask, px. Default 3: the correlation window's.
    pub clean_px: u8,
    /// How far the mask reaches beyond what is near, px. Default 4.
    pub reach_px: u8,
    /// How far from the expected outline edges are looked for, m. Default 0.06.
    pub search_m: f64,
    /// Standard deviation of the border about the expected outline, m. Default 0.02.
    pub prior_m: f64,
    /// Length over which displacements are smoothed (√α), m. Default 0.012.
    pub tension_m: f64,
    /// Length over which they bend (⁴√β), m. Default 0.018.
    pub stiffness_m: f64,
    /// Distance of neighbouring contour points, m. Default 0.01, and at least 1.5 px.
    pub spacing_m: f64,
    /// Distance of neighbouring points of the expected outline, px. Default 2.
    pub outline_px: f64,
    /// Points farther from the skin than this are not fitted to, m. Default 0.1.
    pub near_m: f64,
}

impl Default for ContourOptions {
    fn default() -> Self {
        Self {
            wide_px: 2.5,
            narrow_px: 1.2,
            strong: 0.5,
            weak: 0.4,
            flattest: 2.0,
            volume_m: 0.15,
            clean_px: 3,
            reach_px: 4,
            search_m: 0.06,
            prior_m: 0.02,
            tension_m: 0.012,
            stiffness_m: 0.018,
            spacing_m: 0.01,
            outline_px: 2.0,
            near_m: 0.1,
        }
    }
}

impl ContourOptions {
    /// The same in pixels, of a body seen at so many pixels per metre, for edges of which `strong` is a strong one.
    fn snake(&self, px_per_m: f64, strong: f32) -> SnakeOptions {
        let px = |metres: f64| metres * px_per_m;
        SnakeOptions {
            tension: px(self.tension_m).powi(2),
            stiffness: px(self.stiffness_m).powi(4),
            spacing_px: px(self.spacing_m).max(1.5),
            search_px: px(self.search_m).clamp(4.0, 40.0),
            prior_px: px(self.prior_m).max(1.5),
            edge: 0.5 * f64::from(strong),
            ..SnakeOptions::default()
        }
    }
}

/// Why a view has no contour of its own somewhere; the model's outline stands there, with reliability 0.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum ContourFault {
    /// The body is not in view.
    #[error("no outline is expected in view")]
    NoOutline,
    /// The image cuts the body.
    #[error("{percent:.0} % of the expected outline lies on the edge of the image")]
    PartlyOutside {
        /// Of the outline's points.
        percent: f64,
    },
    /// No edge anywhere where one could be.
    #[error("the picture is flat: no edge near the expected outline")]
    Flat,
    /// The contour shrank to nothing.
    #[error("a contour collapsed")]
    Collapsed,
    /// The contour crossed itself.
    #[error("a contour crossed itself")]
    SelfCrossing,
    /// More depths speak against the body than for it.
    #[error("depth backs {percent:.0} % of the contour and of what stands out from the room")]
    Unbacked {
        /// Of the pixels.
        percent: f64,
    },
    /// Parts of the body are not where it has them.
    #[error("depth shows what stands behind the body's {parts}")]
    SeenThrough {
        /// Their names.
        parts: String,
    },
}
