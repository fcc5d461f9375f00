//! Whether all trials are of one person, and two sessions: by their lengths.
//!
//! Trial k alone found the lengths ℓₖ at rest with the covariance Cₖ = J Σₖ Jᵀ, J their slopes with respect to the shape. The n others
//! found, each by what is known of it,
//!
//! ℓ̄ = C̄ Σ Cⱼ⁻¹ ℓⱼ,  C̄⁻¹ = Σ Cⱼ⁻¹,  j ≠ k.
//!
//! It is a mean of trials, and not what all their data say together with one prior: where the same flesh draws every trial to the same side, that lies far
//! beyond all of them. Trials of one person err alike, by λ of what they state: of one person ℓₖ − ℓ̄ has the covariance λ(Cₖ + C̄). The others tell λ, with
//! what simulated people told before:
//!
//! λ̂ = (ν₀ + Σ (ℓⱼ − ℓ̄)ᵀ Cⱼ⁻¹ (ℓⱼ − ℓ̄)) / ν,  ν = ν₀ + (n − 1) m,
//!
//! F = (ℓₖ − ℓ̄)ᵀ (Cₖ + C̄)⁻¹ (ℓₖ − ℓ̄) / (m λ̂)
//!
//! is F-distributed with m and ν degrees of freedom, m the directions in which lengths vary. ν₀ = 9: the mean squares of errors over standard deviations of eight
//! simulated persons of three makes are .4 to 1.7, .92 ± .43 (docs/decisions, 0032, RMS z), as much as χ²/ν varies with ν = 9. The trial of the largest F is named if
//! its probability is below 1/1000 and a length differs by more than 3 %; the others are tested again without it.
//!
//! # Source
//! A scale that is common to all covariances, with a conjugate prior: Gelman et al. 2013, *Bayesian data analysis*, 3rd ed., § 3.2.

use nalgebra::{DMatrix, DVector, SymmetricEigen};
use statrs::distribution::{ContinuousCDF, FisherSnedecor};

use super::SessionTrial;
use crate::body::{BodyModel, Shape};
use crate::inference::covariance::lengths_slopes;

/// A trial whose lengths are not those of the others.
#[derive(Debug, Clone, PartialEq)]
pub struct Disagreement {
    /// Its position among the trials.
    pub trial: usize,
    /// F of all lengths.
    pub f: f64,
    /// Its degrees of freedom: m, ν.
    pub degrees: [usize; 2],
    /// The probability of such an F and larger ones, if it is the same person.
    pub probability: f64,
    /// The name of the length that differs most, by its standard deviation.
    pub length: String,
    /// That length in this trial alone, m.
    pub own_m: f64,
    /// The same in all others together, m.
    pub others_m: f64,
}

/// Whether two fits show one body.
#[derive(Debug, Clone, Default, PartialEq)]
pub enum OneBody {
    /// One of them states no standard deviations, or their body models differ.
    #[default]
    Unknown,
    /// Their lengths agree.
    Yes,
    /// Their lengths do not: the second is the trial, the first the others.
    No(Disagreement),
}

impl OneBody {
    /// `yes`, `no` or `unknown`.
    pub fn name(&self) -> &'static str {
        match self {
            Self::Unknown => "unknown",
            Self::Yes => "yes",
            Self::No(_) => "no",
        }
    }
}

/// ν₀.
const KNOWN_BEFORE: usize = 9;
/// A disagreement is less probable than this if all trials are of one person.
const IMPROBABLE: f64 = 1e-3;
/// And a length differs by more than this share of it.
const LEAST_SHARE: f64 = 0.03;
/// Directions in which lengths vary by less than this part of the largest variance are rounding.
const ROUNDING: f64 = 1e-3;

/// The lengths of a trial, and how sure they are.
#[derive(Clone)]
struct Lengths {
    metres: DVector<f64>,
    covariance: DMatrix<f64>,
}

