//! Where the person's colours end: of the edges beside a border, the one that parts the two sides.
//!
//! Clothes and furniture have edges of their own, some of them stronger than the border. But only the border has the
//! person's colours on one side and the background's on the other. Both are learnt beside the contour, for each of its points
//! from its neighbours along it: from the colours c in a strip within and in one outside, by kernels k,
//!
//! ℓ(c) = ln (ε + mean k(c − cᵢ) within) − ln (ε + mean k(c − cⱼ) outside).
//!
//! On the point's normal, outwards s, the border is where what lies within looks like the person and what lies outside does not:
//!
//! b = argmax ½λ (Σ_{s<b} ℓ(s) − Σ_{s>b} ℓ(s)) − ½(b/ρ)²,
//!
//! the sums averaged over neighbouring points. λ < 1, as neighbouring pixels are not independent; ρ is how far the contour
//! may be off.
//!
//! # Source
//! Hanek and Beetz 2004, *The contracting curve density algorithm* (colours of both sides from strips along the curve);
//! Lankton and Tannenbaum 2008, *Localizing region-based active contours*. **Differs**: kernels instead of one Gaussian a
//! side, for clothes have several colours.

use nalgebra::{Point2, Vector2};

use crate::image::Plane;
use crate::math::parabola::summit;
use crate::silhouette::snake::outward;

/// How far the border may be from the contour, px.
const REACH_PX: usize = 7;
/// The strips in which colours are learnt lie so far from the contour, px: it is off by less than the near one, mostly.
const STRIP_PX: (usize, usize) = (3, 12);
/// Points on either side along the contour whose colours count, every second of them.
const ALONG: usize = 12;
/// Fewer colours than this in a strip say nothing.
const LEAST_COLOURS: usize = 30;
/// Width of the kernels, grey levels: more than noise and compression change a colour.
const KERNEL: f32 = 6.0;
/// ε: how often a colour is met that was not seen in a strip.
const UNSEEN: f32 = 0.002;
/// |ℓ| of one pixel at most.
const MOST: f32 = 3.0;
/// λ: what one of the pixels counts.
const SHARE: f64 = 0.5;
/// ρ, px.
const OFF_PX: f64 = 2.5;
/// Points on either side over which the sums are averaged.
const AVERAGED: usize = 3;

/// One normal's colours, from STRIP_PX.1 within to as far outside; `None` beyond the picture.
type Normal = [Option<[f32; 3]>; 2 * STRIP_PX.1 + 1];

/// The points of a closed contour, each moved along its normal to where the colours part.
///
/// The contour has the person on the left as seen on the screen; `is_person` knows all of its kind.
pub(super) fn parting(
    contour: &[Point2<f64>],
    colours: &[Plane<f32>],
    is_person: impl Fn(&Point2<f64>) -> bool,
) -> Vec<Point2<f64>> {
    let n = contour.len();
    let [red, green, blue] = colours else {
        return contour.to_vec();
    };
    if n <= 2 * ALONG {
        return contour.to_vec();
    }

    // 1. the colours on every normal, and those of them that either side is learnt from
    let normals: Vec<Vector2<f64>> = (0..n).map(|i| outward(contour, i)).collect();
    let place = |i: usize, s: isize| contour[i] + normals[i] * s as f64;
    let far = STRIP_PX.1 as isize;
    let seen = |i: usize| -> Normal {
        std::array::from_fn(|k| colour([red, green, blue], &place(i, k as isize - far)))
    };
    let seen: Vec<Normal> = (0..n).map(seen).collect();
    let strip = |i: usize, side: isize, person: bool| -> Vec<[f32; 3]> {
        let steps = (STRIP_PX.0..=STRIP_PX.1).map(move |s| side * s as isize);
        let there = steps.filter(|&s| is_person(&place(i, s)) == person);
        there.filter_map(|s| seen[i][(s + far) as usize]).collect()
    };
    let within: Vec<_> = (0..n).map(|i| strip(i, -1, true)).collect();
    let outside: Vec<_> = (0..n).map(|i| strip(i, 1, false)).collect();

    // 2. where they part
    let sums: Vec<Sums> = (0..n)
        .map(|i| {
            let near = || (0..=2 * ALONG).step_by(2).map(|k| (i + n + k - ALONG) % n);
            let of = |strips: &[Vec<[f32; 3]>]| -> Vec<[f32; 3]> {
                near().flat_map(|j| strips[j].iter().copied()).collect()
            };
            parted(&seen[i], &of(&within), &of(&outside))
        })
        .collect();
    let best: Vec<f64> = (0..n).map(|i| border(&sums, i)).collect();
    let smooth = |i: usize| 0.25 * (best[(i + n - 1) % n] + 2.0 * best[i] + best[(i + 1) % n]);
    (0..n).map(|i| contour[i] + normals[i] * smooth(i)).collect()
}

/// ½(Σ_{s<b} ℓ(s) − Σ_{s>b} ℓ(s)) for every whole b within reach.
type Sums = [f64; 2 * REACH_PX + 1];

