//! q, the density of accelerations, estimated from the recording itself.
//!
//! A runner's pelvis accelerates with fifty times the density of a walker's. What is published of one is too loose for the other, and what the prior of
//! accelerations leaves open, detections and borders fill with their noise. So each component of the motion has a density of its own
//! that the recording tells: that under which its data are the most probable.
//!
//! p(Z | q) = ∫ p(Z | m) p(m | q) dm is by Laplace's method e^−E √(|P|/|H|), P the precision of p(m | q) and H that of m given Z. With the accelerations eᵢ
//! of the [chain](super::chain), of which p(m | q) has the factors e^−eᵢ²/2qΔ̄ᵢ, it is stationary where
//!
//! q = Σᵢ êᵢ²/Δ̄ᵢ / γ,  γ = Σᵢ (var₀ eᵢ − var eᵢ)/qΔ̄ᵢ
//!
//! ê is of the optimum, var₀ e of P⁻¹, var e of H⁻¹, and γ is the number of accelerations that the data determine.
//!
//! p(q) is known before: a runner's is q₀. A walker's pelvis moves up and down by 3.9 cm and sideways by 5.1 cm, 1.8 and .9 times a second, which
//! is a 31st and a 290th of q₀. The scaled inverse χ² with two degrees of freedom that has 5 % below q₀/50 has 6 % above q₀. It counts
//! as two accelerations more, of squares 5.99 q₀/50:
//!
//! q = (Σᵢ êᵢ²/Δ̄ᵢ + .12 q₀)/(γ + 2).
//!
//! What nothing shows has γ = 0 and .06 q₀. The equation is solved by turns with the optimum, once in each of its rounds.
//!
//! *Any q leaves a process that stays.* With S and v as they are, θ̈ + aθ̇ + bθ = w has b² = qv/4S³ and a² = 2b + q/2Sv; with q₀ it is the chain's.
//!
//! # Source
//! The fixed point: MacKay 1992, *Bayesian interpolation*, § 4. The scaled inverse χ²: Gelman et al. 2013,
//! *Bayesian data analysis*, § 2.6. A walker's pelvis: Orendurff et al. 2004, *The effect of walking speed on center of mass displacement*, Journal of
//! Rehabilitation Research & Development 41(6A), at 1.2 m/s.

use nalgebra::DVector;

use super::chain::ChainPrior;
use crate::body::Motion;
use crate::solver::BorderedChain;

/// How many accelerations what is published is worth: the degrees of freedom of p(q).
const PUBLISHED_IS_WORTH: f64 = 2.0;
/// The sum of their squares over Δ̄, in q₀: a walker's q₀/50 times the upper 5 % point of χ² with two degrees of freedom.
const PUBLISHED_SQUARES: f64 = 5.99 / 50.0;

/// q of each component.
///
/// `published` has q₀ and `used` is the prior of the optimum. `given` is the optimum's H at its s, with which accelerations hardly change, and
/// `alone` is P. In both accelerations count as often as in `used`. `None` where one is singular.
pub(super) fn densities(
    [published, used]: [&ChainPrior; 2],
    (motions, seconds): (&[Motion], &[f64]),
    [given, alone]: [&BorderedChain; 2],
) -> Option<DVector<f64>> {
    let [given, alone] = [Variances::new(given)?, Variances::new(alone)?];
    let densities = used.densities();
    let mut squares = DVector::zeros(densities.len());
    let mut determined = DVector::zeros(densities.len());
    for i in 0..motions.len() {
        let Some((acceleration, between)) = used.acceleration(motions, seconds, i) else {
            continue;
        };
        squares += acceleration.component_mul(&acceleration) / between;
        let told = alone.of_acceleration(seconds, i) - given.of_acceleration(seconds, i);
        determined += told * (used.accelerations_count() / between);
    }
    determined.component_div_assign(&densities);

    let published = published.densities() * PUBLISHED_SQUARES;
    let worth = determined.map(|gamma| gamma.max(0.0) + PUBLISHED_IS_WORTH);
    Some((squares + published).component_div(&worth))
}

/// Of each component: its variance in every frame, and its covariances with the next frame and the one behind that.
struct Variances {
    own: Vec<DVector<f64>>,
    with_followers: Vec<[DVector<f64>; 2]>,
}

impl Variances {
    /// `None` where H is singular.
    fn new(chain: &BorderedChain) -> Option<Self> {
        let m = chain.links.first()?.gradient.len();
        let none = || DVector::zeros(m);
        let mut own = vec![none(); chain.links.len()];
        let mut with_followers = vec![[none(), none()]; chain.links.len()];
        let complete = chain.marginals(|i, marginal| {
            own[i] = marginal.frame.diagonal();
            for (with, follower) in with_followers[i].iter_mut().zip(marginal.followers) {
                *with = follower.diagonal();
            }
        });
        complete.then_some(Self { own, with_followers })
    }

    /// var eᵢ, e = mᵢ/Δᵢ − mᵢ₋₁(1/Δᵢ + 1/Δᵢ₋₁) + mᵢ₋₂/Δᵢ₋₁.
    fn of_acceleration(&self, seconds: &[f64], i: usize) -> DVector<f64> {
        let (last, first) = (1.0 / seconds[i], 1.0 / seconds[i - 1]);
        let middle = -(last + first);
        let squares = &self.own[i] * last.powi(2)
            + &self.own[i - 1] * middle.powi(2)
            + &self.own[i - 2] * first.powi(2);
        let [first_middle, first_last] = &self.with_followers[i - 2];
        let [middle_last, _] = &self.with_followers[i - 1];
        let products = first_middle * (first * middle)
            + first_last * (first * last)
            + middle_last * (middle * last);
        squares + products * 2.0
    }
}

