//! The movement of a fitted body, as gait analysis and other programs take it.
//!
//! Places, orientations and angles stand evenly in time, each with the standard deviation that the fit gave it.

use nalgebra::{Matrix3, Point3, Vector3};
use serde::{Deserialize, Serialize};

use crate::body::{BodyModel, Motion, Shape};
use crate::gait::{
    Angle, Landmark, Limb, Movement, MovementError, Paired, Segment, Segments, Side, Track,
};
use crate::inference::covariance::FrameUncertainty;
use crate::silhouette::FrameIndex;

/// Standard deviations of one frame of a fitted body.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct FrameSd {
    /// Of the root's origin, world axes.
    pub position_m: [f64; 3],
    /// Of the orientation of each of the model's parts, about its own axes.
    pub parts_rad: Vec<[f64; 3]>,
    /// Of the joints' angles.
    pub angles_rad: Vec<f64>,
    /// Of the points' places, world axes.
    pub points_m: Vec<[f64; 3]>,
    /// Of the vector from each left point to its right twin, world axes, in the order of the right ones; empty in results
    /// of versions that did not write it.
    #[serde(default)]
    pub apart_m: Vec<[f64; 3]>,
}

impl From<&FrameUncertainty> for FrameSd {
    fn from(uncertainty: &FrameUncertainty) -> Self {
        let point = |covariance: &Matrix3<f64>| covariance.diagonal().map(f64::sqrt).into();
        Self {
            position_m: uncertainty.position_sd_m.into(),
            parts_rad: uncertainty.parts_sd.iter().map(|sd| (*sd).into()).collect(),
            angles_rad: uncertainty.angles_sd.as_slice().to_vec(),
            points_m: uncertainty.points.iter().map(point).collect(),
            apart_m: uncertainty.apart.iter().map(point).collect(),
        }
    }
}

/// A fitted body in one frame.
#[derive(Debug, Clone, PartialEq)]
pub struct FramePose {
    /// Which frame.
    pub frame: FrameIndex,
    /// Whether a camera saw the person; otherwise the motion is a guess.
    pub is_seen: bool,
    /// mᵢ.
    pub motion: Motion,
    /// Places of the points, world.
    pub points_m: Vec<[f64; 3]>,
    /// How sure they are; only of the joint optimum.
    pub sd: Option<FrameSd>,
    /// A bit for each of the first seven cameras: whether it saw the person.
    pub cameras: u8,
}

/// A fitted body, frame by frame.
#[derive(Debug, Clone, PartialEq)]
pub struct FittedMotion {
    /// Its model.
    pub model: BodyModel,
    /// s.
    pub shape: Shape,
    /// Frames per second.
    pub rate_hz: f64,
    /// Names of the points, in the order of [`FramePose::points_m`].
    pub points: Vec<String>,
    /// In ascending order; numbers may be left out.
    pub frames: Vec<FramePose>,
}

/// A fitted body, evenly in time.
#[derive(Debug, Clone, PartialEq)]
pub struct FittedBody {
    /// Its model.
    pub model: BodyModel,
    /// s.
    pub shape: Shape,
    /// mᵢ; `None` in a frame in which nobody was seen.
    pub motions: Vec<Option<Motion>>,
    /// The points that it names.
    pub points: Vec<FittedPoint>,
    /// Per frame a bit for each of the first seven cameras: whether it saw the person.
    pub cameras: Vec<u8>,
}

/// A point of a fitted body over time.
#[derive(Debug, Clone, PartialEq)]
pub struct FittedPoint {
    /// Its name in the model.
    pub name: String,
    /// Places in the world; NaN where nobody was seen.
    pub track: Track,
    /// Their standard deviations, world axes; NaN where they are not known.
    pub sd_m: Track,
}

