//! Under what conditions arms are fitted.

use experiments::held::{CAMERAS, Holding, RightArm};
use maquette::solver::Loss;

/// A recording, and how it is fitted.
#[derive(Debug)]
pub(crate) struct Condition {
    /// As it stands in the names of numbers.
    pub(crate) name: &'static str,
    /// As it stands in tables.
    pub(crate) title: &'static str,
    pub(crate) holding: Holding,
    /// Loss of all likelihoods.
    pub(crate) loss: Loss,
    /// Recordings, of persons and noise that other seeds draw.
    pub(crate) recordings: u64,
}

/// Both arms beside the trunk, four low cameras, 100 frames.
const USUAL: Holding = Holding {
    frames: 100,
    cameras: CAMERAS,
    height_m: 1.0,
    spread_deg: 0.0,
    right: RightArm::Side,
    elbow_deg: 20.0,
    raggedness: 1.0,
};

const fn condition(name: &'static str, title: &'static str, holding: Holding) -> Condition {
    Condition { name, title, holding, loss: Loss::Cauchy(3.0), recordings: 1 }
}

/// The same before two cameras.
const TWO: Holding = Holding { cameras: 2, ..USUAL };

pub(crate) const CONDITIONS: [Condition; 15] = [
    condition("usual", "4 cameras, 1 m high, elbow 20°", USUAL),
    condition("two", "2 cameras", TWO),
    condition("two_bent", "2 cameras, elbow 40°", Holding { elbow_deg: 40.0, ..TWO }),
    condition("three", "3 cameras", Holding { cameras: 3, ..USUAL }),
    condition("seven", "7 cameras, 2.2 m high", Holding { cameras: 7, height_m: 2.2, ..USUAL }),
    condition("straighter", "elbow 12°", Holding { elbow_deg: 12.0, ..USUAL }),
    condition("bent", "elbow 40°", Holding { elbow_deg: 40.0, ..USUAL }),
    condition("closer", "arms 3° closer", Holding { spread_deg: -3.0, ..USUAL }),
    condition("farther", "arms 8° farther off", Holding { spread_deg: 8.0, ..USUAL }),
    condition("belly", "a forearm on the belly", Holding { right: RightArm::Belly, ..USUAL }),
    Condition {
        name: "three_belly",
        title: "3 cameras, a forearm on the belly",
        holding: Holding { cameras: 3, right: RightArm::Belly, ..USUAL },
        loss: Loss::Cauchy(3.0),
        recordings: 6,
    },
    condition("clean", "true masks", Holding { raggedness: 0.0, ..USUAL }),
    condition("ragged", "borders three times as ragged", Holding { raggedness: 3.0, ..USUAL }),
    Condition {
        name: "squared",
        title: "squared loss",
        holding: USUAL,
        loss: Loss::Squared,
        recordings: 1,
    },
    Condition {
        name: "two_squared",
        title: "2 cameras, squared loss",
        holding: TWO,
        loss: Loss::Squared,
        recordings: 1,
    },
];
