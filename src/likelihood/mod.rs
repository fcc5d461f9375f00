//! −log p(Z | m, s), one term per kind of data.
//!
//! | term                 | data                         | residual, unit            | source          |
//! |----------------------|------------------------------|---------------------------|-----------------|
//! | [`EllipseSilhouette`] | border points, distance map | distance to outlines, px  | ZS06, App. C    |
//! | [`SilhouetteRays`]   | border points                | distance to the skin, m   | PF02 § 3.2      |
//! | [`PointField`]       | points of the surface        | distance to the skin, m   | PF02 § 3.1      |
//! | [`Keypoints`]        | 2-D detections of joints     | distance to the joint, px | –               |
//!
//! What cameras side by side see differently at one place is weighed apart: [`Parallax`].
//!
//! Every term is ½ Σ w ρ((r/σ)²): r in the unit of its data, σ its standard deviation in that unit
//! (PFD99 eq. 11), w the number of independent observations that a row stands for, ρ a robust loss.

mod body_outline;
mod clear;
mod contact;
mod ellipse_distance;
mod ellipse_silhouette;
mod ellipse_sums;
mod ellipse_view;
mod ellipsoid_surface;
mod folds;
mod foot;
mod keypoints;
mod limb_sums;
mod local_length;
mod nearest_limb;
mod offset_row;
mod options;
mod parallax;
mod part_offset;
mod placed_residual;
mod point_field;
mod point_options;
mod shared_border;
mod silhouette_ray;
mod skin_distance;
mod skin_term;
mod surface_point;
mod touched_limb;
mod union;

pub use body_outline::BodyOutline;
pub use clear::Clear;
pub use ellipse_distance::EllipseDistance;
pub use ellipse_silhouette::{EllipseOptions, EllipseSilhouette, Variant};
pub use ellipse_view::EllipseView;
pub use keypoints::{KeypointOptions, KeypointView, Keypoints, label_sigma_px};
pub use options::{LikelihoodOptions, Measure};
pub use parallax::{Contrast, Parallax, Quarter};
pub use placed_residual::{Place, PlacedResidual, Source};
pub use point_field::PointField;
pub use point_options::{PointOptions, PointResidual};
pub use silhouette_ray::{RayOptions, RayView, SilhouetteRays};
pub use skin_distance::{Derivatives, Residual, SkinScale};
pub use skin_term::SkinTouch;
pub use surface_point::SurfacePoint;

use crate::body::Posed;
use crate::solver::NormalEquations;

/// −log p(one kind of data | pose and shape), up to a constant; never negative.
pub trait Term: Send + Sync {
    /// Name, as in results.
    fn name(&self) -> &'static str;
    /// The term at a pose.
    fn cost(&self, body: &Posed<'_>) -> f64;
    /// Number of independent observations that its rows stand for.
    fn observations(&self) -> f64;
    /// Adds JᵀWJ and JᵀWr and returns the cost.
    ///
    /// Components of the state beyond the dimension of `equations` are held fixed: a problem in the
    /// motion alone passes equations of the motion's dimension.
    fn linearize(&self, body: &Posed<'_>, equations: &mut NormalEquations) -> f64;
    /// The residuals at a pose, those of one source in the order of its data (along a border).
    fn placed_residuals(&self, body: &Posed<'_>) -> Vec<PlacedResidual>;
    /// The same of the data that tell at a pose what they show: not folds of the skin, and not borders that two parts share.
    fn clear(&self, body: &Posed<'_>) -> Clear<'_> {
        Clear { residuals: self.placed_residuals(body), term: None }
    }
    /// What cameras side by side see differently, of a kind of data that can tell.
    fn parallax(&self, _body: &Posed<'_>) -> Option<Parallax> {
        None
    }
}

impl<T: Term + ?Sized> Term for &T {
    fn name(&self) -> &'static str {
        (**self).name()
    }

    fn cost(&self, body: &Posed<'_>) -> f64 {
        (**self).cost(body)
    }

    fn observations(&self) -> f64 {
        (**self).observations()
    }

    fn linearize(&self, body: &Posed<'_>, equations: &mut NormalEquations) -> f64 {
        (**self).linearize(body, equations)
    }

    fn placed_residuals(&self, body: &Posed<'_>) -> Vec<PlacedResidual> {
        (**self).placed_residuals(body)
    }

    fn clear(&self, body: &Posed<'_>) -> Clear<'_> {
        (**self).clear(body)
    }

    fn parallax(&self, body: &Posed<'_>) -> Option<Parallax> {
        (**self).parallax(body)
    }
}
