//! What a person should know about a fit, in plain words.

use std::fmt;

use super::diagnosis::lost_frames;
use super::{CameraQuality, FittedFrame, points};
use crate::camera::{Camera, CameraId, Rig};
use crate::inference::ShapeConfidence;
use crate::inference::search::ENOUGH_KEYFRAMES;
use crate::math::stats::{mean, median};
use crate::silhouette::{FrameIndex, FrameObservations, Rejected};

/// Something about a fit that its reader should know, in one line.
#[derive(Debug, Clone, PartialEq)]
#[non_exhaustive]
pub enum Warning {
    /// A camera whose silhouettes lie elsewhere than the others'.
    OddCamera {
        /// Its name.
        camera: String,
    },
    /// A camera that the body covers worse than the others.
    WeakCamera {
        /// Its name.
        camera: String,
        /// Its mean overlap.
        iou: f64,
        /// The median of the others'.
        others_iou: f64,
    },
    /// A person who may face the other way.
    Facing {
        /// How many times less probable that is.
        odds: f64,
    },
    /// A person whose other way of facing was not tried.
    FacingUntried,
    /// A person whose height is not known: outlines show no scale.
    ScaleUnchecked {
        /// How tall the body is, m.
        found_m: f64,
    },
    /// A body that lies where the masks show nobody.
    Astray {
        /// The share of the body, mean over all silhouettes.
        share: f64,
    },
    /// A part that is as thick as nobody's.
    Swollen {
        /// Its name.
        part: String,
        /// Its volume over the mean body's.
        times: f64,
    },
    /// Nothing but detections of joints.
    DetectionsAlone,
    /// Limbs that lie before or behind the body in all cameras but one, or in all.
    HiddenLimbs {
        /// Their tips, and in which share of the frames.
        limbs: Vec<(String, f64)>,
    },
    /// Cameras that look along one line.
    OneOutline,
    /// Masks that show nobody.
    Rejected {
        /// The camera.
        camera: String,
        /// The frames.
        frames: Frames,
        /// Why the first of them shows nobody.
        reason: Rejected,
    },
    /// Frames that no camera sees.
    Unseen {
        /// The frames.
        frames: Frames,
    },
    /// Frames that one camera sees.
    OneView {
        /// The frames.
        frames: Frames,
    },
    /// Frames in which the tracking was lost and that were searched anew.
    Recovered {
        /// The frames.
        frames: Frames,
    },
    /// Frames that the body covers much worse than the rest.
    Lost {
        /// The frames.
        frames: Frames,
        /// Their mean overlap.
        iou: f64,
    },
    /// Frames from whose detections the body lies much farther off than from the rest's.
    LostJoints {
        /// The frames.
        frames: Frames,
        /// By how much, over the person's size.
        off: f64,
    },
    /// Points that lie outside the silhouettes.
    PointsOutside {
        /// The frames.
        frames: Frames,
        /// Which share of their points, median over the frames.
        share: f64,
        /// By how much, median, m.
        by_m: f64,
    },
    /// Points that are off the skin of a body that covers the silhouettes.
    PointsOffSkin {
        /// The frames.
        frames: Frames,
        /// By how much, median, m.
        by_m: f64,
    },
    /// Parts that nothing sees.
    KeepsPrior {
        /// Their names.
        parts: Vec<String>,
    },
    /// Too few keyframes for a confidence that means much.
    FewKeyframes {
        /// K.
        keyframes: usize,
    },
}

/// Frame numbers, written as ranges: 3–7, 12.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct Frames(pub Vec<FrameIndex>);

impl fmt::Display for Frames {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let mut ranges: Vec<(usize, usize)> = Vec::new();
        for FrameIndex(frame) in &self.0 {
            match ranges.last_mut() {
                Some((_, last)) if *last + 1 == *frame => *last = *frame,
                _ => ranges.push((*frame, *frame)),
            }
        }
        let shown = ranges.iter().take(MOST_RANGES).map(|(a, b)| match b - a {
            0 => a.to_string(),
            1 => format!("{a}, {b}"),
            _ => format!("{a}–{b}"),
        });
        f.write_str(&shown.collect::<Vec<_>>().join(", "))?;
        if ranges.len() > MOST_RANGES {
            f.write_str(", …")?;
        }
        Ok(())
    }
}

/// More ranges of frames than these are not read by anybody.
const MOST_RANGES: usize = 6;

/// A camera this much below the median of the others is weak.
const WEAK_BY: f64 = 0.08;
impl Warning {
    /// Whether this follows where something is wrong with the recording, and says nothing beside the cause.
    pub(super) fn is_symptom(&self) -> bool {
        matches!(self, Self::OddCamera { .. } | Self::WeakCamera { .. })
    }
}

