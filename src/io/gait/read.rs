//! A recording for gait analysis, from a TRC of any system or from the folder of a fit.

use std::path::{Path, PathBuf};

use nalgebra::{Point3, Vector3};

use crate::body::{BodyModel, Motion, Shape};
use crate::gait::{Angle, Landmark, Paired, Recording, RecordingError, Segments, Side, Track};
use crate::io::model::{self, ModelFileError};
use crate::io::result::{FramePart, ResultError, ResultFile};
use crate::io::trc::{TrcError, rate_of_times, read_trc};

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
    Recording {
        /// The file.
        path: PathBuf,
        /// Why.
        source: RecordingError,
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
    pub recording: Recording,
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
    let recording =
        Recording::of_points(rate_hz, points.first_frame, &points.names, &points.frames);
    Ok(GaitInput {
        recording: recording.map_err(|source| GaitInputError::Recording {
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
    let recording = Recording::of_points(rate_hz, first, &result.motion.points, &points);
    let mut recording = recording.map_err(|source| GaitInputError::Recording {
        path: folder.join("result.json"),
        source,
    })?;
    let motions: Vec<Option<Motion>> = frames.iter().map(|f| Some((*f)?.motion())).collect();
    let mut segments = Segments::of_body(&model, &shape, &motions);
    deviations_of_angles(&mut segments, &model, &frames);
    recording.segments = Some(segments);
    let named = fitted_points(&result, &frames);
    deviations_of_places(&mut recording, &named);
    deviations_apart(&mut recording, &model, &frames);
    Ok(GaitInput {
        recording,
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
    deviations_of_pelvis(segments, model, frames);
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

/// The three angles of a pelvis that is the root: to first order in its tilt and obliquity they turn it about its own axes,
/// obliquity about the one that points forwards, tilt to the left, rotation up.
fn deviations_of_pelvis(segments: &mut Segments, model: &BodyModel, frames: &[Option<&FramePart>]) {
    if model.parts.first().is_none_or(|root| root.name != "pelvis") {
        return;
    }
    let about = [
        Angle::PelvisObliquity,
        Angle::PelvisTilt,
        Angle::PelvisRotation,
    ];
    for (axis, angle) in about.into_iter().enumerate() {
        let sd = |frame: &Option<&FramePart>| Some(frame.as_ref()?.sd.as_ref()?.rotation_rad[axis]);
        if frames.iter().any(|f| sd(f).is_some()) {
            let sd: Vec<f64> = frames.iter().map(|f| sd(f).unwrap_or(f64::NAN)).collect();
            for side in Side::BOTH {
                segments.angle_sd.insert((side, angle), sd.clone());
            }
        }
    }
}

/// Standard deviations of the model's points; a heel errs as the ankle does that it was found from.
fn deviations_of_places(recording: &mut Recording, points: &[FittedPoint]) {
    for point in points {
        let Some((landmark, _)) = Landmark::of_name(&point.name) else {
            continue;
        };
        if point.sd_m.iter().any(|sd| sd.x.is_finite()) {
            if let Landmark::Of(side, Paired::Ankle) = landmark {
                let heel = Landmark::Of(side, Paired::Heel);
                recording.sd_m.entry(heel).or_insert(point.sd_m.clone());
            }
            recording.sd_m.insert(landmark, point.sd_m.clone());
        }
    }
}

/// Standard deviations of the ways from left to right places.
fn deviations_apart(recording: &mut Recording, model: &BodyModel, frames: &[Option<&FramePart>]) {
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
            recording.apart_sd_m.insert(place, track);
        }
    }
}
