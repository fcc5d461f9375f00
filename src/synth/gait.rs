//! One person's way of walking.

use std::collections::BTreeMap;

use rand::Rng;
use rand_distr::{Distribution, StandardNormal};

use super::curves::{Curve, JOINTS, Normative, PELVIS, Place};

/// Angles over the gait cycle, and how many cycles there are in a second.
#[derive(Debug, Clone, PartialEq)]
pub struct Gait {
    /// Strides (pairs of steps) per second.
    pub stride_hz: f64,
    /// Tilt forwards, right side up, right side forwards, in the cycle of the right foot.
    pub pelvis: [Curve; 3],
    /// By joint name; every curve in the cycle of the right foot.
    pub joints: BTreeMap<String, Curve>,
}

/// Mean strides per second: 113 steps a minute (Perry & Burnfield 2010, ch. 24, adults at their own speed).
const STRIDE_HZ: f64 = 0.94;
/// Standard deviation between persons, relative (Winter 1991: 5–6 %).
const STRIDE_SD: f64 = 0.055;
/// Standard deviation of a curve's amplitude between persons, relative.
const GAIN_SD: f64 = 0.08;
/// Standard deviation of a curve's timing between persons, in cycles.
const ADVANCE_SD: f64 = 0.008;
/// Left against right of one person, as a fraction of the difference between persons.
const ASYMMETRY: f64 = 0.3;

/// How one curve departs from the norm, in standard deviations.
#[derive(Clone, Copy)]
struct Departure {
    gain: f64,
    offset: f64,
    advance: f64,
}

impl Departure {
    const NONE: Self = Self {
        gain: 0.0,
        offset: 0.0,
        advance: 0.0,
    };

    fn draw(rng: &mut impl Rng) -> Self {
        Self {
            gain: bounded_normal(rng),
            offset: bounded_normal(rng),
            advance: bounded_normal(rng),
        }
    }

    fn plus(self, factor: f64, other: Self) -> Self {
        Self {
            gain: self.gain + factor * other.gain,
            offset: self.offset + factor * other.offset,
            advance: self.advance + factor * other.advance,
        }
    }

    fn apply(self, normative: &Normative) -> Curve {
        let offset = self.offset * normative.sd_deg.to_radians();
        let varied = normative.curve().varied(1.0 + GAIN_SD * self.gain, offset);
        varied.advanced(ADVANCE_SD * self.advance)
    }
}

/// A standard normal number, drawn again beyond ±2.
fn bounded_normal(rng: &mut impl Rng) -> f64 {
    loop {
        let z: f64 = StandardNormal.sample(rng);
        if z.abs() < 2.0 {
            return z;
        }
    }
}

impl Gait {
    /// The mean of healthy adults.
    pub fn normative() -> Self {
        Self::departing(STRIDE_HZ, || Departure::NONE)
    }

    /// A healthy person's: gains, offsets and timing of every curve, and the cadence, drawn about the mean.
    pub fn personal(rng: &mut impl Rng) -> Self {
        let stride_hz = STRIDE_HZ * (1.0 + STRIDE_SD * bounded_normal(rng));
        Self::departing(stride_hz, || Departure::draw(rng))
    }

    fn departing(stride_hz: f64, mut draw: impl FnMut() -> Departure) -> Self {
        let pelvis = PELVIS.each_ref().map(|n| draw().apply(n));
        let mut joints = BTreeMap::new();
        for normative in &JOINTS {
            let person = draw();
            match normative.place {
                Place::Middle => {
                    joints.insert(normative.joint.to_owned(), person.apply(normative));
                }
                Place::BothSides => {
                    for (side, half_cycle) in [("r", 0.0), ("l", 0.5)] {
                        let curve = person.plus(ASYMMETRY, draw()).apply(normative);
                        let name = format!("{}_{side}", normative.joint);
                        joints.insert(name, curve.advanced(half_cycle));
                    }
                }
            }
        }
        Self {
            stride_hz,
            pelvis,
            joints,
        }
    }
}

#[cfg(test)]
mod tests {
    use rand::SeedableRng;
    use rand_chacha::ChaCha8Rng;

    use super::*;

    #[test]
    fn the_left_leg_does_what_the_right_does_half_a_cycle_later() {
        let gait = Gait::normative();
        for phase in [0.0, 0.3, 0.9] {
            let (right, left) = (
                &gait.joints["knee_flexion_r"],
                &gait.joints["knee_flexion_l"],
            );
            approx::assert_relative_eq!(left.at(phase + 0.5), right.at(phase), epsilon = 1e-12);
        }
    }

    #[test]
    fn one_seed_is_one_person_and_another_seed_another() {
        let person = |seed| Gait::personal(&mut ChaCha8Rng::seed_from_u64(seed));
        assert_eq!(person(1), person(1));
        assert_ne!(person(1), person(2));
    }
}
