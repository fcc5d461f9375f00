//! Where what a camera shows jumps beside the body, or in time.
//!
//! A body errs by a centimetre, but from frame to frame by little: what a camera shows lies beside it by d and is ahead of it by τ, which change slowly.
//! So a line through the five frames before a moment and one through the five after it nearly meet there. By how far they do not is the step,
//! metres at the person or frames.
//!
//! The median of steps tells their standard deviation σ: for lengths of two components it is σ √(2 ln 2), for one component 0.6745 σ. The larger
//! counts, that of all cameras or of one, apart from its largest step. Of 550 steps of a walk the largest is five σ. A step may be a jump if it is
//! larger than that, and larger than what is usual: what a calibration errs by, √((σ_turn z)² + σ_place²), and .4 of a frame.

use nalgebra::Vector3;

use super::beside::Beside;
use crate::camera::CameraId;
use crate::inference::camera_prior::{DISPLACEMENT_SD_M, TURN_SD};
use crate::math::stats::median;
use crate::silhouette::FrameIndex;

/// Frames on either side of a step.
pub(super) const SIDE: usize = 5;
/// They may lie so many times as far apart as they would without missing ones.
const MOST_APART: usize = 3;
/// A jump is so many standard deviations large.
const SURE: f64 = 5.0;
/// What no clock errs by from one frame to the next: a frame, but for what the body yields to it.
const LEAST_FRAMES: f64 = 0.4;
/// The median of a length whose two components have the standard deviation 1, √(2 ln 2), …
const MEDIAN_OF_TWO: f64 = 1.177_410_022_515_474_7;
/// … and that of the size of one component.
const MEDIAN_OF_ONE: f64 = 0.674_489_750_196_081_7;

/// A step of what a camera shows.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Step {
    pub(super) camera: CameraId,
    /// The first frame after it.
    pub(super) frame: FrameIndex,
    /// How large it is, metres.
    size_m: f64,
    /// The same in time, frames.
    frames: f64,
    /// How large it must be to be a jump.
    limit_m: f64,
    limit_frames: f64,
}

impl Step {
    /// How many times larger than its limit it is.
    pub(super) fn times(&self) -> f64 {
        (self.size_m / self.limit_m).max(self.frames / self.limit_frames)
    }

    /// Whether it is so near a frame that lines on both sides hold frames of both sides of it.
    pub(super) fn is_about(&self, frame: FrameIndex) -> bool {
        self.frame.0.abs_diff(frame.0) < SIDE
    }

    fn is_jump(&self) -> bool {
        self.times() > 1.0
    }
}

/// Every step of every camera.
pub(super) fn steps(of_cameras: &[Vec<Beside>]) -> Vec<Step> {
    let mut own: Vec<Vec<Step>> = Vec::new();
    for (camera, shown) in of_cameras.iter().enumerate() {
        let around = shown.windows(2 * SIDE);
        own.push(around.filter_map(|around| step(CameraId(camera), around)).collect());
    }

    let (all_m, all_frames) = usual(own.iter().flatten());
    let limited = |steps: Vec<Step>| {
        let (own_m, own_frames) = usual(apart_from_largest(&steps));
        steps.into_iter().map(move |step| Step {
            limit_m: step.limit_m.max(SURE * own_m.max(all_m)),
            limit_frames: step.limit_frames.max(SURE * own_frames.max(all_frames)),
            ..step
        })
    };
    own.into_iter().flat_map(limited).collect()
}

/// The steps of a camera of which no frames are on both sides of its largest: a jump does not tell what is usual.
fn apart_from_largest(steps: &[Step]) -> impl Iterator<Item = &Step> {
    let largest = largest(steps);
    steps.iter().filter(move |step| largest.is_some_and(|largest| !step.is_about(largest.frame)))
}

/// The largest of some.
pub(super) fn largest<'s>(steps: impl IntoIterator<Item = &'s Step>) -> Option<Step> {
    steps.into_iter().max_by(|a, b| a.times().total_cmp(&b.times())).copied()
}

/// The largest of those that are jumps.
pub(super) fn largest_jump<'s>(steps: impl IntoIterator<Item = &'s Step>) -> Option<Step> {
    largest(steps).filter(Step::is_jump)
}

/// σ of steps, in metres and in frames.
fn usual<'s>(steps: impl Iterator<Item = &'s Step>) -> (f64, f64) {
    let (mut sizes_m, mut frames): (Vec<f64>, Vec<f64>) =
        steps.map(|step| (step.size_m, step.frames)).unzip();
    let sd = |sizes: &mut Vec<f64>, of_one: f64| median(sizes).unwrap_or_default() / of_one;
    (sd(&mut sizes_m, MEDIAN_OF_TWO), sd(&mut frames, MEDIAN_OF_ONE))
}

