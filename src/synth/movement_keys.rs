//! The key poses of each movement (E).
//!
//! A thigh hangs hip flexion less the pelvis' tilt ahead of the vertical, a shank the knee's flexion behind it: where a foot is to stand flat, its
//! dorsiflexion is tilt − hip + knee.

use super::Movement;
use crate::body::Side;

/// A pose at a time.
#[derive(Debug, Clone, Copy)]
pub(super) struct Key {
    pub(super) at_s: f64,
    /// The pelvis' turns: tilt forwards, lean to the right, heading to the left.
    pub(super) pelvis_deg: [f64; 3],
    /// By joint; a name without its side is of both. All others are at rest.
    pub(super) angles_deg: &'static [(&'static str, f64)],
    /// The side of the body that the names on the right are of.
    pub(super) right_is: Side,
}

/// What stays where it is on the floor.
#[derive(Debug, Clone, Copy)]
pub(super) enum Support {
    Feet,
    LeftFoot,
    Pelvis,
}

/// A movement: the last pose is the first again.
#[derive(Debug, Clone, Copy)]
pub(super) struct Keys {
    pub(super) keys: &'static [Key],
    pub(super) support: Support,
    pub(super) rise: Rise,
}

/// How the body leaves the floor.
#[derive(Debug, Clone, Copy)]
pub(super) enum Rise {
    /// Its lowest place is on it.
    Never,
    /// It flies from one time to another.
    Flies { from_s: f64, to_s: f64 },
    /// It goes up and down as a cosine, twice a period, and is lowest at a time.
    Bounces { by_m: f64, lowest_at_s: f64 },
}

impl Key {
    /// The angle of a joint; `None` where it is at rest.
    pub(super) fn angle_deg(&self, joint: &str) -> Option<f64> {
        let named = |name: &str| {
            self.angles_deg.iter().find(|(own, _)| *own == name).map(|(_, angle)| *angle)
        };
        let Some((both, side)) =
            joint.rsplit_once('_').filter(|(_, side)| ["r", "l"].contains(side))
        else {
            return named(joint);
        };
        let is_right = (side == "r") == (self.right_is == Side::Right);
        named(&format!("{both}_{}", if is_right { "r" } else { "l" })).or_else(|| named(both))
    }
}

const fn key(at_s: f64, pelvis_deg: [f64; 3], angles_deg: &'static [(&'static str, f64)]) -> Key {
    Key { at_s, pelvis_deg, angles_deg, right_is: Side::Right }
}

/// The limbs of the other side.
const fn mirrored(key: Key) -> Key {
    Key { right_is: Side::Left, ..key }
}

/// A pose of an upright pelvis.
const fn upright(at_s: f64, angles_deg: &'static [(&'static str, f64)]) -> Key {
    key(at_s, [0.0; 3], angles_deg)
}

const SQUATTING: &[(&str, f64)] = &[
    ("hip_flexion", 110.0),
    ("hip_abduction", 15.0),
    ("knee_flexion", 110.0),
    ("ankle_dorsiflexion", 30.0),
    ("lumbar_flexion", 15.0),
    ("shoulder_flexion", 80.0),
];
const HIPS_HELD: &[(&str, f64)] = &[
    ("shoulder_abduction", 45.0),
    ("shoulder_flexion", -15.0),
    ("shoulder_rotation", 70.0),
    ("elbow_flexion", 95.0),
];
const CROSSED: &[(&str, f64)] = &[
    ("shoulder_flexion_r", 38.0),
    ("shoulder_flexion_l", 28.0),
    ("shoulder_rotation", 65.0),
    ("elbow_flexion", 95.0),
];
/// The right foot comes to the floor, and later drives the body on.
const STRIKE: &[(&str, f64)] = &[
    ("hip_flexion_r", 35.0),
    ("knee_flexion_r", 20.0),
    ("ankle_dorsiflexion_r", 5.0),
    ("hip_flexion_l", -5.0),
    ("knee_flexion_l", 75.0),
    ("ankle_dorsiflexion_l", -10.0),
    ("elbow_flexion", 90.0),
    ("shoulder_flexion_r", -35.0),
    ("shoulder_flexion_l", 30.0),
];
const DRIVE: &[(&str, f64)] = &[
    ("hip_flexion_r", -8.0),
    ("knee_flexion_r", 35.0),
    ("ankle_dorsiflexion_r", 10.0),
    ("hip_flexion_l", 45.0),
    ("knee_flexion_l", 95.0),
    ("elbow_flexion", 90.0),
];
const CROUCHED: &[(&str, f64)] = &[
    ("hip_flexion", 70.0),
    ("knee_flexion", 75.0),
    ("ankle_dorsiflexion", 30.0),
    ("shoulder_flexion", -30.0),
];
const STRETCHED: &[(&str, f64)] =
    &[("ankle_dorsiflexion", -30.0), ("shoulder_flexion", 150.0), ("knee_flexion", 0.0)];
