//! Which terms a likelihood is made of, and the settings of each.

use super::{EllipseOptions, KeypointOptions, PointOptions, PointResidual, RayOptions, Residual};
use crate::solver::Loss;

/// What silhouettes and points are compared with.
#[derive(Debug, Clone, Copy, PartialEq, Eq, serde::Serialize, serde::Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Measure {
    /// Silhouettes with the outlines of the ellipsoids (ZS06, App. C).
    Ellipses,
    /// Lines of sight and points with the skin of the metaballs (PF02 eq. 7, § 3.2).
    Metaballs,
    /// With both.
    Both,
}

impl Measure {
    /// Ellipsoids are looked at.
    pub fn has_ellipses(self) -> bool {
        self != Self::Metaballs
    }

    /// Metaballs are looked at.
    pub fn has_metaballs(self) -> bool {
        self != Self::Ellipses
    }
}

/// Settings of every term.
#[derive(Debug, Clone, Copy, Default, PartialEq, serde::Serialize, serde::Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct LikelihoodOptions {
    /// Silhouettes against ellipsoids.
    pub ellipses: EllipseOptions,
    /// Silhouettes against metaballs.
    pub rays: RayOptions,
    /// Points against metaballs.
    pub points: PointOptions,
    /// Detections against joints.
    pub keypoints: KeypointOptions,
}

impl LikelihoodOptions {
    /// Lines of sight and points by T − F in least squares, as published (PF02 eq. 7).
    pub fn by_field(mut self) -> Self {
        (self.rays.residual, self.rays.loss) = (Residual::Field, Loss::Squared);
        (self.points.residual, self.points.loss) = (PointResidual::Field, Loss::Squared);
        self
    }
}
