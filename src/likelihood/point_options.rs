//! How points of the surface are compared with the skin.

use crate::solver::Loss;

/// What a point is compared by.
#[derive(Debug, Clone, Copy, PartialEq, Eq, serde::Serialize, serde::Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum PointResidual {
    /// Signed distance to the nearest place of the skin, metres.
    Distance,
    /// PF02 eq. 7: T − F at the point, over the slope of a limb of radius 5 cm.
    Field,
}

/// Settings of the point likelihood.
#[derive(Debug, Clone, Copy, PartialEq, serde::Serialize, serde::Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct PointOptions {
    /// Which residual.
    pub residual: PointResidual,
    /// σ_m: standard deviation of the body's surface about the skin, m.
    pub sigma_m: f64,
    /// Length over which errors go together, m; 0 makes every point an observation of its own.
    pub correlation_m: f64,
    /// Robust loss, in standard deviations.
    pub loss: Loss,
}

impl Default for PointOptions {
    fn default() -> Self {
        Self {
            residual: PointResidual::Distance,
            sigma_m: 0.01,
            correlation_m: 0.1,
            loss: Loss::Cauchy(3.0),
        }
    }
}
