//! Walking aids: canes, crutches and frames are in the masks, and no part of the body.
//!
//! Where silhouettes hold rods ([`CellMask::without_rods`]) they are taken out of all masks before anybody is fitted. Then what is
//! slender in a mask must be seen by all other cameras but one at some place of its line of sight: two rods in line, or a rod in line
//! with a hand, are as thick as a limb, and other cameras see them apart. A rod of one mask among many is an error of that mask, and stays.

use std::borrow::Cow;

use nalgebra::{Point2, Point3};
use rayon::prelude::*;

use super::cause::{Cause, name};
use super::shown_by_two;
use crate::camera::{Camera, CameraId, Ray, Rig, closest_point};
use crate::inference::hull::lines_of_sight;
use crate::silhouette::{CellMask, FrameObservations, Silhouette};

/// Frames that are looked at first.
const SAMPLED_FRAMES: usize = 6;
/// Rods are taken out if more than this share of the masks holds some.
const LEAST_SHARE: f64 = 0.1;
/// Lines of sight are followed so far before and behind the middle of the person, in such steps, metres.
const REACH_M: f64 = 1.0;
const STEP_M: f64 = 0.02;

/// A recording without the rods that its masks hold.
#[derive(Debug, Clone)]
pub(in crate::pipeline) struct WithoutRods<'a> {
    pub(in crate::pipeline) frames: Cow<'a, [FrameObservations]>,
    pub(super) cause: Option<Cause>,
}

impl<'a> WithoutRods<'a> {
    pub(in crate::pipeline) fn new(rig: &Rig, frames: Cow<'a, [FrameObservations]>) -> Self {
        let sampled = shown_by_two(&frames, SAMPLED_FRAMES);
        let look = |first: usize| -> Vec<(CameraId, bool)> {
            let every_other = sampled.par_iter().skip(first).step_by(2);
            every_other.flat_map_iter(|i| holding(rig, &frames[*i])).collect()
        };
        // most recordings hold none, and half of the frames tell
        let mut looked = look(0);
        if looked.iter().any(|(_, holds)| *holds) {
            looked.extend(look(1));
        }
        let holding: Vec<CameraId> = looked.iter().filter(|l| l.1).map(|l| l.0).collect();
        let share = holding.len() as f64 / looked.len().max(1) as f64;
        if share <= LEAST_SHARE {
            return Self { frames, cause: None };
        }

        let cleaned = frames.par_iter().map(|frame| cleaned(rig, frame)).collect();
        let cameras = rig.iter().filter(|(id, _)| holding.contains(id));
        let cameras = cameras.map(|(id, _)| name(rig, id)).collect();
        Self { frames: Cow::Owned(cleaned), cause: Some(Cause::Rods { cameras, share }) }
    }
}

/// Which cameras show rods.
fn holding(rig: &Rig, frame: &FrameObservations) -> Vec<(CameraId, bool)> {
    let has_rods = |(_, views): (Point3<f64>, Vec<View<'_>>)| {
        let views = views.iter().zip(&frame.views);
        views.map(|(view, (id, _))| (*id, view.has_rods)).collect()
    };
    views(rig, frame).map(has_rods).unwrap_or_default()
}

/// A frame without its rods.
fn cleaned(rig: &Rig, frame: &FrameObservations) -> FrameObservations {
    let mut cleaned = frame.clone();
    let Some((subject, views)) = views(rig, frame).filter(|(_, v)| v.iter().any(|v| v.has_rods))
    else {
        return cleaned;
    };
    for (a, (_, shown)) in cleaned.views.iter_mut().enumerate() {
        let View { camera, own, .. } = &views[a];
        let Some(own) = own else { continue };
        // what two rods in line leave, other cameras see apart
        let is_own = |pixel: &Point2<f64>| is_seen(&camera.ray(pixel), &subject, &views, a);
        if let Some(within) = shown.within(&own.without_slender(is_own), camera) {
            *shown = within;
        }
    }
    cleaned
}

/// A view of a frame.
struct View<'a> {
    camera: &'a Camera,
    /// What it holds without its rods; `None` if its pixels are too large to tell.
    own: Option<CellMask>,
    has_rods: bool,
}

/// The middle of the person, and what each camera shows; `None` if the cameras do not look at one place.
fn views<'a>(rig: &'a Rig, frame: &FrameObservations) -> Option<(Point3<f64>, Vec<View<'a>>)> {
    let subject = closest_point(&lines_of_sight(rig, frame))?;
    let of_view = |(id, shown): &(CameraId, Silhouette)| {
        let camera = &rig.cameras[id.0];
        let depth_m = (camera.camera_from_world * subject).z;
        let px_per_m = camera.intrinsics.focal_px() / depth_m;
        let whole = (depth_m > 0.0).then(|| CellMask::new(shown, px_per_m)).flatten();
        let without = whole.as_ref().and_then(CellMask::without_rods);
        View { camera, has_rods: without.is_some(), own: without.or(whole) }
    };
    let views = frame.views.iter().map(of_view).collect();
    Some((subject, views))
}

