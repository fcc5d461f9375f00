//! Whether cameras, masks and body speak of one scene, before anything is fitted to it.
//!
//! Two cameras *agree* about a frame if the two lines of sight through the middles of their silhouettes come
//! nearest to each other before both, at a point that both see near their silhouette. Only pixels are compared, so
//! this holds in every unit of length; the unit shows in how large the silhouettes are where the cameras agree.

use nalgebra::Point2;

use super::diagnosis::{CameraFaults, camera_causes};
use super::{Cause, FitError, Warning};
use crate::body::{BodyModel, Motion, Posed, Shape};
use crate::camera::{Camera, CameraId, Rig, closest_point};
use crate::inference::hull::{self, Hull, LEAST_POINTS, locates_body};
use crate::math::stats::median;
use crate::silhouette::{FrameObservations, Silhouette};

/// Frames that are looked at, evenly spaced.
const SAMPLED_FRAMES: usize = 50;
/// A camera that agrees with others in less than this share of their meetings is odd: the worst of good cameras
/// beside a bad one is one of two, at one half.
const ODD: f64 = 0.2;
/// Seen size over the body's size, and its inverse, beyond which the unit is doubted: nobody is six times as tall.
const SIZE_RATIO: f64 = 6.0;

/// How many numbers between the first frame and the last may be of no frame: a quarter of an hour at 100 Hz.
pub(crate) const MOST_EMPTY_FRAMES: usize = 100_000;

/// Whether anything is seen, by at least two cameras, that look at one place, in a size that the body can have.
///
/// A camera without a point in common with the others by calibration alone is a fault only if its silhouettes
/// confirm that: along a corridor no point need be seen by all. One whose silhouettes alone disagree is a warning.
///
/// # Errors
/// [`FitError`], the most basic first.
pub fn check_scene(
    model: &BodyModel,
    rig: &Rig,
    frames: &[FrameObservations],
) -> Result<Vec<Warning>, FitError> {
    // 1. two cameras see something, in frames that are numbered as such
    numbered(frames)?;
    seen_by_two(rig, frames)?;
    // 2. the cameras agree where it is
    let step = frames.len().div_ceil(SAMPLED_FRAMES).max(1);
    let sampled: Vec<&FrameObservations> = frames.iter().step_by(step).collect();
    let odd = odd_cameras(rig, &sampled);
    let warnings =
        common_view(rig, &odd).map_err(|fault| named(in_frames(fault, &sampled), rig, frames))?;
    // 3. it is as large as the body
    size(model, rig, &sampled)?;
    Ok(warnings)
}

fn numbered(frames: &[FrameObservations]) -> Result<(), FitError> {
    let (Some(first), Some(last)) = (frames.first(), frames.last()) else {
        return Err(FitError::NoFrames);
    };
    let (first, last) = (first.frame, last.frame);
    match (last.0 - first.0).saturating_sub(frames.len()) {
        empty if empty > MOST_EMPTY_FRAMES => Err(FitError::Sparse { first, last, empty }),
        _ => Ok(()),
    }
}

/// The cause of cameras that share no view, where there is one, or else the fault itself.
fn named(fault: FitError, rig: &Rig, frames: &[FrameObservations]) -> FitError {
    let causes = camera_causes(rig, &CameraFaults::of(rig, frames)).into_iter();
    let is_displaced = |cause: &Cause| matches!(cause, Cause::Displaced { .. });
    let causes: Vec<Cause> = causes.filter(|cause| !is_displaced(cause)).collect();
    if causes.is_empty() { fault } else { FitError::Cameras(causes) }
}

fn seen_by_two(rig: &Rig, frames: &[FrameObservations]) -> Result<(), FitError> {
    if frames.iter().any(locates_body) {
        return Ok(());
    }

    let seen = |id: CameraId| {
        let sees = |f: &&FrameObservations| f.views.iter().any(|(camera, _)| *camera == id);
        frames.iter().filter(sees).count()
    };
    let most = rig.iter().map(|(id, camera)| (seen(id), camera)).max_by_key(|(n, _)| *n);
    match most {
        Some((count, camera)) if count > 0 => {
            Err(FitError::NeverTwo { camera: camera.name.clone(), frames: count })
        }
        _ => Err(nothing_seen(rig, frames)),
    }
}

fn nothing_seen(rig: &Rig, frames: &[FrameObservations]) -> FitError {
    let mut rejected = frames.iter().flat_map(|f| f.rejected.iter().map(|r| (f.frame, *r)));
    let first = rejected.next();
    let named =
        first.and_then(|(frame, (id, reason))| Some((frame, rig.camera(id)?.name.clone(), reason)));

    match named {
        Some((frame, camera, reason)) => {
            FitError::NothingSeen { masks: 1 + rejected.count(), camera, frame, reason }
        }
        None if frames.iter().any(FrameObservations::is_observed) => FitError::FewPoints {
            least: LEAST_POINTS,
            most: frames.iter().map(|f| f.points.len()).max().unwrap_or(0),
        },
        None => FitError::NoFrames,
    }
}

