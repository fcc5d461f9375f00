//! Whether detections were made from pictures of another size than the calibration's.
//!
//! A detector that was given pictures of half the size says half the pixels: x′ = x/q, q = 2. Lines of sight to one joint then pass each
//! other, or meet about people that nobody is. So people are [grouped](super) with their pixels times each q of a list. At the right one
//! lines of sight meet, and Σ n·(0.1 − mean d), over the groups of n people in which d is less, is greatest. Pixels are scaled after the lens's
//! distortion was taken from them, which is wrong by a few pixels at the border of the picture: enough to tell a half from a whole.
//!
//! # Source
//! The list holds the ratios of usual sizes of pictures (2160, 1440, 1080, 720, 540, 480, 360 rows). The limits: E.

use rayon::prelude::*;

use super::Seen;
use super::groups::{self, Group};
use crate::camera::Rig;
use crate::silhouette::{FramePeople, Keypoint};

/// How many of the calibration's pixels one of the detections' may be.
const SCALES: [f64; 12] = [
    1.0 / 4.0,
    1.0 / 3.0,
    1.0 / 2.0,
    2.0 / 3.0,
    3.0 / 4.0,
    4.0 / 3.0,
    3.0 / 2.0,
    2.0,
    9.0 / 4.0,
    8.0 / 3.0,
    3.0,
    4.0,
];
/// The lines of sight to one person miss each other by less, over the size: detectors scatter by .02 to .05.
const MEETING: f64 = 0.1;
/// Another size is told if lines of sight meet so much better with it.
const SURELY: f64 = 2.0;
/// Frames that are looked at.
const SAMPLED: usize = 12;

/// How many of the calibration's pixels one pixel of the detections is, if surely not one.
pub fn other_scale(rig: &Rig, frames: &[FramePeople]) -> Option<f64> {
    let step = frames.len().div_ceil(SAMPLED).max(1);
    let sampled: Vec<&FramePeople> = frames.iter().step_by(step).collect();
    let pictures: usize = sampled.iter().map(|frame| frame.pictures.len()).sum();

    let people: usize =
        sampled.iter().flat_map(|f| &f.pictures).map(|(_, people)| people.len()).sum();

    // no other scale can be so much better if all people meet well enough as they are
    let least = SURELY * Meeting::new(rig, &sampled, 1.0).sum;
    if least >= MEETING * people as f64 {
        return None;
    }
    let others = SCALES.par_iter().map(|&scale| (Meeting::new(rig, &sampled, scale), scale));
    let surely = others.filter(|(m, _)| m.sum > least && 2 * m.members >= pictures);
    let best = surely.max_by(|a, b| a.0.sum.total_cmp(&b.0.sum));
    best.map(|(_, scale)| scale)
}

/// How well lines of sight meet at a scale.
struct Meeting {
    /// Σ n·(0.1 − mean d).
    sum: f64,
    /// Σ n.
    members: usize,
}

impl Meeting {
    fn new(rig: &Rig, frames: &[&FramePeople], scale: f64) -> Self {
        let of_frame =
            |frame: &&FramePeople| groups::groups(rig, &Seen::of_frame(&scaled(frame, scale)));
        let groups = frames.iter().flat_map(of_frame).filter(|group| group.miss < MEETING);
        let nothing = Self { sum: 0.0, members: 0 };
        groups.fold(nothing, |all, group: Group| {
            let n = group.members.len();
            Self { sum: all.sum + n as f64 * (MEETING - group.miss), members: all.members + n }
        })
    }
}

/// The people of a frame as pictures `scale` times as large would show them.
fn scaled(frame: &FramePeople, scale: f64) -> FramePeople {
    let larger = |keypoint: &Keypoint| Keypoint { pixel: keypoint.pixel * scale, ..*keypoint };
    let person = |person: &Vec<Keypoint>| person.iter().map(larger).collect();
    let picture = |people: &Vec<_>| people.iter().map(person).collect();
    let pictures = frame.pictures.iter().map(|(camera, people)| (*camera, picture(people)));
    FramePeople { frame: frame.frame, pictures: pictures.collect() }
}
