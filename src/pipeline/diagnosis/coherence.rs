//! Whether the silhouettes agree with each other, whatever body they show; where there are none, the detections (`joint_misses`).
//!
//! A point p on the border of a silhouette shows a point of the person, somewhere along its line of sight x(t); there every
//! other camera sees the person too. By how much a line of sight *misses* the other silhouettes, in metres,
//!
//! ```text
//! miss(p) = min over t of max over cameras b of d_b(x(t)) · z_b(x(t)) / f_b
//! ```
//!
//! (d_b: pixels outside the silhouette of b, z_b: depth, f_b: focal length) is 0 for any body if cameras, clocks and masks are
//! right (silhouette coherence: Hernández, Schmitt & Cipolla, PAMI 2007). Its mean over border points, cameras and frames
//! compares hypotheses about a recording that no body needs to be fitted for: [`Reading`]s of its pictures.

use nalgebra::{Point2, Point3};
use rayon::prelude::*;

use super::joint_misses::{self, Sighted, as_read};
use super::reading::Reading;
use super::{detected_by_two, shown_by_two};
use crate::camera::{Camera, CameraId, Ray, Rig, closest_point};
use crate::math::stats::mean;
use crate::silhouette::{Detection, FrameObservations, Silhouette};

/// Frames that are looked at, evenly spaced; of detections, which err more and cost less, more of them.
const SAMPLED_FRAMES: usize = 8;
const DETECTED_FRAMES: usize = 24;
/// A bad hypothesis shows in every third of them.
const FEW: usize = 3;
/// Silhouettes that miss each other by less than this agree, metres: the step in which lines of sight are followed hides less. Detections by
/// less than this besides what published labels scatter by: a detector that is worse before one camera is no fault of the camera.
const QUIET_M: f64 = 0.001;
const QUIET_JOINTS_M: f64 = 0.01;
/// Border points of each silhouette that are looked at, and where a bad hypothesis need only show.
const BORDER_POINTS: f64 = 48.0;
const FEW_BORDER_POINTS: f64 = 16.0;
/// How far before and behind the subject a line of sight is followed, and in which steps, metres.
pub(super) const REACH_M: f64 = 1.6;
const STEP_M: f64 = 0.04;
/// A line of sight that misses by more than this misses altogether, metres.
pub(super) const MOST_M: f64 = 0.3;
/// What so many of the cameras that could see it see is there: of three others all, for two of them agree about many places.
pub(super) const NEARLY_ALL: f64 = 0.75;

/// The recording that hypotheses are about.
#[derive(Debug, Clone)]
pub(super) struct Scene<'a> {
    pub(super) rig: &'a Rig,
    frames: &'a [FrameObservations],
    sampled: Vec<usize>,
    /// What is compared.
    shows: Shows,
}

/// What a recording is compared by.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Shows {
    Outlines,
    Joints,
}

/// By camera of the rig, what its pictures show of a frame and how they are read.
type AsRead<'a, T> = Vec<(usize, &'a T, Reading)>;

/// By how much silhouettes miss each other, metres.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Misses {
    /// Camera by camera, mean over frames; `None` for one that is left out or sees nothing.
    pub(super) cameras: Vec<Option<f64>>,
    /// Frame by frame, mean over cameras; `None` where a camera that shows the frame is not there as it is read.
    pub(super) frames: Vec<Option<f64>>,
}

impl Misses {
    /// Mean over the frames; 0 without any.
    pub(super) fn mean_m(&self) -> f64 {
        mean(self.frames.iter().flatten().copied()).unwrap_or(0.0)
    }

    /// Which share of other misses these are, and in which share of the frames they are fewer; `None` unless both are known in
    /// half of the frames.
    pub(super) fn share_of(&self, others: &Self) -> Option<(f64, f64)> {
        let frames = self.frames.iter().zip(&others.frames);
        let both: Vec<(f64, f64)> = frames.filter_map(|(a, b)| Some(((*a)?, (*b)?))).collect();
        let sum = |of: fn(&(f64, f64)) -> f64| both.iter().map(of).sum::<f64>();
        let fewer = both.iter().filter(|(a, b)| a < b).count() as f64 / both.len().max(1) as f64;
        let known = 2 * both.len() >= self.frames.len() && sum(|b| b.1) > 0.0;
        known.then(|| (sum(|b| b.0) / sum(|b| b.1), fewer))
    }
}

/// A silhouette as a hypothesis reads it.
struct View<'a> {
    id: usize,
    camera: &'a Camera,
    silhouette: &'a Silhouette,
    reading: Reading,
}

impl<'a> Scene<'a> {
    /// A recording; frames that fewer than two cameras show are not looked at. Detections are where there are no outlines.
    pub(super) fn new(rig: &'a Rig, frames: &'a [FrameObservations]) -> Self {
        let outlines = shown_by_two(frames, SAMPLED_FRAMES);
        let (sampled, shows) = match outlines.is_empty() {
            false => (outlines, Shows::Outlines),
            true => (detected_by_two(frames, DETECTED_FRAMES), Shows::Joints),
        };
        Self { rig, frames, sampled, shows }
    }

