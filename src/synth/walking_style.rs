//! One person's way of walking.

use std::collections::BTreeMap;

use rand::Rng;
use rand_distr::{Distribution, StandardNormal};

use super::curves::{Curve, JOINTS, NormativeCurve, PELVIS, Sides, Variation};

/// Angles over the gait cycle, and how many cycles there are in a second.
#[derive(Debug, Clone, PartialEq)]
pub struct WalkingStyle {
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
/// Standard deviation of the legs' common amplitude, and so of the step length, relative (Öberg et al. 1993: 6–8 %).
const STEP_SD: f64 = 0.06;
/// Standard deviation of the bend of the knees, degrees (Kadaba et al. 1990: about 5° with marker placement).
const BEND_SD_DEG: f64 = 2.5;
/// Standard deviation of the amplitude of trunk and arms, relative.
const SWING_SD: f64 = 0.15;
/// Standard deviation of the timing of trunk and arms, in cycles.
const ADVANCE_SD: f64 = 0.015;
/// Standard deviation that is left to each single curve, and to left against right, degrees.
const SINGLE_SD_DEG: f64 = 0.4;

/// Standard deviation of cadence and amplitude from trial to trial, relative.
const TRIAL_SD: f64 = 0.02;

/// What all curves of a person have in common.
#[derive(Clone, Copy)]
struct Person {
    step_gain: f64,
    bend_deg: f64,
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

impl WalkingStyle {
    /// The mean of healthy adults.
    pub fn normative() -> Self {
        Self::departing(&mut || 0.0)
    }

    /// A healthy person's: cadence, step length, bend of the knees, swing and timing, drawn about the mean.
    pub fn personal(rng: &mut impl Rng) -> Self {
        Self::departing(&mut || bounded_normal(rng))
    }

    /// Somebody who stands still: every joint at rest.
    pub fn standing() -> Self {
        let still = || Curve { mean: 0.0, harmonics: Vec::new() };
        let pelvis = [still(), still(), still()];
        Self { stride_hz: STRIDE_HZ, pelvis, joints: BTreeMap::new() }
    }

    /// The same person on another trial: cadence and the amplitude of all movements differ by 2 % (E; healthy adults vary by 1 to 3 %
    /// from trial to trial).
    #[must_use]
    pub fn again(&self, rng: &mut impl Rng) -> Self {
        let mut draw = || 1.0 + TRIAL_SD * bounded_normal(rng);
        let (faster, larger) = (draw(), draw());
        let joints = self.joints.iter();
        Self {
            stride_hz: self.stride_hz * faster,
            pelvis: self.pelvis.each_ref().map(|curve| curve.swung(larger)),
            joints: joints.map(|(name, curve)| (name.clone(), curve.swung(larger))).collect(),
        }
    }

    /// A style that departs from the mean by as many standard deviations as `draw` says.
    fn departing(draw: &mut impl FnMut() -> f64) -> Self {
        let stride_hz = STRIDE_HZ * (1.0 + STRIDE_SD * draw());
        let person = Person { step_gain: 1.0 + STEP_SD * draw(), bend_deg: BEND_SD_DEG * draw() };

        let pelvis = PELVIS.each_ref().map(|n| depart(n, person, draw));

        // every joint of the middle once, every joint of the sides with a little of its own
        let mut joints = BTreeMap::new();
        for normative in &JOINTS {
            let name = normative.joint;
            let curve = depart(normative, person, draw);
            if normative.sides == Sides::Middle {
                joints.insert(name.to_owned(), curve);
                continue;
            }
            for (side, half_cycle) in [("r", 0.0), ("l", 0.5)] {
                let own = curve.varied(1.0, (SINGLE_SD_DEG * draw()).to_radians());
                joints.insert(format!("{name}_{side}"), own.advanced(half_cycle));
            }
        }
        Self { stride_hz, pelvis, joints }
    }
}

/// The curve of one person.
fn depart(normative: &NormativeCurve, person: Person, draw: &mut impl FnMut() -> f64) -> Curve {
    let curve = normative.curve();
    match normative.variation {
        Variation::Legs(bend) => {
            let offset_deg = bend * person.bend_deg + SINGLE_SD_DEG * draw();
            curve.varied(person.step_gain, offset_deg.to_radians())
        }
        Variation::Own(sd_deg) => {
            let (gain, offset_deg) = (1.0 + SWING_SD * draw(), sd_deg * draw());
            let varied = curve.varied(gain, offset_deg.to_radians());
            varied.advanced(ADVANCE_SD * draw())
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
        let style = WalkingStyle::normative();
        for phase in [0.0, 0.3, 0.9] {
            let (right, left) = (&style.joints["knee_flexion_r"], &style.joints["knee_flexion_l"]);
            approx::assert_relative_eq!(left.at(phase + 0.5), right.at(phase), epsilon = 1e-12);
        }
    }

    #[test]
    fn another_trial_is_nearly_the_same_walk() {
        let style = WalkingStyle::personal(&mut ChaCha8Rng::seed_from_u64(1));
        let again = style.again(&mut ChaCha8Rng::seed_from_u64(2));
        let faster = again.stride_hz / style.stride_hz;
        assert!((1e-6..0.04).contains(&f64::abs(faster - 1.0)), "{faster}");
        let knee = |style: &WalkingStyle| style.joints["knee_flexion_r"].clone();
        assert_ne!(knee(&again), knee(&style));
        approx::assert_relative_eq!(knee(&again).mean, knee(&style).mean, epsilon = 1e-12);
    }

    #[test]
    fn one_seed_is_one_person_and_another_seed_another() {
        let person = |seed| WalkingStyle::personal(&mut ChaCha8Rng::seed_from_u64(seed));
        assert_eq!(person(1), person(1));
        assert_ne!(person(1), person(2));
    }
}
