//! Joint angles over the gait cycle.

use std::f64::consts::TAU;

/// A periodic angle, as a Fourier series of low order.
///
/// θ(φ) = c + Σₙ aₙ cos 2πnφ + bₙ sin 2πnφ, radians; φ = 0 at the foot strike of the curve's own side, 1 at the next.
#[derive(Debug, Clone, PartialEq)]
pub struct Curve {
    /// c.
    pub mean: f64,
    /// (aₙ, bₙ) from n = 1.
    pub harmonics: Vec<(f64, f64)>,
}

impl Curve {
    fn from_degrees(mean_deg: f64, harmonics_deg: &[(f64, f64)]) -> Self {
        let radians = |&(a, b): &(f64, f64)| (a.to_radians(), b.to_radians());
        Self { mean: mean_deg.to_radians(), harmonics: harmonics_deg.iter().map(radians).collect() }
    }

    /// θ(φ).
    pub fn at(&self, phase: f64) -> f64 {
        let term = |(n, (a, b)): (usize, &(f64, f64))| {
            let (sin, cos) = (TAU * (n + 1) as f64 * phase).sin_cos();
            a * cos + b * sin
        };
        self.mean + self.harmonics.iter().enumerate().map(term).sum::<f64>()
    }

    /// θ'(φ) = gain·θ(φ) + offset.
    #[must_use]
    pub(super) fn varied(&self, gain: f64, offset: f64) -> Self {
        let scale = |&(a, b): &(f64, f64)| (gain * a, gain * b);
        Self {
            mean: gain * self.mean + offset,
            harmonics: self.harmonics.iter().map(scale).collect(),
        }
    }

    /// The same about its mean by `gain` times as much.
    #[must_use]
    pub(super) fn swung(&self, gain: f64) -> Self {
        Self { mean: self.mean, ..self.varied(gain, 0.0) }
    }

    /// θ'(φ) = θ(φ + advance).
    #[must_use]
    pub(super) fn advanced(&self, advance: f64) -> Self {
        let turn = |(n, &(a, b)): (usize, &(f64, f64))| {
            let (sin, cos) = (TAU * (n + 1) as f64 * advance).sin_cos();
            (a * cos + b * sin, b * cos - a * sin)
        };
        Self { mean: self.mean, harmonics: self.harmonics.iter().enumerate().map(turn).collect() }
    }
}

/// The sides of the body that a normative curve is of.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Sides {
    /// Joint `name_r`, and `name_l` half a cycle later.
    BothSides,
    /// Joint `name`, in the cycle of the right foot.
    Middle,
}

/// How a curve differs between persons.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum Variation {
    /// With the length of the stride and the bend of the legs, so that soles stay level: degrees per degree of bend.
    Legs(f64),
    /// By itself: standard deviation of its offset, degrees.
    Own(f64),
}

/// A joint's mean angle of healthy adults at their own speed, degrees.
pub(super) struct NormativeCurve {
    /// Joint, without its side.
    pub(super) joint: &'static str,
    pub(super) sides: Sides,
    pub(super) variation: Variation,
    mean_deg: f64,
    harmonics_deg: &'static [(f64, f64)],
}

impl NormativeCurve {
    pub(super) fn curve(&self) -> Curve {
        Curve::from_degrees(self.mean_deg, self.harmonics_deg)
    }
}

type Harmonics = &'static [(f64, f64)];

const fn sides(
    joint: &'static str,
    variation: Variation,
    mean_deg: f64,
    harmonics_deg: Harmonics,
) -> NormativeCurve {
    NormativeCurve { joint, sides: Sides::BothSides, variation, mean_deg, harmonics_deg }
}

const fn middle(
    joint: &'static str,
    variation: Variation,
    harmonics_deg: Harmonics,
) -> NormativeCurve {
    NormativeCurve { joint, sides: Sides::Middle, variation, mean_deg: 0.0, harmonics_deg }
}

const LEGS: Variation = Variation::Legs(0.0);

/// Tilt forwards, right side up, right side forwards: not joints, but turns of the root.
pub(super) const PELVIS: [NormativeCurve; 3] = [
    middle("pelvis_tilt", Variation::Own(2.0), &[(0.0, 0.0), (0.1, -1.0)]),
    middle("pelvis_obliquity", LEGS, &[(1.73, 3.12), (0.0, 0.0), (-0.73, 0.65)]),
    middle("pelvis_rotation", LEGS, &[(4.5, 0.0)]),
];

