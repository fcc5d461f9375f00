//! How the residuals err, estimated from the recording itself.
//!
//! A likelihood that takes every row for an independent observation with the stated σ is far too sure of itself:
//!
//! 1. *scale*: the residuals may be larger or smaller than stated. With ψ = ρ′·r/σ, the part of a residual that the
//!    robust loss lets through, κ² = Σwψ²/Σwρ′: the covariance of a robust estimate is κ²H⁻¹ (Huber's, H with the weights wρ′).
//! 2. *along the border* neighbouring rows err together. Their score Σwψ has the variance Σᵢⱼwᵢwⱼψᵢψⱼ where Σwψ² was
//!    stated: λ, the ratio of the two, is how many of the stated observations are worth one. With the autocorrelation ρ(u) of
//!    ψ over the distance u along the border, in units of the stated correlation length, λ is ∫ρ(u)du where rows are close.
//!    Points of a cloud have no border: u is the distance of two places on one part of the body.
//! 3. *at one place of the body* looks err together, over time and cameras: soft tissue and cloth stay for some frames, a fold
//!    smaller than the offsets know of stays for all, and cameras that show the same place show the same. Let y be the mean ψ
//!    of one place, 3 cm wide, in one view of one frame. τ = Σ_places (Σy)²/Σ_places Σy² is how many looks are worth one: the
//!    variance of the sum of a place's scores over what it would be if they were independent (cluster-robust, with places as
//!    clusters). A recording with twice the frames in the same time has twice the τ, and says as much.
//!
//!    A part of this passes: τ₁ is how many looks are worth one of one frame's, by several cameras, times how many of one camera's frames
//!    in a row are (`lasting.rs`).
//!
//! The data's cost is divided by κ²λτ, for all unknowns alike: by κ²λτ₁ as of what passes, and as τ/τ₁ frames are worth one. What that says of the error of a motion, which is another in every
//! frame, is in `repeated_error.rs`. What cameras side by side see differently counts more
//! ([`contrasts`](super::contrasts)). What is the same over a decimetre in every frame is not noise
//! but an unknown of its own: the surface's offsets ([`SurfaceOffsets`](crate::body::SurfaceOffsets)).
//!
//! Each kind of data has a noise of its own. A matched point is off by its depth, and an outline by the person's border: with one
//! κ, λ and τ for both, the points' faults weaken the outlines and the outlines' length along the border is given to points.
//!
//! Detections of joints have a noise of their own kind (`keypoint_noise.rs`).
//!
//! *Kinds beside each other.* A motion is one frame's. What it follows there, an outline or a detection, is told by how they err in a frame, κ²λτ₁
//! of each, and not by how long that stays: an outline that lies a centimetre off in every frame shows every movement. So τ/τ₁ is that of the data
//! that chose between hypotheses, for all kinds alike, as it is for what is known of motions. Divided by a τ of their own, detections, whose constant part is
//! an unknown, would count several times as much in each frame as they are worth beside outlines, whose constant part is not.
//!
//! # Source
//! Huber 1981, *Robust Statistics*; Liang & Zeger 1986, *Longitudinal data analysis using generalized linear models*.

mod keypoint_noise;
mod lasting;

use std::collections::BTreeMap;

pub use keypoint_noise::KeypointNoise;
pub use lasting::in_a_row;
use lasting::one;

use super::Kind;
use crate::likelihood::{Place, PlacedResidual, Source};

/// How the residuals of a recording err, kind by kind; `None` where it has none of a kind.
#[derive(Debug, Clone, Copy, Default, PartialEq, serde::Serialize, serde::Deserialize)]
#[serde(default)]
pub struct Noise {
    /// Of outlines.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub outlines: Option<SurfaceNoise>,
    /// Of points of the surface.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub points: Option<SurfaceNoise>,
    /// Of detections of joints.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub keypoints: Option<KeypointNoise>,
}

/// How residuals of the surface err.
#[derive(Debug, Clone, Copy, PartialEq, serde::Serialize, serde::Deserialize)]
pub struct SurfaceNoise {
    /// κ: how many times larger than stated the residuals are, as far as the robust loss lets them through.
    pub scale: f64,
    /// λ: how many of the stated independent observations along a border are worth one.
    pub along_border: f64,
    /// τ: how many looks at one place, by other cameras and in other frames, are worth one.
    pub together: f64,
    /// How many looks at one place in one frame are worth one.
    pub in_one_frame: f64,
    /// How many looks of one camera at one place in frames in a row are worth one, but for what stays in all.
    #[serde(default = "one")]
    pub in_a_row: f64,
}

/// How many times the cost of each kind of data counts.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct DataWeights {
    /// Of outlines.
    pub outlines: f64,
    /// Of points of the surface.
    pub points: f64,
    /// Of detections.
    pub keypoints: f64,
}

impl DataWeights {
    /// The same of all.
    pub fn all(weight: f64) -> Self {
        Self { outlines: weight, points: weight, keypoints: weight }
    }

