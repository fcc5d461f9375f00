//! How good the fit is in the course of time: of each frame the mean of its cameras, and from the least to the most of them.

use std::collections::BTreeMap;

use super::Words;
use super::figure::{Axis, BOTH, Figure, axis_range};
use crate::io::result::ResultFile;
use crate::math::stats::mean;
use crate::silhouette::FrameIndex;

/// A measure of one frame, over its cameras.
pub(super) struct Spread {
    pub(super) frame: usize,
    pub(super) least: f64,
    pub(super) mean: f64,
    pub(super) most: f64,
}

/// The measure frame by frame, from its value in each picture; NaN in frames without any, that are missing, and in which the body was lost.
pub(super) fn spreads(
    result: &ResultFile,
    pictures: impl Iterator<Item = (FrameIndex, f64)>,
) -> Vec<Spread> {
    let mut values: BTreeMap<usize, Vec<f64>> = BTreeMap::new();
    for (frame, value) in pictures {
        values.entry(frame.0).or_default().push(value);
    }

    // of a frame that is lost nothing is stated
    let frames = &result.motion.frames;
    let is_stated = frames.iter().any(|part| part.sd.is_some());
    let lost = frames.iter().filter(|part| is_stated && part.sd.is_none());
    for part in lost {
        values.remove(&part.frame);
    }

    let spacing = frames.windows(2).map(|w| w[1].frame - w[0].frame).min().unwrap_or(1);
    let all = result.recording.first_frame..=result.recording.last_frame;
    let spread = |frame: usize| {
        let values = values.get(&frame).map_or(&[][..], Vec::as_slice);
        Spread {
            frame,
            least: values.iter().copied().fold(f64::NAN, f64::min),
            mean: mean(values.iter().copied()).unwrap_or(f64::NAN),
            most: values.iter().copied().fold(f64::NAN, f64::max),
        }
    };
    all.step_by(spacing.max(1)).map(spread).collect()
}

/// The means as a line, in a band from the least to the most.
pub(super) fn figure(result: &ResultFile, spreads: &[Spread], y: Axis, words: &Words) -> Figure {
    let means: Vec<_> = spreads.iter().map(|s| (s.frame as f64, s.mean)).collect();
    let band: Vec<_> = spreads.iter().map(|s| (s.frame as f64, s.least, s.most)).collect();

    let recording = &result.recording;
    let ends = (recording.first_frame as f64, recording.last_frame as f64);
    let (_, step) = axis_range(std::iter::empty(), ends);
    let x =
        Axis { label: words.of("frame").into(), range: (ends.0, ends.1.max(ends.0 + 1.0)), step };
    Figure::new("", x, y).wide().band(BOTH, 0.2, &band).line(BOTH, 1.5, &means)
}
