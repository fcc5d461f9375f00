//! Verdicts in plain words.

use std::fmt;

use super::verdict::BODY_L;
use super::{Cause, LensOff, Reason, Verdict};
use crate::pipeline::counted;

/// What is said of what the fit moves.
const USED: &str = "taken into account";
const NOT_USED: &str = "told, and not used: --cameras check";

/// Causes in one line.
pub(in crate::pipeline) fn joined(causes: &[Cause]) -> String {
    let causes: Vec<String> = causes.iter().map(ToString::to_string).collect();
    causes.join("; ")
}

impl Verdict {
    /// The headline of a fit that cannot be used.
    pub fn why_unusable(&self) -> Option<String> {
        self.headline().filter(|_| !self.is_usable())
    }

    /// The verdict in one line: why a fit cannot be used, and what is wrong. `None` where there is nothing to say.
    pub fn headline(&self) -> Option<String> {
        let reasons: Vec<String> = self.unusable.iter().map(ToString::to_string).collect();
        let causes = joined(&self.causes);
        match (reasons.is_empty(), causes.is_empty()) {
            (true, true) => None,
            (true, false) => Some(causes),
            (false, true) => Some(format!("not usable: {}", reasons.join(", "))),
            (false, false) => Some(format!("not usable: {}. {causes}", reasons.join(", "))),
        }
    }
}

impl fmt::Display for Reason {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Overlap { found, least } => {
                write!(
                    f,
                    "the body overlaps the silhouettes by {found:.2} (at least {least:.2} is needed)"
                )
            }
            Self::Detections { found, most } => {
                write!(
                    f,
                    "the detections lie {:.0} % of the person's size from the body (at most {:.0} %)",
                    100.0 * found,
                    100.0 * most
                )
            }
            Self::WrongPictures { found, .. } => {
                write!(
                    f,
                    "the pictures of {found:.0} cameras are those of others, mirrored or upside down"
                )
            }
            Self::ThinParts { found, least } => {
                write!(
                    f,
                    "{:.1} % of the silhouettes are thin as arms, hands and feet are (at least {:.0} % is usual)",
                    100.0 * found,
                    100.0 * least
                )
            }
            Self::Body { found, most } => {
                write!(
                    f,
                    "its size and proportions are {found:.0} times as improbable as usual (at most {most:.0})"
                )
            }
            Self::Displacement { found, most } => {
                write!(
                    f,
                    "a camera would stand {found:.1} m from where it was calibrated (at most {most:.0} m is believed)"
                )
            }
            Self::Uncrossed { .. } => {
                write!(
                    f,
                    "cameras side by side no longer stand as they were calibrated, so how far away the person is cannot be told: calibrate again"
                )
            }
            // of all frames
            Self::LostFrames { found, most } => {
                write!(
                    f,
                    "{:.0} % of the frames are lost (at most {:.0} %)",
                    100.0 * found,
                    100.0 * most
                )
            }
        }
    }
}

impl fmt::Display for Cause {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            // cameras
            Self::AllMirrored => {
                write!(f, "all pictures are mirrored: exchange left and right in them")
            }
            Self::Mirrored { camera } => {
                write!(f, "{camera} is mirrored: exchange left and right in its pictures")
            }
            Self::AllUpsideDown => {
                write!(f, "all pictures are upside down: turn them by half a turn")
            }
            Self::UpsideDown { camera } => {
                write!(f, "{camera} is upside down: turn its pictures by half a turn")
            }
            Self::Exchanged { cameras: [a, b] } => {
                write!(f, "{a} and {b} are exchanged: each has the other's files or calibration")
            }

            // clocks and lenses
            Self::Late { camera, frames } => write!(
                f,
                "{camera} is {} by {}: add {} to its offset_frames in sequence.toml",
                if *frames > 0 { "late" } else { "early" },
                counted(frames.unsigned_abs(), "frame"),
                -frames
            ),
            Self::FocalLengths { lens } => write!(f, "the focal lengths of all cameras are {lens}"),
            Self::FocalLength { camera, lens } => {
                write!(f, "the focal length of {camera} is {lens}")
            }