    /// Whether outlines are compared, and not joints.
    pub(super) fn shows_outlines(&self) -> bool {
        self.shows == Shows::Outlines
    }

    /// What misses each other by less agrees, metres.
    pub(super) fn quiet_m(&self) -> f64 {
        match self.shows {
            Shows::Outlines => QUIET_M,
            Shows::Joints => QUIET_JOINTS_M,
        }
    }

    /// The share of the misses that leaving out a camera leaves at most: outlines of fewer cameras can only miss each other less, and
    /// joints that fewer cameras see are less certain.
    pub(super) fn most_left(&self) -> f64 {
        match self.shows {
            Shows::Outlines => 1.0,
            Shows::Joints => f64::INFINITY,
        }
    }

    /// Every camera as it is.
    pub(super) fn plain(&self) -> Vec<Option<Reading>> {
        self.rig.iter().map(|(id, _)| Some(Reading::plain(id))).collect()
    }

    /// By how much the silhouettes miss each other if each camera of the rig is read as `readings` say; `None` leaves it out.
    pub(super) fn misses(&self, readings: &[Option<Reading>]) -> Misses {
        self.misses_in(&self.sampled, readings, BORDER_POINTS)
    }

    /// The same, of every third frame and every third point of the borders: enough to drop a bad hypothesis.
    pub(super) fn few_misses(&self, readings: &[Option<Reading>]) -> Misses {
        let few: Vec<usize> = self.sampled.iter().step_by(FEW).copied().collect();
        self.misses_in(&few, readings, FEW_BORDER_POINTS)
    }

    fn misses_in(
        &self,
        sampled: &[usize],
        readings: &[Option<Reading>],
        border_points: f64,
    ) -> Misses {
        let of_frame = |i: &usize| match self.shows {
            Shows::Outlines => Some(frame_misses(&self.views(*i, readings)?, border_points)),
            Shows::Joints => {
                Some(joint_misses::frame_misses(self.rig, &self.joints(*i, readings)?))
            }
        };
        let frames: Vec<Option<Vec<(usize, f64)>>> = sampled.par_iter().map(of_frame).collect();

        let of_camera = |id: usize| {
            let all = frames.iter().flatten().flatten().filter(|(camera, _)| *camera == id);
            mean(all.map(|(_, miss)| *miss))
        };
        // a camera that agrees takes nothing away, whichever is left out; of joints, which are many cameras' together, the sum counts
        let total = |views: &Option<Vec<(usize, f64)>>| {
            let misses = views.iter().flatten().map(|v| v.1);
            match (self.shows, views) {
                (Shows::Joints, Some(_)) => {
                    Some(misses.sum::<f64>() / self.rig.cameras.len() as f64)
                }
                _ => mean(misses),
            }
        };
        Misses {
            cameras: (0..self.rig.cameras.len()).map(of_camera).collect(),
            frames: frames.iter().map(total).collect(),
        }
    }

    /// Of some pixels in the silhouette of a camera, those that show what the others do not: nowhere along their lines of sight do
    /// nearly all of the others see anything.
    pub(super) fn alone(
        &self,
        position: usize,
        camera: CameraId,
        pixels: &[Point2<f64>],
    ) -> Vec<Point2<f64>> {
        let views = self.views(position, &self.plain()).unwrap_or_default();
        let Some(own) = views.iter().position(|view| view.id == camera.0) else {
            return Vec::new();
        };
        let middle = |view: &View<'_>| view.camera.ray(&view.silhouette.centroid);
        let subject = closest_point(&views.iter().map(middle).collect::<Vec<Ray>>());
        let Some(subject) = subject else { return Vec::new() };
        let is_alone = |pixel: &&Point2<f64>| {
            let ray = views[own].camera.ray(pixel);
            let middle = (subject - ray.origin_world).dot(&ray.direction_world);
            !along(middle).any(|t| is_seen_by_nearly_all(&ray.point_at(t), &views, own))
        };
        pixels.iter().filter(is_alone).copied().collect()
    }

