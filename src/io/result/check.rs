//! Whether the numbers of a result are ones that a fit can have.

use super::{FramePart, HypothesisPart, ResultFile};
use crate::io::frame_rate;
use crate::pipeline::{MOST_EMPTY_FRAMES, POSE};

/// A field that a fit cannot have written.
pub(super) struct OddField {
    pub(super) field: &'static str,
    pub(super) expected: &'static str,
}

/// The first field that is out of range, or of another length than others say.
pub(super) fn odd_field(result: &ResultFile) -> Option<OddField> {
    let (recording, motion, shape) = (&result.recording, &result.motion, &result.shape);
    let numbers = || motion.frames.iter().map(|frame| frame.frame);
    let is_ascending = motion.frames.windows(2).all(|pair| pair[0].frame < pair[1].frame);
    let ends = (numbers().next(), numbers().next_back());
    let is_spanned = ends == (Some(recording.first_frame), Some(recording.last_frame));
    let empty = recording.last_frame.saturating_sub(recording.first_frame);
    let coefficients = shape.coefficients.len();
    let is_square = |rows: &Vec<Vec<f64>>| {
        rows.len() == coefficients && rows.iter().all(|row| row.len() == coefficients)
    };

    // what a keyframe alone is asked for: fewer than the joint optimum knows
    let asked = result.hypotheses.first().map_or(0, |h| h.coefficients.len());
    let is_hypothesis = |h: &HypothesisPart| {
        h.coefficients.len() == asked && h.lengths_m.len() == shape.lengths.len()
    };

    let fields = [
        ("recording.fps", frame_rate::EXPECTED, frame_rate::is_one(recording.fps)),
        (
            "recording.frames",
            "the number of motion.frames",
            recording.frames == motion.frames.len(),
        ),
        ("motion.frames", "one frame or more, by ascending number", is_ascending && is_spanned),
        (
            "recording.last_frame",
            "a number not far beyond the frames that there are",
            empty.saturating_sub(recording.frames) <= MOST_EMPTY_FRAMES,
        ),
        (
            "motion.frames",
            "as many angles and points in each frame as there are names",
            motion.frames.iter().all(|frame| is_of_names(frame, result)),
        ),
        ("winner", "the number of a hypothesis", result.winner < result.hypotheses.len()),
        (
            "hypotheses",
            "as many coefficients and lengths in each, and no more than shape has",
            asked <= coefficients && result.hypotheses.iter().all(is_hypothesis),
        ),
        (
            "shape.covariance",
            "a row and a column for each coefficient",
            shape.covariance.as_ref().is_none_or(is_square),
        ),
    ];
    let odd = fields.into_iter().chain(covariances(result)).find(|(_, _, is_right)| !is_right);
    odd.map(|(field, expected, _)| OddField { field, expected })
}

fn is_of_names(frame: &FramePart, result: &ResultFile) -> bool {
    let (angles, points) = (result.motion.angles.len(), result.motion.points.len());
    let is_right = frame.angles_rad.len() == angles && frame.points_m.len() == points;
    let sd = frame.sd.as_ref();
    is_right && sd.is_none_or(|sd| sd.angles_rad.len() == angles && sd.points_m.len() == points)
}

/// The covariances of the cameras, each of as many as were estimated.
fn covariances(result: &ResultFile) -> [(&'static str, &'static str, bool); 2] {
    let cameras = &result.quality.cameras;
    let poses = POSE * cameras.iter().filter(|camera| camera.found.pose.is_some()).count();
    let clocks = cameras.iter().filter(|camera| camera.found.clock.is_some()).count();
    let is_of = |rows: &Option<Vec<Vec<f64>>>, n: usize| {
        let is_of_n = |rows: &Vec<Vec<f64>>| rows.len() == n && rows.iter().all(|r| r.len() == n);
        rows.as_ref().is_none_or(is_of_n)
    };
    [
        (
            "quality.poses_covariance",
            "seven rows and columns for each camera with a pose",
            is_of(&result.quality.poses_covariance, poses),
        ),
        (
            "quality.clocks_covariance",
            "a row and a column for each camera with a clock",
            is_of(&result.quality.clocks_covariance, clocks),
        ),
    ]
}
