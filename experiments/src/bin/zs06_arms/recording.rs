//! A person who walks and for a while holds the arms where no silhouette shows them.

use std::path::Path;

use experiments::walker::WalkerError;
use maquette::body::BodyModel;
use maquette::io::model;
use maquette::silhouette::FrameIndex;
use maquette::synth::{Recipe, Ring, SegmentationErrors, Synthetic};

/// Frames at 50 Hz, as many as ZS06 had.
pub(crate) const FRAMES: usize = 200;
/// Cameras.
pub(crate) const CAMERAS: usize = 4;
/// When the arms begin to go to the body, are there, begin to leave it and swing again, seconds.
pub(crate) const HIDDEN_S: [f64; 4] = [0.7, 1.2, 3.0, 3.5];

/// Where the arms are held, degrees: the right forearm before the belly, the left arm against the side.
const HELD_DEG: [(&str, f64); 8] = [
    ("shoulder_flexion_r", -8.0),
    ("shoulder_abduction_r", 5.0),
    ("shoulder_rotation_r", 50.0),
    ("elbow_flexion_r", 85.0),
    ("shoulder_flexion_l", 0.0),
    ("shoulder_abduction_l", 3.0),
    ("shoulder_rotation_l", 10.0),
    ("elbow_flexion_l", 30.0),
];

/// Four cameras at the height of the hips, so that arms before the trunk stay within its outline.
///
/// # Errors
/// [`WalkerError`]; the shipped model has none.
pub(crate) fn recording(seed: u64) -> Result<Synthetic, WalkerError> {
    let body = model::load("walker-metaballs", Path::new(""))?;
    let recipe = Recipe {
        seed,
        frames: Some(FRAMES),
        fps: 50.0,
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
        let held = held(i as f64 / recording.fps);
        for (joint, angle_deg) in HELD_DEG {
            if let Some(joint) = body.joint(joint) {
                let angle = &mut motion.angles[joint.0];
                *angle += held * (angle_deg.to_radians() - *angle);
            }
        }
    }
    Ok(recording)
}

/// How far the arms are on their way to the body, 0 to 1: smooth in speed and acceleration.
pub(crate) fn held(seconds: f64) -> f64 {
    let ease = |from: f64, to: f64| {
        let x = ((seconds - from) / (to - from)).clamp(0.0, 1.0);
        x * x * x * (10.0 - 15.0 * x + 6.0 * x * x)
    };
    let [begin, there, leave, swing] = HIDDEN_S;
    ease(begin, there) - ease(leave, swing)
}

/// Which part of an arm's image lies outside the image of the rest of the body: the mean over the cameras and over
/// every tenth frame, of the frames in which the arms are held and of the others; right arm, left arm.
pub(crate) fn visible(recording: &Synthetic) -> [[f64; 2]; 2] {
    ["_r", "_l"].map(|side| {
        let arm = Synthetic {
            model: with_parts(&recording.model, side, true),
            ..recording.clone()
        };
        let rest = Synthetic {
            model: with_parts(&recording.model, side, false),
            ..recording.clone()
        };
        let mut sums = [(0.0, 0.0); 2];
        for frame in (0..recording.frames()).step_by(10) {
            let held = held(frame as f64 / recording.fps);
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

/// The body with one arm's metaballs alone, or without them.
fn with_parts(model: &BodyModel, side: &str, the_arm: bool) -> BodyModel {
    let arm = ["upper_arm", "forearm", "hand"].map(|part| format!("{part}{side}"));
    let is_arm = |part: usize| arm.contains(&model.parts[part].name);
    let mut model = model.clone();
    model.metaballs = (model.metaballs.into_iter())
        .filter(|ball| is_arm(ball.part.0) == the_arm)
        .collect();
    model
}
