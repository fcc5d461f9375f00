//! The metaball field along a ray.

use nalgebra::Vector3;

use crate::body::metaball::Metaball;

/// What one metaball adds to the field along a ray: w·exp(−½ k (t − t₀)²).
///
/// On the ray o + t·r the distance d = (x − c)ᵀA⁻¹(x − c) is the parabola d₀ + a (t − t₀)², so
/// w = exp(−2 d₀) and k = 4 a.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Bump {
    /// w, its value at the closest approach; 0 to 1.
    pub(super) peak: f64,
    /// t₀, where the ray comes closest.
    pub(super) at: f64,
    /// k > 0, in units of 1/t².
    pub(super) sharpness: f64,
}

impl Bump {
    /// What a metaball adds along o + t·r.
    pub(super) fn on_ray(ball: &Metaball, origin: &Vector3<f64>, direction: &Vector3<f64>) -> Self {
        let to = ball.ellipsoid.centre - origin;
        let pull = ball.precision * to;
        let a = direction.dot(&(ball.precision * direction));
        let at = direction.dot(&pull) / a;
        let nearest = to.dot(&pull) - a * at * at;
        Self { peak: (-2.0 * nearest).exp(), at, sharpness: 4.0 * a }
    }

    /// w·exp(−½ k (t − t₀)²).
    pub(super) fn value(&self, t: f64) -> f64 {
        self.peak * (-0.5 * self.sharpness * (t - self.at).powi(2)).exp()
    }
}

/// The field of one limb along a ray, t ≥ 0.
#[derive(Debug, Clone, Default, PartialEq)]
pub(super) struct RayProfile {
    /// The metaballs near the ray, in any order.
    pub(super) bumps: Vec<Bump>,
}

/// Steps after which an ascent ends; most need fewer than ten.
const MOST_STEPS: usize = 40;

impl RayProfile {
    /// F(t).
    pub(super) fn value(&self, t: f64) -> f64 {
        self.bumps.iter().map(|b| b.value(t)).sum()
    }

    /// Where on t ≥ 0 F is largest, and its value there, by climbing from the highest of the bumps' own summits; `None` without
    /// a bump.
    pub(super) fn summit(&self) -> Option<(f64, f64)> {
        let starts = self.bumps.iter().map(|b| (b, self.value(b.at.max(0.0))));
        let (highest, _) = starts.max_by(|a, b| a.1.total_cmp(&b.1))?;
        Some(self.climb(highest, f64::INFINITY))
    }

    /// Whether F reaches `level` anywhere on t ≥ 0.
    ///
    /// By climbing from the bumps' own summits: t ← Σ k f t₀ / Σ k f, a step that never lowers F (Carreira-Perpiñán 2000,
    /// fixed-point iteration for the modes of a Gaussian mixture). On a line a climb passes no mode, so what starts between a start and its
    /// mode ends there, too: from both ends inwards, a ray with one mode needs two climbs. Most rays need no step: one bump alone reaches
    /// the level, or all peaks together do not.
    pub(super) fn reaches(&self, level: f64) -> bool {
        let peaks: f64 = self.bumps.iter().map(|b| b.peak).sum();
        if peaks < level {
            return false;
        }
        let alone = |b: &Bump| b.at >= 0.0 && b.peak >= level;
        self.bumps.iter().any(alone) || self.any_mode_reaches(level)
    }

    fn any_mode_reaches(&self, level: f64) -> bool {
        // only starts between these two are still to be followed
        let (mut low, mut high) = (f64::NEG_INFINITY, f64::INFINITY);
        let by_place = |a: &&Bump, b: &&Bump| a.at.total_cmp(&b.at);
        let between = |low: f64, high: f64| {
            self.bumps.iter().filter(move |bump| low < bump.at && bump.at < high)
        };
        loop {
            let Some(first) = between(low, high).min_by(by_place) else { return false };
            let (mode, value) = self.climb(first, level);
            low = mode.max(first.at);
            if value >= level {
                return true;
            }

            let Some(last) = between(low, high).max_by(by_place) else { return false };
            let (mode, value) = self.climb(last, level);
            high = mode.min(last.at);
            if value >= level {
                return true;
            }
        }
    }

    /// Where climbing from a bump's summit ends, and F there; ends as soon as it is `enough`.
    fn climb(&self, from: &Bump, enough: f64) -> (f64, f64) {
        let mut t = from.at.max(0.0);
        let (mut value, mut mean) = self.value_and_mean(t);
        for _ in 0..MOST_STEPS {
            let previous = value;
            t = mean.max(0.0);
            (value, mean) = self.value_and_mean(t);
            if value >= enough || value - previous < 1e-7 * enough.min(1.0) {
                break;
            }
        }
        (t, value)
    }

    /// F(t), and Σ k f t₀ / Σ k f; t itself where F underflows.
    fn value_and_mean(&self, t: f64) -> (f64, f64) {
        let (mut value, mut pull, mut weight) = (0.0, 0.0, 0.0);
        for bump in &self.bumps {
            let f = bump.value(t);
            let share = bump.sharpness * f;
            value += f;
            pull += share * bump.at;
            weight += share;
        }
        (value, if weight > 0.0 { pull / weight } else { t })
    }
}

#[cfg(test)]
mod tests {
    use rand::{RngExt, SeedableRng};
    use rand_chacha::ChaCha8Rng;

    use super::*;

    fn random_profile(rng: &mut ChaCha8Rng) -> RayProfile {
        let count = rng.random_range(1..8);
        let bump = |_| Bump {
            peak: rng.random_range(0.02..0.5),
            at: rng.random_range(-0.1..1.0),
            sharpness: 1.0 / rng.random_range(0.05_f64..0.3).powi(2),
        };
        RayProfile { bumps: (0..count).map(bump).collect() }
    }

    fn marched_maximum(profile: &RayProfile) -> f64 {
        let each = (0..2000).map(|i| profile.value(f64::from(i) * 1e-3));
        each.fold(0.0, f64::max)
    }

    #[test]
    fn a_level_is_reached_where_dense_marching_reaches_it() {
        let mut rng = ChaCha8Rng::seed_from_u64(2);
        let mut reached = 0;
        for _ in 0..2000 {
            let profile = random_profile(&mut rng);
            let highest = marched_maximum(&profile);
            assert!(profile.reaches(highest * 0.9999), "{profile:?}");
            assert!(!profile.reaches(highest * 1.0001), "{profile:?}");
            reached += usize::from(profile.reaches(0.5));
        }
        assert!((300..1700).contains(&reached), "{reached}");
    }

    #[test]
    fn what_lies_behind_the_origin_counts_only_by_its_tail() {
        let behind = Bump { peak: 0.9, at: -0.1, sharpness: 100.0 };
        let profile = RayProfile { bumps: vec![behind] };
        let at_origin = 0.9 * (-0.5_f64).exp();
        assert!(profile.reaches(at_origin * 0.999));
        assert!(!profile.reaches(at_origin * 1.001));
    }
}
