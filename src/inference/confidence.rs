//! p_ε,σ(K): how likely one of K keyframe estimates is within ε of the reported estimate (ZS06, after Algorithm 1; the equations have no numbers).
//!
//! The errors e = s̄ − s*ₖ of the estimates s*ₖ about the reported s̄ are N(0, σ), with σ by maximum likelihood from the K of them.
//! One is within ε with p_ε,σ = ∫₋ε^ε p(e) de, at least one of K with p_ε,σ(K) = 1 − (1 − p_ε,σ)^K. As σ is estimated from K
//! errors, p(e) is Student's t with K degrees of freedom and the scale σ; for many keyframes that is the normal distribution.
//!
//! **Differs** from ZS06, who have the normal distribution for any K.
//!
//! It is a confidence *of the model's optimum*. A bias that all keyframes and s̄ share (the body is not made of ellipsoids) is
//! invisible to it: the true length may be farther away than ε.

use nalgebra::{Cholesky, DMatrix, DVector, Dyn};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use statrs::distribution::{ContinuousCDF, Normal, StudentsT};

/// The confidence of one number, or of a vector.
#[derive(Debug, Clone, PartialEq, serde::Serialize, serde::Deserialize)]
pub struct Confidence {
    /// ε, in the unit of the estimates.
    pub epsilon: f64,
    /// σ, in the same unit; absent with fewer than two estimates.
    pub sigma: Option<f64>,
    /// K.
    pub keyframes: usize,
    /// p_ε,σ(K); absent with fewer than two estimates.
    pub p_within: Option<f64>,
}

/// p_ε,σ = ∫₋ε^ε N(e; 0, σ) de.
pub fn p_within(epsilon: f64, sigma: f64) -> f64 {
    match Normal::new(0.0, sigma) {
        Ok(normal) => 2.0 * normal.cdf(epsilon) - 1.0,
        Err(_) => 1.0,
    }
}

/// p_ε,σ(K) = 1 − (1 − p_ε,σ)^K.
pub fn p_at_least_one(p_within: f64, k: usize) -> f64 {
    1.0 - (1.0 - p_within).powi(k as i32)
}

/// ∫₋ε^ε t_K(e/σ) de/σ, Student's t with K degrees of freedom.
pub fn p_within_estimated(epsilon: f64, sigma: f64, k: usize) -> f64 {
    match StudentsT::new(0.0, sigma, k as f64) {
        Ok(student) => 2.0 * student.cdf(epsilon) - 1.0,
        Err(_) => 1.0,
    }
}

/// σ of estimates about a reported one; `None` with fewer than two.
pub fn maximum_likelihood_sigma(estimates: &[f64], reported: f64) -> Option<f64> {
    let k = estimates.len() as f64;
    let variance = estimates.iter().map(|s| (reported - s).powi(2)).sum::<f64>() / k;
    (estimates.len() >= 2).then(|| variance.sqrt())
}

/// The confidence of one number from its K keyframe estimates.
pub fn confidence(estimates: &[f64], reported: f64, epsilon: f64) -> Confidence {
    let sigma = maximum_likelihood_sigma(estimates, reported);
    let keyframes = estimates.len();
    let p = |sigma| p_at_least_one(p_within_estimated(epsilon, sigma, keyframes), keyframes);
    Confidence { epsilon, sigma, keyframes, p_within: sigma.map(p) }
}

/// The confidence that one of K whole vectors is within ±ε of the reported one in every component.
///
/// Fewer keyframes than components leave the sample covariance S without an inverse, so it is shrunk to
/// its diagonal: σ = (1 − α)S + α·diag S, α = n/(n + K).
pub(super) fn joint_confidence(
    estimates: &[DVector<f64>],
    reported: &DVector<f64>,
    epsilon: f64,
) -> Confidence {
    let keyframes = estimates.len();
    let none = Confidence { epsilon, sigma: None, keyframes, p_within: None };
    if keyframes < 2 || estimates[0].is_empty() {
        return none;
    }

    // S, shrunk
    let n = reported.len();
    let square = |s: &DVector<f64>| (reported - s) * (reported - s).transpose();
    let sample = estimates.iter().map(square).sum::<DMatrix<f64>>() / keyframes as f64;
    let alpha = n as f64 / (n + keyframes) as f64;
    let covariance = DMatrix::from_fn(n, n, |i, j| {
        if i == j { sample[(i, i)] + 1e-16 } else { (1.0 - alpha) * sample[(i, j)] }
    });

    let p = box_probability(&covariance, epsilon);
    Confidence { p_within: p.map(|p| p_at_least_one(p, keyframes)), ..none }
}

