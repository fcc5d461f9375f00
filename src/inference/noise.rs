//! How the residuals err, estimated from the recording itself.
//!
//! A likelihood that takes every row for an independent observation of its stated σ is far too sure of itself:
//!
//! 1. *scale*: the residuals may be larger or smaller than stated. With ψ = ρ′·r/σ, what the robust loss lets through
//!    of a residual, κ² = Σwψ²/Σwρ′: the covariance of a robust estimate is κ²H⁻¹ (Huber's, H with the weights wρ′).
//! 2. *along the border* neighbouring rows err together. Their score Σwψ varies by Σᵢⱼwᵢwⱼψᵢψⱼ where Σwψ² was stated:
//!    λ, the ratio, of the stated observations are one. With the autocorrelation ρ(u) of ψ over the distance u along the border,
//!    in units of what was stated to go together, it is ∫ρ(u)du where rows are close. The points of a cloud are taken in
//!    their order, for want of a border.
//! 3. *over time* the flesh's mismatch with the model returns in every frame and camera that shows the same place
//!    of the body. Let y be the mean ψ of one place in one view: Var y = V = P + I, P what returns (the
//!    mean product of two y of one place far apart in time), I what does not. N of them are worth
//!    V/(P + I′/N), with I′ = I and what it shares with its neighbours in time. The two sides of a body are alike, and so is what
//!    the model has wrong of them: for s, a place and its mirror image are one.
//!
//!    Within a frame, k cameras that show a place share P as well: k of its y are worth k/μ, μ = 1 + (k − 1)·P/V.
//!
//! The data's cost is divided by κ²λμ, for all unknowns alike. What returns is no noise that a frame's motion
//! would average out, but neither are n frames n times the evidence about s: p(s) counts τ = N/N_eff times
//! against the data, which is the same as weighing the data by 1/τ where they speak of s.

use std::collections::BTreeMap;

use crate::likelihood::{PlacedResidual, Source};

/// How the residuals of a recording err.
#[derive(Debug, Clone, Copy, PartialEq, serde::Serialize, serde::Deserialize)]
pub struct Noise {
    /// κ: by how much the residuals are larger than stated, as far as the robust loss lets them through.
    pub scale: f64,
    /// λ: how many of the stated independent observations along a border are one.
    pub along_border: f64,
    /// μ: how many cameras that show one place in one frame are one.
    pub within_frame: f64,
    /// √(P/V): which part of a place's mean residual returns in every frame.
    pub repeated: f64,
    /// τ: how many observations of s are one.
    pub over_time: f64,
}

/// A place of the body: edge of the cubes into which a part's frame is divided, metres.
const CELL_M: f64 = 0.1;
/// Places are looked at again after this long, seconds: what is alike then, returns.
const APART_S: f64 = 0.4;

impl Noise {
    /// As stated: every row's σ and weight are right; and n frames, of which nothing is known yet, are √n times the
    /// evidence about s that one is.
    pub fn stated(frames: usize) -> Self {
        Self {
            scale: 1.0,
            along_border: 1.0,
            within_frame: 1.0,
            repeated: 0.0,
            over_time: (frames as f64).sqrt().max(1.0),
        }
    }

    /// From the residuals of every frame at the optimum, the frames' times, and the parts that are mirror images of others:
    /// (right, left).
    pub fn from_residuals(
        frames: &[Vec<PlacedResidual>],
        seconds: &[f64],
        part_pairs: &[(usize, usize)],
    ) -> Self {
        let scale = scale_of(frames);
        let places_of = |twins: &[(usize, usize)]| places(frames, seconds, twins);
        let places = places_of(&[]);
        let (repeated, _) = over_time(&places);
        let (_, over_time) = over_time(&places_of(part_pairs));
        Self {
            scale,
            along_border: along_border(frames),
            within_frame: 1.0 + (views_of_a_place(&places) - 1.0) * repeated * repeated,
            repeated,
            over_time,
        }
    }

    /// What the data's cost is to be multiplied with: 1/(κ²λμ).
    pub fn data_weight(&self) -> f64 {
        1.0 / (self.scale * self.scale * self.along_border * self.within_frame)
    }
}

/// ψ.
fn influence(residual: &PlacedResidual) -> f64 {
    residual.trust * residual.value
}

/// κ.
fn scale_of(frames: &[Vec<PlacedResidual>]) -> f64 {
    let (mut squares, mut weights) = (0.0, 0.0);
    for r in frames.iter().flatten() {
        squares += r.weight * influence(r).powi(2);
        weights += r.weight * r.trust;
    }
    if weights <= 0.0 {
        return 1.0;
    }
    (squares / weights).sqrt().max(1e-6)
}

