//! A person who walks and for a while holds the arms where no silhouette shows them.

use std::path::Path;

use experiments::walker::WalkerError;
use maquette::body::BodyModel;
use maquette::io::model;
use maquette::silhouette::FrameIndex;
use maquette::synth::{Make, Recipe, Ring, SegmentationErrors, Synthetic};

/// Frames per second.
const FPS: f64 = 50.0;
/// Frames, as many as ZS06 had, and of the quick run.
pub(crate) const FRAMES: [usize; 2] = [200, 100];
/// Cameras.
pub(crate) const CAMERAS: usize = 4;
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

/// Four cameras at the height of the hips, so that arms before the trunk stay within its outline.
///
/// # Errors
/// [`WalkerError`]; the shipped model has none.
pub(crate) fn recording(frames: usize, seed: u64) -> Result<Synthetic, WalkerError> {
    let body = model::load("walker-metaballs", Path::new(""))?;
    let recipe = Recipe {
        seed,
        frames: Some(frames),
        fps: FPS,
        make: Make::Metaballs,
        ring: Ring {
            cameras: CAMERAS,
            radius: 6.0,
            height: 1.0,
            focal_px: 560.0,
            width_px: 800,
            height_px: 600,
            ..Ring::default()
        },
        errors: Some(SegmentationErrors::MILD),
        stereo: None,
    };
    let mut recording = recipe.walker(&body)?;
    for (i, motion) in recording.motions.iter_mut().enumerate() {
        let held = held(i, frames);
        for (joint, angle_deg) in HELD_DEG {
            if let Some(joint) = body.joint(joint) {
                let angle = &mut motion.angles[joint.0];
                *angle += held * (angle_deg.to_radians() - *angle);
            }
        }
    }
    Ok(recording)
}

/// How far the arms are on their way to the body in a frame, 0 to 1: smooth in speed and acceleration.
pub(crate) fn held(frame: usize, frames: usize) -> f64 {
    let time = frame as f64 / frames as f64;
    let ease = |from: f64, to: f64| {
        let x = ((time - from) / (to - from)).clamp(0.0, 1.0);
        x * x * x * (10.0 - 15.0 * x + 6.0 * x * x)
    };
    let [begin, there, leave, swing] = HELD;
    ease(begin, there) - ease(leave, swing)
}

/// From when to when the arms are held, seconds.
pub(crate) fn held_s(frames: usize) -> [f64; 2] {
    [HELD[1], HELD[2]].map(|part| part * frames as f64 / FPS)
}

/// Which part of an arm's image lies outside the image of the rest of the body: the mean over the cameras and over
/// every tenth frame, of the frames in which the arms are held and of the others; right arm, left arm.
pub(crate) fn visible(recording: &Synthetic) -> [[f64; 2]; 2] {
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