const ARMS_ASIDE: &[(&str, f64)] = &[("shoulder_abduction", 90.0), ("elbow_flexion", 3.0)];
const CRAWL: &[(&str, f64)] = &[
    ("hip_flexion_r", 105.0),
    ("hip_flexion_l", 80.0),
    ("knee_flexion", 90.0),
    ("ankle_dorsiflexion", -45.0),
    ("shoulder_flexion_r", 78.0),
    ("shoulder_flexion_l", 98.0),
    ("elbow_flexion", 8.0),
    ("neck_flexion", -25.0),
];
const LYING: &[(&str, f64)] = &[("shoulder_abduction", 25.0), ("neck_flexion", 5.0)];

const SQUAT: [Key; 3] =
    [upright(0.0, &[]), key(0.9, [30.0, 0.0, 0.0], SQUATTING), upright(1.8, &[])];
const JACKS: [Key; 3] = [
    upright(0.0, &[]),
    upright(0.5, &[("shoulder_abduction", 150.0), ("hip_abduction", 25.0)]),
    upright(1.0, &[]),
];
const HANDS_ON_HIPS: [Key; 3] = [
    key(0.0, [0.0, 0.0, -8.0], HIPS_HELD),
    key(0.8, [5.0, 2.0, 8.0], HIPS_HELD),
    key(1.6, [0.0, 0.0, -8.0], HIPS_HELD),
];
const ARMS_CROSSED: [Key; 3] = [
    key(0.0, [0.0, 0.0, -8.0], CROSSED),
    key(0.8, [5.0, 2.0, 8.0], CROSSED),
    key(1.6, [0.0, 0.0, -8.0], CROSSED),
];
const KICK: [Key; 4] = [
    upright(0.0, &[("hip_flexion_r", -20.0), ("knee_flexion_r", 70.0)]),
    key(
        0.4,
        [-8.0, 0.0, 10.0],
        &[("hip_flexion_r", 75.0), ("knee_flexion_r", 10.0), ("shoulder_flexion_l", 50.0)],
    ),
    upright(0.9, &[]),
    upright(1.5, &[("hip_flexion_r", -20.0), ("knee_flexion_r", 70.0)]),
];
const PICK_UP: [Key; 3] = [
    upright(0.0, &[]),
    key(
        0.9,
        [60.0, 0.0, 0.0],
        &[
            ("hip_flexion", 90.0),
            ("knee_flexion", 40.0),
            ("ankle_dorsiflexion", 10.0),
            ("lumbar_flexion", 35.0),
            ("thorax_flexion", 15.0),
            ("shoulder_flexion", 95.0),
        ],
    ),
    upright(1.8, &[]),
];
const LUNGE: [Key; 3] = [
    upright(0.0, &[]),
    key(
        0.8,
        [5.0, 0.0, 0.0],
        &[
            ("hip_flexion_r", 80.0),
            ("knee_flexion_r", 85.0),
            ("ankle_dorsiflexion_r", 10.0),
            ("hip_flexion_l", -20.0),
            ("knee_flexion_l", 35.0),
            ("ankle_dorsiflexion_l", 25.0),
        ],
    ),
    upright(1.6, &[]),
];
const REACH: [Key; 3] = [
    upright(0.0, &[]),
    upright(
        0.8,
        &[("shoulder_flexion", 165.0), ("ankle_dorsiflexion", -25.0), ("neck_flexion", -25.0)],
    ),
    upright(1.6, &[]),
];
const RUN: [Key; 5] = [
    key(0.0, [10.0, 0.0, -8.0], STRIKE),
    key(0.175, [10.0, 0.0, 0.0], DRIVE),
    mirrored(key(0.35, [10.0, 0.0, 8.0], STRIKE)),
    mirrored(key(0.525, [10.0, 0.0, 0.0], DRIVE)),
    key(0.7, [10.0, 0.0, -8.0], STRIKE),
];
const STAND_UP: [Key; 4] = [
    key(
        0.0,
        [0.0, 0.0, 0.0],
        &[("hip_flexion", 85.0), ("knee_flexion", 95.0), ("ankle_dorsiflexion", 10.0)],
    ),
    key(
        0.5,
        [35.0, 0.0, 0.0],
        &[("hip_flexion", 115.0), ("knee_flexion", 100.0), ("ankle_dorsiflexion", 20.0)],
    ),
    upright(1.2, &[]),
    key(
        2.2,
        [0.0, 0.0, 0.0],
        &[("hip_flexion", 85.0), ("knee_flexion", 95.0), ("ankle_dorsiflexion", 10.0)],
    ),
];
const T_POSE: [Key; 3] = [
    key(0.0, [0.0, 0.0, -6.0], ARMS_ASIDE),
    key(0.8, [0.0, 3.0, 6.0], ARMS_ASIDE),
    key(1.6, [0.0, 0.0, -6.0], ARMS_ASIDE),
];
const SPIN: [Key; 3] =
    [upright(0.0, &[]), key(1.5, [0.0, 0.0, 240.0], &[]), key(3.0, [0.0, 0.0, 0.0], &[])];