/// What is to be said about the observations and the fit, worst first.
pub(super) fn warnings(
    rig: &Rig,
    observations: &[FrameObservations],
    frames: &[FittedFrame],
    cameras: &[CameraQuality],
    confidence: &ShapeConfidence,
) -> Vec<Warning> {
    let mut warnings = overlap_warnings(frames, cameras);
    let is_detected = frames.iter().any(|frame| !frame.detections.is_empty());
    if is_detected && frames.iter().all(|f| f.views.is_empty() && f.points.is_none()) {
        warnings.push(Warning::DetectionsAlone);
    }

    let those = |is: &dyn Fn(&&FittedFrame) -> bool| {
        Frames(frames.iter().filter(is).map(|f| f.frame).collect())
    };
    let (unseen, one) = (those(&|f| !f.is_observed()), those(&|f| f.cameras() == 1));
    let recovered = those(&|f| f.fit.recovered);
    for (frames, warning) in [
        (unseen, (|frames| Warning::Unseen { frames }) as fn(Frames) -> Warning),
        (one, |frames| Warning::OneView { frames }),
        (recovered, |frames| Warning::Recovered { frames }),
    ] {
        if !frames.0.is_empty() {
            warnings.push(warning(frames));
        }
    }

    warnings.extend(rejection_warnings(rig, observations));
    warnings.extend(points::warnings(frames, observations));
    let keyframes = confidence.keyframes();
    if keyframes < ENOUGH_KEYFRAMES {
        warnings.push(Warning::FewKeyframes { keyframes });
    }
    warnings
}

fn overlap_warnings(frames: &[FittedFrame], cameras: &[CameraQuality]) -> Vec<Warning> {
    let mut warnings = Vec::new();

    // each camera beside the others
    let seen: Vec<&CameraQuality> = cameras.iter().filter(|c| c.frames > 0).collect();
    for quality in &seen {
        let others = seen.iter().filter(|c| c.camera != quality.camera);
        let others_iou = median(&mut others.map(|c| c.mean_iou).collect());
        if let Some(others_iou) = others_iou.filter(|iou| quality.mean_iou < iou - WEAK_BY) {
            warnings.push(Warning::WeakCamera {
                camera: quality.camera.clone(),
                iou: quality.mean_iou,
                others_iou,
            });
        }
    }

    // frames
    let lost: Vec<&FittedFrame> = lost_frames(frames).into_iter().map(|i| &frames[i]).collect();
    let those = |frames: &[&FittedFrame]| Frames(frames.iter().map(|frame| frame.frame).collect());
    if let Some(iou) = mean(lost.iter().filter_map(|frame| frame.mean_iou())) {
        warnings.push(Warning::Lost { frames: those(&lost), iou });
    }
    if let Some(off) = mean(lost.iter().filter_map(|frame| frame.detected_off())) {
        warnings.push(Warning::LostJoints { frames: those(&lost), off });
    }
    warnings
}

fn rejection_warnings(rig: &Rig, observations: &[FrameObservations]) -> Vec<Warning> {
    let of = |(id, camera): (CameraId, &Camera)| {
        let rejected: Vec<(FrameIndex, Rejected)> = observations
            .iter()
            .flat_map(|o| o.rejected.iter().map(move |(c, why)| (o.frame, *c, *why)))
            .filter_map(|(frame, camera, why)| (camera == id).then_some((frame, why)))
            .collect();
        let reason = rejected.first()?.1;
        let frames = Frames(rejected.into_iter().map(|(frame, _)| frame).collect());
        Some(Warning::Rejected { camera: camera.name.clone(), frames, reason })
    };
    rig.iter().filter_map(of).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn frames_are_listed_as_ranges() {
        let of = |numbers: &[usize]| {
            Frames(numbers.iter().copied().map(FrameIndex).collect()).to_string()
        };
        assert_eq!(of(&[3, 4, 5, 9, 11, 12]), "3–5, 9, 11, 12");
        assert_eq!(of(&[0, 2, 4, 6, 8, 10, 12]), "0, 2, 4, 6, 8, 10, …");
        assert_eq!(of(&[]), "");
    }

    #[test]
    fn a_weak_camera_is_told_as_a_person_would() {
        let warning =
            Warning::WeakCamera { camera: "cam_03".into(), iou: 0.714, others_iou: 0.931 };
        assert_eq!(
            warning.to_string(),
            "cam_03 overlaps the body by 0.71, the other cameras by 0.93: check its calibration and its masks"
        );
    }
}
