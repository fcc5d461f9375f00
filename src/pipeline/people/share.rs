//! What of the masks is each person's.

use nalgebra::Point2;

use super::room::{PersonCells, Room};
use crate::body::{PartId, Posed};
use crate::camera::{Camera, CameraId, Rig};
use crate::image::Plane;
use crate::likelihood::BodyOutline;
use crate::math::stats::{mean, median};
use crate::silhouette::{ContourPoint, FrameObservations, Silhouette};

/// ν of Student's t, of how far borders lie from an outline: bodies that are fitted coarsely, and clothes.
const FREEDOM: f64 = 4.0;
/// σ of normal deviates over the median of their size.
const SD_OF_MEDIAN: f64 = 1.4826;
/// Labels are looked at so many pixels around a border point.
const BESIDE_PX: i32 = 2;
/// Every so many border points are looked at where σ is estimated.
const SPARSE: usize = 5;

/// A person of a frame, before any body is fitted: the voxels that they fill.
type Voxels<'a> = Option<&'a [usize]>;

/// Each person's share of a frame, by the voxels that they fill: borders and pixels that can only be theirs.
pub(super) fn by_voxels(
    room: &Room,
    rig: &Rig,
    frame: &FrameObservations,
    people: &[Voxels<'_>],
) -> Vec<FrameObservations> {
    let voxels: Vec<&[usize]> = people.iter().map(|voxels| voxels.unwrap_or(&[])).collect();
    let of_camera = |id: CameraId| room.person_cells(rig, id, &voxels);
    let cells: Vec<PersonCells<'_>> = frame.views.iter().map(|(id, _)| of_camera(*id)).collect();
    let share = |person: usize| {
        let of_view = |(i, (id, silhouette)): (usize, &(CameraId, Silhouette))| {
            let may_be = |pixel: &Point2<f64>| cells[i].at(pixel);
            let border =
                |point: &ContourPoint| f64::from(u8::from(may_be(&point.pixel) == 1 << person));
            let share = silhouette.share(border, |pixel| may_be(pixel) & 1 << person != 0);
            share.map(|share| (*id, share))
        };
        let views = frame.views.iter().enumerate().filter_map(of_view).collect();
        FrameObservations { views, ..FrameObservations::nothing(frame.frame) }
    };
    (0..people.len()).map(share).collect()
}

/// A person's share of a frame, by masks with a value for each: theirs is `value`.
///
/// Where two people meet in the picture there is no border of the union; a border point beside both is theirs by the share of its neighbours.
pub fn by_labels(
    rig: &Rig,
    frame: &FrameObservations,
    labels: &[(CameraId, Plane<u16>)],
    value: u16,
) -> FrameObservations {
    let of_view = |(id, silhouette): &(CameraId, Silhouette)| {
        let (_, labels) = labels.iter().find(|(camera, _)| camera == id)?;
        let camera = &rig.cameras[id.0];
        let at = |pixel: &Point2<f64>, (x, y): (i32, i32)| {
            let recorded = camera.distort(pixel);
            let near = |pixel: f64, off: i32| (pixel.round() + f64::from(off)).max(0.0) as usize;
            labels.get(near(recorded.x, x), near(recorded.y, y)).unwrap_or(0)
        };
        let border = |point: &ContourPoint| {
            let around = (-BESIDE_PX..=BESIDE_PX)
                .flat_map(|y| (-BESIDE_PX..=BESIDE_PX).map(move |x| (x, y)));
            let shown: Vec<u16> =
                around.map(|off| at(&point.pixel, off)).filter(|label| *label > 0).collect();
            let own = shown.iter().filter(|label| **label == value).count();
            own as f64 / shown.len().max(1) as f64
        };
        let share = silhouette.share(border, |pixel| at(pixel, (0, 0)) == value);
        share.map(|share| (*id, share))
    };
    let views = frame.views.iter().filter_map(of_view).collect();
    FrameObservations { views, ..FrameObservations::nothing(frame.frame) }
}

/// Each person's share of a frame, by the bodies that were fitted to them; `spread_m` is σ.
pub(super) fn by_bodies(
    rig: &Rig,
    frame: &FrameObservations,
    bodies: &[Option<Posed<'_>>],
    spread_m: f64,
) -> Vec<FrameObservations> {
    let outlines = |(id, _): &(CameraId, Silhouette)| Outlines::new(&rig.cameras[id.0], bodies);
    let outlines: Vec<Outlines> = frame.views.iter().map(outlines).collect();
    let share = |person: usize| {
        let of_view = |(outlines, (id, silhouette)): (&Outlines, &(CameraId, Silhouette))| {
            let border =
                |point: &ContourPoint| outlines.probability(person, &point.pixel, spread_m);
            let share = silhouette.share(border, |pixel| outlines.nearest(pixel) == Some(person));
            share.map(|share| (*id, share))
        };
        let views = outlines.iter().zip(&frame.views);
        let views = match bodies[person] {
            Some(_) => views.filter_map(of_view).collect(),
            None => Vec::new(),
        };
        FrameObservations { views, ..FrameObservations::nothing(frame.frame) }
    };
    (0..bodies.len()).map(share).collect()
}

/// σ: how far border points lie from the nearest of all outlines, 1.48 times the median over a frame's views, metres; `None` without any.
pub(super) fn spread_m(
    rig: &Rig,
    frame: &FrameObservations,
    bodies: &[Option<Posed<'_>>],
) -> Option<f64> {
    median(&mut misses_m(rig, frame, bodies)).map(|median| SD_OF_MEDIAN * median)
}

/// How far border points lie from the nearest of all outlines, the mean over a frame's views, metres; `None` without any.
pub(super) fn miss_m(
    rig: &Rig,
    frame: &FrameObservations,
    bodies: &[Option<Posed<'_>>],
) -> Option<f64> {
    mean(misses_m(rig, frame, bodies))
}

fn misses_m(rig: &Rig, frame: &FrameObservations, bodies: &[Option<Posed<'_>>]) -> Vec<f64> {
    let of_view = |(id, silhouette): &(CameraId, Silhouette)| {
        let outlines = Outlines::new(&rig.cameras[id.0], bodies);
        let least = move |point: &ContourPoint| {
            let all = outlines.distances_m(&point.pixel).into_iter().map(f64::abs);
            all.reduce(f64::min)
        };
        silhouette.contour.iter().step_by(SPARSE).filter_map(least).collect::<Vec<f64>>()
    };
    frame.views.iter().flat_map(of_view).collect()
}

/// The bodies that were fitted to the people of a frame, as one camera shows them.
struct Outlines {
    /// Outline, and pixels per metre at the body; `None` of who is not there.
    people: Vec<Option<(BodyOutline, f64)>>,
}

impl Outlines {
    fn new(camera: &Camera, bodies: &[Option<Posed<'_>>]) -> Self {
        let outline = |body: &Posed<'_>| {
            let trunk = body.origin_of_part(PartId(0));
            let depth_m = (camera.camera_from_world * trunk).z.max(f64::EPSILON);
            (BodyOutline::new(camera, body), camera.intrinsics.focal_px() / depth_m)
        };
        Self { people: bodies.iter().map(|body| body.as_ref().map(outline)).collect() }
    }

    /// How far a pixel lies from each person's outline, m; negative inside, infinite of who is not there.
    fn distances_m(&self, pixel: &Point2<f64>) -> Vec<f64> {
        let distance = |person: &Option<(BodyOutline, f64)>| {
            let distance = person.as_ref();
            distance
                .map_or(f64::INFINITY, |(outline, px_per_m)| outline.distance_px(pixel) / px_per_m)
        };
        self.people.iter().map(distance).collect()
    }

    /// r of a border pixel.
    fn probability(&self, person: usize, pixel: &Point2<f64>, spread_m: f64) -> f64 {
        let density =
            |d: f64| (1.0 + (d / spread_m).powi(2) / FREEDOM).powf(-0.5 * (FREEDOM + 1.0));
        let densities: Vec<f64> = self.distances_m(pixel).into_iter().map(density).collect();
        densities[person] / densities.iter().sum::<f64>().max(f64::MIN_POSITIVE)
    }

    /// Whose a pixel inside is: of the body that it lies deepest in, or nearest to.
    fn nearest(&self, pixel: &Point2<f64>) -> Option<usize> {
        let distances = self.distances_m(pixel);
        let all = distances.iter().enumerate();
        all.min_by(|a, b| a.1.total_cmp(b.1)).map(|(person, _)| person)
    }
}
