//! How the detections of joints of a recording err: a κ and a τ.
//!
//! What a detector means by a joint is an unknown
//! ([`keypoints`](crate::likelihood::Keypoints)); what it errs besides lasts for some frames, so the looks of
//! one camera at one keypoint, along one axis of the picture, are a cluster. About its mean, ψ has the autocorrelation ρ(k) over k frames, and
//! τ₁ = 1 + 2 Σₖ ρ(k) frames in a row are worth one: what is left of τ stays as long as the recording. A motion that changes more slowly than the errors do
//! sees them as white noise of τ₁ times the variance.

use std::collections::BTreeMap;

use super::{add, influence, near, scale, worth_one};
use crate::likelihood::{PlacedResidual, Source};

/// How the detections of a recording err.
#[derive(Debug, Clone, Copy, PartialEq, serde::Serialize, serde::Deserialize)]
pub struct KeypointNoise {
    /// κ: how many times larger than stated the residuals are.
    pub scale: f64,
    /// τ: how many detections of one joint by one camera are worth one.
    pub together: f64,
    /// τ₁: how many of them in a row are worth one, but for what stays in all.
    #[serde(default = "one")]
    pub in_a_row: f64,
}

/// Of a result that was written before errors were known to last.
fn one() -> f64 {
    1.0
}

impl KeypointNoise {
    pub(super) fn from_residuals(frames: &[Vec<&PlacedResidual>]) -> Option<Self> {
        // ψ of each camera at one keypoint along one axis, and in which frames
        let mut clusters: BTreeMap<(Source, bool), Vec<(usize, f64)>> = BTreeMap::new();
        for (i, rows) in frames.iter().enumerate() {
            for r in rows {
                let key = (r.source, r.outward_px.x > r.outward_px.y);
                clusters.entry(key).or_default().push((i, influence(r)));
            }
        }
        if clusters.is_empty() {
            return None;
        }

        let sums: Vec<(f64, f64)> = clusters.values().map(|scores| sums(scores)).collect();
        let in_a_row = in_a_row(clusters.values().map(Vec::as_slice));
        let together = worth_one(sums.iter()).max(in_a_row);
        Some(Self { scale: scale(frames), together, in_a_row })
    }

    /// The factor of their cost, as of what passes: 1/(κ²τ₁).
    pub fn weight_in_frame(&self) -> f64 {
        1.0 / (self.scale.powi(2) * self.in_a_row)
    }
}

/// Σψ and Σψ² of a cluster.
fn sums(scores: &[(usize, f64)]) -> (f64, f64) {
    let mut sums = (0.0, 0.0);
    scores.iter().for_each(|(_, y)| add(&mut sums, *y));
    sums
}

/// 1 + 2 Σₖ ρ(k) of clusters about their means, each in the order of frames, over the k up to where ρ first falls below 0.05.
fn in_a_row<'a>(clusters: impl Iterator<Item = &'a [(usize, f64)]>) -> f64 {
    const FRAMES: usize = 200;

    let (mut own, mut rows) = (0.0, 0.0);
    // Σψᵢψⱼ and the number of the pairs so many frames apart
    let mut pairs = [(0.0, 0.0); FRAMES];
    for cluster in clusters {
        let mean = sums(cluster).0 / cluster.len() as f64;
        for (i, (frame, y)) in cluster.iter().enumerate() {
            own += (y - mean).powi(2);
            rows += 1.0;
            for (later, other) in &cluster[i + 1..] {
                let Some(pair) = pairs.get_mut(later - frame) else { break };
                pair.0 += (y - mean) * (other - mean);
                pair.1 += 1.0;
            }
        }
    }
    if own <= 0.0 { 1.0 } else { 1.0 + 2.0 * near(&pairs, own / rows) / own }
}
