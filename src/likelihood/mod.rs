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

mod association;
mod contact;
mod ellipse_distance;
mod ellipse_silhouette;
mod ellipse_sums;
mod limb_sums;
mod point_field;
mod silhouette_ray;
mod skin_distance;
mod union;

pub use association::{Belonging, associate};
pub use ellipse_distance::{EllipseDistance, OutlineEllipse, exact_distance};
pub use ellipse_silhouette::{EllipseOptions, EllipseSilhouette, Variant, View, ViewResiduals};
pub use point_field::{PointField, PointOptions, PointResidual, SurfacePoint};
pub use silhouette_ray::{RayOptions, RayResidual, RayView, SilhouetteRays};
pub use skin_distance::{Derivatives, Residual, SkinResidual, SkinScale};

use crate::body::Posed;
use crate::solver::NormalEquations;

/// −log p(one kind of data | pose and shape), up to a constant; never negative.
pub trait Term: Send + Sync {
    /// Name, as it stands in results.
    fn name(&self) -> &'static str;
    /// The term at a pose.
    fn cost(&self, body: &Posed<'_>) -> f64;
    /// Adds JᵀWJ and JᵀWr and returns the cost.
    ///
    /// Components of the state beyond the dimension of `equations` are held fixed: a problem in the
    /// motion alone passes equations of the motion's dimension.
    fn linearize(&self, body: &Posed<'_>, equations: &mut NormalEquations) -> f64;
}
