//! Warnings in plain words.

use std::fmt;

use super::{Frames, Warning};

impl fmt::Display for Warning {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            // cameras
            Self::OddCamera { camera } => write!(
                f,
                "{camera} sees the person in another place than the other cameras do: check its calibration, unit and up, and offset_frames"
            ),
            Self::WeakCamera { camera, iou, others_iou } => write!(
                f,
                "{camera} overlaps the body by {iou:.2}, the other cameras by {others_iou:.2}: check its calibration and its masks"
            ),
            // the body
            Self::KeepsPrior { parts } => match parts.as_slice() {
                [part] => {
                    write!(f, "{part}: no camera shows how it is turned, so it keeps its prior")
                }
                parts => write!(
                    f,
                    "{}: no camera shows how they are turned, so they keep their priors",
                    parts.join(", ")
                ),
            },
            Self::Facing { odds } => write!(
                f,
                "the person may face the other way: that is only {odds:.0} times less probable; look at the overlays"
            ),
            Self::FacingUntried => write!(
                f,
                "which way the person faces was not compared: turned around, the body turned back; look at the overlays"
            ),
            Self::ScaleUnchecked { found_m } => write!(
                f,
                "the body is {found_m:.2} m tall; pictures alone do not show whether the calibration's unit of length and focal lengths are right: give the person's height (--height), and they are checked"
            ),
            Self::DetectionsAlone => write!(
                f,
                "no masks: the body is fitted to detections of joints alone, so how thick it is comes from its bones and the prior"
            ),
            Self::HiddenLimbs { limbs } => write!(
                f,
                "fewer than two cameras show these limbs apart from the body: {}. A limb that lies before or behind the body can be elsewhere than its standard deviation says; add a camera",
                shares(limbs)
            ),
            Self::OneOutline => write!(
                f,
                "the cameras look along one line, so they show one outline: left and right legs, and left and right arms, can be exchanged; add a camera from the side"
            ),
            Self::FewKeyframes { keyframes: 0 | 1 } => write!(
                f,
                "only one keyframe, so there is no confidence: use a smaller --keyframe-every"
            ),
            Self::FewKeyframes { keyframes } => write!(
                f,
                "only {keyframes} keyframes, so their spread σ is itself uncertain: use a smaller --keyframe-every"
            ),
            of_masks => of_masks.fmt_masks(f),
        }
    }
}

impl Warning {
    /// What the body says of the masks.
    fn fmt_masks(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Astray { share } => write!(
                f,
                "{:.1} % of the body lies more than 4 cm outside the masks: they lack a part of the person, or hold something that moves along; some joints can be farther off than their standard deviations say",
                100.0 * share
            ),
            Self::Swollen { part, times } => write!(
                f,
                "{part}: {times:.0} times the volume of the mean person's: the masks hold clothes that hang wide, or something else that moves along; its joints can be farther off than their standard deviations say"
            ),
            of_frames => of_frames.fmt_frames(f),
        }
    }

    /// The warnings that name frames.
    fn fmt_frames(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Rejected { camera, frames: of, reason } => {
                write!(f, "{camera} shows nobody in {}: {reason}", frames(of))
            }
            Self::Unseen { frames: of } => write!(
                f,
                "no camera sees the person in {}: the motion there is a guess",
                frames(of)
            ),
            Self::OneView { frames: of } => write!(
                f,
                "only one camera sees the person in {}: the depth there comes from the neighbouring frames",
                frames(of)
            ),
            Self::Recovered { frames: of } => {
                write!(f, "the track was lost and found again in {}", frames(of))
            }
            Self::Lost { frames: of, iou } => write!(
                f,
                "the body fits {} much worse than the rest (overlap {iou:.2}): look at the overlays",
                frames(of)
            ),
            Self::LostJoints { frames: of, off } => write!(
                f,
                "the body lies {:.0} % of the person's size from the detections of {}, much farther than in the rest",
                100.0 * off,
                frames(of)
            ),
            // points
            Self::PointsOutside { frames: of, share, by_m } => write!(
                f,
                "points and silhouettes disagree in {}: {:.0} % of the points lie outside a silhouette, by {by_m:.2} m: check the frame numbers, unit and world of the points",
                frames(of),
                100.0 * share
            ),
            Self::PointsOffSkin { frames: of, by_m } => write!(
                f,
                "points and silhouettes disagree in {}: half of the points lie {by_m:.2} m or more off the skin: check the frame numbers, unit and world of the points",
                frames(of)
            ),
            _ => Ok(()),
        }
    }
}

/// `hand_r (40 % of the frames)`, one after the other.
fn shares(limbs: &[(String, f64)]) -> String {
    let each =
        limbs.iter().map(|(tip, share)| format!("{tip} ({:.0} % of the frames)", 100.0 * share));
    each.collect::<Vec<_>>().join(", ")
}

/// How many frames, and which.
fn frames(frames: &Frames) -> String {
    match frames.0.len() {
        1 => format!("1 frame ({frames})"),
        n => format!("{n} frames ({frames})"),
    }
}
