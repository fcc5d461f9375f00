//! How far surfaces lie from their model, and what detectors mean from the joints: spreads that are estimated from the recording itself.
//!
//! The k offsets b of a part are N(0, σ²). σ maximises their marginal likelihood, ∫ p(Z | b, …) p(b | σ) db, with an inverse χ² of
//! ν degrees of freedom about σ₀² as hyper-prior. One step of expectation and maximisation is
//!
//! σ² ← (ν σ₀² + Σ (b̂² + var b))/(ν + k)
//!
//! with b̂ the optimum and var b its variance, of the σ before. A part in a shoe or loose cloth gets a σ of its own; one that is
//! not seen keeps σ₀. The coefficients β of all keypoints ([`BodyModel::with_keypoints`]) have a σ likewise.
//!
//! # Source
//! Dempster, Laird, Rubin 1977; MacKay 1992, *Bayesian interpolation*.

use std::ops::Range;

use nalgebra::DMatrix;

use crate::body::{BodyModel, KEYPOINT_SD_M, Shape, ShapeStatistics, SurfaceOffsets};

/// ν: the hyper-prior counts as so many offsets that were seen.
const HYPER_OFFSETS: f64 = 4.0;

/// p(s) of a model with the spreads of its offsets and keypoints as they are found at an optimum and its covariance.
pub(super) fn with_spreads(
    model: &BodyModel,
    shape: &Shape,
    covariance: &DMatrix<f64>,
) -> ShapeStatistics {
    let mut statistics = model.statistics.clone();
    let mut spread = |own: Range<usize>, stated_m: f64| {
        let square = |k: usize| shape.0[k].powi(2) + covariance[(k, k)];
        let squares: f64 = own.clone().map(square).sum();
        let variance =
            (HYPER_OFFSETS * stated_m.powi(2) + squares) / (HYPER_OFFSETS + own.len() as f64);
        own.for_each(|k| statistics.covariance[(k, k)] = variance);
    };

    if let Some(offsets) = &model.offsets {
        let mut first = offsets.first().0;
        for part in offsets.owners().chunk_by(|a, b| a == b) {
            spread(first..first + part.len(), SurfaceOffsets::FLESH_SD_M);
            first += part.len();
        }
    }
    spread(model.keypoint_coefficients(), KEYPOINT_SD_M);
    statistics
}

#[cfg(test)]
mod tests {
    use std::path::Path;

    use super::*;

    /// The spreads of the first part and of the last, where the first part's offsets are all of a size and certain.
    fn found(size: f64) -> (f64, f64) {
        let model = crate::io::model::load("human-ellipsoids", Path::new("")).unwrap().detailed();
        let offsets = model.offsets.as_ref().unwrap();
        let first = offsets.first().0;
        let part = offsets.owners().iter().take_while(|p| **p == offsets.owners()[0]).count();
        let mut shape = Shape(model.statistics.mean.clone());
        let mut covariance = model.statistics.covariance.clone();
        shape.0.rows_mut(first, part).fill(size);
        covariance.view_mut((first, first), (part, part)).fill(0.0);
        let variances = with_spreads(&model, &shape, &covariance).covariance.diagonal();
        (variances[first].sqrt(), variances[shape.0.len() - 1].sqrt())
    }

    #[test]
    fn a_part_that_lies_far_off_gets_a_wide_spread_and_one_that_is_not_seen_keeps_its_own() {
        let stated = SurfaceOffsets::FLESH_SD_M;
        let (far, unseen) = found(5.0 * stated);
        assert!((3.5 * stated..5.0 * stated).contains(&far), "{far}");
        approx::assert_relative_eq!(unseen, stated, max_relative = 1e-9);
        let (near, _) = found(0.1 * stated);
        assert!(near < 0.8 * stated, "{near}");
    }

    #[test]
    fn keypoints_that_all_lie_near_their_joints_get_a_narrow_spread_and_unseen_ones_keep_theirs() {
        let model = crate::io::model::load("human-ellipsoids", Path::new("")).unwrap();
        let names: Vec<&str> = model.points.iter().map(|p| p.name.as_str()).collect();
        let model = model.with_keypoints(&names);
        let own = model.keypoint_coefficients();
        let shape = Shape(model.statistics.mean.clone());
        let mut covariance = model.statistics.covariance.clone();
        let found = |covariance: &DMatrix<f64>| {
            with_spreads(&model, &shape, covariance).covariance[(own.start, own.start)].sqrt()
        };
        approx::assert_relative_eq!(found(&covariance), KEYPOINT_SD_M, max_relative = 1e-9);
        covariance.view_mut((own.start, own.start), (own.len(), own.len())).fill(0.0);
        assert!(found(&covariance) < 0.3 * KEYPOINT_SD_M);
    }
}
