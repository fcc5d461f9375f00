//! A recording for gait analysis, from a TRC of any system or from the folder of a fit.

use std::path::{Path, PathBuf};

use nalgebra::{Point3, Vector3};

use crate::body::{BodyModel, Motion, Shape};
use crate::gait::{
    Angle, Landmark, Limb, Movement, MovementError, Paired, Segment, Segments, Side, Track,
};
use crate::io::model::{self, ModelFileError};
use crate::io::points::trc::{TrcError, rate_of_times, read_trc};
use crate::io::result::{FramePart, ResultError, ResultFile};

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

/// Why nothing can be analysed.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum GaitInputError {
    /// A file that cannot be read.
    #[error("{}: cannot be read: {source}", path.display())]
    Read {
        /// The file.
        path: PathBuf,
        /// Why.
        source: std::io::Error,
    },
    /// No TRC.
    #[error(transparent)]
    Trc(#[from] TrcError),
    /// Two frame rates.
    #[error(
        "{}: the header states {stated_hz} Hz, the Time column {counted_hz:.6} Hz: give the right one with --fps",
        path.display()
    )]
    Rate {
        /// The file.
        path: PathBuf,
        /// DataRate.
        stated_hz: f64,
        /// Of the times.
        counted_hz: f64,
    },
    /// Points of which no gait can be made.
    #[error("{}: {source}", path.display())]
    Movement {
        /// The file.
        path: PathBuf,
        /// Why.
        source: MovementError,
    },
    /// No fit.
    #[error(transparent)]
    Result(#[from] ResultError),
    /// The body of the fit.
    #[error(transparent)]
    Model(#[from] ModelFileError),
}

/// What was read.
#[derive(Debug, Clone, PartialEq)]
pub struct GaitInput {
    /// The moving body.
    pub movement: Movement,
    /// `points` or the name of the fitted body.
    pub source: String,
    /// The body of a fit.
    pub body: Option<FittedBody>,
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
    /// For each frame a bit for each camera that saw the person, the first seven of them.
    pub cameras: Vec<u8>,
}

/// Reads a TRC; `fps` replaces the rate that it states.
///
/// # Errors
/// [`GaitInputError`] names the file, and the line where there is one.
pub fn read_points(path: &Path, fps: Option<f64>) -> Result<GaitInput, GaitInputError> {
    let bytes = std::fs::read(path).map_err(|source| GaitInputError::Read {
        path: path.into(),
        source,
    })?;
    let text = String::from_utf8_lossy(&bytes);
    let points = read_trc(&text, path)?;
    let stated_hz = points.rate_hz;
    match (fps, rate_of_times(&text)) {
        (None, Some(counted_hz)) if (counted_hz / stated_hz - 1.0).abs() > 0.02 => {
            let path = path.into();
            return Err(GaitInputError::Rate {
                path,
                stated_hz,
                counted_hz,
            });
        }
        _ => {}
    }
    let rate_hz = fps.unwrap_or(stated_hz);
    let movement =
        Movement::from_points(rate_hz, points.first_frame, &points.names, &points.frames);
    Ok(GaitInput {
        movement: movement.map_err(|source| GaitInputError::Movement {
            path: path.into(),
            source,
        })?,
        source: "points".into(),
        body: None,
    })
}

/// Reads the folder of a fit: places and parts of the body with their standard deviations.
///
/// `body` is the model of the fit, if it is not a shipped one; `fps` replaces the rate of the recording.
///
/// # Errors
/// [`GaitInputError`].
pub fn read_fit(
    folder: &Path,
    body: Option<&str>,
    fps: Option<f64>,
) -> Result<GaitInput, GaitInputError> {
    let result = ResultFile::read(folder)?;
    let model = model::load(body.unwrap_or(&result.body), Path::new(""))?;
    let shape = result.shape_of(&model)?;
    let frames = evenly(&result);
    let place = |frame: &Option<&FramePart>| -> Vec<Option<Point3<f64>>> {
        let points = frame.map_or(&[][..], |f| &f.points_m);
        points.iter().map(|p| Some(Point3::from(*p))).collect()
    };
    let points: Vec<_> = frames.iter().map(place).collect();
    let rate_hz = fps.unwrap_or(result.recording.fps);
    let first = result.recording.first_frame;
    let movement = Movement::from_points(rate_hz, first, &result.motion.points, &points);
    let mut movement = movement.map_err(|source| GaitInputError::Movement {
        path: folder.join("result.json"),
        source,
    })?;
    let motions: Vec<Option<Motion>> = frames.iter().map(|f| Some((*f)?.motion())).collect();
    let mut segments = Segments::of_body(&model, &shape, &motions);
    deviations_of_angles(&mut segments, &model, &frames);
    movement.segments = Some(segments);
    let named = fitted_points(&result, &frames);
    deviations_of_places(&mut movement, &named);
    deviations_apart(&mut movement, &model, &frames);
    Ok(GaitInput {
        movement,
        body: Some(FittedBody {
            points: named,
            cameras: cameras(&result, &frames),
            model,
            shape,
            motions,
        }),
        source: result.body,
    })
}

/// Most frame numbers that a fit may leave out, for each frame that it has.
const MOST_GAPS: usize = 1000;

/// One place for every frame number; `None` where nobody was seen.
fn evenly(result: &ResultFile) -> Vec<Option<&FramePart>> {
    let frames = &result.motion.frames;
    let first = frames.first().map_or(0, |f| f.frame);
    let last = frames.last().map_or(0, |f| f.frame);
    let count = (last.saturating_sub(first) + 1).min(MOST_GAPS * frames.len().max(1));
    let mut even = vec![None; count];
    for frame in frames.iter().filter(|f| f.views > 0) {
        let place = frame.frame.checked_sub(first);
        if let Some(slot) = place.and_then(|i| even.get_mut(i)) {
            *slot = Some(frame);
        }
    }
    even
}

fn fitted_points(result: &ResultFile, frames: &[Option<&FramePart>]) -> Vec<FittedPoint> {
    let unknown = Vector3::repeat(f64::NAN);
    let of = |place: Option<&[f64; 3]>| place.map_or(unknown, |p| Vector3::from(*p));
    let point = |(i, name): (usize, &String)| {
        let place = |f: &Option<&FramePart>| of(f.and_then(|f| f.points_m.get(i)));
        let sd = |f: &Option<&FramePart>| of(f.and_then(|f| f.sd.as_ref()?.points_m.get(i)));
        FittedPoint {
            name: name.clone(),
            track: frames.iter().map(place).collect(),
            sd_m: frames.iter().map(sd).collect(),
        }
    };
    result.motion.points.iter().enumerate().map(point).collect()
}

/// Which of the first seven cameras saw the person, as bits.
fn cameras(result: &ResultFile, frames: &[Option<&FramePart>]) -> Vec<u8> {
    let mut of_frame = std::collections::BTreeMap::new();
    for view in &result.quality.views {
        let place = result
            .recording
            .cameras
            .iter()
            .position(|c| *c == view.camera);
        if let Some(camera) = place.filter(|c| *c < 7) {
            *of_frame.entry(view.frame).or_insert(0) |= 1_u8 << camera;
        }
    }
    let seen = |frame: &Option<&FramePart>| frame.and_then(|f| of_frame.get(&f.frame).copied());
    frames.iter().map(|f| seen(f).unwrap_or(0)).collect()
}

fn deviations_of_angles(segments: &mut Segments, model: &BodyModel, frames: &[Option<&FramePart>]) {
    deviations_in_the_room(segments, model, frames);
    for side in Side::BOTH {
        let letter = &side.name()[..1];
        for angle in Angle::ALL {
            let joint = angle.model_joint().map(|name| format!("{name}_{letter}"));
            let Some(joint) = joint.and_then(|name| model.joint(&name)) else {
                continue;
            };
            let sd = |frame: &Option<&FramePart>| {
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

/// Angles of pelvis, trunk and feet in the room.
///
/// To first order in tilt and obliquity, pelvis and trunk are turned by obliquity about their own axis that points forwards, by
/// tilt about the one to the left and by rotation about the one upwards. A foot's direction on the floor turns with the
/// foot about its own upward axis, by 1/cos θ of that when its sole is pitched by θ.
fn deviations_in_the_room(
    segments: &mut Segments,
    model: &BodyModel,
    frames: &[Option<&FramePart>],
) {
    for (segment, part) in Segments::of_model(model) {
        let sd = |frame: &Option<&FramePart>| {
            let known = frame.and_then(|f| f.sd.as_ref()?.parts_rad.get(part.0));
            known.map_or(Vector3::repeat(f64::NAN), |sd| Vector3::from(*sd))
        };
        let sd: Vec<Vector3<f64>> = frames.iter().map(sd).collect();
        if sd.iter().all(|sd| sd.x.is_nan()) {
            continue;
        }
        let about = |axis: usize| sd.iter().map(move |sd| sd[axis]);
        let mut both_sides = |angles: [Angle; 3]| {
            for (axis, angle) in angles.into_iter().enumerate() {
                for side in Side::BOTH {
                    segments
                        .angle_sd
                        .insert((side, angle), about(axis).collect());
                }
            }
        };
        match segment {
            Segment::Pelvis => both_sides([
                Angle::PelvisObliquity,
                Angle::PelvisTilt,
                Angle::PelvisRotation,
            ]),
            Segment::Trunk => both_sides([
                Angle::TrunkObliquity,
                Angle::TrunkTilt,
                Angle::TrunkRotation,
            ]),
            Segment::Of(side, Limb::Foot) => {
                let axes = segments.axes.get(&segment).into_iter().flatten();
                let level = axes.map(|axes| axes.column(0).xy().norm());
                let turned = about(2).zip(level).map(|(sd, level)| sd / level).collect();
                let key = (side, Angle::FootProgression);
                segments.angle_sd.insert(key, turned);
            }
            Segment::Of(..) => {}
        }
    }
}

/// Standard deviations of the model's points; a heel errs as the ankle does that it was found from.
fn deviations_of_places(movement: &mut Movement, points: &[FittedPoint]) {
    for point in points {
        let Some((landmark, _)) = Landmark::of_name(&point.name) else {
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

/// Standard deviations of the ways from left to right places.
fn deviations_apart(movement: &mut Movement, model: &BodyModel, frames: &[Option<&FramePart>]) {
    for (i, (right, _)) in model.point_pairs().into_iter().enumerate() {
        let landmark = Landmark::of_name(&model.points[right].name);
        let Some((Landmark::Of(_, place), _)) = landmark else {
            continue;
        };
        let sd = |frame: &Option<&FramePart>| {
            let known = frame.and_then(|f| f.sd.as_ref()?.apart_m.get(i));
            known.map_or(Vector3::repeat(f64::NAN), |sd| Vector3::from(*sd))
        };
        let track: Vec<_> = frames.iter().map(sd).collect();
        if track.iter().any(|sd| sd.x.is_finite()) {
            movement.apart_sd_m.insert(place, track);
        }
    }
}

#[cfg(test)]
mod tests {
    use nalgebra::Rotation3;

    use super::*;
    use crate::io::result::FrameSdPart;

    #[test]
    fn trunk_and_feet_err_about_their_own_axes_and_a_raised_foot_twice_as_much_on_the_floor() {
        let model = model::load("human-ellipsoids", Path::new("")).unwrap();
        let pitched = Rotation3::from_axis_angle(&Vector3::y_axis(), 60_f64.to_radians());
        let motion = Motion {
            world_from_root: pitched,
            ..Motion::straight(&model)
        };
        let shape = Shape(model.statistics.mean.clone());
        let frame = FramePart {
            frame: 0,
            time_s: 0.0,
            views: 1,
            recovered: false,
            position_m: [0.0; 3],
            rotation_rad: pitched.scaled_axis().into(),
            angles_rad: motion.angles.as_slice().to_vec(),
            points_m: Vec::new(),
            sd: Some(FrameSdPart {
                position_m: [0.0; 3],
                parts_rad: vec![[0.01, 0.02, 0.03]; model.parts.len()],
                angles_rad: vec![0.0; model.joints.len()],
                points_m: Vec::new(),
                apart_m: Vec::new(),
            }),
            data: 0.0,
            pose: 0.0,
            step: 0.0,
        };
        let mut segments = Segments::of_body(&model, &shape, &[Some(motion)]);
        deviations_of_angles(&mut segments, &model, &[Some(&frame)]);
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