fn parted(normal: &Normal, within: &[[f32; 3]], outside: &[[f32; 3]]) -> Sums {
    if within.len().min(outside.len()) < LEAST_COLOURS {
        return [0.0; 2 * REACH_PX + 1];
    }

    // ℓ of each pixel
    let first = STRIP_PX.1 - REACH_PX;
    let ratios: [f64; 2 * REACH_PX + 1] = std::array::from_fn(|k| {
        let Some(c) = normal[first + k] else {
            return 0.0;
        };
        let ratio = ((UNSEEN + density(&c, within)) / (UNSEEN + density(&c, outside))).ln();
        f64::from(ratio.clamp(-MOST, MOST))
    });

    // and its sums
    let all: f64 = ratios.iter().sum();
    let mut before = 0.0;
    ratios.map(|ratio| {
        let after = all - before - ratio;
        let sum = 0.5 * (before - after);
        before += ratio;
        sum
    })
}

fn density(colour: &[f32; 3], among: &[[f32; 3]]) -> f32 {
    let kernel = |c: &[f32; 3]| {
        let off = (0..3).map(|k| (c[k] - colour[k]).powi(2)).sum::<f32>();
        (-off / (2.0 * KERNEL * KERNEL)).exp()
    };
    among.iter().map(kernel).sum::<f32>() / among.len() as f32
}

/// b of a point, between the pixels.
fn border(sums: &[Sums], i: usize) -> f64 {
    let n = sums.len();
    let score = |k: usize| {
        let near = (0..=2 * AVERAGED).map(|j| sums[(i + n + j - AVERAGED) % n][k]);
        let mean = near.sum::<f64>() / (2 * AVERAGED + 1) as f64;
        let b = k as f64 - REACH_PX as f64;
        SHARE * mean - 0.5 * (b / OFF_PX).powi(2)
    };
    let scores: Sums = std::array::from_fn(score);
    let best = (1..2 * REACH_PX).max_by(|a, b| scores[*a].total_cmp(&scores[*b]));
    let best = best.unwrap_or(REACH_PX);
    let offset = summit([best - 1, best, best + 1].map(|k| scores[k]));
    best as f64 - REACH_PX as f64 + offset
}

/// The colour between four pixels.
fn colour(planes: [&Plane<f32>; 3], place: &Point2<f64>) -> Option<[f32; 3]> {
    if !(place.x >= 0.0 && place.y >= 0.0) {
        return None;
    }
    let (x, y) = (place.x as usize, place.y as usize);
    let (right, down) = ((place.x - x as f64) as f32, (place.y - y as f64) as f32);
    let mut mixed = [0.0; 3];
    for (value, plane) in mixed.iter_mut().zip(planes) {
        let [[a, b], [c, d]] = plane.square(x, y)?;
        let (upper, lower) = (a + (b - a) * right, c + (d - c) * right);
        *value = upper + (lower - upper) * down;
    }
    mixed.iter().all(|v| v.is_finite()).then_some(mixed)
}

#[cfg(test)]
mod tests {
    use std::f64::consts::TAU;

    use super::*;

    /// A disk of 40 px in stripes of two colours, more different from one another than from the grey around.
    fn striped(channel: usize) -> Plane<f32> {
        let value = |i: usize| {
            let (x, y) = ((i % 160) as f64 - 80.0, (i / 160) as f64 - 80.0);
            let is_in = x.hypot(y) < 40.0;
            let stripe = usize::from((x + y).rem_euclid(16.0) < 8.0);
            let colours = [[170.0, 60.0, 60.0], [20.0, 60.0, 110.0]];
            if is_in { colours[stripe][channel] } else { 95.0 }
        };
        Plane::from_values(160, 160, (0..160 * 160).map(value).collect()).unwrap()
    }

    fn circle(radius_px: f64) -> Vec<Point2<f64>> {
        let at = |i: i32| -TAU * f64::from(i) / 160.0;
        let point = |i| Point2::new(80.0 + radius_px * at(i).cos(), 80.0 + radius_px * at(i).sin());
        (0..160).map(point).collect()
    }

    #[test]
    fn a_contour_beside_the_border_goes_to_where_the_colours_part_and_not_to_the_stripes() {
        let colours = [0, 1, 2].map(striped);
        for radius_px in [38.0, 40.0, 42.0] {
            let is_person = |p: &Point2<f64>| (p - Point2::new(80.0, 80.0)).norm() < radius_px;
            let found = parting(&circle(radius_px), &colours, is_person);
            let off = found.iter().map(|p| ((p - Point2::new(80.0, 80.0)).norm() - 40.0).abs());
            assert!(off.clone().sum::<f64>() / 160.0 < 0.4, "{radius_px}: {found:?}");
            assert!(off.fold(0.0, f64::max) < 1.5, "{radius_px}");
        }
    }

    #[test]
    fn where_both_sides_look_alike_a_contour_stays() {
        let colours = [0, 1, 2].map(|c| Plane::filled(160, 160, 50.0 + 10.0 * c as f32));
        let is_person = |p: &Point2<f64>| (p - Point2::new(80.0, 80.0)).norm() < 40.0;
        let found = parting(&circle(40.0), &colours, is_person);
        let still = circle(40.0);
        assert!(found.iter().zip(&still).all(|(a, b)| (a - b).norm() < 1e-9));
    }
}