    /// That of one kind.
    pub fn of(self, kind: Kind) -> f64 {
        match kind {
            Kind::Outlines => self.outlines,
            Kind::Points => self.points,
            Kind::Keypoints => self.keypoints,
        }
    }
}

impl Noise {
    /// From the residuals of every frame.
    pub fn from_residuals(frames: &[Vec<PlacedResidual>]) -> Self {
        let of = |kind: Kind| -> Vec<Vec<&PlacedResidual>> {
            let rows = frames.iter().map(|rows| rows.iter().filter(|r| Kind::of(r.source) == kind));
            rows.map(Iterator::collect).collect()
        };
        Self {
            outlines: SurfaceNoise::from_residuals(&of(Kind::Outlines), along_border),
            points: SurfaceNoise::from_residuals(&of(Kind::Points), about_place),
            keypoints: KeypointNoise::from_residuals(&of(Kind::Keypoints)),
        }
    }

    /// The factors of all kinds of data: those within one frame, times τ₁/τ; 1 of a kind of which there is none.
    pub fn weights(&self) -> DataWeights {
        let passes = 1.0 - self.staying_share();
        self.of_each(
            |noise| noise.weight_in_frame() * passes,
            |noise| noise.weight_in_frame() * passes,
        )
    }

    /// The factors of all kinds of data within one frame; 1 of a kind of which there is none.
    pub fn weights_in_frame(&self) -> DataWeights {
        self.of_each(SurfaceNoise::weight_in_frame, KeypointNoise::weight_in_frame)
    }

    /// 1 − τ₁/τ: the share of the variance that stays from frame to frame, of the data that chose between hypotheses.
    pub fn staying_share(&self) -> f64 {
        let together = self.of_each(|noise| noise.together, |noise| noise.together);
        let passes = self.of_each(SurfaceNoise::passes, |noise| noise.in_a_row);
        1.0 - passes.of(self.chooses()) / together.of(self.chooses())
    }

    /// ν: how many independent observations residuals are worth.
    pub fn independent(&self, frames: &[Vec<PlacedResidual>]) -> f64 {
        let worth = self.of_each(
            |noise| 1.0 / (noise.along_border * noise.together),
            |noise| 1.0 / noise.together,
        );
        frames.iter().flatten().map(|r| r.weight * worth.of(Kind::of(r.source))).sum()
    }

    /// The factor of the data that chose between hypotheses.
    pub fn data_weight(&self) -> f64 {
        self.weights().of(self.chooses())
    }

    /// What chose between hypotheses: outlines, or else points, or else detections.
    fn chooses(&self) -> Kind {
        match (self.outlines, self.points) {
            (Some(_), _) => Kind::Outlines,
            (None, Some(_)) => Kind::Points,
            (None, None) => Kind::Keypoints,
        }
    }

    /// A number of each kind of data; 1 of a kind of which there is none.
    fn of_each(
        &self,
        of_surface: impl Fn(&SurfaceNoise) -> f64,
        of_keypoints: impl Fn(&KeypointNoise) -> f64,
    ) -> DataWeights {
        DataWeights {
            outlines: self.outlines.as_ref().map_or(1.0, &of_surface),
            points: self.points.as_ref().map_or(1.0, &of_surface),
            keypoints: self.keypoints.as_ref().map_or(1.0, of_keypoints),
        }
    }
}

impl SurfaceNoise {
    /// `neighbours` is how λ is found.
    fn from_residuals(
        frames: &[Vec<&PlacedResidual>],
        neighbours: fn(&[Vec<&PlacedResidual>]) -> f64,
    ) -> Option<Self> {
        if frames.iter().all(Vec::is_empty) {
            return None;
        }
        let ((scale, along_border), (together, passing)) = rayon::join(
            || (scale(frames), neighbours(frames)),
            || {
                let looks = looks(frames);
                let in_one_frame = together(&looks, |frame, place| (frame, place));
                (together(&looks, |_, place| place), [in_one_frame, lasting(&looks)])
            },
        );
        let [in_one_frame, in_a_row] = passing;
        let together = together.max(in_one_frame * in_a_row);
        Some(Self { scale, along_border, together, in_one_frame, in_a_row })
    }

    /// τ₁: how many looks at one place are worth one, but for what stays in all frames.
    pub fn passes(&self) -> f64 {
        self.in_one_frame * self.in_a_row
    }

    /// The factor of their cost as of what passes: 1/(κ²λτ₁).
    pub fn weight_in_frame(&self) -> f64 {
        1.0 / (self.scale.powi(2) * self.along_border * self.passes())
    }
}

/// ψ.
fn influence(residual: &PlacedResidual) -> f64 {
    residual.trust * residual.value
}