#[cfg(test)]
mod tests {
    use std::path::Path;

    use nalgebra::DMatrix;
    use rand::SeedableRng;
    use rand_distr::{Distribution, StandardNormal};

    use super::*;
    use crate::body::{BodyModel, Layout};
    use crate::inference::step::MotionModel;
    use crate::solver::QuadraticModel;
    use crate::solver::dense;

    const SECONDS: f64 = 0.02;
    /// By which the whole chain is held, 1/rad².
    const HELD: f64 = 1e-3;

    fn arm() -> BodyModel {
        crate::io::model::load("arm", Path::new("")).expect("a shipped body")
    }

    /// Angles whose accelerations have a density, as they are and with noise of a standard deviation.
    fn swinging(model: &BodyModel, q: &DVector<f64>, sd: f64, frames: usize) -> [Vec<Motion>; 2] {
        let layout = Layout::new(model);
        let mut rng = rand_chacha::ChaCha8Rng::seed_from_u64(5);
        let mut normal = || -> f64 { StandardNormal.sample(&mut rng) };
        let rest = Motion::rest(model);
        let (mut angles, mut speeds) = (DVector::zeros(q.len()), DVector::zeros(q.len()));
        let mut both = [Vec::new(), Vec::new()];
        for _ in 0..frames {
            speeds += q.map(|q| (q * SECONDS).sqrt() * normal());
            angles += &speeds * SECONDS;
            let noisy = angles.map(|angle: f64| angle + sd * normal());
            both[0].push(layout.retract_motion(&rest, &angles));
            both[1].push(layout.retract_motion(&rest, &noisy));
        }
        both
    }

    /// The optimum before angles that were seen with noise, its H, and P.
    fn optimum(
        model: &BodyModel,
        prior: &ChainPrior,
        seen: &[Motion],
        sd: f64,
    ) -> (Vec<Motion>, [BorderedChain; 2]) {
        let layout = Layout::new(model);
        let (n, m) = (seen.len(), layout.motion());
        let mut alone = BorderedChain::zeros(n, m, 0, prior.reach());
        for i in 0..n {
            prior.linearize(seen, &vec![SECONDS; n], i, &mut alone.links);
            alone.links[i].diagonal += DMatrix::identity(m, m) * HELD;
        }
        let mut given = alone.clone();
        given.links.iter_mut().for_each(|l| l.diagonal += DMatrix::identity(m, m) / (sd * sd));
        let step = given.minimizer(0.0).expect("a chain that is not singular");
        let moved = |i: usize| layout.retract_motion(&seen[i], &step.rows(i * m, m).into_owned());
        ((0..n).map(moved).collect(), [given, alone])
    }

    /// The estimate of what was seen, after so many turns.
    fn estimated(model: &BodyModel, seen: &[Motion], sd: f64, turns: usize) -> DVector<f64> {
        let published = ChainPrior::new(model, MotionModel::ConstantVelocity);
        let seconds = vec![SECONDS; seen.len()];
        let mut used = published.clone();
        for _ in 0..turns {
            let (motions, [given, alone]) = optimum(model, &used, seen, sd);
            let moves = (motions.as_slice(), seconds.as_slice());
            let found = densities([&published, &used], moves, [&given, &alone]);
            used = used.with_densities(&found.expect("densities"));
        }
        used.densities()
    }

    #[test]
    fn the_density_of_what_swings_is_found_under_noise() {
        let model = arm();
        let published = ChainPrior::new(&model, MotionModel::ConstantVelocity).densities();
        for share in [0.05, 1.0] {
            let truth = &published * share;
            let [_, seen] = swinging(&model, &truth, 0.01, 600);
            let found = estimated(&model, &seen, 0.01, 12);
            for (found, truth) in found.iter().zip(&truth) {
                assert!((found / truth).ln().abs() < 0.5, "{found} for {truth}, {share}");
            }
        }
    }

    #[test]
    fn what_nothing_shows_keeps_what_is_published() {
        let model = arm();
        let published = ChainPrior::new(&model, MotionModel::ConstantVelocity).densities();
        let [seen, _] = swinging(&model, &(&published * 1e-9), 0.0, 600);
        let found = estimated(&model, &seen, 1e4, 3);
        approx::assert_relative_eq!(found, published * 0.06, max_relative = 0.05);
    }

    #[test]
    fn the_variance_of_an_acceleration_is_that_of_the_dense_covariance() {
        let model = arm();
        let prior = ChainPrior::new(&model, MotionModel::ConstantVelocity);
        let q = prior.densities();
        let [seen, _] = swinging(&model, &q, 0.01, 5);
        let (_, [mut chain, _]) = optimum(&model, &prior, &seen, 0.01);
        let m = q.len();
        (0..5).for_each(|i| chain.links[i].diagonal[(0, 0)] += 100.0 * i as f64);

        let covariance = dense(&chain).cholesky().expect("a covariance").inverse();

        let seconds = [0.02, 0.02, 0.03, 0.02, 0.05];
        let variances = Variances::new(&chain).expect("variances");
        for i in 2..5 {
            let found = variances.of_acceleration(&seconds, i);
            for k in 0..m {
                let mut row = DVector::zeros(5 * m);
                row[i * m + k] = 1.0 / seconds[i];
                row[(i - 1) * m + k] = -1.0 / seconds[i] - 1.0 / seconds[i - 1];
                row[(i - 2) * m + k] = 1.0 / seconds[i - 1];
                let expected = row.dot(&(&covariance * &row));
                approx::assert_relative_eq!(found[k], expected, max_relative = 1e-8);
            }
        }
    }
}
