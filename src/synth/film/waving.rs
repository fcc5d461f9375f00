//! A person who walks on the spot, as on a belt, and waves.

use std::f64::consts::TAU;

use nalgebra::{Rotation3, Vector3};
use rand::{Rng, RngExt};

use super::Staging;
use crate::body::{BodyModel, Motion};

/// How the arms wave, and how the body turns and wanders on the belt.
#[derive(Debug, Clone)]
pub(super) struct Waving {
    arms: [Arm; 2],
    /// How far a lifted arm is lifted, 0 to 1.
    raised: f64,
    /// Direction in which the belt runs, from the world's x axis.
    pub(super) heading: f64,
    /// Greatest turn away from the heading, radians, and turns to and fro in a second.
    turn: [f64; 2],
    /// Greatest distance from the middle of the belt along x and y, metres, and ways to and fro along y in a second.
    wander: [f64; 3],
}

/// One arm is lifted, waves, and is lowered again.
#[derive(Debug, Clone)]
struct Arm {
    /// Lifts in a second, and their phase at the start.
    lifts: [f64; 2],
    /// Waves in a second.
    hertz: f64,
    joints: [Reach; 4],
}

/// The angle about which a lifted arm's joint waves, and how far, radians.
#[derive(Debug, Clone)]
struct Reach {
    joint: &'static str,
    middle: f64,
    swing: f64,
}

/// Middle and swing of a lifted arm's joints, degrees: (least, most) of each.
const LIFTED_DEG: [(&str, [f64; 2], [f64; 2]); 4] = [
    ("shoulder_flexion", [45.0, 95.0], [10.0, 25.0]),
    ("shoulder_abduction", [20.0, 55.0], [5.0, 20.0]),
    ("shoulder_rotation", [-10.0, 10.0], [5.0, 15.0]),
    ("elbow_flexion", [50.0, 85.0], [20.0, 32.0]),
];

impl Waving {
    /// Arms that wave in turns and together.
    pub(super) fn random(rng: &mut impl Rng) -> Self {
        let begin = rng.random_range(0.0..1.0);
        Self {
            arms: [0.0, 0.4].map(|later| Arm::random(begin + later, rng)),
            raised: 1.0,
            heading: rng.random_range(-0.7..0.7),
            turn: [rng.random_range(0.2..0.4), rng.random_range(0.06..0.12)],
            wander: [
                rng.random_range(0.05..0.12),
                rng.random_range(0.35..0.45),
                rng.random_range(0.085..0.12),
            ],
        }
    }

    /// The same with as much of it as is staged, and turned further.
    pub(super) fn staged(mut self, staging: &Staging) -> Self {
        self.raised = staging.waving;
        self.heading += staging.turned;
        self.wander[0] *= staging.waving;
        self.wander[1] *= staging.waving;
        self
    }

    /// Takes a straight walk along x onto the belt; returns how far the belt has run in each frame, metres.
    ///
    /// The belt runs at the mean speed of the walk, so the feet stand still on it.
    pub(super) fn apply(&self, model: &BodyModel, motions: &mut [Motion], fps: f64) -> Vec<f64> {
        let speed = match motions {
            [first, .., last] => {
                let way = last.position_world.x - first.position_world.x;
                way * fps / (motions.len() - 1) as f64
            }
            _ => 0.0,
        };

        let start = motions.first().map_or(0.0, |m| m.position_world.x);
        let mut travelled = Vec::new();
        for (frame, motion) in motions.iter_mut().enumerate() {
            let time = frame as f64 / fps;
            motion.position_world.x -= start + speed * time;
            self.turn_and_wander(motion, time);
            for (side, arm) in ["r", "l"].into_iter().zip(&self.arms) {
                arm.wave(model, motion, side, self.raised, time);
            }
            travelled.push(speed * time);
        }
        travelled
    }

    fn turn_and_wander(&self, motion: &mut Motion, time: f64) {
        let [most, hertz] = self.turn;
        let angle = self.heading + most * (TAU * hertz * time).sin();
        let turn = Rotation3::from_axis_angle(&Vector3::z_axis(), angle);
        motion.world_from_root = turn * motion.world_from_root;
        let [x, y, hertz] = self.wander;
        let wander =
            Vector3::new(x * (TAU * 0.11 * time).sin(), y * (TAU * hertz * time).sin(), 0.0);
        motion.position_world = turn * motion.position_world + wander;
    }
}

impl Arm {
    fn random(begin: f64, rng: &mut impl Rng) -> Self {
        let mut within = |[least, most]: [f64; 2]| rng.random_range(least..most);
        Self {
            lifts: [within([0.15, 0.22]), begin],
            hertz: within([0.5, 0.8]),
            joints: LIFTED_DEG.map(|(joint, middle, swing)| Reach {
                joint,
                middle: within(middle).to_radians(),
                swing: within(swing).to_radians(),
            }),
        }
    }

    /// Blends the walk's swing into the wave as the arm is lifted.
    fn wave(&self, model: &BodyModel, motion: &mut Motion, side: &str, most: f64, time: f64) {
        let [hertz, begin] = self.lifts;
        let raised = (0.5 + 0.9 * (TAU * (hertz * time + begin)).sin()).clamp(0.0, 1.0);
        let lifted = most * raised * raised * (3.0 - 2.0 * raised);
        for (k, reach) in self.joints.iter().enumerate() {
            let Some(joint) = model.joint(&format!("{}_{side}", reach.joint)) else {
                continue;
            };
            let (low, high) = model.joints[joint.0].limits;
            let wave = reach.middle + reach.swing * (TAU * self.hertz * time + k as f64).sin();
            let angle = &mut motion.angles[joint.0];
            *angle = (*angle * (1.0 - lifted) + wave * lifted).clamp(low, high);
        }
    }
}
