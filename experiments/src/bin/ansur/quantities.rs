//! The model's quantities, made of the survey's measures as docs/anthropometry.md (§§ 2–4, 6) defines them.

use super::survey::Person;

/// A length between joint centres or a dimension of a section.
pub(crate) struct Quantity {
    pub(crate) name: &'static str,
    /// Metres.
    pub(crate) of: Formula,
}

type Formula = fn(&Person) -> f64;

/// Height of the ankle's centre: the medial malleolus is higher than the lateral one by .006 of stature.
fn ankle(p: &Person) -> f64 {
    p.metres("lateralmalleolusheight") + 0.003 * p.metres("stature")
}

/// Height of the knee's centre, between the epicondyles.
fn knee(p: &Person) -> f64 {
    p.metres("lateralfemoralepicondyleheight")
}

/// Height of the hip's centre: .044 of stature above the crotch.
fn hip(p: &Person) -> f64 {
    p.metres("crotchheight") + 0.044 * p.metres("stature")
}

/// Height of C7/T1's centre: 35 mm below its skin.
fn neck_base(p: &Person) -> f64 {
    p.metres("cervicaleheight") - 0.035
}

/// Height of the skull base: 18 mm below the tragion.
fn skull_base(p: &Person) -> f64 {
    p.metres("stature") - p.metres("tragiontopofhead") - 0.018
}

/// Height of the shoulder's centre: 50 mm below the acromion's skin.
fn shoulder(p: &Person) -> f64 {
    p.metres("acromialheight") - 0.050
}

/// Shoulder to elbow: from 10.4 % below the acromion to 4.3 % above radiale.
fn upper_arm(p: &Person) -> f64 {
    (1.0 - 0.104 - 0.043) * p.metres("acromionradialelength")
}

/// Elbow to wrist: the wrist's centre is 4 mm beyond stylion.
fn forearm(p: &Person) -> f64 {
    p.metres("radialestylionlength") + 0.043 * p.metres("acromionradialelength") + 0.004
}

macro_rules! measured {
    ($($name:literal from $measure:literal),* $(,)?) => {
        [$(Quantity { name: $name, of: |p| p.metres($measure) }),*]
    };
}

/// All of them, in the order of every matrix here.
pub(crate) fn quantities() -> Vec<Quantity> {
    let lengths: [(&str, Formula); 9] = [
        ("ankle height", ankle),
        ("shank", |p| knee(p) - ankle(p)),
        (THIGH, |p| hip(p) - knee(p)),
        (TRUNK, |p| neck_base(p) - hip(p)),
        ("shoulder below C7/T1", |p| neck_base(p) - shoulder(p)),
        ("neck", |p| skull_base(p) - neck_base(p)),
        ("head", |p| p.metres("stature") - skull_base(p)),
        ("upper arm", upper_arm),
        ("forearm", forearm),
    ];
    let sections = measured![
        "hand length" from "handlength",
        "foot length" from "footlength",
        "biacromial breadth" from "biacromialbreadth",
        "hip breadth" from "hipbreadth",
        "buttock depth" from "buttockdepth",
        "waist breadth" from "waistbreadth",
        "waist depth" from "waistdepth",
        "chest breadth" from "chestbreadth",
        "chest depth" from "chestdepth",
        "neck girth" from "neckcircumference",
        "head breadth" from "headbreadth",
        "head length" from "headlength",
        "biceps girth" from "bicepscircumferenceflexed",
        "forearm girth" from "forearmcircumferenceflexed",
        "wrist girth" from "wristcircumference",
        "hand breadth" from "handbreadth",
        "thigh girth" from "thighcircumference",
        "lower thigh girth" from "lowerthighcircumference",
        "calf girth" from "calfcircumference",
        "ankle girth" from "anklecircumference",
        "foot breadth" from "footbreadthhorizontal",
        "heel breadth" from "heelbreadth",
    ];
    let lengths = lengths.map(|(name, of)| Quantity { name, of });
    lengths.into_iter().chain(sections).collect()
}

/// The two lengths that end at the hip.
pub(crate) const THIGH: &str = "thigh";
pub(crate) const TRUNK: &str = "trunk";

/// Buttock to knee, seated: holds the thigh and nothing of the crotch's height.
pub(crate) fn buttock_knee(p: &Person) -> f64 {
    p.metres("buttockkneelength")
}
