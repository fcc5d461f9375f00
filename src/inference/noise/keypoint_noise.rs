//! How the detections of joints of a recording err: a κ and a τ.
//!
//! What a detector means by a joint is an unknown
//! ([`keypoints`](crate::likelihood::Keypoints)); what it errs besides lasts for some frames, so the looks of
//! one camera at one keypoint, along one axis of the picture, are a cluster. About its mean, ψ has the autocorrelation ρ(k) over k frames, and
//! τ₁ = 1 + 2 Σₖ ρ(k) frames in a row are worth one: what is left of τ stays as long as the recording. A motion that changes more slowly than the errors do
//! sees them as white noise of τ₁ times the variance.

use std::collections::BTreeMap;

use super::lasting::{in_a_row, one, sums};
use super::{influence, scale, worth_one};
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