const JUMP: [Key; 6] = [
    upright(0.0, &[]),
    key(0.4, [25.0, 0.0, 0.0], CROUCHED),
    upright(0.65, STRETCHED),
    upright(1.1, STRETCHED),
    key(1.35, [25.0, 0.0, 0.0], CROUCHED),
    upright(1.9, &[]),
];
const THROW: [Key; 4] = [
    upright(0.0, &[]),
    key(
        0.6,
        [0.0, 0.0, -25.0],
        &[
            ("shoulder_abduction_r", 90.0),
            ("shoulder_rotation_r", -70.0),
            ("elbow_flexion_r", 100.0),
            ("thorax_rotation", -25.0),
        ],
    ),
    key(
        0.95,
        [10.0, 0.0, 25.0],
        &[
            ("shoulder_flexion_r", 70.0),
            ("shoulder_abduction_r", 20.0),
            ("thorax_rotation", 25.0),
            ("lumbar_flexion", 20.0),
        ],
    ),
    upright(1.6, &[]),
];
const ALL_FOURS: [Key; 3] = [
    key(0.0, [90.0, 0.0, 0.0], CRAWL),
    mirrored(key(0.6, [90.0, 0.0, 0.0], CRAWL)),
    key(1.2, [90.0, 0.0, 0.0], CRAWL),
];
const LIE: [Key; 3] = [
    key(0.0, [-90.0, 0.0, 0.0], LYING),
    key(
        0.9,
        [-90.0, 0.0, 0.0],
        &[("shoulder_abduction", 25.0), ("hip_flexion_r", 60.0), ("knee_flexion_r", 100.0)],
    ),
    key(1.8, [-90.0, 0.0, 0.0], LYING),
];

impl Movement {
    pub(super) fn keys(self) -> Keys {
        let (keys, support): (&[Key], _) = match self {
            Self::Squat => (&SQUAT, Support::Feet),
            Self::Jacks => (&JACKS, Support::Feet),
            Self::HandsOnHips => (&HANDS_ON_HIPS, Support::Feet),
            Self::ArmsCrossed => (&ARMS_CROSSED, Support::Feet),
            Self::Kick => (&KICK, Support::LeftFoot),
            Self::PickUp => (&PICK_UP, Support::Feet),
            Self::Lunge => (&LUNGE, Support::LeftFoot),
            Self::Reach => (&REACH, Support::Feet),
            Self::Run => (&RUN, Support::Pelvis),
            Self::StandUp => (&STAND_UP, Support::Feet),
            Self::TPose => (&T_POSE, Support::Feet),
            Self::Spin => (&SPIN, Support::Feet),
            Self::Jump => (&JUMP, Support::Feet),
            Self::Throw => (&THROW, Support::LeftFoot),
            Self::AllFours => (&ALL_FOURS, Support::Pelvis),
            Self::Lie => (&LIE, Support::Pelvis),
        };
        let rise = match self {
            Self::Jump => Rise::Flies { from_s: 0.65, to_s: 1.1 },
            Self::Run => Rise::Bounces { by_m: 0.04, lowest_at_s: 0.09 },
            _ => Rise::Never,
        };
        Keys { keys, support, rise }
    }
}
