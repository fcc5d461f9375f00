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
        Self {
            mean: mean_deg.to_radians(),
            harmonics: harmonics_deg.iter().map(radians).collect(),
        }
    }

    /// θ(φ).
    pub fn at(&self, phase: f64) -> f64 {
        let term = |(n, (a, b)): (usize, &(f64, f64))| {
            let (sin, cos) = (TAU * (n + 1) as f64 * phase).sin_cos();
            a * cos + b * sin
        };
        self.mean + self.harmonics.iter().enumerate().map(term).sum::<f64>()
    }

    /// θ'(φ) = c + offset + gain·(θ(φ) − c).
    #[must_use]
    pub fn varied(&self, gain: f64, offset: f64) -> Self {
        let scale = |&(a, b): &(f64, f64)| (gain * a, gain * b);
        Self {
            mean: self.mean + offset,
            harmonics: self.harmonics.iter().map(scale).collect(),
        }
    }

    /// θ'(φ) = θ(φ + advance).
    #[must_use]
    pub fn advanced(&self, advance: f64) -> Self {
        let turn = |(n, &(a, b)): (usize, &(f64, f64))| {
            let (sin, cos) = (TAU * (n + 1) as f64 * advance).sin_cos();
            (a * cos + b * sin, b * cos - a * sin)
        };
        Self {
            mean: self.mean,
            harmonics: self.harmonics.iter().enumerate().map(turn).collect(),
        }
    }
}

/// Where a normative curve belongs.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Place {
    /// Joint `name_r`, and `name_l` half a cycle later.
    BothSides,
    /// Joint `name`, in the cycle of the right foot.
    Middle,
}

/// A joint's mean angle of healthy adults at their own speed, degrees.
pub(super) struct Normative {
    /// Joint, without its side.
    pub(super) joint: &'static str,
    pub(super) place: Place,
    /// Standard deviation of its mean between persons, degrees.
    pub(super) sd_deg: f64,
    mean_deg: f64,
    harmonics_deg: &'static [(f64, f64)],
}

impl Normative {
    pub(super) fn curve(&self) -> Curve {
        Curve::from_degrees(self.mean_deg, self.harmonics_deg)
    }
}

const fn sides(
    joint: &'static str,
    sd_deg: f64,
    mean_deg: f64,
    harmonics_deg: &'static [(f64, f64)],
) -> Normative {
    Normative {
        joint,
        place: Place::BothSides,
        sd_deg,
        mean_deg,
        harmonics_deg,
    }
}

const fn middle(
    joint: &'static str,
    sd_deg: f64,
    mean_deg: f64,
    harmonics_deg: &'static [(f64, f64)],
) -> Normative {
    Normative {
        joint,
        place: Place::Middle,
        sd_deg,
        mean_deg,
        harmonics_deg,
    }
}

/// Tilt forwards, right side up, right side forwards: not joints, but turns of the root.
pub(super) const PELVIS: [Normative; 3] = [
    middle("pelvis_tilt", 2.0, 0.0, &[(0.0, 0.0), (0.1, -1.0)]),
    middle(
        "pelvis_obliquity",
        0.7,
        0.0,
        &[(1.73, 3.12), (0.0, 0.0), (-0.73, 0.65)],
    ),
    middle("pelvis_rotation", 0.7, 0.0, &[(4.5, 0.0)]),
];

