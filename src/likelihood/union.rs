//! From a point to several ellipses at once.

use nalgebra::{SVector, Vector2};

use super::ellipse_distance::{EllipseDistance, OutlineEllipse};

/// The ellipses on which the distance of one border point depends.
pub(super) struct NearEllipses {
    /// An ellipse that is likely near: that of the neighbouring border point.
    hint: usize,
    /// Each with the distance's derivative in its numbers.
    pub(super) slopes: Vec<(usize, SVector<f64, 5>)>,
}

impl NearEllipses {
    pub(super) fn new() -> Self {
        Self { hint: 0, slopes: Vec::with_capacity(MAX_NEAR) }
    }

    /// The ellipse on which the distance depends most.
    pub(super) fn most(&self) -> Option<usize> {
        let largest = self.slopes.iter().max_by(|a, b| a.1.norm().total_cmp(&b.1.norm()));
        largest.map(|(index, _)| *index)
    }
}

/// min |dᵢ| (ZS06, App. C), with its sign.
pub(super) fn nearest(
    ellipses: &[Option<OutlineEllipse>],
    x: &Vector2<f64>,
    kind: EllipseDistance,
    near: &mut NearEllipses,
) -> Option<f64> {
    near.slopes.clear();
    let all =
        ellipses.iter().enumerate().filter_map(|(i, e)| Some((i, e.as_ref()?.distance(x, kind))));
    let (i, (d, slope)) = all.min_by(|a, b| a.1.0.abs().total_cmp(&b.1.0.abs()))?;
    near.slopes.push((i, slope));
    Some(d)
}

/// Ellipses farther than this many τ beyond the nearest do not count in the smooth minimum.
const REACH_IN_BLENDS: f64 = 8.0;

/// No more ellipses than this overlap at one border point.
const MAX_NEAR: usize = 16;

/// −τ ln Σ exp(−dᵢ/τ): ∂ = Σ pᵢ ∂dᵢ with pᵢ ∝ exp(−dᵢ/τ); τ is `blend_px`.
///
/// The hint bounds the distance of all ellipses, so that few distances are computed; the sum depends on it by e⁻⁸.
pub(super) fn smooth_union(
    ellipses: &[Option<OutlineEllipse>],
    x: &Vector2<f64>,
    kind: EllipseDistance,
    blend_px: f64,
    near: &mut NearEllipses,
) -> Option<f64> {
    let NearEllipses { hint, slopes } = near;
    slopes.clear();

    // the near ones and their distances
    let reach = REACH_IN_BLENDS * blend_px;
    let mut least = ellipses[*hint].as_ref().map_or(f64::INFINITY, |e| e.distance(x, kind).0);
    let mut distances = [0.0; MAX_NEAR];
    for (i, ellipse) in ellipses.iter().enumerate() {
        let Some(ellipse) = ellipse.as_ref().filter(|e| !e.is_farther_than(least + reach, x))
        else {
            continue;
        };
        let (d, slope) = ellipse.distance(x, kind);
        if d <= least + reach && slopes.len() < MAX_NEAR {
            distances[slopes.len()] = d;
            slopes.push((i, slope));
            if d < least {
                (least, *hint) = (d, i);
            }
        }
    }
    if slopes.is_empty() {
        return None;
    }

    // pᵢ ∂dᵢ, and the minimum
    let mut sum = 0.0;
    for ((_, slope), d) in slopes.iter_mut().zip(distances) {
        let weight = (-(d - least) / blend_px).exp();
        sum += weight;
        *slope *= weight;
    }
    slopes.iter_mut().for_each(|(_, slope)| *slope /= sum);
    Some(least - blend_px * sum.ln())
}
