//! −log p(Z | m, s), one term per kind of data.
//!
//! | term                 | data                         | residual, unit            | source          |
//! |----------------------|------------------------------|---------------------------|-----------------|
//! | [`EllipseSilhouette`] | border points, distance map | distance to outlines, px  | ZS06, App. C    |
//! | [`SilhouetteRays`]   | border points                | distance to the skin, m   | PF02 § 3.2      |
//! | [`PointField`]       | points of the surface        | distance to the skin, m   | PF02 § 3.1      |
//!
//! Every term is ½ Σ w ρ((r/σ)²): r in the unit of its data, σ its standard deviation in that unit
//! (PFD99 eq. 11), w the number of independent observations that a row stands for, ρ a robust loss.

mod contact;
mod ellipse_distance;
mod ellipse_silhouette;
mod ellipse_sums;
mod ellipsoid_surface;
mod limb_sums;
mod local_length;
mod offset_row;
mod options;
mod point_field;
mod silhouette_ray;
mod skin_distance;
mod skin_term;
mod union;

pub use ellipse_distance::EllipseDistance;
pub use ellipse_silhouette::{EllipseOptions, EllipseSilhouette, EllipseView, Variant};
pub use options::{LikelihoodOptions, Measure};
pub use point_field::{PointField, PointOptions, SurfacePoint};
pub use silhouette_ray::{RayOptions, RayView, SilhouetteRays};
pub use skin_distance::{Derivatives, Residual, SkinScale};
pub use skin_term::SkinTouch;

use nalgebra::{Vector2, Vector3};

use crate::body::{PartId, Posed};
use crate::solver::NormalEquations;

/// Where an observation comes from.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum Source {
    /// A silhouette: its position among the frame's views.
    View(usize),
    /// A cloud of points.
    Cloud,
}

/// One residual, and where on the body it was measured.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PlacedResidual {
    /// Where it comes from.
    pub source: Source,
    /// r/σ.
    pub value: f64,
    /// ρ′: the part of its weight that the robust loss leaves, 1 for an inlier.
    pub trust: f64,
    /// σ, px for a view, metres for a cloud.
    pub sigma: f64,
    /// w: the number of independent observations that it stands for.
    pub weight: f64,
    /// Unit normal of the border there, away from the person, in undistorted pixels; 0 for a cloud.
    pub outward_px: Vector2<f64>,
    /// The part on which it was measured.
    pub part: PartId,
    /// Where on it, in the part's frame, metres.
    pub place_part: Vector3<f64>,
}

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
}