/// The joints. Those of a model that are not here stay at rest.
///
/// Legs: series fitted to the key values of published mean curves (hip 22° at foot strike to −19° at 54 %, measured to
/// the vertical and so without the pelvis' standing tilt; knee 18° at 14 %, 62° at 72 %; ankle −5° at 8 %, 12° at 44 %,
/// −16° at 63 %; hip adduction 7° at 15 %). **Differs**: hip, knee and ankle were then moved, by 1–1.5° RMS, until the
/// standing foot of a body of mean proportions neither slides nor lifts, which mean curves of many persons do not give.
/// Hip rotation undoes the pelvis', so that the foot keeps its heading, 5° outwards.
/// Trunk: turns against the pelvis and leans against its obliquity, so that shoulders and head stay nearly level.
/// Arms: 32° of swing against the leg of their side.
///
/// # Source
/// Perry & Burnfield, *Gait Analysis*, 2nd ed. 2010, ch. 3–8; Winter, *Biomechanics and Motor Control of Human
/// Movement*, 4th ed. 2009, ch. 3; Kadaba et al. 1990 (pelvis, frontal plane, spreads); Crosbie et al. 1997 (trunk);
/// Murray et al. 1967 (arms).
pub(super) const JOINTS: [NormativeCurve; 14] = [
    sides(
        "hip_flexion",
        Variation::Legs(0.5),
        5.68,
        &[
            (21.05, -3.28),
            (-3.94, -2.61),
            (-0.84, 0.63),
            (-0.8, 0.19),
            (-0.04, 0.25),
            (0.24, -0.09),
        ],
    ),
    sides(
        "hip_abduction",
        Variation::Own(1.0),
        -1.74,
        &[(-0.83, -5.03), (-0.04, 0.49), (1.15, -0.75), (-0.06, -0.18)],
    ),
    sides("hip_rotation", LEGS, -5.0, &[(-4.5, 0.0)]),
    sides(
        "knee_flexion",
        Variation::Legs(1.0),
        22.59,
        &[(-2.24, -19.36), (-14.75, 6.8), (-0.42, 6.05), (0.41, 0.49), (0.14, 0.04), (0.46, -0.13)],
    ),
    sides(
        "ankle_dorsiflexion",
        Variation::Legs(0.5),
        1.35,
        &[(-1.66, 5.42), (1.63, -6.62), (-4.38, 0.55), (1.61, 0.13), (0.83, -1.06), (-0.03, -0.1)],
    ),
    middle("lumbar_flexion", Variation::Own(2.0), &[]),
    middle("lumbar_bending", Variation::Own(0.5), &[(1.0, 1.8), (0.0, 0.0), (-0.4, 0.4)]),
    middle("lumbar_rotation", Variation::Own(0.7), &[(-3.5, 0.0)]),
    middle("thorax_bending", Variation::Own(0.5), &[(0.5, 1.0), (0.0, 0.0), (-0.2, 0.2)]),
    middle("thorax_rotation", Variation::Own(0.7), &[(-4.5, 0.0)]),
    middle("neck_rotation", Variation::Own(1.0), &[(3.5, 0.0)]),
    sides("shoulder_flexion", Variation::Own(3.0), -6.0, &[(-16.0, 2.0)]),
    sides("shoulder_abduction", Variation::Own(2.0), 9.0, &[]),
    sides("elbow_flexion", Variation::Own(5.0), 28.0, &[(-9.0, 2.0)]),
];

#[cfg(test)]
mod tests {
    use super::*;

    /// The greatest value of `sign` · angle in degrees, and its percentage of the cycle.
    fn extreme(joint: &str, sign: f64) -> (f64, f64) {
        let curve = JOINTS.iter().find(|n| n.joint == joint).unwrap().curve();
        let angle = |i: u32| sign * curve.at(f64::from(i) / 1000.0).to_degrees();
        let best = (0..1000).max_by(|&a, &b| angle(a).total_cmp(&angle(b))).unwrap();
        (angle(best), f64::from(best) / 10.0)
    }

    #[test]
    fn the_knee_bends_sixty_degrees_in_swing() {
        let (angle_deg, percent) = extreme("knee_flexion", 1.0);
        assert!((60.0..65.0).contains(&angle_deg) && (70.0..74.0).contains(&percent));
    }

    #[test]
    fn the_ankle_dorsiflexes_late_in_stance_and_pushes_off_at_toe_off() {
        let (angle_deg, percent) = extreme("ankle_dorsiflexion", 1.0);
        assert!((10.0..13.0).contains(&angle_deg) && (42.0..48.0).contains(&percent));
        let (angle_deg, percent) = extreme("ankle_dorsiflexion", -1.0);
        assert!((14.0..20.0).contains(&angle_deg) && (61.0..68.0).contains(&percent));
    }

    #[test]
    fn the_sole_is_level_in_mid_stance() {
        let curve = |joint: &str| JOINTS.iter().find(|n| n.joint == joint).unwrap().curve();
        let (hip, knee, ankle) =
            (curve("hip_flexion"), curve("knee_flexion"), curve("ankle_dorsiflexion"));
        for percent in 8..25 {
            let phase = f64::from(percent) / 100.0;
            let pitch = hip.at(phase) - knee.at(phase) + ankle.at(phase);
            assert!(pitch.to_degrees().abs() < 2.5, "{percent} %: {pitch}");
        }
    }

    #[test]
    fn an_advanced_curve_is_the_curve_a_little_later() {
        let curve = JOINTS[0].curve();
        let advanced = curve.advanced(0.13);
        for phase in [0.0, 0.2, 0.7] {
            approx::assert_relative_eq!(
                advanced.at(phase),
                curve.at(phase + 0.13),
                epsilon = 1e-12
            );
        }
    }
}