impl FittedMotion {
    /// The movement for gait analysis, and the body for the formats of other programs.
    ///
    /// # Errors
    /// [`MovementError`] if the body has no hips, knees, ankles or toes, or there are too few frames.
    pub fn into_movement(self) -> Result<(Movement, FittedBody), MovementError> {
        let first_frame = self.frames.first().map_or(0, |f| f.frame.0);
        let frames = evenly(&self.frames);

        let row = |frame: &Option<&FramePose>| -> Vec<Option<Point3<f64>>> {
            let points = frame.map_or(&[][..], |f| &f.points_m);
            points.iter().map(|p| Some(Point3::from(*p))).collect()
        };
        let places: Vec<_> = frames.iter().map(row).collect();
        let mut movement = Movement::from_points(self.rate_hz, first_frame, &self.points, &places)?;

        let motion = |frame: &Option<&FramePose>| Some((*frame)?.motion.clone());
        let motions: Vec<Option<Motion>> = frames.iter().map(motion).collect();
        let mut segments = Segments::from_body(&self.model, &self.shape, &motions);
        add_part_sd(&mut segments, &self.model, &frames);
        add_joint_sd(&mut segments, &self.model, &frames);
        movement.segments = Some(segments);

        let points = fitted_points(&self.points, &frames);
        add_place_sd(&mut movement, &points);
        add_apart_sd(&mut movement, &self.model, &frames);

        let cameras = frames.iter().map(|f| f.map_or(0, |f| f.cameras)).collect();
        let body = FittedBody { model: self.model, shape: self.shape, motions, points, cameras };
        Ok((movement, body))
    }
}

/// Most frame numbers that a fit may leave out per frame that it has.
const MOST_GAPS: usize = 1000;

/// One place for every frame number; `None` where nobody was seen.
fn evenly(frames: &[FramePose]) -> Vec<Option<&FramePose>> {
    let first = frames.first().map_or(0, |f| f.frame.0);
    let last = frames.last().map_or(0, |f| f.frame.0);
    let count = (last.saturating_sub(first) + 1).min(MOST_GAPS * frames.len().max(1));
    let mut even = vec![None; count];
    for frame in frames.iter().filter(|f| f.is_seen) {
        let place = frame.frame.0.checked_sub(first);
        if let Some(slot) = place.and_then(|i| even.get_mut(i)) {
            *slot = Some(frame);
        }
    }
    even
}

/// One row of a frame's numbers as a vector; NaN where there is none.
fn vector_or_nan(row: Option<&[f64; 3]>) -> Vector3<f64> {
    row.map_or(Vector3::repeat(f64::NAN), |row| Vector3::from(*row))
}

fn fitted_points(names: &[String], frames: &[Option<&FramePose>]) -> Vec<FittedPoint> {
    let point = |(i, name): (usize, &String)| {
        let place = |f: &Option<&FramePose>| vector_or_nan(f.and_then(|f| f.points_m.get(i)));
        let sd =
            |f: &Option<&FramePose>| vector_or_nan(f.and_then(|f| f.sd.as_ref()?.points_m.get(i)));
        FittedPoint {
            name: name.clone(),
            track: frames.iter().map(place).collect(),
            sd_m: frames.iter().map(sd).collect(),
        }
    };
    names.iter().enumerate().map(point).collect()
}

/// Adds the standard deviations of joint angles.
fn add_joint_sd(segments: &mut Segments, model: &BodyModel, frames: &[Option<&FramePose>]) {
    for side in Side::BOTH {
        let letter = &side.name()[..1];
        for angle in Angle::ALL {
            let joint = angle.model_joint().map(|name| format!("{name}_{letter}"));
            let Some(joint) = joint.and_then(|name| model.joint(&name)) else {
                continue;
            };

            let sd = |frame: &Option<&FramePose>| {
                let sd = frame.and_then(|f| f.sd.as_ref());
                sd.and_then(|sd| sd.angles_rad.get(joint.0)).copied()
            };
            if frames.iter().any(|f| sd(f).is_some()) {
                let sd = frames.iter().map(|f| sd(f).unwrap_or(f64::NAN)).collect();
                segments.angle_sd.insert((side, angle), sd);
            }
        }
    }
}