/// λ; the pairs that count are those nearer than where ρ first falls below 0.05.
fn along_border(frames: &[Vec<PlacedResidual>]) -> f64 {
    const BIN: f64 = 0.2;
    const BINS: usize = 100;
    let (mut own, mut stated, mut weights) = (0.0, 0.0, 0.0);
    // Σwᵢwⱼψᵢψⱼ and Σwᵢwⱼ of the pairs so many bins apart
    let mut pairs = [(0.0, 0.0); BINS];
    let rows = frames.iter();
    let borders = rows.flat_map(|rows| rows.chunk_by(|a, b| a.source == b.source));
    for border in borders {
        let mut at = 0.0;
        let mut place = |r: &PlacedResidual| {
            at += r.weight;
            (at - 0.5 * r.weight, r.weight, r.weight * influence(r))
        };
        let rows: Vec<_> = border.iter().map(&mut place).collect();
        for (i, (u, w, score)) in rows.iter().enumerate() {
            own += score * score;
            stated += score * score / w.max(1e-12);
            weights += w;
            for (v, other_w, other) in &rows[i + 1..] {
                let bin = ((v - u) / BIN).round() as usize;
                if bin >= BINS {
                    break;
                }
                pairs[bin].0 += score * other;
                pairs[bin].1 += w * other_w;
            }
        }
    }
    if stated <= 0.0 {
        return 1.0;
    }
    let variance = stated / weights;
    // rows may lie farther apart than a bin is wide: some bins have no pair
    let filled = pairs.iter().filter(|(_, weight)| *weight > 0.0);
    let together = filled.take_while(|(product, weight)| product / weight > 0.05 * variance);
    let together: f64 = together.map(|(product, _)| product).sum();
    (own + 2.0 * together) / stated
}

/// The mean residuals of one place, in the order of time.
type Place = Vec<(f64, f64)>;

/// By part and cube. With pairs of parts, (right, left), what is on the left counts as its mirror image on the right.
fn places(
    frames: &[Vec<PlacedResidual>],
    seconds: &[f64],
    part_pairs: &[(usize, usize)],
) -> Vec<Place> {
    let right_of: BTreeMap<usize, usize> = part_pairs.iter().map(|(r, l)| (*l, *r)).collect();
    let is_right = |part: usize| part_pairs.iter().any(|(right, _)| *right == part);
    let cell_of = |r: &PlacedResidual| {
        let [x, y, z] = r.place_part.into();
        let y = match r.part.0 {
            _ if part_pairs.is_empty() => y,
            part if is_right(part) => y,
            part if right_of.contains_key(&part) => -y,
            _ => y.abs(),
        };
        [x, y, z].map(|length: f64| (length / CELL_M).floor() as i32)
    };
    let mut places: BTreeMap<(usize, [i32; 3]), Place> = BTreeMap::new();
    for (frame, time) in frames.iter().zip(seconds) {
        let mut seen: BTreeMap<(usize, [i32; 3], Source), (f64, f64)> = BTreeMap::new();
        for r in frame {
            let (sum, weight) = seen.entry((r.part.0, cell_of(r), r.source)).or_default();
            *sum += r.weight * influence(r);
            *weight += r.weight;
        }
        for ((part, cell, _), (sum, weight)) in seen {
            let part = *right_of.get(&part).unwrap_or(&part);
            places
                .entry((part, cell))
                .or_default()
                .push((*time, sum / weight.max(1e-12)));
        }
    }
    places.into_values().collect()
}

/// k, as a mean over all y.
fn views_of_a_place(places: &[Place]) -> f64 {
    let (mut squares, mut count) = (0usize, 0usize);
    for place in places {
        for at_once in place.chunk_by(|a, b| a.0.total_cmp(&b.0).is_eq()) {
            squares += at_once.len() * at_once.len();
            count += at_once.len();
        }
    }
    squares as f64 / count.max(1) as f64
}

/// (√(P/V), τ).
fn over_time(places: &[Place]) -> (f64, f64) {
    // sums of products: of each with itself, with its neighbours in time, with those far apart
    let (mut own, mut count) = (0.0, 0.0);
    let (mut near, mut near_pairs) = (0.0, 0.0);
    let (mut far, mut far_pairs) = (0.0, 0.0);
    for place in places {
        let n = place.len() as f64;
        let sum: f64 = place.iter().map(|(_, y)| y).sum();
        let squares: f64 = place.iter().map(|(_, y)| y * y).sum();
        let (mut close, mut close_pairs) = (0.0, 0.0);
        for (i, (t, y)) in place.iter().enumerate() {
            for (_, other) in place[i + 1..].iter().take_while(|(u, _)| u - t < APART_S) {
                close += 2.0 * y * other;
                close_pairs += 2.0;
            }
        }
        own += squares;
        count += n;
        near += close;
        near_pairs += close_pairs;
        far += sum * sum - squares - close;
        far_pairs += n * (n - 1.0) - close_pairs;
    }
    if count < 1.0 || own <= 0.0 {
        return (0.0, 1.0);
    }
    let v = own / count;
    // a recording too short to tell: all of it may return
    let p = if far_pairs > 0.0 {
        (far / far_pairs).clamp(0.0, v)
    } else {
        v
    };
    let independent = ((own + near - p * (near_pairs + count)) / count).max(1e-6 * v);
    let worth: f64 = places
        .iter()
        .map(|place| v / (p + independent / place.len() as f64))
        .sum();
    ((p / v).sqrt(), (count / worth).max(1.0))
}
