//! From a point to several ellipses at once.

use nalgebra::{SVector, Vector2};

use super::ellipse_distance::{EllipseDistance, OutlineEllipse};

/// min |dᵢ| (ZS06, App. C), with its sign.
pub(super) fn nearest(
    ellipses: &[Option<OutlineEllipse>],
    x: &Vector2<f64>,
    kind: EllipseDistance,
    near: &mut Vec<(usize, SVector<f64, 5>)>,
) -> Option<f64> {
    let all = ellipses
        .iter()
        .enumerate()
        .filter_map(|(i, e)| Some((i, e.as_ref()?.distance(x, kind))));
    let (i, (d, slope)) = all.min_by(|a, b| a.1.0.abs().total_cmp(&b.1.0.abs()))?;
    near.push((i, slope));
    Some(d)
}

/// Ellipses farther than this many τ beyond the nearest have no say in the smooth minimum.
const REACH_IN_BLENDS: f64 = 8.0;

/// −τ ln Σ exp(−dᵢ/τ): ∂ = Σ pᵢ ∂dᵢ with pᵢ ∝ exp(−dᵢ/τ).
///
/// `hint` is an ellipse that is likely near (that of the neighbouring border point) and becomes the
/// nearest one: it bounds the others, so that few distances are computed; the sum depends on it by e⁻⁸.
pub(super) fn smooth_union(
    ellipses: &[Option<OutlineEllipse>],
    x: &Vector2<f64>,
    (kind, blend): (EllipseDistance, f64),
    hint: &mut usize,
    near: &mut Vec<(usize, SVector<f64, 5>)>,
) -> Option<f64> {
    let reach = REACH_IN_BLENDS * blend;
    let mut least = ellipses[*hint]
        .as_ref()
        .map_or(f64::INFINITY, |e| e.distance(x, kind).0);
    let mut distances = [0.0; MAX_NEAR];
    for (i, ellipse) in ellipses.iter().enumerate() {
        let Some(ellipse) = ellipse
            .as_ref()
            .filter(|e| !e.is_farther_than(least + reach, x))
        else {
            continue;
        };
        let (d, slope) = ellipse.distance(x, kind);
        if d <= least + reach && near.len() < MAX_NEAR {
            distances[near.len()] = d;
            near.push((i, slope));
            if d < least {
                (least, *hint) = (d, i);
            }
        }
    }
    if near.is_empty() {
        return None;
    }
    let mut sum = 0.0;
    for ((_, slope), d) in near.iter_mut().zip(distances) {
        let weight = (-(d - least) / blend).exp();
        sum += weight;
        *slope *= weight;
    }
    near.iter_mut().for_each(|(_, slope)| *slope /= sum);
    Some(least - blend * sum.ln())
}

/// No more ellipses than this overlap at one border point.
const MAX_NEAR: usize = 16;
