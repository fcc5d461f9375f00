//! Orientations of the body's parts, in the axes of the ISB: X forwards, Y up the part, Z to the body's right.
//!
//! A fitted body's parts have axes of their own. Between joint centres and markers, axes are built from lines. What such
//! lines cannot show (the turn of a straight leg about itself, the tilt of a pelvis of which only the hips are known) is
//! listed in [`Segments::unknown`], not guessed.
//!
//! # Source
//! Wu et al., J. Biomech. 35 (2002) 543–548 (pelvis to foot) and 38 (2005) 981–992 (trunk, arm).

use std::collections::BTreeMap;

use nalgebra::Matrix3;

use super::angle::Angle;
use super::landmark::Side;
use crate::body::{BodyModel, Motion, PartId, Posed, Shape};

/// A part of a limb.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum Limb {
    /// Thigh.
    Thigh,
    /// Shank.
    Shank,
    /// Foot: X along the sole.
    Foot,
    /// Upper arm.
    UpperArm,
    /// Forearm.
    Forearm,
}

/// A part of the body.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum Segment {
    /// Pelvis.
    Pelvis,
    /// Thorax.
    Trunk,
    /// Part of a limb.
    Of(Side, Limb),
}

/// World from part, columns X Y Z; NaN where it is not known.
pub type Axes = Vec<Matrix3<f64>>;

/// The orientations of parts over time, and what cannot be known from them.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Segments {
    /// Part by part.
    pub axes: BTreeMap<Segment, Axes>,
    /// Standard deviations of angles, radians; only of a fitted body.
    pub angle_sd: BTreeMap<(Side, Angle), Vec<f64>>,
    /// Angles that cannot be known, and why.
    pub unknown: BTreeMap<Angle, &'static str>,
}

/// Parts of the shipped body models.
const PARTS: [(&str, Limb); 5] = [
    ("thigh", Limb::Thigh),
    ("shank", Limb::Shank),
    ("foot", Limb::Foot),
    ("upper_arm", Limb::UpperArm),
    ("forearm", Limb::Forearm),
];

impl Segments {
    /// The parts of a fitted body; the motion of a frame in which nobody was seen is `None`.
    ///
    /// Parts are found by their names in the shipped models.
    pub(crate) fn from_body(model: &BodyModel, shape: &Shape, motions: &[Option<Motion>]) -> Self {
        let mut segments = Self::default();
        let posed = |motion: &Option<Motion>| Some(Posed::new(model, shape, motion.as_ref()?));
        let bodies: Vec<Option<Posed<'_>>> = motions.iter().map(posed).collect();

        for (segment, part) in Self::model_parts(model) {
            let part_axes = |body: &Posed<'_>| isb_from_model(&body.world_from_part(part));
            let axes = bodies.iter().map(|b| b.as_ref().map_or(unknown(), part_axes));
            segments.axes.insert(segment, axes.collect());
        }

        if has_hinges(model) {
            let reason = "the knee of the fitted body is a hinge: it only bends";
            segments.unknown.insert(Angle::KneeAdduction, reason);
            segments.unknown.insert(Angle::KneeRotation, reason);
        }
        segments
    }

    /// The segments of a body model, and its parts.
    pub(crate) fn model_parts(model: &BodyModel) -> Vec<(Segment, PartId)> {
        let trunk = [(Segment::Pelvis, "pelvis".to_owned()), (Segment::Trunk, "thorax".to_owned())];
        let limbs = PARTS.into_iter().flat_map(|(name, limb)| {
            Side::BOTH
                .map(|side| (Segment::Of(side, limb), format!("{name}_{}", &side.name()[..1])))
        });
        let part = |name: &str| model.parts.iter().position(|p| p.name == name);
        let found = |(segment, name): (Segment, String)| Some((segment, PartId(part(&name)?)));
        trunk.into_iter().chain(limbs).filter_map(found).collect()
    }
}

/// Whether one joint, and no more, leads from thigh to shank.
fn has_hinges(model: &BodyModel) -> bool {
    let depth = |name: &str| {
        let part = model.parts.iter().find(|p| p.name == name)?;
        Some(model.chain(part.joint).len())
    };
    matches!((depth("thigh_r"), depth("shank_r")), (Some(thigh), Some(shank)) if shank == thigh + 1)
}

pub(super) fn unknown() -> Matrix3<f64> {
    Matrix3::repeat(f64::NAN)
}

/// ISB axes (forwards, up, right) from the model's (forwards, left, up).
fn isb_from_model(world_from_part: &Matrix3<f64>) -> Matrix3<f64> {
    let column = |i: usize| world_from_part.column(i).into_owned();
    Matrix3::from_columns(&[column(0), column(2), -column(1)])
}
