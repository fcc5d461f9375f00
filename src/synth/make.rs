//! Makes of body: stated certainty that is tested on one make alone may be true of that make alone.
//!
//! | make                | flesh at a joint          | sections of a limb         | outside                    |
//! |---------------------|---------------------------|----------------------------|----------------------------|
//! | [`Make::Metaballs`] | that of both parts adds up | those of metaballs         | skin                       |
//! | [`Make::Flesh`]     | follows both by shares    | uneven                     | skin                       |
//! | [`Make::Dressed`]   | follows both by shares    | uneven                     | cloth, shoes, hair         |
//!
//! *By shares* is linear blend skinning, as in animators' programs, with shares that change as fast as those of their skins (`shares.rs`). *Uneven*: the skin lies u(x) outside that of the metaballs, a
//! random sum of waves 10 to 30 cm long with a standard deviation of 5 mm, the same on both sides of the body. What is worn lies outside
//! the skin, by an amount that is drawn for each person and varies by a half along it. Ease of garments (what their girth is more than
//! the body's) is 6 to 12 cm around the chest and 4 to 10 cm around the thigh (Aldrich, *Metric pattern cutting for menswear*): divided
//! by 2π, and some of it lies in folds, 3 to 15 mm. Soles are 15 to 30 mm thick, uppers 4 to 8, hair 5 to 25 (E).

use nalgebra::Vector3;
use rand::{Rng, RngExt};
use rand_distr::{Distribution, StandardNormal};

use super::bound_skin::BoundSkin;
use super::shares::sharpen;
use super::worn::{self, HAIR, SHIRT, SHOES, TROUSERS, ZONES};
use crate::body::{BodyModel, Shape};
use crate::skin::SkinError;

/// What a person is made of.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Make {
    /// Metaballs, each fixed to its part.
    #[default]
    Metaballs,
    /// A skin that follows the parts by shares, of uneven sections.
    Flesh,
    /// The same with clothes, shoes and hair.
    Dressed,
}

/// Standard deviation of the skin's unevenness, metres.
const UNEVEN_M: f64 = 0.005;
/// The waves of which it is made: how many, and their lengths, metres.
const WAVES: usize = 24;
const LENGTHS_M: (f64, f64) = (0.10, 0.30);
/// What is worn varies by this share of its mean.
const VARIES: f64 = 0.5;

/// The least and the most that each zone lies outside the skin, metres.
const OUTSIDE_M: [(usize, f64, f64); 4] =
    [(SHIRT, 0.003, 0.015), (TROUSERS, 0.003, 0.015), (SHOES, 0.004, 0.008), (HAIR, 0.005, 0.025)];
/// Thickness of a sole, metres.
const SOLE_M: (f64, f64) = (0.015, 0.030);

impl Make {
    /// The skin of a body of this make, and how much higher it stands; `None` for metaballs, which are their own.
    ///
    /// # Errors
    /// [`SkinError`] if the body cannot have a skin.
    pub(super) fn skin(
        self,
        model: &BodyModel,
        shape: &Shape,
        rng: &mut impl Rng,
    ) -> Result<Option<(BoundSkin, f64)>, SkinError> {
        if self == Self::Metaballs {
            return Ok(None);
        }

        let mut bound = BoundSkin::new(model, shape)?;
        sharpen(model, &mut bound.skin);
        let uneven = Waves::random(rng);
        let is_dressed = self == Self::Dressed;
        let worn = is_dressed.then(|| (Worn::random(rng), worn::zones(model, &bound.skin)));

        let mesh = &mut bound.skin.mesh;
        for (i, (vertex, normal)) in mesh.vertices.iter_mut().zip(&mesh.normals).enumerate() {
            let place = *vertex;
            *vertex += normal * (UNEVEN_M * uneven.at(&place));
            if let Some((worn, zones)) = &worn {
                *vertex += worn.outside(&zones[i], &place, normal);
            }
        }
        let sole_m = worn.map_or(0.0, |(worn, _)| worn.sole_m);
        Ok(Some((bound, sole_m)))
    }
}

/// A smooth random function of the place, of mean 0 and variance 1, the same on both sides of the body.
struct Waves {
    /// Wave vector, 1/m, and phase.
    waves: Vec<(Vector3<f64>, f64)>,
}

