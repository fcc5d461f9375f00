//! Pictures that come twice: a video of half the frame rate that was stretched to the whole, or a camera that hangs.
//!
//! Each second picture is of another moment than its number says, and a body before all cameras cannot be at two places. A picture that came
//! before is known by what it shows, point by point and bit by bit the same, while at least half of the other cameras show that the person
//! moved. It is left out. Who stands still is shown alike by all.

use std::borrow::Cow;

use nalgebra::Point2;
use rayon::prelude::*;

use super::cause::{Cause, name};
use crate::camera::{CameraId, Rig};
use crate::silhouette::FrameObservations;

/// Fewer such pictures of a camera say little, and do little harm.
const LEAST: usize = 3;
/// The person moved if the box around them did by more than this, as a share of its size and in pixels: 1 cm, and more than the edge of a mask wavers.
const MOVED: f64 = 0.005;
const MOVED_PX: f64 = 1.5;

/// A recording without pictures that came before.
#[derive(Debug, Clone)]
pub(super) struct WithoutRepeats<'a> {
    pub(super) frames: Cow<'a, [FrameObservations]>,
    /// The cameras whose pictures were left out.
    pub(super) causes: Vec<Cause>,
}

impl<'a> WithoutRepeats<'a> {
    pub(super) fn new(rig: &Rig, frames: &'a [FrameObservations]) -> Self {
        let repeated: Vec<Vec<CameraId>> =
            frames.par_windows(2).map(|pair| repeated(rig, &pair[0], &pair[1])).collect();

        let times =
            |id: CameraId| repeated.iter().flatten().filter(|camera| **camera == id).count();
        let often: Vec<(CameraId, usize)> =
            rig.iter().map(|(id, _)| (id, times(id))).filter(|(_, n)| *n >= LEAST).collect();
        if often.is_empty() {
            return Self { frames: Cow::Borrowed(frames), causes: Vec::new() };
        }

        let kept = |(frame, repeated): (&FrameObservations, &Vec<CameraId>)| {
            let left_out = often.iter().filter(|(id, _)| repeated.contains(id));
            left_out.fold(frame.clone(), |frame, (id, _)| frame.without(*id))
        };
        let first = frames.first().cloned();
        let others = frames.iter().skip(1).zip(&repeated).map(kept);
        let causes = often
            .iter()
            .map(|(id, pictures)| Cause::Repeated { camera: name(rig, *id), pictures: *pictures });
        Self { frames: first.into_iter().chain(others).collect(), causes: causes.collect() }
    }
}

/// The cameras that show in a frame what they showed in the one before, while the person moved.
fn repeated(rig: &Rig, before: &FrameObservations, frame: &FrameObservations) -> Vec<CameraId> {
    let of = |(id, _)| {
        let [before, now] = [before, frame].map(|frame| shown(frame, id));
        (!before.is_empty() && !now.is_empty())
            .then(|| (id, before == now, has_moved(&before, &now)))
    };
    let all: Vec<(CameraId, bool, bool)> = rig.iter().filter_map(of).collect();
    let moved = all.iter().filter(|(.., has_moved)| *has_moved).count();
    if moved == 0 || 2 * moved < all.len() - 1 {
        return Vec::new();
    }
    all.into_iter().filter(|(_, is_same, _)| *is_same).map(|(id, ..)| id).collect()
}

/// What a camera shows, point by point.
fn shown(frame: &FrameObservations, id: CameraId) -> Vec<Point2<f64>> {
    let views = frame.views.iter().filter(|(camera, _)| *camera == id);
    let borders = views.flat_map(|(_, silhouette)| silhouette.contour.iter().map(|p| p.pixel));
    let detections = frame.detections.iter().filter(|(camera, _)| *camera == id);
    let joints = detections.flat_map(|(_, detection)| detection.keypoints.iter().map(|k| k.pixel));
    borders.chain(joints).collect()
}

/// Whether the box around what is shown is another.
fn has_moved(before: &[Point2<f64>], now: &[Point2<f64>]) -> bool {
    let boxed = |points: &[Point2<f64>]| {
        points.iter().map(|p| (*p, *p)).reduce(|a, b| (a.0.inf(&b.0), a.1.sup(&b.1)))
    };
    let (Some((low, high)), Some((new_low, new_high))) = (boxed(before), boxed(now)) else {
        return false;
    };
    let moved_px = (new_low - low).amax().max((new_high - high).amax());
    moved_px > MOVED_PX.max(MOVED * (new_high - new_low).norm())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::pipeline::diagnosis::figures::walker;

    /// The recording with every second picture of some cameras shown twice.
    fn stretched(frames: &[FrameObservations], cameras: &[usize]) -> Vec<FrameObservations> {
        let of = |i: usize| {
            let before = &frames[i - i % 2];
            cameras.iter().fold(frames[i].clone(), |frame, id| frame.with(CameraId(*id), before))
        };
        (0..frames.len()).map(of).collect()
    }

    #[test]
    fn pictures_that_come_twice_are_left_out_of_a_camera_and_named_while_the_person_moves() {
        let (rig, frames) = walker();
        let found = WithoutRepeats::new(&rig, &frames);
        assert!(matches!(found.frames, Cow::Borrowed(_)) && found.causes.is_empty());

        let spoiled = stretched(&frames, &[1]);
        let WithoutRepeats { frames: kept, causes } = WithoutRepeats::new(&rig, &spoiled);
        let camera = rig.cameras[1].name.clone();
        assert_eq!(causes, [Cause::Repeated { camera, pictures: frames.len() / 2 }]);
        for (i, frame) in kept.iter().enumerate() {
            assert_eq!(frame.is_shown_by(CameraId(1)), i % 2 == 0, "frame {i}");
            assert!(frame.is_shown_by(CameraId(0)));
        }
    }

    #[test]
    fn who_stands_still_before_all_cameras_is_no_picture_that_comes_twice() {
        let (rig, frames) = walker();
        let all: Vec<usize> = (0..rig.cameras.len()).collect();
        assert_eq!(WithoutRepeats::new(&rig, &stretched(&frames, &all)).causes, []);
    }
}
