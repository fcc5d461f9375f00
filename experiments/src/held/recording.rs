//! A person who walks and for a while holds the arms where no silhouette shows them.

use std::path::Path;

use maquette::body::BodyModel;
use maquette::io::model;
use maquette::silhouette::FrameIndex;
use maquette::synth::{Make, Recipe, Ring, SegmentationErrors, Synthetic};

use crate::walker::WalkerError;

/// Frames per second.
const FPS: f64 = 50.0;
/// Frames, as many as ZS06 had, and of the quick run.
pub const FRAMES: [usize; 2] = [200, 100];
/// Cameras.
pub const CAMERAS: usize = 4;
/// When the arms begin to go to the body, are there, begin to leave it and swing again: parts of the recording.
const HELD: [f64; 4] = [0.175, 0.3, 0.75, 0.875];

/// Where the arms are held, degrees: the right forearm before the belly, the left arm against the side.
const HELD_DEG: [(&str, f64); 8] = [
    ("shoulder_flexion_r", 5.0),
    ("shoulder_abduction_r", -10.0),
    ("shoulder_rotation_r", 65.0),
    ("elbow_flexion_r", 100.0),
    ("shoulder_flexion_l", 0.0),
    ("shoulder_abduction_l", -6.0),
    ("shoulder_rotation_l", 10.0),
    ("elbow_flexion_l", 20.0),
];

/// Where the right arm is held; the left one is beside the trunk.
#[derive(Debug, Clone, Copy, PartialEq, Eq, serde::Serialize)]
#[serde(rename_all = "lowercase")]
pub enum RightArm {
    /// The forearm before the belly.
    Belly,
    /// Beside the trunk, as the left one.
    Side,
}

/// What a recording of held arms is made of.
#[derive(Debug, Clone, Copy, PartialEq, serde::Serialize)]
pub struct Holding {
    /// Frames.
    pub frames: usize,
    /// Cameras around the person.
    pub cameras: usize,
    /// Their height, metres.
    pub height_m: f64,
    /// By how much both upper arms are spread from where they are held, degrees.
    pub spread_deg: f64,
    /// Where the right arm is held.
    pub right: RightArm,
    /// Flexion of an elbow beside the trunk while held, degrees.
    pub elbow_deg: f64,
    /// How often the errors of a mild segmentation; 0 is none.
    pub raggedness: f64,
}

impl Holding {
    /// Four cameras at the height of the hips, so that arms before the trunk stay within its outline.
    pub fn new(frames: usize) -> Self {
        Self {
            frames,
            cameras: CAMERAS,
            height_m: 1.0,
            spread_deg: 0.0,
            right: RightArm::Belly,
            elbow_deg: 20.0,
            raggedness: 1.0,
        }
    }

    /// The recording.
    ///
    /// # Errors
    /// [`WalkerError`]; the shipped model has none.
    pub fn recording(&self, seed: u64) -> Result<Synthetic, WalkerError> {
        let body = model::load("walker-metaballs", Path::new(""))?;
        let mild = SegmentationErrors::MILD;
        let errors =
            SegmentationErrors { border_sd_px: mild.border_sd_px * self.raggedness, ..mild };
        let recipe = Recipe {
            seed,
            frames: Some(self.frames),
            fps: FPS,
            make: Make::Metaballs,
            ring: Ring {
                cameras: self.cameras,
                radius: 6.0,
                height: self.height_m,
                focal_px: 560.0,
                width_px: 800,
                height_px: 600,
                ..Ring::default()
            },
            errors: (self.raggedness > 0.0).then_some(errors),
            stereo: None,
            ..Recipe::default()
        };
        let mut recording = recipe.walker(&body)?;
        for (i, motion) in recording.motions.iter_mut().enumerate() {
            let held = held(i, self.frames);
            for (joint, _) in HELD_DEG {
                if let (Some(id), Some(angle_deg)) = (body.joint(joint), self.held_deg(joint)) {
                    let angle = &mut motion.angles[id.0];
                    *angle += held * (angle_deg.to_radians() - *angle);
                }
            }
        }
        Ok(recording)
    }

    /// Where a joint is held, degrees.
    fn held_deg(&self, joint: &str) -> Option<f64> {
        let beside = joint.replace("_r", "_l");
        let as_held = match self.right {
            RightArm::Belly => joint,
            RightArm::Side => beside.as_str(),
        };
        let (_, usual_deg) = HELD_DEG.iter().find(|(name, _)| *name == as_held)?;
        Some(match as_held {
            "elbow_flexion_l" => self.elbow_deg,
            "shoulder_abduction_r" | "shoulder_abduction_l" => usual_deg + self.spread_deg,
            _ => *usual_deg,
        })
    }
}

/// How far the arms are on their way to the body in a frame, 0 to 1: smooth in speed and acceleration.
pub fn held(frame: usize, frames: usize) -> f64 {
    let time = frame as f64 / frames as f64;
    let ease = |from: f64, to: f64| {
        let x = ((time - from) / (to - from)).clamp(0.0, 1.0);
        x * x * x * (10.0 - 15.0 * x + 6.0 * x * x)
    };
    let [begin, there, leave, swing] = HELD;
    ease(begin, there) - ease(leave, swing)
}

/// From when to when the arms are held, seconds.
pub fn held_s(frames: usize) -> [f64; 2] {
    [HELD[1], HELD[2]].map(|part| part * frames as f64 / FPS)
}

/// Which part of an arm's image lies outside the image of the rest of the body: the mean over the cameras and over
/// every tenth frame, of the frames in which the arms are held and of the others; right arm, left arm.
pub fn visible(recording: &Synthetic) -> [[f64; 2]; 2] {
    ["_r", "_l"].map(|side| {
        let of = |kept| Synthetic {
            model: with_parts(&recording.model, side, kept),
            ..recording.clone()
        };
        let (arm, rest) = (of(Kept::Arm), of(Kept::Rest));
        let mut sums = [(0.0, 0.0); 2];
        for frame in (0..recording.frames()).step_by(10) {
            let held = held(frame, recording.frames());
            let sum = &mut sums[usize::from(held < 0.5)];
            for (camera, _) in recording.rig.iter() {
                let masks = [&arm, &rest].map(|of| of.true_mask(FrameIndex(frame), camera));
                let [Some(arm), Some(rest)] = masks else {
                    continue;
                };
                for y in 0..arm.height() {
                    for x in 0..arm.width() {
                        let shown = arm.is_foreground(x, y);
                        sum.0 += f64::from(u8::from(shown && !rest.is_foreground(x, y)));
                        sum.1 += f64::from(u8::from(shown));
                    }
                }
            }
        }
        sums.map(|(outside, all)| outside / f64::max(all, 1.0))
    })
}

/// What is left of a body.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Kept {
    Arm,
    Rest,
}

/// The body with one arm's metaballs alone, or without them.
fn with_parts(model: &BodyModel, side: &str, kept: Kept) -> BodyModel {
    let arm = ["upper_arm", "forearm", "hand"].map(|part| format!("{part}{side}"));
    let is_arm = |part: usize| arm.contains(&model.parts[part].name);
    let mut left = model.clone();
    left.metaballs.retain(|ball| is_arm(ball.part.0) == (kept == Kept::Arm));
    left
}
