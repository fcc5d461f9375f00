//! Which terms a likelihood is made of, and the settings of each.

use super::{EllipseOptions, KeypointOptions, PointOptions, RayOptions};

/// What silhouettes and points are compared with.
#[derive(Debug, Clone, Copy, PartialEq, Eq, serde::Serialize, serde::Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Measure {
    /// Silhouettes with the outlines of the ellipsoids (ZS06).
    Ellipses,
    /// Lines of sight and points with the skin of the metaballs (PF02).
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