/// The trials that are not of the person of the others, the most improbable first; none where there are not two whose
/// lengths have standard deviations. `model` has no details.
pub fn disagreements(model: &BodyModel, trials: &[SessionTrial<'_>]) -> Vec<Disagreement> {
    let body = model.detailed();
    let known = trials.iter().enumerate().filter_map(|(k, trial)| {
        let alone = &trial.alone;
        Some((k, Lengths::new(&body, &alone.shape, alone.covariance.as_ref()?)))
    });

    let mut left: Vec<(usize, Lengths)> = known.collect();
    let names = names(&body);
    let mut found = Vec::new();
    while let Some(odd) = oddest(&left, &names) {
        left.retain(|(k, _)| *k != odd.trial);
        found.push(odd);
    }
    found
}

/// Whether two fits show one body, by the test of a session's trials. `body` is the model of both with its details; of each fit the
/// shape and its covariance.
pub fn one_body(
    body: &BodyModel,
    before: (&Shape, &DMatrix<f64>),
    after: (&Shape, &DMatrix<f64>),
) -> OneBody {
    let [before, after] = [before, after].map(|(s, covariance)| Lengths::new(body, s, covariance));
    one_of_two(&before, &after, &names(body))
}

fn one_of_two(before: &Lengths, after: &Lengths, names: &[String]) -> OneBody {
    let tested = Mean::new(&[before]).and_then(|alone| test(1, after, &alone, names));
    match tested {
        None => OneBody::Unknown,
        Some(found) if found.is_sure() => OneBody::No(found),
        Some(_) => OneBody::Yes,
    }
}

fn names(body: &BodyModel) -> Vec<String> {
    body.lengths.iter().map(|(name, ..)| name.clone()).collect()
}

impl Lengths {
    fn new(body: &BodyModel, shape: &Shape, covariance: &DMatrix<f64>) -> Self {
        let slopes = lengths_slopes(body, shape);
        let metres = DVector::from_vec(body.rest_lengths_m(shape));
        Self { metres, covariance: &slopes * covariance * slopes.transpose() }
    }
}

impl Disagreement {
    /// Whether it is beyond chance, and more than a fold of cloth.
    fn is_sure(&self) -> bool {
        let share = (self.own_m / self.others_m - 1.0).abs();
        self.probability < IMPROBABLE && share > LEAST_SHARE
    }
}

/// What some trials found together.
struct Mean {
    /// ℓ̄ and C̄.
    lengths: Lengths,
    /// n.
    trials: usize,
    /// Σ (ℓⱼ − ℓ̄)ᵀ Cⱼ⁻¹ (ℓⱼ − ℓ̄).
    squares: f64,
}

impl Mean {
    /// Of at least one trial; `None` where a covariance has no inverse.
    fn new(trials: &[&Lengths]) -> Option<Self> {
        let precisions = trials.iter().map(|own| precision(&own.covariance));
        let precisions: Vec<DMatrix<f64>> = precisions.collect::<Option<_>>()?;
        let weighted =
            precisions.iter().zip(trials).map(|(precision, own)| precision * &own.metres);
        let covariance = precision(&precisions.iter().sum())?;
        let metres = &covariance * weighted.sum::<DVector<f64>>();

        let square = |(precision, own): (&DMatrix<f64>, &&Lengths)| {
            let off = &own.metres - &metres;
            off.dot(&(precision * &off))
        };
        let squares = precisions.iter().zip(trials).map(square).sum();
        Some(Self { lengths: Lengths { metres, covariance }, trials: trials.len(), squares })
    }
}

/// The trial of the largest F, if it is not of the person of the others.
fn oddest(trials: &[(usize, Lengths)], names: &[String]) -> Option<Disagreement> {
    if trials.len() < 2 {
        return None;
    }
    let tested = trials.iter().filter_map(|(k, own)| {
        let others = trials.iter().filter(|(other, _)| other != k).map(|(_, lengths)| lengths);
        test(*k, own, &Mean::new(&others.collect::<Vec<_>>())?, names)
    });
    let oddest = tested.max_by(|a, b| a.f.total_cmp(&b.f));
    oddest.filter(Disagreement::is_sure)
}

/// The inverse of a symmetric matrix, over the directions that are more than rounding.
fn precision(covariance: &DMatrix<f64>) -> Option<DMatrix<f64>> {
    let mut eigen = SymmetricEigen::new(0.5 * (covariance + covariance.transpose()));
    let floor = 1e-9 * eigen.eigenvalues.amax();
    let is_usable = floor.is_finite() && floor > 0.0;
    eigen.eigenvalues.apply(|value| *value = 1.0 / value.max(floor));
    is_usable.then(|| eigen.recompose())
}

/// F of a trial, and the length by which it differs most from the others.
fn test(trial: usize, own: &Lengths, others: &Mean, names: &[String]) -> Option<Disagreement> {
    let mean = &others.lengths;
    let difference = &own.metres - &mean.metres;
    let covariance = &own.covariance + &mean.covariance;
    let eigen = SymmetricEigen::new(0.5 * (&covariance + covariance.transpose()));
    let least = ROUNDING * eigen.eigenvalues.amax();
    let along = eigen.eigenvectors.tr_mul(&difference);
    let known = (0..along.len()).filter(|k| eigen.eigenvalues[*k] > least);
    let squares: Vec<f64> = known.map(|k| along[k].powi(2) / eigen.eigenvalues[k]).collect();

    let m = squares.len();
    let nu = KNOWN_BEFORE + (others.trials - 1) * m;
    let scale = (KNOWN_BEFORE as f64 + others.squares) / nu as f64;
    let f = squares.iter().sum::<f64>() / (m as f64 * scale);
    let probability = FisherSnedecor::new(m as f64, nu as f64).ok()?.sf(f);
    let by_sd = |k: &usize| difference[*k].abs() / covariance[(*k, *k)].max(least).sqrt();
    let length = (0..names.len()).max_by(|a, b| by_sd(a).total_cmp(&by_sd(b)))?;
    Some(Disagreement {
        trial,
        f,
        degrees: [m, nu],
        probability,
        length: names[length].clone(),
        own_m: own.metres[length],
        others_m: mean.metres[length],
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use rand::SeedableRng;
    use rand_chacha::ChaCha8Rng;
    use rand_distr::{Distribution, StandardNormal};

    fn names() -> Vec<String> {
        ["thigh", "shank", "upper_arm"].map(String::from).to_vec()
    }

    fn prior() -> Lengths {
        let metres = DVector::from_vec(vec![0.43, 0.42, 0.30]);
        let mut covariance = DMatrix::from_diagonal_element(3, 3, 4e-4);
        covariance.fill_lower_triangle(3e-4, 1);
        covariance.fill_upper_triangle(3e-4, 1);
        Lengths { metres, covariance }
    }

    /// What a trial of a person says: the posterior of a measurement with 8 mm of standard deviation.
    fn trial(truth: &DVector<f64>, rng: &mut ChaCha8Rng) -> Lengths {
        let (sd, prior) = (0.008, prior());
        let of_data = DMatrix::from_diagonal_element(3, 3, 1.0 / (sd * sd));
        let mut seen = truth.clone();
        seen.apply(|x| *x += sd * Distribution::<f64>::sample(&StandardNormal, rng));
        let of_prior = precision(&prior.covariance).unwrap();
        let covariance = precision(&(&of_data + &of_prior)).unwrap();
        let metres = &covariance * (of_data * seen + of_prior * prior.metres);
        Lengths { metres, covariance }
    }

    fn oddest_of(trials: &[Lengths]) -> Option<Disagreement> {
        let trials: Vec<_> = trials.iter().cloned().enumerate().collect();
        oddest(&trials, &names())
    }

    #[test]
    fn trials_of_one_person_agree_and_one_of_another_is_named() {
        let mut rng = ChaCha8Rng::seed_from_u64(3);
        let person = DVector::from_vec(vec![0.45, 0.43, 0.32]);
        for _ in 0..200 {
            let same: Vec<Lengths> = (0..4).map(|_| trial(&person, &mut rng)).collect();
            assert_eq!(oddest_of(&same), None);
        }
        let other = DVector::from_vec(vec![0.38, 0.36, 0.27]);
        for k in 0..4 {
            let mut trials: Vec<Lengths> = (0..4).map(|_| trial(&person, &mut rng)).collect();
            trials[k] = trial(&other, &mut rng);
            let odd = oddest_of(&trials).unwrap();
            assert_eq!(odd.trial, k);
            assert!(odd.own_m < odd.others_m && odd.degrees == [3, 15], "{odd:?}");
        }
    }

    #[test]
    fn two_sessions_of_one_person_have_one_body_and_those_of_two_have_not() {
        let mut rng = ChaCha8Rng::seed_from_u64(5);
        let [person, other] =
            [vec![0.45, 0.43, 0.32], vec![0.38, 0.36, 0.27]].map(DVector::from_vec);
        let said = |a: Lengths, b: Lengths| one_of_two(&a, &b, &names());
        for _ in 0..200 {
            assert_eq!(said(trial(&person, &mut rng), trial(&person, &mut rng)), OneBody::Yes);
            let found = said(trial(&person, &mut rng), trial(&other, &mut rng));
            let OneBody::No(odd) = &found else { panic!("{found:?}") };
            assert!(odd.own_m < odd.others_m, "{odd:?}");
        }
    }

    /// Ten trials that err alike, in a direction of which each alone knows little: all data together with one prior would lie beyond
    /// all of them.
    #[test]
    fn what_draws_all_trials_alike_names_none() {
        let mut rng = ChaCha8Rng::seed_from_u64(4);
        let drawn = DVector::from_vec(vec![0.43, 0.42, 0.52]);
        let sd = DVector::from_vec(vec![0.008, 0.008, 0.04]);
        let of_data = DMatrix::from_diagonal(&sd.map(|sd| 1.0 / (sd * sd)));
        let prior = prior();
        let of_prior = precision(&prior.covariance).unwrap();
        let covariance = precision(&(&of_data + &of_prior)).unwrap();
        let mut trial = || {
            let noise =
                sd.map(|sd| 0.1 * sd * Distribution::<f64>::sample(&StandardNormal, &mut rng));
            let right = &of_data * (&drawn + noise) + &of_prior * &prior.metres;
            Lengths { metres: &covariance * right, covariance: covariance.clone() }
        };
        let trials: Vec<Lengths> = (0..10).map(|_| trial()).collect();
        assert_eq!(oddest_of(&trials), None);
    }

    #[test]
    fn the_mean_of_trials_weighs_each_by_what_it_knows() {
        let of = |metres: f64, sd: f64| Lengths {
            metres: DVector::from_element(1, metres),
            covariance: DMatrix::from_element(1, 1, sd * sd),
        };
        let mean = Mean::new(&[&of(0.40, 0.01), &of(0.46, 0.02)]).unwrap();
        approx::assert_relative_eq!(mean.lengths.metres[0], 0.412, max_relative = 1e-9);
        approx::assert_relative_eq!(mean.lengths.covariance[(0, 0)], 8e-5, max_relative = 1e-9);
        // 1.2 and 2.4 of their standard deviations
        approx::assert_relative_eq!(mean.squares, 7.2, max_relative = 1e-9);
    }

    /// Nine degrees of freedom say that errors are as stated; trials that vary less make a small difference a large one.
    #[test]
    fn trials_that_vary_little_name_a_difference_that_one_trial_would_not() {
        let of = |metres: f64| Lengths {
            metres: DVector::from_element(1, metres),
            covariance: DMatrix::from_element(1, 1, 1e-4),
        };
        let name = ["thigh".to_owned()];
        let against = |others: &[f64]| {
            let trials = std::iter::once(0.46).chain(others.iter().copied()).map(of);
            let trials: Vec<_> = trials.enumerate().collect();
            oddest(&trials, &name).map(|odd| (odd.trial, odd.degrees))
        };
        assert_eq!(against(&[0.42]), None);
        let alike = [0.42; 30];
        assert_eq!(against(&alike), Some((0, [1, 38])));
        let spread: Vec<f64> = (0..30).map(|i| if i % 2 == 0 { 0.40 } else { 0.44 }).collect();
        assert_eq!(against(&spread), None);
    }
}
