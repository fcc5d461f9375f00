//! How an optimum errs: by what stays from frame to frame, and by what passes.
//!
//! A surface that lies elsewhere than the model's at a place of the body does so in every frame. So the noise model divides the data
//! by τ, the looks at one place that are worth one, and τ grows with the number of frames ([`noise`](super::noise)). H of that weight says how
//! sure s is, which all frames share. It does not say how sure a motion is: each frame has its own, and would be found the less surely the longer the
//! recording is. The error of mᵢ is
//!
//! mᵢ − m̂ᵢ = (∂mᵢ/∂s)(s − ŝ) + δ + eᵢ,
//!
//! three parts that are independent. With Dᵢ the data's part of H in frame i, and P the precision of p(m):
//!
//! - s − ŝ: Σ_s, the shared block of H⁻¹.
//! - δ stays. The data of all frames together say where it is, A = Σᵢ Dᵢ/(κ²λτ), and the prior draws it to rest: it is as far off as what
//!   stays in the data moves it, Cov δ = (1 − τ₁/τ) (A + P)⁻¹ A (A + P)⁻¹. τ₁ looks at a place are worth one within a frame; the
//!   rest of τ is what stays.
//! - eᵢ passes: the chain of all frames, given s, with the weight 1/(κ²λτ₁). A part that nobody sees keeps the prior's deviation here.
//!
//! *Leverage.* An optimum follows what errs, and its residuals are smaller for that. The data are worth ν = Σ w/(λτ) independent
//! observations. Of these the unknowns that stay follow
//!
//! q = p − tr(Λ₀ Σ_s) + m − tr(P (A + P)⁻¹),
//!
//! p and m their numbers, Λ₀ the precision of the shared prior. So what stays has f = ν/(ν − q) times the variance that residuals show:
//! Σ_s⁻¹ ← Λ₀ + (Σ_s⁻¹ − Λ₀)/f and Cov δ ← f Cov δ.
//!
//! # Source
//! Variance components of repeated measures: Laird & Ware 1982, *Random-effects models for longitudinal data*. q: Spiegelhalter et
//! al. 2002, *Bayesian measures of model complexity*, § 2.4; with flat priors f is n/(n − p) of ordinary least squares.

use nalgebra::DMatrix;

use super::noise::Noise;
use super::sequence_posterior::SequencePosterior;
use super::sequence_state::SequenceState;
use crate::body::Layout;
use crate::solver::{BorderedChain, Problem, QuadraticModel, Solution};

/// The covariances of an optimum's error.
pub(super) struct RepeatedError {
    /// Σ_s, and H of eᵢ.
    pub(super) passes: BorderedChain,
    /// Cov δ, m × m.
    pub(super) stays: DMatrix<f64>,
}

/// The most of the data that the unknowns are taken to follow: beyond it residuals say nothing.
const MOST_FOLLOWED: f64 = 0.9;

impl RepeatedError {
    /// Of an optimum that was found with this noise before ν `observations`, by the posterior of data and motions
    /// that count once; `None` where a matrix is singular.
    pub(super) fn new(
        posterior: &SequencePosterior<'_>,
        solution: &Solution<SequenceState, BorderedChain>,
        noise: &Noise,
        observations: f64,
    ) -> Option<Self> {
        let Solution { model: chain, linearized_at: state, .. } = solution;

        // the priors of H, and the data without them
        let mut priors = posterior.empty_model();
        let beside = posterior.motion_prior.beside(noise.staying_share(), posterior.seconds);
        let sought = SequencePosterior { motion_prior: &beside, ..*posterior };
        sought.linearize_priors(state, &mut priors);
        let mut shared_prior = priors.corner.clone();
        shared_prior.fill_upper_triangle_with_lower_triangle();
        let m = Layout::new(posterior.model).motion();
        let pose_prior = posterior.motion_prior.precision(state.motions.first()?);
        let mut data = DMatrix::zeros(m, m);
        for (link, prior) in chain.links.iter().zip(&priors.links) {
            data += &link.diagonal - &prior.diagonal;
        }
        data.fill_upper_triangle_with_lower_triangle();

        // what stays
        let shared = chain.shared_covariance()?;
        let still = (&data + &pose_prior).cholesky()?.inverse();
        let followed = count(&shared, &shared_prior) + count(&still, &pose_prior);
        let leverage = 1.0 / (1.0 - (followed / observations).min(MOST_FOLLOWED));
        let of_data = (shared.cholesky()?.inverse() - &shared_prior) / leverage;
        let precision = of_data + shared_prior;
        let stays = &still * data * &still * (leverage * noise.staying_share());

        let passes = passing(posterior, state, chain, priors, noise);
        Some(Self { passes: passes.with_shared_precision(&precision)?, stays })
    }
}