            // where it stands
            Self::Displaced { camera, miss_m } => write!(
                f,
                "{camera} shows the person elsewhere than the other cameras do, by {:.0} cm: it was moved, turned or zoomed after the calibration; calibrate it again, or leave it out",
                (100.0 * miss_m).max(1.0)
            ),
            Self::Touched { camera, pose } => {
                let ((turn, turn_sd), (place, place_sd)) = (pose.turn(), pose.displacement());
                write!(
                    f,
                    "{camera} was touched after its calibration: turned by {turn:.1} ± {:.1}°, displaced by {:.0} ± {:.0} mm ({})",
                    turn_sd.unwrap_or_default(),
                    1e3 * place,
                    1e3 * place_sd.unwrap_or_default(),
                    if pose.used { USED } else { NOT_USED }
                )
            }
            Self::Clock { camera, late_frames, sd_frames } => write!(
                f,
                "{camera} is {} by {:.1} ± {sd_frames:.1} frames ({USED})",
                if *late_frames > 0.0 { "late" } else { "early" },
                late_frames.abs()
            ),
            of_masks => of_masks.fmt_masks(f),
        }
    }
}

impl Cause {
    /// What is wrong with the masks.
    fn fmt_masks(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::StillParts { cameras, share } => write!(
                f,
                "the masks of {} hold something that never moves, up to {:.0} % of the person's area: furniture, a second person who stays in place, or a stale picture of the empty room; segment again",
                cameras.join(", "),
                100.0 * share
            ),
            Self::SecondBody { litres } if *litres > BODY_L => write!(
                f,
                "the silhouettes hold {litres:.0} litres beside the body: a second person or a large object; keep one person in the masks"
            ),
            Self::SecondBody { litres } => write!(
                f,
                "the silhouettes hold {litres:.0} litres beside the body, as much as a limb: a second person, a stale picture of the person, or something carried; keep one person in the masks"
            ),
            Self::MasksDisagree { miss_m } => write!(
                f,
                "the outlines of all cameras miss each other, by {:.0} mm: thin parts (arms, hands, feet) are lost in the masks, or the masks hold more than the person; segment again",
                1e3 * miss_m
            ),
            Self::Cropped { cameras } => write!(
                f,
                "the masks of {} end at one upright line inside the picture, time and again: a part of the picture is cut off, or was never segmented; segment whole pictures",
                cameras.join(", ")
            ),
            Self::ThinPartsGone => write!(
                f,
                "the masks have lost the thin parts (arms, hands, feet): clean them up with a smaller disk, or segment again"
            ),
            Self::CutOff { height_m } => write!(
                f,
                "what the silhouettes show is {height_m:.2} m tall, less than a standing person: the legs or other parts are hidden, cut off or lost in the masks (or the person sits or crouches, or the unit of the calibration is wrong)"
            ),
            left_out => left_out.fmt_left_out(f),
        }
    }

    /// What was left out.
    fn fmt_left_out(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Repeated { camera, pictures } => write!(
                f,
                "{camera} shows the picture before once more in {} while the person moves: they were left out; give its video at the frame rate it was recorded with",
                counted(*pictures, "frame")
            ),
            Self::Rods { share, .. } => write!(
                f,
                "{:.0} % of the masks hold something longer than a hand and thinner than a wrist, as canes, crutches and walking frames are: it was taken out of them",
                100.0 * share
            ),
            Self::PartsHidden { cameras, share } => write!(
                f,
                "{} left out where the masks lack a part of the person that the other cameras see, up to {:.0} %: hidden by furniture, or lost in the masks",
                were(cameras),
                100.0 * share
            ),
            Self::PartsAlone { cameras, share } => write!(
                f,
                "{} left out where the masks hold something that the other cameras do not see, up to {:.0} % of their area: furniture or somebody else; segment again",
                were(cameras),
                100.0 * share
            ),
            Self::Things { cameras, share } => write!(
                f,
                "the masks of {} hold something that never moves while the person walks, up to {:.0} % of their area: it was left out",
                cameras.join(", "),
                100.0 * share
            ),
            Self::Shadows { share } => write!(
                f,
                "the masks hold shadows on the floor, {:.0} % of their area: they were left out, and with them what they hide of the feet",
                100.0 * share
            ),
            Self::Worn { .. } => write!(
                f,
                "the masks hold something that moves with the person, as a bag, a skirt or a long coat does: their borders count less where they lie outside the body, and joints are less sure"
            ),
            Self::TouchedWhile { camera, frame, turn_deg, left_out: [first, last] } => write!(
                f,
                "{camera} was touched while it recorded: what it shows jumps at {frame}, as if it had been turned by {turn_deg:.1}°; its frames {} to {} were left out",
                first.0, last.0
            ),
            Self::LostFrames { camera, frame, frames } => write!(
                f,
                "{camera} {} before its {frame} ({USED}): number its files from there on {} {}",
                match frames {
                    1.. => format!("has lost {}", counted(frames.unsigned_abs(), "frame")),
                    _ => format!("shows {} twice", counted(frames.unsigned_abs(), "frame")),
                },
                frames.unsigned_abs(),
                if *frames > 0 { "higher" } else { "lower" }
            ),
            Self::Strayed { cameras } => write!(
                f,
                "{} left out, for no place near the calibrated one explains what they show: the masks hold something that the other cameras do not see, or lack a part of the person, or the camera was moved far; look at the masks, or calibrate again",
                were(cameras)
            ),
            of_scene => of_scene.fmt_scene(f),
        }
    }

    /// What is wrong with the world or the body.
    fn fmt_scene(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Turned { head } => write!(
                f,
                "the person's head points along {} of the world, not up: set another `up` in sequence.toml (z, -z, y or -y)",
                head.name()
            ),
            Self::FrameRate { acceleration_g } => write!(
                f,
                "the pelvis is accelerated by {acceleration_g:.0} g on average, and nobody moves so: the frame rate is too high (--fps)"
            ),
            Self::Scale { factor } => write!(
                f,
                "the body is about {} for a person: is the calibration's unit of length right (the size of the board's squares)? Give the height if it is (--height)",
                too_large(*factor, "large", "small")
            ),
            Self::Height { found_m, given_m } => write!(
                f,
                "the body is {found_m:.2} m tall, {} for a person of {given_m:.2} m: is the calibration's unit of length right (the size of the board's squares), and are the focal lengths (zoom)?",
                too_large(found_m / given_m, "large", "small")
            ),
            _ => write!(
                f,
                "no cause was found: look at the overlays (--overlays): does every mask show one whole person, and nothing else?"
            ),
        }
    }
}