/// P(|eᵢ| ≤ ε for all i), e ~ N(0, σ), by separation of variables over 4000 fixed samples.
///
/// # Source
/// Genz 1992, *Numerical computation of multivariate normal probabilities*.
fn box_probability(covariance: &DMatrix<f64>, epsilon: f64) -> Option<f64> {
    const SAMPLES: usize = 4000;
    let l = Cholesky::<f64, Dyn>::new(covariance.clone())?.l();
    let normal = Normal::standard();
    let mut rng = ChaCha8Rng::seed_from_u64(0);
    let n = covariance.nrows();

    let mut sum = 0.0;
    for _ in 0..SAMPLES {
        // component by component: the chance to stay within ±ε, given the ones before

        let mut y = DVector::zeros(n);
        let mut p = 1.0;
        for i in 0..n {
            let offset: f64 = (0..i).map(|j| l[(i, j)] * y[j]).sum();
            let low = normal.cdf((-epsilon - offset) / l[(i, i)]);
            let high = normal.cdf((epsilon - offset) / l[(i, i)]);
            p *= high - low;
            let u = low + rng.random::<f64>() * (high - low);
            y[i] = normal.inverse_cdf(u.clamp(1e-15, 1.0 - 1e-15));
        }
        sum += p;
    }
    Some(sum / SAMPLES as f64)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn one_sigma_holds_68_of_100_and_ten_keyframes_nearly_all() {
        approx::assert_relative_eq!(p_within(0.02, 0.02), 0.682_689, epsilon = 1e-5);
        approx::assert_relative_eq!(p_at_least_one(0.5, 3), 0.875);
        assert!(p_at_least_one(p_within(0.02, 0.02), 10) > 0.9999);
    }

    #[test]
    fn a_single_keyframe_gives_no_confidence() {
        assert_eq!(confidence(&[0.4], 0.4, 0.02).p_within, None);
    }

    #[test]
    fn sigma_is_that_about_the_reported_estimate() {
        approx::assert_relative_eq!(maximum_likelihood_sigma(&[1.0, 3.0], 2.0).unwrap(), 1.0);
        // keyframes that agree far from it are not sure
        approx::assert_relative_eq!(maximum_likelihood_sigma(&[2.0, 2.0], 3.0).unwrap(), 1.0);
    }

    #[test]
    fn few_keyframes_are_less_sure_and_many_are_the_normal_distribution() {
        // Student's t of two degrees of freedom: P(|t| < 1) = 1/√3
        let few = p_within_estimated(0.02, 0.02, 2);
        approx::assert_relative_eq!(few, 1.0 / 3.0_f64.sqrt(), epsilon = 1e-6);
        let many = p_within_estimated(0.02, 0.02, 100_000);
        approx::assert_relative_eq!(many, p_within(0.02, 0.02), epsilon = 1e-4);
    }

    #[test]
    fn a_box_of_independent_numbers_is_the_product() {
        let p = box_probability(&DMatrix::identity(3, 3), 1.0).unwrap();
        approx::assert_relative_eq!(p, p_within(1.0, 1.0).powi(3), epsilon = 1e-9);
    }

    #[test]
    fn a_box_of_two_equal_numbers_is_nearly_that_of_one() {
        let covariance = DMatrix::from_row_slice(2, 2, &[1.0, 0.9999, 0.9999, 1.0]);
        approx::assert_relative_eq!(
            box_probability(&covariance, 1.0).unwrap(),
            p_within(1.0, 1.0),
            epsilon = 0.01
        );
    }
}
