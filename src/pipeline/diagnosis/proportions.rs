//! Whether a body is too large or too small to be anybody: the scale of the world.
//!
//! Silhouettes say nothing of scale: cameras and body may be λ times as large. The bones' lengths alone tell, as clothes, hair and
//! shoes change the rest: with the log lengths lᵢ − ln λ, ½(l − μ)ᵀΣ⁻¹(l − μ) of the population falls, and a world that is so wrong
//! is improbable itself, by ½(ln λ/σ)². A world that is wrong by 10 % makes a tall person of a usual one, and nobody can tell.

use nalgebra::{DMatrix, DVector};

use crate::body::{BodyModel, Scale, Shape};

/// σ of ln λ, of worlds whose scale is wrong.
const WRONG_BY: f64 = 0.2;
/// By how much −log must fall: one recording in a hundred is so, and odds of ten to one on top.
const EVIDENCE: f64 = 6.9;
/// The λ that are tried, percent above 1.
const PERCENT: std::ops::RangeInclusive<i32> = -50..=100;

/// The λ by which the world is too large, if that is much more probable than a body of this size.
pub(super) fn wrong_scale(model: &BodyModel, shape: &Shape) -> Option<f64> {
    let bones = bone_lengths(model);
    let statistics = &model.statistics;
    let n = bones.len();
    let covariance = DMatrix::from_fn(n, n, |i, j| statistics.covariance[(bones[i], bones[j])]);
    let precision = covariance.cholesky()?.inverse();
    let offset = DVector::from_fn(n, |i, _| shape.0[bones[i]] - statistics.mean[bones[i]]);
    let cost = |lambda: f64| {
        let smaller = offset.add_scalar(-lambda.ln());
        0.5 * (smaller.dot(&(&precision * &smaller)) + (lambda.ln() / WRONG_BY).powi(2))
    };

    let tried = PERCENT.map(|percent| 1.0 + f64::from(percent) / 100.0);
    let best = tried.map(|lambda| (lambda, cost(lambda))).min_by(|a, b| a.1.total_cmp(&b.1))?;
    (cost(1.0) - best.1 > EVIDENCE).then_some(best.0)
}

/// ln λ of the most probable λ by which the world is too large, and its standard deviation, where nothing else is known of the scale:
/// 1ᵀΣ⁻¹(l − μ)/1ᵀΣ⁻¹1 and 1/√(1ᵀΣ⁻¹1).
pub(in crate::pipeline) fn likeliest_scale(model: &BodyModel, shape: &Shape) -> Option<(f64, f64)> {
    let bones = bone_lengths(model);
    let statistics = &model.statistics;
    let n = bones.len();
    let covariance = DMatrix::from_fn(n, n, |i, j| statistics.covariance[(bones[i], bones[j])]);
    let offset = DVector::from_fn(n, |i, _| shape.0[bones[i]] - statistics.mean[bones[i]]);
    let weights = covariance.cholesky()?.solve(&DVector::from_element(n, 1.0));
    Some((weights.dot(&offset) / weights.sum(), 1.0 / weights.sum().sqrt()))
}

/// The coefficients that are logs of the distances between joints.
fn bone_lengths(model: &BodyModel) -> Vec<usize> {
    let scales = model.joints.iter().flat_map(|joint| joint.translation.scale);
    let log = |scale| if let Scale::Log(c) = scale { Some(c.0) } else { None };
    let mut bones: Vec<usize> = scales.filter_map(log).collect();
    bones.sort_unstable();
    bones.dedup();
    bones
}

#[cfg(test)]
mod tests {
    use std::path::Path;

    use super::*;

    /// A mean body, all bones so many times as long.
    fn found(factor: f64) -> Option<f64> {
        let model = crate::io::model::load("human-ellipsoids", Path::new("")).unwrap();
        let mut shape = Shape(model.statistics.mean.clone());
        bone_lengths(&model).into_iter().for_each(|bone| shape.0[bone] += factor.ln());
        wrong_scale(&model, &shape)
    }

    #[test]
    fn a_giant_and_a_dwarf_are_a_wrong_world_and_a_tall_person_is_not() {
        let model = crate::io::model::load("human-ellipsoids", Path::new("")).unwrap();
        let mut shape = Shape(model.statistics.mean.clone());
        bone_lengths(&model).into_iter().for_each(|bone| shape.0[bone] += 0.1);
        let (log, sd) = likeliest_scale(&model, &shape).unwrap();
        assert!((log - 0.1).abs() < 1e-9 && (0.01..0.08).contains(&sd), "{log} {sd}");

        assert_eq!(found(1.0), None);
        assert_eq!(found(1.12), None);
        assert!(found(1.4).unwrap() > 1.2);
        assert!(found(0.7).unwrap() < 0.85);
    }
}