/// `cam_01 and cam_02 were`.
fn were(cameras: &[String]) -> String {
    match cameras.split_last() {
        Some((last, [])) => format!("{last} was"),
        Some((last, others)) => format!("{} and {last} were", others.join(", ")),
        None => "no camera was".into(),
    }
}

/// `5 % too long`.
fn too_large(factor: f64, large: &str, small: &str) -> String {
    let percent = 100.0 * (factor - 1.0).abs();
    format!("{percent:.0} % too {}", if factor > 1.0 { large } else { small })
}

impl fmt::Display for LensOff {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { factor, sd, used } = self;
        let Some(sd) = sd else {
            let off = too_large(*factor, "long", "short");
            return write!(
                f,
                "about {off}: calibrate again, with zoom and picture size as recorded"
            );
        };
        write!(
            f,
            "{:.1} ± {:.1} % too {} ({})",
            100.0 * (factor - 1.0).abs(),
            100.0 * sd,
            if *factor > 1.0 { "long" } else { "short" },
            if *used { USED } else { NOT_USED }
        )
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::pipeline::PoseFound;

    #[test]
    fn what_is_told_and_not_used_is_said_to_be_so() {
        let touched = |used: bool| Cause::Touched {
            camera: "cam_02".into(),
            pose: Box::new(PoseFound {
                turn_deg: [1.0, 0.0, 0.0],
                turn_sd_deg: Some([0.1; 3]),
                displacement_m: [0.02, 0.0, 0.0],
                displacement_sd_m: Some([0.005; 3]),
                zoom: 1.0,
                zoom_sd: Some(0.001),
                used,
            }),
        };
        let late = Cause::Clock { camera: "cam_03".into(), late_frames: 2.0, sd_frames: 0.1 };
        let words =
            |causes: Vec<Cause>| Verdict { unusable: Vec::new(), causes }.headline().unwrap();
        let told = words(vec![touched(false), late]);
        assert!(told.contains("displaced by 20 ± 5 mm (told, and not used"), "{told}");
        assert!(
            told.ends_with("cam_03 is late by 2.0 ± 0.1 frames (taken into account)"),
            "{told}"
        );
        assert!(words(vec![touched(true)]).ends_with("(taken into account)"));
    }
}
