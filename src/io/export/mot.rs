//! OpenSim's motion files: the coordinates of Rajagopal's model, by name and sign.
//!
//! `.mot` and `.sto` differ in their title and in whether angles are degrees. Ground is the file's world, Y up.
//!
//! # Source
//! Rajagopal et al., IEEE Trans. Biomed. Eng. 63 (2016) 2068–2079: names, axes, signs, and where the pelvis' origin lies.

use std::fmt::Write;

use nalgebra::{Matrix3, Vector3};

use super::FrameTable;
use crate::camera::UpAxis;
use crate::gait::{
    Angle, GaitAnalysis, Landmark, Limb, Movement, Segment, Segments, Side, cardan_zxy,
};

/// The origin of Rajagopal's pelvis (between the ASIS) from the middle of its hips, in its own axes, metres, unscaled.
const PELVIS_FROM_HIPS: [f64; 3] = [0.0563, 0.0785, 0.0];

/// Which file it is to be.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum TableKind {
    /// Motion: degrees.
    Mot,
    /// Storage: radians.
    Sto,
}

/// A coordinate over time.
type Column = (String, Vec<f64>);

const OF_LEG: [(Angle, &str); 5] = [
    (Angle::HipFlexion, "hip_flexion"),
    (Angle::HipAdduction, "hip_adduction"),
    (Angle::HipRotation, "hip_rotation"),
    (Angle::KneeFlexion, "knee_angle"),
    (Angle::AnkleDorsiflexion, "ankle_angle"),
];

const OF_ARM: [(Angle, &str); 4] = [
    (Angle::ShoulderFlexion, "arm_flex"),
    (Angle::ShoulderAdduction, "arm_add"),
    (Angle::ShoulderRotation, "arm_rot"),
    (Angle::ElbowFlexion, "elbow_flex"),
];

/// The coordinates of Rajagopal's model that a fit knows; those that it does not (subtalar, toes) are 0.
///
/// Radians and metres. `None` if the recording has no oriented pelvis.
pub fn coordinates(movement: &Movement, gait: &GaitAnalysis) -> Option<FrameTable> {
    let segments = movement.segments.as_ref()?;
    let pelvis = segments.axes.get(&Segment::Pelvis)?;
    let mut table = FrameTable::new(movement, "time");
    let columns = &mut table.columns;
    columns.extend(pelvis_columns(pelvis, movement.track(Landmark::MidHip)?));
    for side in [Side::Right, Side::Left] {
        columns.extend(side_columns(segments, gait, side, movement.frames));
    }

    if let Some(trunk) = segments.axes.get(&Segment::Trunk) {
        let turn = |(p, t): (&Matrix3<f64>, &Matrix3<f64>)| cardan_zxy(&(p.transpose() * t));
        let turns: Vec<[f64; 3]> = pelvis.iter().zip(trunk).map(turn).collect();
        columns.extend(three(["lumbar_extension", "lumbar_bending", "lumbar_rotation"], &turns));
    }

    Some(table)
}

fn pelvis_columns(pelvis: &[Matrix3<f64>], hips: &[Vector3<f64>]) -> Vec<Column> {
    let turn = |axes: &Matrix3<f64>| cardan_zxy(&(UpAxis::Y.export_from_world() * axes));
    let turns: Vec<[f64; 3]> = pelvis.iter().map(turn).collect();
    let origin = |(hips, axes): (&Vector3<f64>, &Matrix3<f64>)| -> [f64; 3] {
        UpAxis::Y.to_export(&(hips + axes * Vector3::from(PELVIS_FROM_HIPS))).into()
    };
    let origins: Vec<[f64; 3]> = hips.iter().zip(pelvis).map(origin).collect();
    let mut columns = three(["pelvis_tilt", "pelvis_list", "pelvis_rotation"], &turns);
    for (_, values) in &mut columns {
        *values = continuous(values);
    }
    columns.extend(three(["pelvis_tx", "pelvis_ty", "pelvis_tz"], &origins));
    columns
}

