//! How far surfaces lie from their model: the spread of the offsets, part by part, estimated from the recording itself.
//!
//! The k offsets b of a part are N(0, σ²). σ maximises their marginal likelihood, ∫ p(Z | b, …) p(b | σ) db, with an inverse χ² of
//! ν degrees of freedom about σ₀² as hyper-prior. One step of expectation and maximisation is
//!
//! σ² ← (ν σ₀² + Σ (b̂² + var b))/(ν + k)
//!
//! with b̂ the optimum and var b its variance, of the σ before. A part in a shoe or loose cloth gets a σ of its own; one that is
//! not seen keeps σ₀.
//!
//! # Source
//! Dempster, Laird, Rubin 1977; MacKay 1992, *Bayesian interpolation*.

use nalgebra::DMatrix;

use crate::body::{BodyModel, Shape, ShapeStatistics, SurfaceOffsets};

/// ν: the hyper-prior counts as so many offsets that were seen.
const HYPER_OFFSETS: f64 = 4.0;

/// p(s) of a model with the spreads of its offsets as they are found at an optimum and its covariance.
pub(super) fn with_spreads(
    model: &BodyModel,
    shape: &Shape,
    covariance: &DMatrix<f64>,
) -> ShapeStatistics {
    let mut statistics = model.statistics.clone();
    let Some(offsets) = &model.offsets else {
        return statistics;
    };

    let mut first = offsets.first().0;
    for part in offsets.owners().chunk_by(|a, b| a == b) {
        let own = first..first + part.len();
        let square = |k: usize| shape.0[k].powi(2) + covariance[(k, k)];
        let squares: f64 = own.clone().map(square).sum();
        let stated = SurfaceOffsets::FLESH_SD_M.powi(2);
        let variance = (HYPER_OFFSETS * stated + squares) / (HYPER_OFFSETS + part.len() as f64);
        first = own.end;
        own.for_each(|k| statistics.covariance[(k, k)] = variance);
    }
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
}