/// The step in the middle of some frames; `None` where many between them are missing.
fn step(camera: CameraId, around: &[Beside]) -> Option<Step> {
    let number = |shown: &Beside| shown.frame.0 as f64;
    let (before, after) = around.split_at(around.len() / 2);
    let (last, first) = (before.last()?, after.first()?);
    if around.last()?.frame.0 - around.first()?.frame.0 > MOST_APART * around.len() {
        return None;
    }

    let middle = 0.5 * (number(last) + number(first));
    let apart = line_at(after, middle)? - line_at(before, middle)?;
    Some(Step {
        camera,
        frame: first.frame,
        size_m: apart.xy().norm(),
        frames: apart.z.abs(),
        limit_m: (TURN_SD * first.depth_m).hypot(DISPLACEMENT_SD_M),
        limit_frames: LEAST_FRAMES,
    })
}

/// Where a line through d and τ over the frames' numbers is at one of them; `None` of fewer than two frames.
fn line_at(shown: &[Beside], number: f64) -> Option<Vector3<f64>> {
    let n = shown.len() as f64;
    let value = |s: &Beside| Vector3::new(s.offset_m.x, s.offset_m.y, s.ahead_frames);
    let mean_value = shown.iter().map(value).sum::<Vector3<f64>>() / n;
    let mean = shown.iter().map(|s| s.frame.0 as f64).sum::<f64>() / n;
    let (mut across, mut along) = (Vector3::zeros(), 0.0);
    for s in shown {
        let from_mean = s.frame.0 as f64 - mean;
        across += value(s) * from_mean;
        along += from_mean * from_mean;
    }
    (along > 0.0).then(|| mean_value + across / along * (number - mean))
}

#[cfg(test)]
mod tests {
    use nalgebra::Vector2;

    use super::*;

    /// Two cameras of which offsets and clocks wander and shake a little; `change` is made to the first's, frame by frame.
    fn shown(change: impl Fn(usize) -> Vector3<f64>) -> Vec<Vec<Beside>> {
        let of_camera = |camera: usize| {
            let beside = |i: usize| {
                let t = i as f64;
                let shake = [0.5, -0.35, 0.1, -0.6, 0.25, 0.45, -0.3][(3 * i + camera) % 7];
                let own = if camera == 0 { change(i) } else { Vector3::zeros() };
                let wander = Vector2::new(0.4 * (0.2 * t).sin() + shake, 0.1 * t - shake);
                Beside {
                    frame: FrameIndex(i),
                    offset_m: 1e-3 * wander + own.xy(),
                    ahead_frames: 0.1 * (0.2 * t).cos() + 0.05 * shake + own.z,
                    depth_m: 4.0,
                }
            };
            (0..60).map(beside).collect()
        };
        (0..2).map(of_camera).collect()
    }

    fn found(change: impl Fn(usize) -> Vector3<f64>) -> Option<(CameraId, FrameIndex)> {
        largest_jump(&steps(&shown(change))).map(|jump| (jump.camera, jump.frame))
    }

    /// What changes at a frame.
    fn from_33(x: f64, y: f64, frames: f64) -> impl Fn(usize) -> Vector3<f64> {
        move |i| if i < 33 { Vector3::zeros() } else { Vector3::new(x, y, frames) }
    }

    #[test]
    fn a_jump_is_found_where_it_is_and_what_changes_slowly_is_none() {
        assert_eq!(steps(&shown(|_| Vector3::zeros())).len(), 2 * (60 - 2 * SIDE + 1));
        assert_eq!(found(|_| Vector3::zeros()), None);
        assert_eq!(found(|i| Vector3::new(1.5e-3, 0.0, 0.03) * i as f64), None);

        let there = Some((CameraId(0), FrameIndex(33)));
        assert_eq!(found(from_33(0.015, -0.02, 0.0)), there);
        assert_eq!(found(from_33(0.0, 0.0, -1.0)), there);
        assert_eq!(found(from_33(0.005, 0.0, 0.3)), None, "less than a calibration errs by");
    }

    #[test]
    fn frames_far_apart_tell_of_no_jump() {
        let mut all = shown(|_| Vector3::zeros());
        all[0].retain(|shown| shown.frame.0 < 30);
        let mut later = shown(|_| Vector3::new(0.08, 0.0, 0.0)).swap_remove(0);
        later.iter_mut().for_each(|shown| shown.frame.0 += 100);
        all[0].extend(later);
        assert_eq!(largest_jump(&steps(&all)), None);
    }
}