impl Waves {
    fn random(rng: &mut impl Rng) -> Self {
        let mut wave = |_| {
            let along: Vector3<f64> = Vector3::from_fn(|_, _| StandardNormal.sample(rng));
            let length_m = rng.random_range(LENGTHS_M.0..LENGTHS_M.1);
            let phase = rng.random_range(0.0..std::f64::consts::TAU);
            (along * (std::f64::consts::TAU / (length_m * along.norm())), phase)
        };
        Self { waves: (0..WAVES).map(&mut wave).collect() }
    }

    fn at(&self, place: &Vector3<f64>) -> f64 {
        let place = Vector3::new(place.x, place.y.abs(), place.z);
        let sum: f64 = self.waves.iter().map(|(k, phase)| (k.dot(&place) + phase).sin()).sum();
        sum * (2.0 / WAVES as f64).sqrt()
    }
}

/// What one person wears.
struct Worn {
    outside_m: [f64; ZONES],
    sole_m: f64,
    folds: Waves,
}

impl Worn {
    fn random(rng: &mut impl Rng) -> Self {
        let mut outside_m = [0.0; ZONES];
        for (zone, least_m, most_m) in OUTSIDE_M {
            outside_m[zone] = rng.random_range(least_m..most_m);
        }
        let sole_m = rng.random_range(SOLE_M.0..SOLE_M.1);
        Self { outside_m, sole_m, folds: Waves::random(rng) }
    }

    /// By how much what is worn lies outside the skin.
    fn outside(
        &self,
        zones: &[f32; ZONES],
        place: &Vector3<f64>,
        normal: &Vector3<f64>,
    ) -> Vector3<f64> {
        let each = zones.iter().zip(self.outside_m);
        let mean_m: f64 = each.map(|(share, outside_m)| f64::from(*share) * outside_m).sum();
        let varied_m = mean_m * (1.0 + VARIES * self.folds.at(place)).max(0.0);
        let sole_m = f64::from(zones[SHOES]) * self.sole_m * (-normal.z).max(0.0);
        normal * varied_m - Vector3::z() * sole_m
    }
}

#[cfg(test)]
mod tests {
    use std::path::Path;

    use rand::SeedableRng;
    use rand_chacha::ChaCha8Rng;

    use super::*;
    use crate::math::stats::mean_and_sd;

    /// Mean and standard deviation of how far the skin of a make lies outside that of metaballs, mm, and the same of the feet's lowest.
    fn outside(make: Make) -> (f64, f64, f64) {
        let model = crate::io::model::load("walker-metaballs", Path::new("")).unwrap();
        let shape = Shape(model.statistics.mean.clone());
        let plain = BoundSkin::new(&model, &shape).unwrap().skin.mesh;
        let mut rng = ChaCha8Rng::seed_from_u64(5);
        let (bound, sole_m) = make.skin(&model, &shape, &mut rng).unwrap().unwrap();
        let moved = bound.skin.mesh.vertices.iter().zip(&plain.vertices).zip(&plain.normals);
        let along: Vec<f64> = moved.map(|((to, from), n)| 1e3 * (to - from).dot(n)).collect();
        let (mean, sd) = mean_and_sd(&along).unwrap();
        let lowest = |mesh: &[Vector3<f64>]| mesh.iter().map(|v| v.z).fold(f64::INFINITY, f64::min);
        let lower_mm = 1e3 * (lowest(&plain.vertices) - lowest(&bound.skin.mesh.vertices));
        assert!(sole_m == 0.0 || (lower_mm - 1e3 * sole_m).abs() < 15.0, "{lower_mm} {sole_m}");
        (mean, sd.unwrap(), lower_mm)
    }

    #[test]
    fn flesh_is_uneven_about_the_skin_and_clothes_lie_outside_it() {
        let (mean, sd, _) = outside(Make::Flesh);
        assert!(mean.abs() < 2.0 && (3.0..7.0).contains(&sd), "{mean} {sd}");
        let (dressed, _, sole) = outside(Make::Dressed);
        assert!(dressed > mean + 3.0 && sole > 12.0, "{dressed} {sole}");
    }
}
