//! Colours of solid things: procedural textures that are a function of a place.

use std::f32::consts::TAU;

use rand::{Rng, RngExt};

/// Red, green, blue: 0 black, 1 white.
pub(super) type Colour = [f32; 3];

/// Two colours in blotches, with stripes if wanted, and grain over both.
///
/// t = S(½ + k·(n(x) + ½ n(2x) + s·sin 2π x·d/p)), colour = (dark + t·(light − dark))·(1 + g·n(x/c)), with n value noise
/// between −1 and 1, S the smooth step. Everything is smooth over a centimetre: two samples a pixel are enough.
#[derive(Debug, Clone, Copy)]
pub(super) struct Texture {
    pub(super) dark: Colour,
    pub(super) light: Colour,
    /// Blotches in a metre along each axis.
    pub(super) per_m: [f32; 3],
    /// k, how sharply the two colours part.
    pub(super) contrast: f32,
    /// s, and the stripes in a metre along each axis.
    pub(super) stripes: (f32, [f32; 3]),
    /// g.
    pub(super) grain: f32,
    pub(super) seed: u32,
}

/// Grain in a metre, 1/c.
const GRAIN_PER_M: f32 = 75.0;

impl Texture {
    /// A cloth, carpet or print: two colours well apart in brightness, blotches of 2 to 7 cm.
    pub(super) fn printed(rng: &mut impl Rng) -> Self {
        let size = rng.random_range(14.0..45.0f32);
        let striped = rng.random_range(0.0..1.0) < 0.35;
        let direction = [0, 1, 2].map(|_| rng.random_range(-1.0..1.0f32));
        let stripes = direction.map(|d| d * rng.random_range(8.0..22.0));
        Self {
            dark: colour(rng, 0.08, 0.35),
            light: colour(rng, 0.45, 0.9),
            per_m: [size; 3],
            contrast: rng.random_range(0.8..2.5),
            stripes: (if striped { 1.0 } else { 0.0 }, stripes),
            grain: 0.2,
            seed: rng.random(),
        }
    }

    /// Wood: grain drawn out along z.
    pub(super) fn wooden(rng: &mut impl Rng) -> Self {
        let brightness = rng.random_range(0.25..0.75f32);
        Self {
            dark: [0.6, 0.4, 0.25].map(|c| c * brightness),
            light: [1.1, 0.8, 0.55].map(|c| c * brightness),
            per_m: [45.0, 45.0, 3.0],
            contrast: 0.8,
            stripes: (0.0, [0.0; 3]),
            grain: 0.25,
            seed: rng.random(),
        }
    }

    /// One colour that varies a little: skin, plaster, leaves.
    pub(super) fn plain(colour: Colour, variation: f32, rng: &mut impl Rng) -> Self {
        Self {
            dark: colour.map(|c| c * (1.0 - variation)),
            light: colour.map(|c| c * (1.0 + variation)),
            per_m: [30.0; 3],
            contrast: 0.6,
            stripes: (0.0, [0.0; 3]),
            grain: 0.12,
            seed: rng.random(),
        }
    }

    /// The colour at a place of the texture.
    pub(super) fn at(&self, place: [f32; 3]) -> Colour {
        let scaled = |factor: f32| std::array::from_fn(|i| place[i] * self.per_m[i] * factor);
        let mut value = noise(scaled(1.0), self.seed) + 0.5 * noise(scaled(2.0), self.seed ^ 1);
        let (strength, per_m) = self.stripes;
        if strength > 0.0 {
            let turns: f32 = place.iter().zip(per_m).map(|(x, n)| x * n).sum();
            value += strength * (TAU * turns).sin();
        }
        let t = smooth((0.5 + self.contrast * value).clamp(0.0, 1.0));
        let fine = noise(place.map(|x| x * GRAIN_PER_M), self.seed ^ 2);
        let brightness = 1.0 + self.grain * fine;
        std::array::from_fn(|i| brightness * (self.dark[i] + t * (self.light[i] - self.dark[i])))
    }
}

/// A colour with a brightness between two bounds.
fn colour(rng: &mut impl Rng, least: f32, most: f32) -> Colour {
    let brightness = rng.random_range(least..most);
    [0, 1, 2].map(|_| (brightness * rng.random_range(0.55..1.45f32)).min(1.0))
}

pub(super) fn smooth(t: f32) -> f32 {
    t * t * (3.0 - 2.0 * t)
}

/// Value noise between −1 and 1: random numbers at whole places, joined smoothly.
fn noise(place: [f32; 3], seed: u32) -> f32 {
    let cell = place.map(f32::floor);
    let t: [f32; 3] = std::array::from_fn(|i| smooth(place[i] - cell[i]));
    let [x, y, z] = cell.map(|c| c as i32);
    let mix = |a: f32, b: f32, t: f32| a + t * (b - a);
    let along_x = |dy: i32, dz: i32| {
        let at = |dx: i32| {
            lattice_value([x.wrapping_add(dx), y.wrapping_add(dy), z.wrapping_add(dz)], seed)
        };
        mix(at(0), at(1), t[0])
    };
    let plane = |dz: i32| mix(along_x(0, dz), along_x(1, dz), t[1]);
    mix(plane(0), plane(1), t[2])
}

/// A random number between −1 and 1 for each place of a lattice.
///
/// # Source
/// The finaliser of MurmurHash3 (Appleby, public domain).
fn lattice_value(place: [i32; 3], seed: u32) -> f32 {
    let [x, y, z] = place;
    let mut h = (x as u32).wrapping_mul(0x8da6_b343)
        ^ (y as u32).wrapping_mul(0xd816_3841)
        ^ (z as u32).wrapping_mul(0xcb1a_b31f)
        ^ seed.wrapping_mul(0x9e37_79b9);
    h = (h ^ (h >> 16)).wrapping_mul(0x85eb_ca6b);
    h = (h ^ (h >> 13)).wrapping_mul(0xc2b2_ae35);
    h ^= h >> 16;
    h as f32 * (2.0 / u32::MAX as f32) - 1.0
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn noise_is_even_about_zero_and_has_no_jumps() {
        let (mut sum, mut squares, mut jump) = (0.0, 0.0, 0.0f32);
        let mut last = noise([0.0; 3], 3);
        for k in 0..20_000 {
            let t = k as f32 * 0.01;
            let value = noise([t, 0.7 * t, -0.3 * t], 3);
            jump = jump.max((value - last).abs());
            last = value;
            sum += value;
            squares += value * value;
        }
        assert!((sum / 20_000.0).abs() < 0.08, "{sum}");
        assert!(squares / 20_000.0 > 0.1 && jump < 0.08, "{squares} {jump}");
    }
}
