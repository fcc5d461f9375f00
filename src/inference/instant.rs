//! The body at a moment between frames.
//!
//! A camera whose clock is τ ahead shows the body of the time t + τ. About the nearest frame k, the motion is a parabola
//! through three frames,
//!
//! m(t) = mₖ ⊞ Σⱼ wⱼ(t) (mⱼ ⊟ mₖ),  j = k − 1, k, k + 1,
//!
//! wⱼ Lagrange's polynomials of the frames' own times: frames may be missing. m moves by Σ wⱼ δⱼ with the three motions, and with
//! the time by Σ ẇⱼ (mⱼ ⊟ mₖ). Both are to first order in the root's turn from one frame to the next.

use std::ops::Range;

use nalgebra::DVector;

use crate::body::{Layout, Motion};

/// A moment, and how the motion there follows those of the frames.
#[derive(Debug, Clone)]
pub struct Instant {
    /// The motion.
    pub motion: Motion,
    /// The frames about it, in order, and their weights.
    pub frames: Vec<(usize, f64)>,
    /// How fast it moves, by the second.
    pub velocity: DVector<f64>,
}

impl Instant {
    /// The moment of a frame.
    pub fn of_frame(motions: &[Motion], frame: usize) -> Self {
        let motion = motions[frame].clone();
        Self { velocity: DVector::zeros(0), frames: vec![(frame, 1.0)], motion }
    }

    /// Any moment; beyond the first and the last frame the parabola goes on.
    pub fn at(layout: Layout, motions: &[Motion], times_s: &[f64], time_s: f64) -> Self {
        let (first, middle, end) = about(times_s, time_s);
        let (mut delta, mut velocity) =
            (DVector::zeros(layout.motion()), DVector::zeros(layout.motion()));
        let mut frames = Vec::with_capacity(3);
        for j in first..end {
            let others = || (first..end).filter(move |k| *k != j);
            let factor = |k: usize| (time_s - times_s[k]) / (times_s[j] - times_s[k]);
            let without = |left: usize| {
                let rest: f64 = others().filter(|k| *k != left).map(factor).product();
                rest / (times_s[j] - times_s[left])
            };
            let weight: f64 = others().map(factor).product();
            let slope: f64 = others().map(without).sum();
            frames.push((j, weight));
            if j != middle {
                let apart = layout.motion_difference(&motions[middle], &motions[j]);
                delta.axpy(weight, &apart, 1.0);
                velocity.axpy(slope, &apart, 1.0);
            }
        }
        Self { motion: layout.retract_motion(&motions[middle], &delta), frames, velocity }
    }

    /// The same, of frames that are counted from another one on.
    pub(super) fn after(mut self, frames: usize) -> Self {
        self.frames.iter_mut().for_each(|(frame, _)| *frame += frames);
        self
    }
}

/// The time of each frame since the first of its trial; `seconds[i]` lie between frames i − 1 and i, infinitely many where
/// another trial begins, the first is not read.
pub fn times_s(seconds: &[f64]) -> Vec<f64> {
    let mut time_s = 0.0;
    let later = seconds.iter().skip(1).map(|interval| {
        time_s = if interval.is_finite() { time_s + interval } else { 0.0 };
        time_s
    });
    std::iter::once(0.0).chain(later).take(seconds.len()).collect()
}

/// The frames of the trial of each frame.
pub(super) fn trials(seconds: &[f64]) -> Vec<Range<usize>> {
    let begins = |i: &usize| *i == 0 || seconds[*i].is_infinite();
    let first: Vec<usize> = (0..seconds.len()).filter(begins).collect();
    let end = |k: usize| first.get(k + 1).copied().unwrap_or(seconds.len());
    let whole = first.iter().enumerate().map(|(k, first)| *first..end(k));
    whole.flat_map(|trial| std::iter::repeat_n(trial.clone(), trial.len())).collect()
}

/// The first of the frames about a moment, the middle one, and the one after the last.
fn about(times_s: &[f64], time_s: f64) -> (usize, usize, usize) {
    let n = times_s.len();
    let after = times_s.partition_point(|t| *t < time_s).min(n - 1);
    let before = after.saturating_sub(1);
    let nearest = if time_s - times_s[before] < times_s[after] - time_s { before } else { after };
    let last = n.saturating_sub(2).max(1).min(n - 1);
    let middle = nearest.clamp(last.min(1), last);
    (middle.saturating_sub(1), middle, (middle + 2).min(n))
}

#[cfg(test)]
mod tests {
    use std::path::Path;

    use nalgebra::{Rotation3, Vector3};

    use super::*;

    #[test]
    fn a_motion_of_constant_acceleration_is_met_between_uneven_frames_and_beyond_them() {
        let model = crate::io::model::load("walker-metaballs", Path::new("")).unwrap();
        let layout = Layout::new(&model);
        let at = |t: f64| {
            let mut motion = Motion::rest(&model);
            motion.position_world = Vector3::new(1.2 * t, 0.3 - t * t, 0.9);
            let turn = Vector3::new(0.0, 0.0, 0.4 * t);
            motion.world_from_root = Rotation3::from_scaled_axis(turn);
            motion.angles[3] = 0.2 + 0.5 * t - 2.0 * t * t;
            motion
        };
        let times_s = [0.0, 0.02, 0.04, 0.10, 0.12];
        let motions: Vec<Motion> = times_s.iter().map(|t| at(*t)).collect();
        for time_s in [-0.03, 0.0, 0.013, 0.055, 0.1, 0.119, 0.14] {
            let found = Instant::at(layout, &motions, &times_s, time_s);
            let off = layout.motion_difference(&found.motion, &at(time_s));
            assert!(off.amax() < 1e-9, "{time_s}: {off}");
            let speed = layout.motion_difference(&at(time_s - 1e-4), &at(time_s + 1e-4)) / 2e-4;
            let off = (speed - &found.velocity).amax();
            assert!(off < 1e-6, "{time_s}: {off}");
            let sum: f64 = found.frames.iter().map(|(_, weight)| weight).sum();
            approx::assert_relative_eq!(sum, 1.0, epsilon = 1e-12);
        }
    }

    #[test]
    fn each_trial_has_a_time_of_its_own() {
        let seconds = [0.1, 0.1, 0.2, f64::INFINITY, 0.1];
        assert_eq!(times_s(&seconds), [0.0, 0.1, 0.1 + 0.2, 0.0, 0.1]);
        assert_eq!(trials(&seconds), [0..3, 0..3, 0..3, 3..5, 3..5]);
    }

    #[test]
    fn two_frames_are_a_line_and_one_stands_still() {
        let model = crate::io::model::load("walker-metaballs", Path::new("")).unwrap();
        let layout = Layout::new(&model);
        let mut far = Motion::rest(&model);
        far.position_world.x = 0.1;
        let motions = [Motion::rest(&model), far];
        let found = Instant::at(layout, &motions, &[0.0, 0.1], 0.025);
        approx::assert_relative_eq!(found.motion.position_world.x, 0.025, epsilon = 1e-12);
        approx::assert_relative_eq!(found.velocity[0], 1.0, epsilon = 1e-12);
        let still = Instant::at(layout, &motions[..1], &[0.0], 0.3);
        assert_eq!((still.motion, still.velocity.amax()), (motions[0].clone(), 0.0));
    }
}
