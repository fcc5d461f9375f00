//! Bodies drawn from a model's statistics.

use nalgebra::DVector;
use rand::Rng;
use rand_distr::{Distribution, StandardNormal};

use crate::body::{BodyModel, Shape};

/// A shape drawn from p(s) of the model: s = μ + L z, Σ = L Lᵀ, z standard normal.
///
/// A model whose covariance has no Cholesky factor gives its mean.
pub fn draw_shape(model: &BodyModel, rng: &mut impl Rng) -> Shape {
    let statistics = &model.statistics;
    let z = DVector::from_fn(statistics.mean.len(), |_, _| StandardNormal.sample(rng));
    match statistics.covariance.clone().cholesky() {
        Some(factor) => Shape(&statistics.mean + factor.l() * z),
        None => Shape(statistics.mean.clone()),
    }
}

#[cfg(test)]
mod tests {
    use std::path::Path;

    use nalgebra::DMatrix;
    use rand::SeedableRng;
    use rand_chacha::ChaCha8Rng;

    use super::*;
    use crate::io::model;

    /// Fails by chance for less than one seed in a million (5 standard errors, a few hundred numbers).
    #[test]
    fn many_bodies_have_the_models_covariance() {
        let model = model::load("human-ellipsoids", Path::new("")).unwrap();
        let mut rng = ChaCha8Rng::seed_from_u64(3);
        let count = 4000;
        let mut sum = DMatrix::zeros(model.coefficients.len(), model.coefficients.len());
        for _ in 0..count {
            let offset = draw_shape(&model, &mut rng).0 - &model.statistics.mean;
            sum += &offset * offset.transpose();
        }
        let expected = &model.statistics.covariance;
        let measured = sum / f64::from(count);
        for i in 0..measured.nrows() {
            for j in 0..=i {
                let variance = expected[(i, i)] * expected[(j, j)] + expected[(i, j)].powi(2);
                let error = (measured[(i, j)] - expected[(i, j)]).abs();
                assert!(error < 5.0 * (variance / f64::from(count)).sqrt());
            }
        }
    }
}