/// The cameras that agree with hardly any other.
fn odd_cameras(rig: &Rig, frames: &[&FrameObservations]) -> Vec<CameraId> {
    let count = rig.cameras.len();
    let (mut meetings, mut agreements) = (vec![0usize; count], vec![0usize; count]);
    for frame in frames {
        for (k, (i, a)) in frame.views.iter().enumerate() {
            for (j, b) in &frame.views[..k] {
                let (a, b) = (Place::of(a), Place::of(b));
                let agree = agree((&rig.cameras[i.0], a), (&rig.cameras[j.0], b));
                for camera in [i.0, j.0] {
                    meetings[camera] += 1;
                    agreements[camera] += usize::from(agree);
                }
            }
        }
    }
    let is_odd =
        |i: &usize| meetings[*i] > 0 && (agreements[*i] as f64) < ODD * meetings[*i] as f64;
    (0..count).filter(is_odd).map(CameraId).collect()
}

/// Where a picture shows somebody: the middle, and the least and the largest pixel.
#[derive(Debug, Clone, Copy)]
pub(super) struct Place {
    pub(super) middle: Point2<f64>,
    pub(super) bounds: (Point2<f64>, Point2<f64>),
}

impl Place {
    pub(super) fn of(silhouette: &Silhouette) -> Self {
        Self { middle: silhouette.centroid, bounds: silhouette.bounds }
    }
}

/// Whether two cameras see somebody at one place.
pub(super) fn agree(a: (&Camera, Place), b: (&Camera, Place)) -> bool {
    let rays = [a, b].map(|(camera, place)| camera.ray(&place.middle));
    closest_point(&rays).is_some_and(|point| {
        [a, b].iter().all(|(camera, place)| {
            let (low, high) = place.bounds;
            let margin = (high - low) * 0.5;
            camera.project_undistorted(&point).is_some_and(|pixel| {
                let (low, high) = (low - margin, high + margin);
                low.x <= pixel.x && pixel.x <= high.x && low.y <= pixel.y && pixel.y <= high.y
            })
        })
    })
}

/// The same fault, or where most masks are cut another cause: a person who is not yet in view.
fn in_frames(fault: FitError, frames: &[&FrameObservations]) -> FitError {
    let views = || frames.iter().flat_map(|frame| &frame.views);
    let cut = views().filter(|(_, silhouette)| silhouette.cut_px > 0.0).count();
    match fault {
        FitError::NoCommonView { cameras, .. } if 2 * cut > views().count() => {
            FitError::NotInView { cameras }
        }
        fault => fault,
    }
}

/// Refuses the odd cameras that share no point with the others, and warns of the other odd ones.
fn common_view(rig: &Rig, odd: &[CameraId]) -> Result<Vec<Warning>, FitError> {
    let names = |ids: &[CameraId]| -> Vec<String> {
        let camera = |id: &CameraId| Some(rig.camera(*id)?.name.clone());
        ids.iter().filter_map(camera).collect()
    };
    let blind = rig.common_view().map_or(Vec::new(), |view| view.blind);
    let both: Vec<_> = blind.iter().filter(|(id, _)| odd.contains(id)).collect();
    if let Some((_, why)) = both.first() {
        // without a majority nobody can say which camera is right
        let lost: Vec<CameraId> = if rig.cameras.len() - odd.len() < 2 {
            odd.to_vec()
        } else {
            both.iter().map(|(id, _)| *id).collect()
        };
        return Err(FitError::NoCommonView { cameras: names(&lost), why: why.to_string() });
    }
    if !odd.is_empty() && rig.cameras.len() - odd.len() < 2 {
        return Err(FitError::NoCommonView {
            cameras: names(odd),
            why: "it shows the person elsewhere".into(),
        });
    }
    let warning = |camera| Warning::OddCamera { camera };
    Ok(names(odd).into_iter().map(warning).collect())
}

fn size(model: &BodyModel, rig: &Rig, frames: &[&FrameObservations]) -> Result<(), FitError> {
    let mut sizes: Vec<f64> = frames.iter().flat_map(|frame| sizes_of_views(rig, frame)).collect();
    if sizes.is_empty() {
        let hulls = frames.iter().filter_map(|f| Hull::from_points(&f.points));
        sizes = hulls.map(|hull| hull.top - hull.bottom).collect();
    }
    let body_m = body_size(model);
    match median(&mut sizes) {
        Some(seen_m) if seen_m > SIZE_RATIO * body_m || seen_m * SIZE_RATIO < body_m => {
            Err(FitError::Size { seen_m, body: model.name.clone(), body_m })
        }
        _ => Ok(()),
    }
}

/// How large each silhouette is where the cameras see the body, m.
fn sizes_of_views(rig: &Rig, frame: &FrameObservations) -> Vec<f64> {
    let Some(subject) = hull::subject(rig, frame) else {
        return Vec::new();
    };
    let size = |(id, silhouette): &(CameraId, Silhouette)| {
        let camera = &rig.cameras[id.0];
        let depth = (camera.camera_from_world * subject).z;
        let (low, high) = silhouette.bounds;
        let focal_px = camera.intrinsics.focal_px();
        (depth > 0.0).then(|| (high - low).max() * depth / focal_px)
    };
    frame.views.iter().filter_map(size).collect()
}

/// Longest side of the box around the mean body at rest.
pub(super) fn body_size(model: &BodyModel) -> f64 {
    let shape = Shape(model.statistics.mean.clone());
    let body = Posed::new(model, &shape, &Motion::rest(model));
    body.bounds().map_or(0.0, |(low, high)| (high - low).max())
}
