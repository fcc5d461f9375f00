//! Joint angles over time: Cardan angles of one part's ISB axes in another's, as Grood and Suntay define them.
//!
//! Joints: R = Rot_z(flexion)·Rot_x(adduction)·Rot_y(rotation), the distal part's axes in the proximal part's. So
//! flexion is about the proximal part's axis to the right, rotation about the distal part's long axis. Pelvis and trunk
//! in the room: R = Rot_y(rotation)·Rot_x(obliquity)·Rot_z(tilt), from the axes of the direction of walking (Baker
//! 2001). Signs are the same on both sides of the body: see [`Angle::positive`], also for where OpenSim differs.
//!
//! # Source
//! Grood & Suntay, J. Biomech. Eng. 105 (1983) 136–144; Wu et al. 2002, 2005; Baker, Gait Posture 13 (2001) 1–6.

use std::collections::BTreeMap;

use nalgebra::{Matrix3, Vector3};

use super::angle::Angle;
use super::landmark::Side;
use super::segments::{Limb, Segment, Segments};

/// Angles over time, radians; NaN where they are not known.
pub type AngleTracks = BTreeMap<(Side, Angle), Vec<f64>>;

/// All angles that the parts show, except those that cannot be known.
///
/// `heading` is the horizontal direction of walking in each frame.
pub(super) fn angles(segments: &Segments, heading: &[Vector3<f64>]) -> AngleTracks {
    let mut tracks = AngleTracks::new();
    for side in Side::BOTH {
        let in_room = room_angles(segments, heading, side);
        let of_joints = joint_angles(segments, side);
        for (angle, values) in in_room.into_iter().chain(of_joints) {
            tracks.insert((side, angle), values);
        }
    }
    tracks.retain(|(_, angle), values| {
        !segments.unknown.contains_key(angle) && values.iter().any(|v| v.is_finite())
    });
    tracks.values_mut().for_each(|values| unwrap(values));
    tracks
}

const PELVIS: [Angle; 3] = [Angle::PelvisTilt, Angle::PelvisObliquity, Angle::PelvisRotation];
const TRUNK: [Angle; 3] = [Angle::TrunkTilt, Angle::TrunkObliquity, Angle::TrunkRotation];
const HIP: [Angle; 3] = [Angle::HipFlexion, Angle::HipAdduction, Angle::HipRotation];
const KNEE: [Angle; 3] = [Angle::KneeFlexion, Angle::KneeAdduction, Angle::KneeRotation];
const SHOULDER: [Angle; 3] =
    [Angle::ShoulderFlexion, Angle::ShoulderAdduction, Angle::ShoulderRotation];

/// Pelvis, trunk and foot against the direction of walking.
fn room_angles(
    segments: &Segments,
    heading: &[Vector3<f64>],
    side: Side,
) -> Vec<(Angle, Vec<f64>)> {
    let mut found = Vec::new();
    for (segment, names) in [(Segment::Pelvis, PELVIS), (Segment::Trunk, TRUNK)] {
        let Some(axes) = segments.axes.get(&segment) else {
            continue;
        };
        let triple = |(axes, heading): (&Matrix3<f64>, &Vector3<f64>)| {
            let [rotation, obliquity, tilt] = yxz(&(room(heading).transpose() * axes));
            [-tilt, -side.sign() * obliquity, side.sign() * rotation]
        };
        let triples: Vec<[f64; 3]> = axes.iter().zip(heading).map(triple).collect();
        found.extend(columns(names, &triples));
    }

    if let Some(axes) = segments.axes.get(&Segment::Of(side, Limb::Foot)) {
        let inwards = |(axes, heading): (&Matrix3<f64>, &Vector3<f64>)| {
            let x = room(heading).transpose() * axes.column(0);
            -side.sign() * x.z.atan2(x.x)
        };
        let values = axes.iter().zip(heading).map(inwards).collect();
        found.push((Angle::FootProgression, values));
    }
    found
}

/// Hip, knee, ankle, shoulder and elbow of one side.
fn joint_angles(segments: &Segments, side: Side) -> Vec<(Angle, Vec<f64>)> {
    let triples = |proximal: Segment, distal: Limb| -> Vec<[f64; 3]> {
        let distal = Segment::Of(side, distal);
        let (Some(p), Some(d)) = (segments.axes.get(&proximal), segments.axes.get(&distal)) else {
            return Vec::new();
        };
        let triple = |(p, d): (&Matrix3<f64>, &Matrix3<f64>)| {
            let [flexion, adduction, rotation] = cardan_zxy(&(p.transpose() * d));
            [flexion, side.sign() * adduction, side.sign() * rotation]
        };
        p.iter().zip(d).map(triple).collect()
    };

    let hip = triples(Segment::Pelvis, Limb::Thigh);
    let mut knee = triples(Segment::Of(side, Limb::Thigh), Limb::Shank);
    // a knee bends backwards
    for [flexion, ..] in &mut knee {
        *flexion = -*flexion;
    }
    let ankle = triples(Segment::Of(side, Limb::Shank), Limb::Foot);
    let shoulder = triples(Segment::Trunk, Limb::UpperArm);
    let elbow = triples(Segment::Of(side, Limb::UpperArm), Limb::Forearm);

    let mut found = columns(HIP, &hip);
    found.extend(columns(KNEE, &knee));
    found.extend(columns(SHOULDER, &shoulder));
    let flexions = |triples: &[[f64; 3]]| triples.iter().map(|t| t[0]).collect();
    found.push((Angle::AnkleDorsiflexion, flexions(&ankle)));
    found.push((Angle::ElbowFlexion, flexions(&elbow)));
    found
}

