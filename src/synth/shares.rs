//! How skin near a joint follows the bones on both sides.
//!
//! A skin that is bound by the shares of metaballs follows both over the length at which they overlap. The walker's overlap far. Below
//! a joint the share of what lies beyond it rises from 2 to 98 % within so many centimetres at a stature of 1.70 m, of which MakeHuman's
//! skin takes so many (CC0; base mesh, skeleton and weights `cmu_mb` of MPFB 2, means over bands around the limb):
//!
//! | | hip | knee | ankle | shoulder | elbow | wrist |
//! |---|---|---|---|---|---|---|
//! | `walker-metaballs` | 20 | 31 | 12 | 23 | 22 | 20 |
//! | MakeHuman | 30 | 16 | 16 | 23 | 10 | 8 |
//!
//! So the odds of both sides of knee, elbow and wrist are squared, w ↦ w²/(w² + (1 − w)²). That halves the length, and leaves
//! the place where both have one half.

use crate::body::{BodyModel, towards_root};
use crate::skin::{BONES, SkinnedMesh};

/// The parts beyond the joints at which the walker's flesh follows over twice the length, by the beginnings of their names.
const BEYOND: [&str; 3] = ["shank", "forearm", "hand"];

/// The skin with shares that change as fast at knee, elbow and wrist as those of a skin that is made for bones.
pub(super) fn sharpen(model: &BodyModel, skin: &mut SkinnedMesh) {
    let parents = model.part_parents();
    let named = |part: &usize| BEYOND.iter().any(|name| model.parts[*part].name.starts_with(name));
    for root in (0..model.parts.len()).filter(named) {
        for (parts, weights) in skin.parts.iter().zip(&mut skin.weights) {
            let is_on_root = |part: u8| towards_root(&parents, part.into()).any(|p| p == root);
            square_odds(weights, parts.map(is_on_root));
        }
    }
}

/// Squares the odds of the weights of what lies beyond a joint against those before it; all are 1 together, before and after.
fn square_odds(weights: &mut [f32; BONES], is_beyond: [bool; BONES]) {
    let both = weights.iter().zip(is_beyond);
    let beyond: f32 = both.filter(|(_, is)| *is).map(|(weight, _)| weight).sum();
    let before = weights.iter().sum::<f32>() - beyond;
    let squares = beyond * beyond + before * before;
    for (weight, is_beyond) in weights.iter_mut().zip(is_beyond) {
        *weight *= if is_beyond { beyond } else { before } / squares;
    }
}

#[cfg(test)]
mod tests {
    use std::path::Path;

    use nalgebra::Vector3;

    use super::*;
    use crate::body::{PartId, Posed, Shape};
    use crate::skin::skinned;

    /// The share of right shank and foot in the skin, over heights above the knee, metres.
    fn shares(model: &BodyModel, shape: &Shape, skin: &SkinnedMesh) -> Vec<(f64, f32)> {
        let body = Posed::new(model, shape, &skin.bind);
        let part = |name: &str| model.parts.iter().position(|p| p.name == name).unwrap();
        let [knee, ankle] =
            ["shank_r", "foot_r"].map(|name| body.origin_of_part(PartId(part(name))));
        let along = (knee - ankle).try_normalize(0.0).unwrap();
        let of_leg = |vertex: &Vector3<f64>| (vertex - knee.coords).cross(&along).norm() < 0.14;
        let leg = (0..skin.parts.len()).filter(|i| of_leg(&skin.mesh.vertices[*i]));
        let share = |i: usize| {
            let own = skin.parts[i].iter().zip(skin.weights[i]);
            let beyond = own.filter(|(p, _)| {
                ["shank_r", "foot_r"].contains(&model.parts[usize::from(**p)].name.as_str())
            });
            let sum: f32 = beyond.map(|(_, weight)| weight).sum();
            ((skin.mesh.vertices[i] - knee.coords).dot(&along), sum)
        };
        leg.filter(|i| skin.mesh.vertices[*i].y < 0.0).map(share).collect()
    }

    /// How far below and above the knee skin follows both sides by more than 2 %, metres.
    fn length_m(shares: &[(f64, f32)]) -> f64 {
        let both = shares.iter().filter(|(_, share)| (0.02..0.98).contains(share));
        let (low, high) = both.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), (at, _)| {
            (low.min(*at), high.max(*at))
        });
        high - low
    }

    #[test]
    fn skin_follows_both_sides_of_a_knee_over_half_the_length_and_hangs_with_all_its_weight() {
        let model = crate::io::model::load("walker-metaballs", Path::new("")).unwrap();
        let shape = Shape(model.statistics.mean.clone());
        let plain = skinned(&model, &shape).unwrap();
        let mut sharp = plain.clone();
        sharpen(&model, &mut sharp);

        let [before, after] = [&plain, &sharp].map(|skin| shares(&model, &shape, skin));
        let (long_m, short_m) = (length_m(&before), length_m(&after));
        assert!((0.4..0.6).contains(&(short_m / long_m)), "{short_m} of {long_m}");
        for ((_, share), (_, sharper)) in before.iter().zip(&after) {
            assert_eq!(share.total_cmp(&0.5), sharper.total_cmp(&0.5), "{share} {sharper}");
        }
        for weights in &sharp.weights {
            approx::assert_relative_eq!(weights.iter().sum::<f32>(), 1.0, epsilon = 1e-5);
        }
    }
}