/// Whether there is a place on a line of sight that all other cameras see but one, of those that look there.
fn is_seen(ray: &Ray, subject: &Point3<f64>, views: &[View<'_>], own: usize) -> bool {
    let middle = (subject - ray.origin_world).dot(&ray.direction_world);
    let steps = (REACH_M / STEP_M) as i32;
    (-steps..=steps).any(|step| {
        let place = ray.point_at(middle + f64::from(step) * STEP_M);
        let others = views.iter().enumerate().filter(|(b, _)| *b != own);
        let sees = |(_, view): (usize, &View<'_>)| {
            let pixel = view.camera.project_undistorted(&place)?;
            Some(view.own.as_ref()?.contain(&pixel))
        };
        others.filter_map(sees).filter(|sees| !sees).count() <= 1
    })
}

#[cfg(test)]
mod tests {
    use nalgebra::Vector3;

    use super::*;
    use crate::image::Mask;
    use crate::pipeline::diagnosis::figures::{Figures, joined};
    use crate::synth::Ring;

    /// Persons before cameras that show how thick a rod is.
    fn figures() -> Figures {
        let ring = Ring { width_px: 640, height_px: 480, focal_px: 500.0, ..Ring::default() };
        Figures { rig: ring.regular(), ..Figures::new() }
    }

    /// The masks of a walking frame of tubes 25 mm thick, before a person who stands at the origin.
    fn walking_frame(rig: &Rig) -> Vec<Mask> {
        let tube = |from: [f64; 3], to: [f64; 3]| (Point3::from(from), Point3::from(to));
        let side = |y: f64| {
            [
                tube([0.3, y, 0.0], [0.35, y, 0.85]),
                tube([0.7, y, 0.0], [0.65, y, 0.85]),
                tube([0.35, y, 0.85], [0.65, y, 0.85]),
            ]
        };
        let across = tube([0.68, -0.28, 0.5], [0.68, 0.28, 0.5]);
        let tubes: Vec<_> = [-0.28, 0.28].into_iter().flat_map(side).chain([across]).collect();
        rig.cameras.iter().map(|camera| drawn(camera, &tubes, 0.0125)).collect()
    }

    /// What a camera shows of tubes of this radius.
    fn drawn(camera: &Camera, tubes: &[(Point3<f64>, Point3<f64>)], radius_m: f64) -> Mask {
        let ends = tubes.iter().map(|(from, to)| {
            let depth_m = (camera.camera_from_world * nalgebra::center(from, to)).z;
            let pixel = |p: &Point3<f64>| camera.project_undistorted(p).unwrap();
            (pixel(from), pixel(to), radius_m * camera.intrinsics.focal_px() / depth_m)
        });
        let ends: Vec<_> = ends.collect();
        Mask::from_fn(camera.width_px as usize, camera.height_px as usize, |x, y| {
            let pixel = Point2::new(x as f64, y as f64);
            ends.iter().any(|(a, b, radius)| {
                let along = (pixel - a).dot(&(b - a)) / (b - a).norm_squared();
                (pixel - (a + (b - a) * along.clamp(0.0, 1.0))).norm() < *radius
            })
        })
    }

    /// The share of cells that one of two silhouettes holds and not the other, over those of the first.
    fn difference(a: &Silhouette, b: &Silhouette) -> f64 {
        let rows =
            (0..480).flat_map(|y| (0..640).map(move |x| Point2::new(f64::from(x), f64::from(y))));
        let pixels: Vec<_> = rows.collect();
        let count = |is_so: &dyn Fn(&Point2<f64>) -> bool| {
            pixels.iter().filter(|pixel| is_so(pixel)).count() as f64
        };
        count(&|p| a.contains(p) != b.contains(p)) / count(&|p| a.contains(p))
    }

    #[test]
    fn a_walking_frame_is_taken_out_and_named() {
        let figures = figures();
        let person = figures.masks(&figures.standing(0.0, 0.0));
        let alone = figures.frame(0, &person);
        let with_frame = figures.frame(0, &joined(&person, &walking_frame(&figures.rig)));
        let observed = [with_frame.clone()];
        let WithoutRods { frames, cause } =
            WithoutRods::new(&figures.rig, Cow::Borrowed(&observed));
        let Some(Cause::Rods { cameras, share }) = cause else { panic!("{cause:?}") };
        assert_eq!(cameras.len(), figures.rig.cameras.len());
        assert!(share > 0.9, "{share}");

        for (k, (_, shown)) in alone.views.iter().enumerate() {
            let before = difference(shown, &with_frame.views[k].1);
            let after = difference(shown, &frames[0].views[k].1);
            assert!(after < 0.06 && after < 0.5 * before, "{k}: {before} {after}");
        }
    }

    #[test]
    fn a_person_alone_and_a_rod_in_one_mask_stay_as_they_are() {
        let figures = figures();
        let masks = figures.masks(&figures.standing(0.0, 0.0));
        let frames: Vec<FrameObservations> = (0..6)
            .map(|number| {
                let mut masks = masks.clone();
                if number == 3 {
                    let frame = walking_frame(&figures.rig);
                    masks[1] = joined(&masks[1..2], &frame[1..2]).remove(0);
                }
                figures.frame(number, &masks)
            })
            .collect();
        let without = WithoutRods::new(&figures.rig, Cow::Borrowed(&frames));
        assert!(without.cause.is_none() && matches!(without.frames, Cow::Borrowed(_)));
    }

    #[test]
    fn of_a_line_of_sight_all_other_cameras_but_one_must_see_a_place() {
        let figures = figures();
        let frame = figures.frame(0, &figures.masks(&figures.standing(0.0, 0.0)));
        let (subject, views) = views(&figures.rig, &frame).unwrap();
        let camera = &figures.rig.cameras[0];
        let through = |place: Point3<f64>| {
            let pixel = camera.project_undistorted(&place).unwrap();
            is_seen(&camera.ray(&pixel), &subject, &views, 0)
        };
        assert!(through(subject));
        assert!(!through(subject + Vector3::new(0.0, 0.0, 1.2)));
    }
}
