//! How long errors last.
//!
//! The looks of one camera at one place err alike for some frames. About the mean of such a cluster, ψ has the autocorrelation ρ(k) over k frames, and
//! 1 + 2 Σₖ ρ(k) frames in a row are worth one. What its mean is stays as long as the recording.

use super::{add, near};

/// Of a result that was written before errors were known to last.
pub(super) fn one() -> f64 {
    1.0
}

/// Σψ and Σψ² of a cluster.
pub(super) fn sums(scores: &[(usize, f64)]) -> (f64, f64) {
    let mut sums = (0.0, 0.0);
    scores.iter().for_each(|(_, y)| add(&mut sums, *y));
    sums
}

/// 1 + 2 Σₖ ρ(k) of clusters about their means, each in the order of frames, over the k up to where ρ first falls below 0.05.
pub fn in_a_row<'a>(clusters: impl Iterator<Item = &'a [(usize, f64)]>) -> f64 {
    const FRAMES: usize = 200;
    /// A cluster that varies by less than this share of its square does not.
    const CONSTANT: f64 = 1e-12;

    let (mut own, mut all, mut rows) = (0.0, 0.0, 0.0);
    // Σψᵢψⱼ and the number of the pairs so many frames apart
    let mut pairs = [(0.0, 0.0); FRAMES];
    for cluster in clusters {
        let mean = sums(cluster).0 / cluster.len() as f64;
        for (i, (frame, y)) in cluster.iter().enumerate() {
            own += (y - mean).powi(2);
            all += y * y;
            rows += 1.0;
            for (later, other) in &cluster[i + 1..] {
                let Some(pair) = pairs.get_mut(later - frame) else { break };
                pair.0 += (y - mean) * (other - mean);
                pair.1 += 1.0;
            }
        }
    }
    if own <= CONSTANT * all { 1.0 } else { 1.0 + 2.0 * near(&pairs, own / rows) / own }
}