    /// The silhouettes of a frame; `None` as for [`Scene::read`].
    fn views(&self, position: usize, readings: &[Option<Reading>]) -> Option<Vec<View<'a>>> {
        let read = self.read(position, readings, |frame| &frame.views)?.into_iter();
        let view = |(id, silhouette, reading)| View {
            id,
            camera: &self.rig.cameras[id],
            silhouette,
            reading,
        };
        Some(read.map(view).collect())
    }

    /// The detections of a frame; `None` as for [`Scene::read`].
    fn joints(&self, position: usize, readings: &[Option<Reading>]) -> Option<Vec<Sighted>> {
        let read = self.read(position, readings, |frame| &frame.detections)?;
        let sighted = |(id, detection, reading): &(usize, &Detection, Reading)| {
            (CameraId(*id), as_read(&self.rig.cameras[*id], detection, reading))
        };
        Some(read.iter().map(sighted).collect())
    }

    /// What the cameras show of a frame; `None` if a camera is not there at the moment at which it is read, but shows the frame.
    fn read<T>(
        &self,
        position: usize,
        readings: &[Option<Reading>],
        of_frame: impl Fn(&'a FrameObservations) -> &'a Vec<(CameraId, T)>,
    ) -> Option<AsRead<'a, T>> {
        let shown = |frame: &'a FrameObservations, id: CameraId| {
            of_frame(frame).iter().find(|(c, _)| *c == id).map(|(_, seen)| seen)
        };
        let mut all = Vec::new();
        for (id, reading) in readings.iter().enumerate() {
            let Some(reading) = *reading else {
                continue;
            };
            let moment = self.shifted(position, reading.late);
            match moment.and_then(|frame| shown(frame, reading.camera)) {
                Some(seen) => all.push((id, seen, reading)),
                None if shown(&self.frames[position], reading.camera).is_some() => return None,
                None => {}
            }
        }
        Some(all)
    }

    /// The frame so many frame numbers on.
    fn shifted(&self, position: usize, by: isize) -> Option<&'a FrameObservations> {
        let number = self.frames[position].frame.0.checked_add_signed(by)?;
        let found = self.frames.binary_search_by_key(&number, |f| f.frame.0);
        self.frames.get(found.ok()?)
    }
}

impl View<'_> {
    /// Where the picture shows what the calibration puts at a pixel.
    fn shown(&self, calibrated: Point2<f64>) -> Point2<f64> {
        self.reading.shown(self.camera, calibrated)
    }

    /// Where the calibration would put what the picture shows at a pixel.
    fn calibrated(&self, shown: Point2<f64>) -> Point2<f64> {
        self.reading.calibrated(self.camera, shown)
    }
}

/// The camera and the mean miss of each view.
fn frame_misses(views: &[View<'_>], border_points: f64) -> Vec<(usize, f64)> {
    let middle = |v: &View<'_>| v.camera.ray(&v.calibrated(v.silhouette.centroid));
    let sights: Vec<Ray> = views.iter().map(middle).collect();
    let Some(subject) = closest_point(&sights) else {
        return Vec::new();
    };

    let of_view = |(i, view): (usize, &View<'_>)| {
        let border: f64 = view.silhouette.contour.iter().map(|p| p.length_px).sum();
        let points = view.silhouette.thinned(border / border_points);
        let misses = points.iter().filter_map(|point| {
            let ray = view.camera.ray(&view.calibrated(point.pixel));
            let middle = (subject - ray.origin_world).dot(&ray.direction_world);
            line_of_sight_miss(&ray, middle, views, i)
        });
        Some((view.id, mean(misses)?))
    };
    views.iter().enumerate().filter_map(of_view).collect()
}

/// The least over the line of sight of the most over the other views; `None` where no other camera sees any of it.
fn line_of_sight_miss(ray: &Ray, middle: f64, views: &[View<'_>], own: usize) -> Option<f64> {
    let mut least: Option<f64> = None;
    for t in along(middle) {
        if let Some(miss) = place_miss(&ray.point_at(t), views, own, least.unwrap_or(MOST_M)) {
            least = Some(least.map_or(miss, |l| l.min(miss)));
        }
        if least == Some(0.0) {
            break;
        }
    }
    least
}

/// The places along a line of sight that are looked at.
fn along(middle: f64) -> impl Iterator<Item = f64> {
    let steps = (2.0 * REACH_M / STEP_M) as usize;
    (0..=steps).map(move |step| middle - REACH_M + step as f64 * STEP_M).filter(|t| *t > 0.0)
}

/// Whether at least [`NEARLY_ALL`] of the other views that could see a place see something there.
fn is_seen_by_nearly_all(place: &Point3<f64>, views: &[View<'_>], own: usize) -> bool {
    let (mut could, mut do_see) = (0, 0);
    for view in views.iter().enumerate().filter(|(i, _)| *i != own).map(|(_, view)| view) {
        let pixel = view.camera.project_undistorted(place);
        let Some(pixel) = pixel.filter(|pixel| view.silhouette.sees(pixel)) else { continue };
        could += 1;
        do_see += usize::from(view.silhouette.contains(&pixel));
    }
    do_see > 0 && do_see as f64 >= NEARLY_ALL * could as f64
}

/// By how much a place lies outside the silhouette that it is farthest outside of; no more than `enough`.
fn place_miss(place: &Point3<f64>, views: &[View<'_>], own: usize, enough: f64) -> Option<f64> {
    let mut most: Option<f64> = None;
    for view in views.iter().enumerate().filter(|(i, _)| *i != own).map(|(_, v)| v) {
        let Some(pixel) = view.camera.project_undistorted(place) else {
            continue;
        };

        let pixel = view.shown(pixel);
        if !view.silhouette.sees(&pixel) {
            continue;
        }

        let depth = (view.camera.camera_from_world * place).z;
        let (outside_px, _) = view.silhouette.outside.sample(&pixel);
        let miss = outside_px * depth / (view.reading.zoom * view.camera.intrinsics.focal_px());
        most = Some(most.map_or(miss, |m: f64| m.max(miss)));
        if miss >= enough {
            return Some(enough);
        }
    }
    most
}