/// H of what passes, where `chain` is H. Data without contrasts are as there, without its `priors`, and count τ/τ₁ times as often. The
/// priors are those of the same state: before detections alone the body and what they mean may turn together, and what differences of
/// another state's turns leave there is no precision.
fn passing(
    posterior: &SequencePosterior<'_>,
    state: &SequenceState,
    chain: &BorderedChain,
    mut priors: BorderedChain,
    noise: &Noise,
) -> BorderedChain {
    if !posterior.contrasts.are_none() {
        let in_frames = SequencePosterior { weights: noise.weights_in_frame(), ..*posterior };
        priors.clear();
        in_frames.linearize(state, &mut priors);
        return priors;
    }
    let times = 1.0 / (1.0 - noise.staying_share());
    let mut passes = chain.clone();
    passes.scale(times);
    passes.add_scaled(&priors, -times);
    priors.clear();
    posterior.linearize_priors(state, &mut priors);
    passes.add_scaled(&priors, 1.0);
    passes
}

/// How many unknowns the data determine: n − tr(Λ₀Σ).
fn count(covariance: &DMatrix<f64>, prior: &DMatrix<f64>) -> f64 {
    covariance.nrows() as f64 - covariance.component_mul(prior).sum()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::body::Shape;
    use crate::inference::camera_prior::CameraPrior;
    use crate::inference::contrasts::Contrasts;
    use crate::inference::looks::ClearLooks;
    use crate::inference::motion_prior::MotionPrior;
    use crate::inference::noise::{DataWeights, Noise};
    use crate::inference::prior::ShapePrior;
    use crate::inference::propagate::tests::walker;
    use crate::inference::step::MotionModel;
    use crate::inference::{Detail, Evidence, Look};
    use crate::likelihood::{LikelihoodOptions, Measure};

    #[test]
    fn what_passes_is_as_if_the_data_were_looked_at_again() {
        let (walker, frames) = walker(3, 25.0);
        let options = LikelihoodOptions::default();
        let evidence = Evidence::new(&walker.model, &walker.rig, options, Measure::Metaballs);
        let looks: Vec<_> =
            frames.iter().map(|f| evidence.looks_of_all(f, Detail::Coarse)).collect();
        let looks: Vec<Vec<&Look<'_>>> = looks.iter().map(|look| look.iter().collect()).collect();
        let shape = Shape(walker.model.statistics.mean.clone());
        let state = SequenceState::new(shape, walker.motions.clone());
        let motion_prior = MotionPrior::new(&walker.model, MotionModel::ConstantVelocity);
        let seconds = [0.04; 3];
        let posterior = SequencePosterior {
            model: &walker.model,
            rig: &walker.rig,
            camera_prior: &CameraPrior::trusting(),
            shape_prior: &ShapePrior::new(&walker.model),
            motion_prior: &motion_prior,
            seconds: &seconds,
            looks: &looks,
            weights: DataWeights::all(1.0),
            contrasts: &Contrasts::none(3),
        };
        let noise =
            Noise::from_residuals(&ClearLooks::new(&looks, &posterior.bodies(&state)).residuals);
        assert!(noise.staying_share() > 0.1, "{noise:?}");

        // H as an optimum has it, and its priors
        let beside = motion_prior.beside(noise.staying_share(), &seconds);
        let weights = noise.weights();
        let sought = SequencePosterior { weights, motion_prior: &beside, ..posterior };
        let (mut chain, mut priors) = (posterior.empty_model(), posterior.empty_model());
        sought.linearize(&state, &mut chain);
        sought.linearize_priors(&state, &mut priors);
        let found = passing(&posterior, &state, &chain, priors, &noise);

        let again = SequencePosterior { weights: noise.weights_in_frame(), ..posterior };
        let mut expected = posterior.empty_model();
        again.linearize(&state, &mut expected);
        approx::assert_relative_eq!(
            found.corner,
            expected.corner,
            max_relative = 1e-9,
            epsilon = 1e-6
        );
        for (found, expected) in found.links.iter().zip(&expected.links) {
            let alike = |a: &DMatrix<f64>, b: &DMatrix<f64>| {
                approx::assert_relative_eq!(a, b, max_relative = 1e-9, epsilon = 1e-6);
            };
            alike(&found.diagonal, &expected.diagonal);
            alike(&found.border, &expected.border);
            found.couplings.iter().zip(&expected.couplings).for_each(|(a, b)| alike(a, b));
        }
    }
}
