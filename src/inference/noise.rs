//! How the residuals err, estimated from the recording itself.
//!
//! A likelihood that takes every row for an independent observation with the stated σ is far too sure of itself:
//!
//! 1. *scale*: the residuals may be larger or smaller than stated. With ψ = ρ′·r/σ, the part of a residual that the
//!    robust loss lets through, κ² = Σwψ²/Σwρ′: the covariance of a robust estimate is κ²H⁻¹ (Huber's, H with the weights wρ′).
//! 2. *along the border* neighbouring rows err together. Their score Σwψ has the variance Σᵢⱼwᵢwⱼψᵢψⱼ where Σwψ² was
//!    stated: λ, the ratio of the two, is how many of the stated observations are worth one. With the autocorrelation ρ(u) of
//!    ψ over the distance u along the border, in units of the stated correlation length, λ is ∫ρ(u)du where rows are close. The
//!    points of a cloud have no border and are taken in their order.
//! 3. *over time* the flesh's mismatch with the model returns in every frame and camera that shows the same place
//!    of the body. Let y be the mean ψ of one place in one view: Var y = V = P + I. P is what returns (the
//!    mean product of two y of one place far apart in time), I what does not. N of them are worth
//!    V/(P + I′/N), with I′ = I and what it shares with its neighbours in time. The two sides of a body are alike, and so
//!    are the model's errors on them: for s, a place and its mirror image are one.
//!
//!    Within a frame, k cameras that show a place share P as well: k of its y are worth k/μ, μ = 1 + (k − 1)·P/V.
//!
//! The data's cost is divided by κ²λμ, for all unknowns alike. A motion is of one frame: what returns in every frame does not
//! average out of it. The shape is of all frames, but n of them are not n times the evidence about s: p(s) counts τ = N/N_eff
//! times against the data, which is the same as weighing the data by 1/τ where they speak of s.

use std::collections::BTreeMap;

use crate::likelihood::{PlacedResidual, Source};

/// How the residuals of a recording err.
#[derive(Debug, Clone, Copy, PartialEq, serde::Serialize, serde::Deserialize)]
pub struct Noise {
    /// κ: how many times larger than stated the residuals are, as far as the robust loss lets them through.
    pub scale: f64,
    /// λ: how many of the stated independent observations along a border are worth one.
    pub along_border: f64,
    /// μ: how many cameras that show one place in one frame are worth one.
    pub within_frame: f64,
    /// √(P/V): the part of a place's mean residual that returns in every frame.
    pub repeated: f64,
    /// τ: how many observations of s are worth one.
    pub over_time: f64,
}

/// Edge of the cubes into which a part's frame is divided, metres; each is a place of the body.
const CELL_M: f64 = 0.1;
/// Time after which a place is seen anew, seconds: what is the same then, returns.
const APART_S: f64 = 0.4;

impl Noise {
    /// As stated: every row's σ and weight are right. Nothing is known yet of what returns over time: n frames are taken for √n
    /// times the evidence about s that one is.
    pub fn stated(frames: usize) -> Self {
        Self {
            scale: 1.0,
            along_border: 1.0,
            within_frame: 1.0,
            repeated: 0.0,
            over_time: (frames as f64).sqrt().max(1.0),
        }
    }

    /// From the residuals of every frame at the optimum, the frames' times, and the pairs of parts that are mirror images:
    /// (right, left).
    pub fn from_residuals(
        frames: &[Vec<PlacedResidual>],
        seconds: &[f64],
        part_pairs: &[(usize, usize)],
    ) -> Self {
        let by_side = places(frames, seconds, Twins(&[]));
        let mirrored = places(frames, seconds, Twins(part_pairs));
        let repeated = repetition(&by_side).repeated;
        Self {
            scale: scale(frames),
            along_border: along_border(frames),
            within_frame: 1.0 + (mean_views(&by_side) - 1.0) * repeated * repeated,
            repeated,
            over_time: repetition(&mirrored).over_time,
        }
    }

    /// The factor of the data's cost: 1/(κ²λμ).
    pub fn data_weight(&self) -> f64 {
        1.0 / (self.scale * self.scale * self.along_border * self.within_frame)
    }
}

/// ψ.
fn influence(residual: &PlacedResidual) -> f64 {
    residual.trust * residual.value
}

/// κ.
fn scale(frames: &[Vec<PlacedResidual>]) -> f64 {
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
        // u, w and wψ of each row
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

/// The mean residuals y of one place, each with its time, in the order of time.
type Place = Vec<(f64, f64)>;

/// Pairs of parts, (right, left), whose places are one; without any, every place is its own.
#[derive(Clone, Copy)]
struct Twins<'a>(&'a [(usize, usize)]);

impl Twins<'_> {
    /// The part, or its twin on the right.
    fn right_part(self, part: usize) -> usize {
        let twin = self.0.iter().find(|(_, left)| *left == part);
        twin.map_or(part, |(right, _)| *right)
    }

    /// The cube of a residual's part; what is on the left counts as its mirror image on the right.
    fn cell(self, r: &PlacedResidual) -> [i32; 3] {
        let [x, y, z] = r.place_part.into();
        let is_right = self.0.iter().any(|(right, _)| *right == r.part.0);
        let y = match r.part.0 {
            _ if self.0.is_empty() || is_right => y,
            part if self.right_part(part) != part => -y,
            _ => y.abs(),
        };
        [x, y, z].map(|length: f64| (length / CELL_M).floor() as i32)
    }
}

/// The places of a body, by part and cube.
fn places(frames: &[Vec<PlacedResidual>], seconds: &[f64], twins: Twins<'_>) -> Vec<Place> {
    let mut places: BTreeMap<(usize, [i32; 3]), Place> = BTreeMap::new();
    for (frame, time) in frames.iter().zip(seconds) {
        // Σwψ and Σw of each place in each view
        let mut sums: BTreeMap<(usize, [i32; 3], Source), (f64, f64)> = BTreeMap::new();
        for r in frame {
            let key = (r.part.0, twins.cell(r), r.source);
            let (sum, weight) = sums.entry(key).or_default();
            *sum += r.weight * influence(r);
            *weight += r.weight;
        }

        for ((part, cell, _), (sum, weight)) in sums {
            let place = places.entry((twins.right_part(part), cell)).or_default();
            place.push((*time, sum / weight.max(1e-12)));
        }
    }
    places.into_values().collect()
}

/// k, as a mean over all y.
fn mean_views(places: &[Place]) -> f64 {
    let (mut squares, mut count) = (0usize, 0usize);
    for place in places {
        for at_once in place.chunk_by(|a, b| a.0.total_cmp(&b.0).is_eq()) {
            squares += at_once.len() * at_once.len();
            count += at_once.len();
        }
    }
    squares as f64 / count.max(1) as f64
}

/// What returns over time.
struct Repetition {
    /// √(P/V).
    repeated: f64,
    /// τ.
    over_time: f64,
}

fn repetition(places: &[Place]) -> Repetition {
    // sums of products: of each y with itself, with its neighbours in time, with those far apart
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
        return Repetition { repeated: 0.0, over_time: 1.0 };
    }

    // V, P and I′; in a recording too short to tell, all of V may return
    let v = own / count;
    let p = if far_pairs > 0.0 { (far / far_pairs).clamp(0.0, v) } else { v };
    let independent = ((own + near - p * (near_pairs + count)) / count).max(1e-6 * v);

    // N and N_eff
    let worth: f64 = places.iter().map(|place| v / (p + independent / place.len() as f64)).sum();
    Repetition { repeated: (p / v).sqrt(), over_time: (count / worth).max(1.0) }
}
