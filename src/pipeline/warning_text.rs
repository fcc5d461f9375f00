//! Warnings in plain words.

use std::fmt;

use super::{Frames, Warning};

impl fmt::Display for Warning {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::OddCamera { camera } => write!(
                f,
                "{camera} has the person elsewhere than the other cameras: check its calibration, unit and up, and offset_frames"
            ),
            Self::Aim {
                camera,
                px: [right, down],
            } => write!(
                f,
                "{camera} shows everything {}, {} of where its calibration says, which is taken into account: calibrate it again (--aim off: believe the calibration)",
                way(*right, "right", "left"),
                way(*down, "below", "above"),
            ),
            Self::WeakCamera {
                camera,
                iou,
                others_iou,
            } => write!(
                f,
                "{camera} overlaps {iou:.2}, the others {others_iou:.2}: check its calibration and its masks"
            ),
            Self::PoorFit { iou } => write!(
                f,
                "the body covers the silhouettes badly (overlap {iou:.2}): is this the right body, and is up right in sequence.toml?"
            ),
            Self::OddBody { ratio } => write!(
                f,
                "the chosen body is a rare one ({ratio:.0} times the usual −log p(s)): check up and unit, and the masks"
            ),
            Self::KeepsPrior { parts } => match parts.as_slice() {
                [part] => write!(f, "{part} keeps its prior: nothing sees how it is turned"),
                parts => write!(
                    f,
                    "{} keep their prior: nothing sees how they are turned",
                    parts.join(", ")
                ),
            },
            Self::FewKeyframes { keyframes: 0 | 1 } => write!(
                f,
                "one keyframe only, so there is no confidence: a smaller --keyframe-every gives more"
            ),
            Self::FewKeyframes { keyframes } => write!(
                f,
                "{keyframes} keyframes only: their spread σ is itself uncertain; a smaller --keyframe-every gives more"
            ),
            of_frames => of_frames.of_frames(f),
        }
    }
}

impl Warning {
    /// Those that name frames.
    fn of_frames(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Rejected {
                camera,
                frames: of,
                reason,
            } => {
                write!(f, "{camera} shows nobody in {}: {reason}", frames(of))
            }
            Self::Unseen { frames: of } => write!(
                f,
                "no camera sees the person in {}: the motion there is a guess",
                frames(of)
            ),
            Self::OneView { frames: of } => write!(
                f,
                "only one camera sees the person in {}: the depth there rests on the frames around",
                frames(of)
            ),
            Self::Recovered { frames: of } => {
                write!(f, "the track was lost and found again in {}", frames(of))
            }
            Self::Lost { frames: of, iou } => write!(
                f,
                "the body covers {} much worse than the rest (overlap {iou:.2}): look at the overlays",
                frames(of)
            ),
            Self::PointsOutside {
                frames: of,
                share,
                by_m,
            } => write!(
                f,
                "points and silhouettes disagree in {}: {:.0} % of the points lie outside a silhouette, by {by_m:.2} m: check the points' numbers, unit and world",
                frames(of),
                100.0 * share
            ),
            Self::PointsOffSkin { frames: of, by_m } => write!(
                f,
                "points and silhouettes disagree in {}: half of the points lie {by_m:.2} m or more off the skin: check the points' numbers, unit and world",
                frames(of)
            ),
            _ => Ok(()),
        }
    }
}

/// `3.1 px right`.
fn way(px: f64, positive: &str, negative: &str) -> String {
    let to = if px < 0.0 { negative } else { positive };
    format!("{:.1} px {to}", px.abs())
}

/// How many frames, and which.
fn frames(frames: &Frames) -> String {
    match frames.0.len() {
        1 => format!("1 frame ({frames})"),
        n => format!("{n} frames ({frames})"),
    }
}