/// Adds the standard deviations of the angles of pelvis, trunk and feet in the room.
///
/// To first order in tilt and obliquity, obliquity turns pelvis and trunk about their own forward axis, tilt about their
/// axis to the left and rotation about their upward axis. A foot turned by δ about its own upward axis turns its direction
/// on the floor by δ/cos θ, with θ the pitch of its sole.
fn add_part_sd(segments: &mut Segments, model: &BodyModel, frames: &[Option<&FramePose>]) {
    for (segment, part) in Segments::model_parts(model) {
        let sd = |frame: &Option<&FramePose>| {
            vector_or_nan(frame.and_then(|f| f.sd.as_ref()?.parts_rad.get(part.0)))
        };
        let sd: Vec<Vector3<f64>> = frames.iter().map(sd).collect();
        if sd.iter().all(|sd| sd.x.is_nan()) {
            continue;
        }

        let about = |axis: usize| sd.iter().map(move |sd| sd[axis]);
        let angles_about_axes = match segment {
            Segment::Pelvis => [Angle::PelvisObliquity, Angle::PelvisTilt, Angle::PelvisRotation],
            Segment::Trunk => [Angle::TrunkObliquity, Angle::TrunkTilt, Angle::TrunkRotation],
            Segment::Of(side, Limb::Foot) => {
                // cos θ: how much of the foot's forward axis lies in the floor
                let axes = segments.axes.get(&segment).into_iter().flatten();
                let level = axes.map(|axes| axes.column(0).xy().norm());
                let turned = about(2).zip(level).map(|(sd, level)| sd / level).collect();
                let key = (side, Angle::FootProgression);
                segments.angle_sd.insert(key, turned);
                continue;
            }
            Segment::Of(..) => continue,
        };

        for (axis, angle) in angles_about_axes.into_iter().enumerate() {
            for side in Side::BOTH {
                let sd = about(axis).collect();
                segments.angle_sd.insert((side, angle), sd);
            }
        }
    }
}

/// Adds the standard deviations of the model's points; a heel found from the ankle has the ankle's.
fn add_place_sd(movement: &mut Movement, points: &[FittedPoint]) {
    for point in points {
        let Some((landmark, _)) = Landmark::from_name(&point.name) else {
            continue;
        };
        if point.sd_m.iter().any(|sd| sd.x.is_finite()) {
            if let Landmark::Of(side, Paired::Ankle) = landmark {
                let heel = Landmark::Of(side, Paired::Heel);
                movement.sd_m.entry(heel).or_insert(point.sd_m.clone());
            }
            movement.sd_m.insert(landmark, point.sd_m.clone());
        }
    }
}

/// Adds the standard deviations of the vectors from left to right places.
fn add_apart_sd(movement: &mut Movement, model: &BodyModel, frames: &[Option<&FramePose>]) {
    for (i, (right, _)) in model.point_pairs().into_iter().enumerate() {
        let landmark = Landmark::from_name(&model.points[right].name);
        let Some((Landmark::Of(_, place), _)) = landmark else {
            continue;
        };
        let sd = |frame: &Option<&FramePose>| {
            vector_or_nan(frame.and_then(|f| f.sd.as_ref()?.apart_m.get(i)))
        };
        let track: Track = frames.iter().map(sd).collect();
        if track.iter().any(|sd| sd.x.is_finite()) {
            movement.apart_sd_m.insert(place, track);
        }
    }
}

#[cfg(test)]
mod tests {
    use std::path::Path;

    use nalgebra::Rotation3;

    use super::*;

    #[test]
    fn trunk_and_feet_err_about_their_own_axes_and_a_raised_foot_twice_as_much_on_the_floor() {
        let model = crate::io::model::load("human-ellipsoids", Path::new("")).unwrap();
        let pitched = Rotation3::from_axis_angle(&Vector3::y_axis(), 60_f64.to_radians());
        let motion = Motion { world_from_root: pitched, ..Motion::straight(&model) };
        let shape = Shape(model.statistics.mean.clone());
        let frame = FramePose {
            frame: FrameIndex(0),
            is_seen: true,
            motion: motion.clone(),
            points_m: Vec::new(),
            sd: Some(FrameSd {
                position_m: [0.0; 3],
                parts_rad: vec![[0.01, 0.02, 0.03]; model.parts.len()],
                angles_rad: vec![0.0; model.joints.len()],
                points_m: Vec::new(),
                apart_m: Vec::new(),
            }),
            cameras: 0,
        };
        let mut segments = Segments::from_body(&model, &shape, &[Some(motion)]);
        add_part_sd(&mut segments, &model, &[Some(&frame)]);
        for (angle, expected) in [
            (Angle::TrunkObliquity, 0.01),
            (Angle::TrunkTilt, 0.02),
            (Angle::PelvisRotation, 0.03),
            (Angle::FootProgression, 0.06),
        ] {
            let sd = segments.angle_sd[&(Side::Left, angle)][0];
            assert!((sd - expected).abs() < 1e-9, "{angle:?}: {sd}");
        }
    }
}
