//! The frames that are fitted together, and their time base.

use crate::silhouette::FrameObservations;

/// Frames of a recording with their time base.
#[derive(Debug, Clone, Copy)]
pub struct Sequence<'a> {
    /// Observations, ascending by frame.
    pub frames: &'a [FrameObservations],
    /// Frames per second.
    pub fps: f64,
}

impl Sequence<'_> {
    /// Seconds from each frame's predecessor; the first frame has the interval of one frame.
    pub fn intervals_s(self) -> Vec<f64> {
        (0..self.frames.len())
            .map(|i| self.frames_between(i.saturating_sub(1), i) / self.fps)
            .collect()
    }

    /// Frames of the recording from one position in the sequence to another, at least 1.
    pub(crate) fn frames_between(self, from: usize, to: usize) -> f64 {
        let number = |i: usize| self.frames[i].frame.0;
        number(from).abs_diff(number(to)).max(1) as f64
    }
}
