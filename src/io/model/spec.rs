//! A model file as it is written.

use std::collections::BTreeMap;

use serde::Deserialize;

use super::side::Sides;
use crate::body::Limbs;

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct ModelSpec {
    pub(super) name: String,
    pub(super) root: RootSpec,
    #[serde(default)]
    pub(super) factors: Vec<String>,
    #[serde(default, rename = "coefficient")]
    pub(super) coefficients: Vec<CoefficientSpec>,
    #[serde(rename = "part")]
    pub(super) parts: Vec<PartSpec>,
    #[serde(default, rename = "point")]
    pub(super) points: Vec<PointSpec>,
    #[serde(default, rename = "pose")]
    pub(super) poses: Vec<PoseSpec>,
    #[serde(default, rename = "length")]
    pub(super) lengths: Vec<LengthSpec>,
}

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct RootSpec {
    #[serde(default)]
    pub(super) fixed: bool,
    #[serde(default = "walking_speed")]
    pub(super) speed: f64,
    #[serde(default = "walking_turn")]
    pub(super) turn_deg: f64,
}

fn walking_speed() -> f64 {
    2.0
}
fn walking_turn() -> f64 {
    120.0
}

/// One logarithmic coefficient: mean 0 unless given, sd its own spread, loadings those that it shares.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct CoefficientSpec {
    pub(super) name: String,
    #[serde(default)]
    pub(super) mean: f64,
    pub(super) sd: f64,
    #[serde(default)]
    pub(super) loadings: BTreeMap<String, f64>,
    #[serde(default)]
    pub(super) sides: Sides,
}

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct PartSpec {
    pub(super) name: String,
    pub(super) parent: Option<String>,
    #[serde(default)]
    pub(super) sides: Sides,
    #[serde(default)]
    pub(super) at: [f64; 3],
    pub(super) at_scale: Option<[String; 3]>,
    #[serde(default)]
    pub(super) turn_deg: [f64; 3],
    pub(super) pivot: Option<[String; 3]>,
    #[serde(default)]
    pub(super) sd: [f64; 3],
    #[serde(default)]
    pub(super) folds: bool,
    #[serde(default)]
    pub(super) scale: [String; 3],
    #[serde(default, rename = "joint")]
    pub(super) joints: Vec<JointSpec>,
    #[serde(default, rename = "ellipsoid")]
    pub(super) ellipsoids: Vec<PrimitiveSpec>,
    #[serde(default, rename = "metaball")]
    pub(super) metaballs: Vec<PrimitiveSpec>,
}

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct JointSpec {
    pub(super) name: String,
    pub(super) axis: Option<AxisSpec>,
    pub(super) dh: Option<DhSpec>,
    pub(super) limits_deg: [f64; 2],
    #[serde(default)]
    pub(super) rest_deg: f64,
    pub(super) spread_deg: f64,
    pub(super) speed_deg: f64,
}

#[derive(Debug, Deserialize)]
#[serde(untagged)]
pub(super) enum AxisSpec {
    Letter(String),
    Vector([f64; 3]),
}

/// Modified Denavit–Hartenberg parameters: Rot_x(α)·Trans_x(a)·Trans_z(d)·Rot_z(θ₀), then the joint about z.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct DhSpec {
    #[serde(default)]
    pub(super) a: f64,
    #[serde(default)]
    pub(super) alpha_deg: f64,
    #[serde(default)]
    pub(super) d: f64,
    #[serde(default)]
    pub(super) theta_deg: f64,
}

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct PrimitiveSpec {
    pub(super) centre: [f64; 3],
    pub(super) centre_scale: Option<[String; 3]>,
    pub(super) radii: [f64; 3],
    pub(super) radii_scale: Option<[String; 3]>,
    #[serde(default)]
    pub(super) turn_deg: [f64; 3],
    #[serde(default = "rigid")]
    pub(super) follows: f64,
}

fn rigid() -> f64 {
    1.0
}

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct PointSpec {
    pub(super) name: String,
    pub(super) part: Option<String>,
    #[serde(default)]
    pub(super) at: [f64; 3],
    pub(super) at_scale: Option<[String; 3]>,
    pub(super) sd: Option<[f64; 3]>,
    #[serde(default)]
    pub(super) midpoint: Vec<String>,
}

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct PoseSpec {
    pub(super) name: String,
    pub(super) limbs: Limbs,
    #[serde(default)]
    pub(super) angles_deg: BTreeMap<String, f64>,
}

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct LengthSpec {
    pub(super) name: String,
    pub(super) from: String,
    pub(super) to: String,
}