/// κ.
fn scale(frames: &[Vec<&PlacedResidual>]) -> f64 {
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
fn along_border(frames: &[Vec<&PlacedResidual>]) -> f64 {
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
        let mut place = |r: &&PlacedResidual| {
            at += r.weight;
            (at - 0.5 * r.weight, r.weight, r.weight * influence(r))
        };
        let rows: Vec<_> = border.iter().map(&mut place).collect();

        for (i, (u, w, score)) in rows.iter().enumerate() {
            own += score * score;
            stated += score * score / w.max(1e-12);
            weights += w;
            for (v, other_w, other) in &rows[i + 1..] {
                // what is nearer than a bin counts with the neighbours: it is too little to say where ρ ends
                let bin = ((v - u) / BIN).round().max(1.0) as usize;
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

    // rows may lie farther apart than a bin is wide: some bins have no pair
    (own + 2.0 * near(&pairs, stated / weights)) / stated
}

/// Σwᵢwⱼψᵢψⱼ of the pairs nearer than where ρ first falls below 0.05, of sums bin by bin; bins without a pair tell nothing.
fn near(pairs: &[(f64, f64)], variance: f64) -> f64 {
    let filled = pairs.iter().filter(|(_, weight)| *weight > 0.0);
    let near = filled.take_while(|(product, weight)| product / weight > 0.05 * variance);
    near.map(|(product, _)| product).sum()
}

/// λ of points: scores of one place together, and of pairs of places of a part that are nearer than where ρ first falls below 0.05.
fn about_place(frames: &[Vec<&PlacedResidual>]) -> f64 {
    const BINS: usize = 40;

    let (mut own, mut own_weights, mut stated) = (0.0, 0.0, 0.0);
    // Σwᵢwⱼψᵢψⱼ and Σwᵢwⱼ of the pairs so many places apart
    let mut pairs = [(0.0, 0.0); BINS];
    for frame in frames {
        stated += frame.iter().map(|r| r.weight * influence(r).powi(2)).sum::<f64>();
        let places: Vec<(Place, (f64, f64))> =
            scores(frame).into_iter().map(|((place, _), score)| (place, score)).collect();

        for (i, (place, (score, weight))) in places.iter().enumerate() {
            own += score * score;
            own_weights += weight * weight;
            let of_part = places[i + 1..].iter().take_while(|(other, _)| other.0 == place.0);
            for (other_place, (other, other_weight)) in of_part {
                if let Some(pair) = pairs.get_mut(places_apart(place, other_place)) {
                    pair.0 += score * other;
                    pair.1 += weight * other_weight;
                }
            }
        }
    }
    if stated <= 0.0 {
        return 1.0;
    }
    (own + 2.0 * near(&pairs, own / own_weights)) / stated
}

/// The distance of two places of a part, in places.
fn places_apart((_, a): &Place, (_, b): &Place) -> usize {
    let squares = a.iter().zip(b).map(|(a, b)| f64::from(a - b).powi(2));
    squares.sum::<f64>().sqrt().round() as usize
}

/// y of one place of the body in one view of a frame.
type Look = ((Place, Source), f64);

/// The looks of every frame.
fn looks(frames: &[Vec<&PlacedResidual>]) -> Vec<Vec<Look>> {
    let of_frame = |frame: &Vec<&PlacedResidual>| {
        let scores = scores(frame).into_iter();
        scores.map(|(at, (sum, weight))| (at, sum / weight.max(1e-12))).collect()
    };
    frames.iter().map(of_frame).collect()
}

/// How many of the looks that `cluster` puts together by their frame and place are worth one.
fn together<K: Ord>(looks: &[Vec<Look>], cluster: impl Fn(usize, Place) -> K) -> f64 {
    // Σy and Σy² of each cluster
    let mut clusters: BTreeMap<K, (f64, f64)> = BTreeMap::new();
    for (i, frame) in looks.iter().enumerate() {
        for ((place, _), y) in frame {
            add(clusters.entry(cluster(i, *place)).or_default(), *y);
        }
    }
    worth_one(clusters.values())
}

/// How many of one camera's looks at a place in a row are worth one.
fn lasting(looks: &[Vec<Look>]) -> f64 {
    let mut clusters: BTreeMap<(Place, Source), Vec<(usize, f64)>> = BTreeMap::new();
    for (i, frame) in looks.iter().enumerate() {
        for (cluster, y) in frame {
            clusters.entry(*cluster).or_default().push((i, *y));
        }
    }
    in_a_row(clusters.values().map(Vec::as_slice))
}

/// Adds y to the Σy and Σy² of a cluster.
fn add((sum, squares): &mut (f64, f64), y: f64) {
    *sum += y;
    *squares += y * y;
}

/// Σ_clusters (Σy)²/Σ_clusters Σy².
fn worth_one<'a>(clusters: impl Iterator<Item = &'a (f64, f64)>) -> f64 {
    let (together, apart) =
        clusters.fold((0.0, 0.0), |(a, b), (sum, squares)| (a + sum * sum, b + squares));
    if apart > 0.0 { (together / apart).max(1.0) } else { 1.0 }
}

/// Σwψ and Σw of each place in each view of a frame.
fn scores(frame: &[&PlacedResidual]) -> BTreeMap<(Place, Source), (f64, f64)> {
    let mut scores: BTreeMap<(Place, Source), (f64, f64)> = BTreeMap::new();
    for r in frame {
        let (sum, weight) = scores.entry((r.place(), r.source)).or_default();
        *sum += r.weight * influence(r);
        *weight += r.weight;
    }
    scores
}