/// The joints. Those of a model that are not here stay at rest.
///
/// Legs: series fitted to the key values of the sagittal and frontal curves (hip 22° at foot strike to −19° at 53 %
/// measured to the vertical, so without the pelvis' standing tilt; knee 18° at 14 %, 62° at 72 %; ankle −5° at 8 %,
/// 12° at 44 %, −16° at 63 %; hip adduction 7° at 15 %; RMS of the fit 0.2–0.35°). The ankle between 8 % and 36 % is
/// what keeps the sole level (within 1.5°), and hip rotation what keeps the foot's heading, 5° outwards.
/// Trunk: turns against the pelvis and leans against its obliquity, so that shoulders and head stay nearly level.
/// Arms: 32° of swing against the leg of their side.
///
/// # Source
/// Perry & Burnfield, *Gait Analysis*, 2nd ed. 2010, ch. 3–8; Winter, *Biomechanics and Motor Control of Human
/// Movement*, 4th ed. 2009, ch. 3; Kadaba et al. 1990 (pelvis, frontal plane, spreads); Crosbie et al. 1997 (trunk);
/// Murray et al. 1967 (arms).
pub(super) const JOINTS: [Normative; 16] = [
    sides(
        "hip_flexion",
        3.0,
        5.79,
        &[
            (20.87, -2.63),
            (-3.58, -2.64),
            (-0.63, 1.38),
            (-0.23, -0.12),
        ],
    ),
    sides(
        "hip_abduction",
        1.0,
        -1.74,
        &[(-0.83, -5.03), (-0.04, 0.49), (1.15, -0.75), (-0.06, -0.18)],
    ),
    sides("hip_rotation", 3.0, -5.0, &[(-4.5, 0.0)]),
    sides(
        "knee_flexion",
        2.0,
        22.24,
        &[
            (-2.05, -20.01),
            (-14.61, 7.55),
            (-0.14, 4.83),
            (-0.46, 0.59),
            (0.09, 0.52),
        ],
    ),
    sides(
        "ankle_dorsiflexion",
        2.0,
        1.02,
        &[
            (-1.91, 6.77),
            (1.15, -7.07),
            (-2.83, 0.62),
            (1.81, -0.82),
            (-0.29, -0.94),
            (0.34, 0.26),
        ],
    ),
    middle("lumbar_flexion", 2.0, 1.0, &[]),
    middle(
        "lumbar_bending",
        0.5,
        0.0,
        &[(1.0, 1.8), (0.0, 0.0), (-0.4, 0.4)],
    ),
    middle("lumbar_rotation", 0.7, 0.0, &[(-3.5, 0.0)]),
    middle("thorax_flexion", 2.0, 0.0, &[]),
    middle(
        "thorax_bending",
        0.5,
        0.0,
        &[(0.5, 1.0), (0.0, 0.0), (-0.2, 0.2)],
    ),
    middle("thorax_rotation", 0.7, 0.0, &[(-4.5, 0.0)]),
    middle("neck_rotation", 1.0, 0.0, &[(3.5, 0.0)]),
    sides("shoulder_flexion", 3.0, -6.0, &[(-16.0, 2.0)]),
    sides("shoulder_abduction", 2.0, 9.0, &[]),
    sides("elbow_flexion", 5.0, 28.0, &[(-9.0, 2.0)]),
    sides("forearm_twist", 5.0, 20.0, &[]),
];

#[cfg(test)]
mod tests {
    use super::*;

    fn extreme(joint: &str, of: fn(f64, f64) -> f64) -> (f64, f64) {
        let curve = JOINTS.iter().find(|n| n.joint == joint).unwrap().curve();
        let angle = |i: usize| curve.at(i as f64 / 1000.0).to_degrees();
        let best = (0..1000).map(angle).reduce(of).unwrap();
        let at = (0..1000).find(|&i| angle(i) == best).unwrap();
        (best, at as f64 / 10.0)
    }

    #[test]
    fn the_knee_bends_sixty_degrees_in_swing() {
        let (angle_deg, percent) = extreme("knee_flexion", f64::max);
        assert!((60.0..65.0).contains(&angle_deg) && (70.0..74.0).contains(&percent));
    }

    #[test]
    fn the_ankle_dorsiflexes_late_in_stance_and_pushes_off_at_toe_off() {
        let (angle_deg, percent) = extreme("ankle_dorsiflexion", f64::max);
        assert!((10.0..13.0).contains(&angle_deg) && (42.0..48.0).contains(&percent));
        let (angle_deg, percent) = extreme("ankle_dorsiflexion", f64::min);
        assert!((-20.0..-14.0).contains(&angle_deg) && (61.0..66.0).contains(&percent));
    }

    #[test]
    fn the_sole_is_level_in_mid_stance() {
        let curve = |joint: &str| JOINTS.iter().find(|n| n.joint == joint).unwrap().curve();
        let (hip, knee, ankle) = (
            curve("hip_flexion"),
            curve("knee_flexion"),
            curve("ankle_dorsiflexion"),
        );
        for percent in 9..36 {
            let phase = f64::from(percent) / 100.0;
            let pitch = hip.at(phase) - knee.at(phase) + ankle.at(phase);
            assert!(pitch.to_degrees().abs() < 1.6, "{percent} %: {pitch}");
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