fn side_columns(
    segments: &Segments,
    gait: &GaitAnalysis,
    side: Side,
    frames: usize,
) -> Vec<Column> {
    let known = |angle| gait.angles.get(&(side, angle)).cloned();
    let column =
        |(angle, name): (Angle, &'static str)| (name, known(angle).unwrap_or(vec![0.0; frames]));
    let mut columns: Vec<(&str, Vec<f64>)> = OF_LEG.into_iter().map(column).collect();
    columns.push(("subtalar_angle", vec![0.0; frames]));
    columns.push(("mtp_angle", vec![0.0; frames]));
    columns.extend(OF_ARM.into_iter().map(column));
    columns.push(("pro_sup", forearm_turn(segments, side, frames)));
    let letter = &side.name()[..1];
    let own = |(name, values): (&str, Vec<f64>)| (format!("{name}_{letter}"), values);
    columns.into_iter().map(own).collect()
}

fn three(names: [&str; 3], rows: &[[f64; 3]]) -> Vec<Column> {
    let column = |(i, name): (usize, &str)| (name.to_owned(), rows.iter().map(|r| r[i]).collect());
    names.into_iter().enumerate().map(column).collect()
}

/// Turn of the forearm about its own length in the upper arm, inwards; 0 where it is not known.
fn forearm_turn(segments: &Segments, side: Side, n: usize) -> Vec<f64> {
    let axes = |limb| segments.axes.get(&Segment::Of(side, limb));
    let (Some(upper), Some(fore)) = (axes(Limb::UpperArm), axes(Limb::Forearm)) else {
        return vec![0.0; n];
    };
    let sign = if side == Side::Right { 1.0 } else { -1.0 };
    let turn = |(u, f): (&Matrix3<f64>, &Matrix3<f64>)| sign * cardan_zxy(&(u.transpose() * f))[2];
    upper.iter().zip(fore).map(turn).collect()
}

/// Without jumps of whole turns.
fn continuous(values: &[f64]) -> Vec<f64> {
    let turn = std::f64::consts::TAU;
    let mut before = None;
    let step = |&value: &f64| {
        let near = before.map_or(value, |b: f64| value - turn * ((value - b) / turn).round());
        if near.is_finite() {
            before = Some(near);
        }
        near
    };
    values.iter().map(step).collect()
}

/// The text of a file. Frames with unknown values are left out: OpenSim has no missing values.
pub fn motion_text(table: &FrameTable, kind: TableKind, name: &str) -> String {
    let is_known = |i: &usize| table.columns.iter().all(|(_, values)| values[*i].is_finite());
    let rows: Vec<usize> = (0..table.frames.len()).filter(is_known).collect();

    let (title, in_degrees) = match kind {
        TableKind::Mot => ("Coordinates", "yes"),
        TableKind::Sto => (name, "no"),
    };
    let (n, m) = (rows.len(), table.columns.len());
    let mut text = format!(
        "{title}\nversion=1\nnRows={n}\nnColumns={m}\ninDegrees={in_degrees}\n\nUnits are S.I. units (second, meters, Newtons, ...)\n\
         If the header above contains a line with 'inDegrees', this indicates whether rotational values are in degrees (yes) or radians (no).\n\n\
         endheader\n"
    );

    let names: Vec<&str> = table.columns.iter().map(|(name, _)| name.as_str()).collect();
    let _ = writeln!(text, "{}", names.join("\t"));

    for i in rows {
        let number = |(name, values): &Column| match kind {
            TableKind::Mot if is_angle(name) => format!("{:16.8}", values[i].to_degrees()),
            _ => format!("{:16.8}", values[i]),
        };
        let row: Vec<String> = table.columns.iter().map(number).collect();
        let _ = writeln!(text, "{}", row.join("\t"));
    }

    text
}

/// Whether a column is an angle, and neither the time nor a place of the pelvis.
fn is_angle(name: &str) -> bool {
    name != "time" && (!name.starts_with("pelvis_t") || name == "pelvis_tilt")
}