fn columns(names: [Angle; 3], triples: &[[f64; 3]]) -> Vec<(Angle, Vec<f64>)> {
    let column = |(i, name): (usize, Angle)| (name, triples.iter().map(|t| t[i]).collect());
    names.into_iter().enumerate().map(column).collect()
}

/// Axes of the room: X the direction of walking, Y up, Z to its right.
fn room(heading: &Vector3<f64>) -> Matrix3<f64> {
    Matrix3::from_columns(&[*heading, Vector3::z(), heading.cross(&Vector3::z())])
}

/// \[α, β, γ\] of R = Rot_z(α)·Rot_x(β)·Rot_y(γ), radians; β within ±90°.
pub fn cardan_zxy(r: &Matrix3<f64>) -> [f64; 3] {
    let beta = r[(2, 1)].clamp(-1.0, 1.0).asin();
    [(-r[(0, 1)]).atan2(r[(1, 1)]), beta, (-r[(2, 0)]).atan2(r[(2, 2)])]
}

/// [α, β, γ] of R = Rot_y(α)·Rot_x(β)·Rot_z(γ).
fn yxz(r: &Matrix3<f64>) -> [f64; 3] {
    let beta = (-r[(1, 2)]).clamp(-1.0, 1.0).asin();
    [r[(0, 2)].atan2(r[(2, 2)]), beta, r[(1, 0)].atan2(r[(1, 1)])]
}

/// Removes jumps of whole turns.
fn unwrap(values: &mut [f64]) {
    let mut before = f64::NAN;
    for value in values {
        if before.is_finite() && value.is_finite() {
            let turns = ((*value - before) / std::f64::consts::TAU).round();
            *value -= turns * std::f64::consts::TAU;
        }
        if value.is_finite() {
            before = *value;
        }
    }
}

#[cfg(test)]
mod tests {
    use nalgebra::Rotation3;

    use super::*;

    fn turn(axis: usize, angle: f64) -> Matrix3<f64> {
        let axis = [Vector3::x_axis(), Vector3::y_axis(), Vector3::z_axis()][axis];
        *Rotation3::from_axis_angle(&axis, angle).matrix()
    }

    #[test]
    fn cardan_angles_are_those_that_made_the_rotation() {
        let r = turn(2, 0.5) * turn(0, -0.2) * turn(1, 0.3);
        for (found, made) in cardan_zxy(&r).iter().zip([0.5, -0.2, 0.3]) {
            approx::assert_relative_eq!(*found, made, epsilon = 1e-12);
        }
        let r = turn(1, 0.5) * turn(0, -0.2) * turn(2, 0.3);
        for (found, made) in yxz(&r).iter().zip([0.5, -0.2, 0.3]) {
            approx::assert_relative_eq!(*found, made, epsilon = 1e-12);
        }
    }

    /// A body that stands facing `heading`, with one part turned about an axis of its own.
    fn standing(part: Segment, axis: usize, angle: f64) -> AngleTracks {
        let heading = Vector3::new(0.6, 0.8, 0.0);
        let mut segments = Segments::default();
        let mut parts = vec![Segment::Pelvis, Segment::Trunk];
        for side in Side::BOTH {
            for limb in [Limb::Thigh, Limb::Shank, Limb::Foot, Limb::UpperArm, Limb::Forearm] {
                parts.push(Segment::Of(side, limb));
            }
        }
        for segment in parts {
            let own = if segment == part { turn(axis, angle) } else { Matrix3::identity() };
            segments.axes.insert(segment, vec![room(&heading) * own]);
        }
        angles(&segments, &[heading])
    }

    #[test]
    fn every_sign_is_the_documented_one() {
        let (left, right) = (Side::Left, Side::Right);
        // part, axis turned about, angle that shows it, its sign on the left and on the right
        let cases = [
            (Segment::Pelvis, 2, Angle::PelvisTilt, [-1.0, -1.0]),
            (Segment::Pelvis, 0, Angle::PelvisObliquity, [1.0, -1.0]),
            (Segment::Pelvis, 1, Angle::PelvisRotation, [-1.0, 1.0]),
        ];
        for (part, axis, angle, signs) in cases {
            let tracks = standing(part, axis, 0.1);
            for (side, sign) in [left, right].into_iter().zip(signs) {
                approx::assert_relative_eq!(tracks[&(side, angle)][0], 0.1 * sign, epsilon = 1e-12);
            }
        }
        // a right thigh turned about Z swings forwards, about X inwards, about Y inwards
        for (axis, angle) in [Angle::HipFlexion, Angle::HipAdduction, Angle::HipRotation]
            .into_iter()
            .enumerate()
            .map(|(i, a)| ([2, 0, 1][i], a))
        {
            for (side, sign) in [(right, 1.0), (left, if axis == 2 { 1.0 } else { -1.0 })] {
                let tracks = standing(Segment::Of(side, Limb::Thigh), axis, 0.1);
                approx::assert_relative_eq!(tracks[&(side, angle)][0], 0.1 * sign, epsilon = 1e-12);
            }
        }
        let bent = standing(Segment::Of(right, Limb::Shank), 2, -0.4);
        approx::assert_relative_eq!(bent[&(right, Angle::KneeFlexion)][0], 0.4, epsilon = 1e-12);
        let toes = standing(Segment::Of(right, Limb::Foot), 1, 0.1);
        approx::assert_relative_eq!(
            toes[&(right, Angle::FootProgression)][0],
            0.1,
            epsilon = 1e-12
        );
        let toes = standing(Segment::Of(left, Limb::Foot), 2, 0.1);
        approx::assert_relative_eq!(
            toes[&(left, Angle::AnkleDorsiflexion)][0],
            0.1,
            epsilon = 1e-12
        );
    }
}
