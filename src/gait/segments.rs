//! Orientations of the body's parts, in the axes of the ISB: X forwards, Y up the part, Z to the body's right.
//!
//! Of a fitted body they are the parts' own axes. Of joint centres and markers they are built from lines between them,
//! and what such lines cannot show (the turn of a straight leg about itself, the tilt of a pelvis of which only the hips
//! are known) is said, not guessed: see [`Segments::unknown`].
//!
//! # Source
//! Wu et al., J. Biomech. 35 (2002) 543–548 (pelvis to foot) and 38 (2005) 981–992 (trunk, arm).

use std::collections::BTreeMap;

use nalgebra::{Matrix3, Vector3};

use super::angles::Angle;
use super::complete::pelvis_frame;
use super::landmark::{Landmark, Paired, Side};
use super::recording::{Recording, Track};
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

/// How far the line from ankle to toe slopes down in a foot that stands flat: atan(0.055/0.180), as in `complete.rs`.
const FOOT_SLOPE: f64 = 0.2966;

impl Segments {
    /// The parts of a fitted body; `None` for a frame nobody was seen in.
    ///
    /// Parts are found by the names that the shipped models give them.
    pub fn of_body(model: &BodyModel, shape: &Shape, motions: &[Option<Motion>]) -> Self {
        let mut segments = Self::default();
        let posed = |motion: &Option<Motion>| Some(Posed::new(model, shape, motion.as_ref()?));
        let bodies: Vec<Option<Posed<'_>>> = motions.iter().map(posed).collect();
        for (segment, part) in Self::of_model(model) {
            let axes = |body: &Option<Posed<'_>>| {
                body.as_ref()
                    .map_or(unknown(), |b| isb_from_model(&b.world_from_part(part)))
            };
            segments
                .axes
                .insert(segment, bodies.iter().map(axes).collect());
        }
        if has_hinges(model) {
            let reason = "the knee of the fitted body is a hinge: it only bends";
            segments.unknown.insert(Angle::KneeAdduction, reason);
            segments.unknown.insert(Angle::KneeRotation, reason);
        }
        segments
    }

    /// The segments that a body model has, and its parts.
    pub fn of_model(model: &BodyModel) -> Vec<(Segment, PartId)> {
        let trunk = [
            (Segment::Pelvis, "pelvis".to_owned()),
            (Segment::Trunk, "thorax".to_owned()),
        ];
        let limbs = PARTS.into_iter().flat_map(|(name, limb)| {
            Side::BOTH.map(|side| {
                (
                    Segment::Of(side, limb),
                    format!("{name}_{}", &side.name()[..1]),
                )
            })
        });
        let part = |name: &str| model.parts.iter().position(|p| p.name == name);
        let found = |(segment, name): (Segment, String)| Some((segment, PartId(part(&name)?)));
        trunk.into_iter().chain(limbs).filter_map(found).collect()
    }

    /// The parts that places of the body span.
    pub(super) fn of_landmarks(recording: &Recording) -> Self {
        let mut segments = Self::default();
        segments.pelvis(recording);
        segments.trunk(recording);
        for side in Side::BOTH {
            segments.leg(recording, side);
            segments.arm(recording, side);
        }
        segments.say_unknown(recording);
        segments
    }

    fn pelvis(&mut self, recording: &Recording) {
        let axes = match recording.spines() {
            Some(spines) => {
                let frame = |[l, r, b]: &[Vector3<f64>; 3]| pelvis_frame(l, r, b);
                spines
                    .iter()
                    .map(|s| frame(s).unwrap_or(unknown()))
                    .collect()
            }
            None => {
                let hips = Side::BOTH.map(|side| recording.of(side, Paired::Hip));
                let [Some(left), Some(right)] = hips else {
                    return;
                };
                let frame = |(l, r): (&Vector3<f64>, &Vector3<f64>)| level(&(r - l));
                left.iter().zip(right).map(frame).collect()
            }
        };
        self.axes.insert(Segment::Pelvis, axes);
    }

    fn trunk(&mut self, recording: &Recording) {
        let shoulders = Side::BOTH.map(|side| recording.of(side, Paired::Shoulder));
        let [Some(left), Some(right)] = shoulders else {
            return;
        };
        let Some(low) = recording.track(Landmark::MidHip) else {
            return;
        };
        let high: Track = match recording.track(Landmark::Neck) {
            Some(neck) => neck.clone(),
            None => left.iter().zip(right).map(|(l, r)| (l + r) * 0.5).collect(),
        };
        let axes =
            (0..recording.frames).map(|i| of_y_and_z(&(high[i] - low[i]), &(right[i] - left[i])));
        self.axes.insert(Segment::Trunk, axes.collect());
    }

    fn leg(&mut self, recording: &Recording, side: Side) {
        let place = |place| recording.of(side, place);
        let (Some(hip), Some(knee), Some(ankle), Some(toe), Some(pelvis)) = (
            place(Paired::Hip),
            place(Paired::Knee),
            place(Paired::Ankle),
            place(Paired::Toe),
            self.axes.get(&Segment::Pelvis),
        ) else {
            return;
        };
        let medial = place(Paired::KneeMedial);
        let medial_ankle = place(Paired::AnkleMedial);
        let heel = recording
            .has_heel_marker(side)
            .then(|| place(Paired::Heel))
            .flatten();
        let mut axes: [Axes; 3] = Default::default();
        for i in 0..recording.frames {
            // the flexion axis: from the epicondyles where both are marked, else the pelvis' own right
            let right = match medial {
                Some(inner) => (knee[i] - inner[i]) * side.sign(),
                None => pelvis[i].column(2).into_owned(),
            };
            let thigh = of_y_and_z(&(hip[i] - knee[i]), &right);
            let right = match medial_ankle {
                Some(inner) => (ankle[i] - inner[i]) * side.sign(),
                None => thigh.column(2).into_owned(),
            };
            let shank = of_y_and_z(&(knee[i] - ankle[i]), &right);
            let right = shank.column(2).into_owned();
            let foot = match heel {
                Some(heel) => of_x_and_z(&(toe[i] - heel[i]), &right),
                None => raised(&of_x_and_z(&(toe[i] - ankle[i]), &right)),
            };
            for (all, one) in axes.iter_mut().zip([thigh, shank, foot]) {
                all.push(one);
            }
        }
        for (limb, axes) in [Limb::Thigh, Limb::Shank, Limb::Foot].into_iter().zip(axes) {
            self.axes.insert(Segment::Of(side, limb), axes);
        }
    }

    fn arm(&mut self, recording: &Recording, side: Side) {
        let place = |place| recording.of(side, place);
        let (Some(shoulder), Some(elbow), Some(wrist), Some(trunk)) = (
            place(Paired::Shoulder),
            place(Paired::Elbow),
            place(Paired::Wrist),
            self.axes.get(&Segment::Trunk),
        ) else {
            return;
        };
        let mut axes: [Axes; 2] = Default::default();
        for i in 0..recording.frames {
            // an elbow bends about the normal of its plane; nearly straight it is taken to bend as the trunk does
            let (upper, lower) = (shoulder[i] - elbow[i], elbow[i] - wrist[i]);
            let normal = upper.cross(&lower);
            let bend = normal.norm() / (upper.norm() * lower.norm());
            let right = match bend > 0.17 {
                true => normal,
                false => trunk[i].column(2).into_owned(),
            };
            axes[0].push(of_y_and_z(&upper, &right));
            axes[1].push(of_y_and_z(&lower, &right));
        }
        for (limb, axes) in [Limb::UpperArm, Limb::Forearm].into_iter().zip(axes) {
            self.axes.insert(Segment::Of(side, limb), axes);
        }
    }

    fn say_unknown(&mut self, recording: &Recording) {
        if recording.spines().is_none() {
            let reason =
                "the hips alone do not show how the pelvis is tilted; it is taken to be upright";
            self.unknown.insert(Angle::PelvisTilt, reason);
        }
        let has = |place| {
            Side::BOTH
                .iter()
                .all(|side| recording.of(*side, place).is_some())
        };
        if !has(Paired::KneeMedial) {
            let reason =
                "the turn of a leg about itself needs a lateral and a medial marker on the knee";
            self.unknown.insert(Angle::HipRotation, reason);
        }
        if !has(Paired::KneeMedial) || !has(Paired::AnkleMedial) {
            let reason = "the axes of the shank need lateral and medial markers on knee and ankle";
            self.unknown.insert(Angle::KneeAdduction, reason);
            self.unknown.insert(Angle::KneeRotation, reason);
        }
        let reason = "the turn of an arm about itself is not shown by joint centres";
        self.unknown.insert(Angle::ShoulderRotation, reason);
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

fn unknown() -> Matrix3<f64> {
    Matrix3::repeat(f64::NAN)
}

/// The model's axes are forwards, left, up.
fn isb_from_model(world_from_part: &Matrix3<f64>) -> Matrix3<f64> {
    let column = |i: usize| world_from_part.column(i).into_owned();
    Matrix3::from_columns(&[column(0), column(2), -column(1)])
}

/// Axes with Y as given and Z as near as it can be.
fn of_y_and_z(y: &Vector3<f64>, z: &Vector3<f64>) -> Matrix3<f64> {
    let axes = || {
        let y = y.try_normalize(1e-9)?;
        let z = (z - y * z.dot(&y)).try_normalize(1e-9)?;
        Some(Matrix3::from_columns(&[y.cross(&z), y, z]))
    };
    axes().unwrap_or(unknown())
}

/// Axes with Z as given and Y as upright as it can be.
fn level(z: &Vector3<f64>) -> Matrix3<f64> {
    let axes = || {
        let z = z.try_normalize(1e-9)?;
        let x = Vector3::z().cross(&z).try_normalize(1e-9)?;
        Some(Matrix3::from_columns(&[x, z.cross(&x), z]))
    };
    axes().unwrap_or(unknown())
}

/// Axes with X as given and Z as near as it can be.
fn of_x_and_z(x: &Vector3<f64>, z: &Vector3<f64>) -> Matrix3<f64> {
    let axes = || {
        let x = x.try_normalize(1e-9)?;
        let z = (z - x * z.dot(&x)).try_normalize(1e-9)?;
        Some(Matrix3::from_columns(&[x, z.cross(&x), z]))
    };
    axes().unwrap_or(unknown())
}

/// Axes whose X was the line from ankle to toe, turned up until it lies along the sole.
fn raised(axes: &Matrix3<f64>) -> Matrix3<f64> {
    axes * nalgebra::Rotation3::from_axis_angle(&Vector3::z_axis(), FOOT_SLOPE).matrix()
}
