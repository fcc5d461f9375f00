//! Whether all trials are of one person, and two sessions: by their lengths.
//!
//! Trial k alone found the lengths ℓₖ at rest with the covariance Cₖ = J Σₖ Jᵀ, J their slopes with respect to the shape. All trials
//! together find ℓ̄ with C̄, the prior (ℓ₀, C₀) counted once:
//!
//! C̄⁻¹ = Σ Cₖ⁻¹ − (K − 1) C₀⁻¹,  ℓ̄ = C̄ (Σ Cₖ⁻¹ ℓₖ − (K − 1) C₀⁻¹ ℓ₀).
//!
//! Of one person, ℓ̄ is ℓₖ with more known, so ℓₖ − ℓ̄ has the covariance Cₖ − C̄ and
//!
//! χ² = (ℓₖ − ℓ̄)ᵀ (w²(Cₖ − C̄))⁻¹ (ℓₖ − ℓ̄)
//!
//! is χ²-distributed with as many degrees of freedom as there are directions in which C̄ is less than Cₖ. w = 1.5 widens the standard
//! deviations: 95 % intervals of lengths hold 81 to 90 % of the truths (docs/results.md). The trial of the largest χ² is
//! named if its probability is below 1/1000 and a length differs by more than 3 %; the others are tested again without it.
//!
//! # Source
//! The covariance of a difference between an estimate and one with more data: Hausman 1978, *Specification tests in econometrics*.

use nalgebra::{DMatrix, DVector, SymmetricEigen};
use statrs::distribution::{ChiSquared, ContinuousCDF};

use super::SessionTrial;
use crate::body::{BodyModel, Shape};
use crate::inference::covariance::lengths_slopes;

/// A trial whose lengths are not those of the others.
#[derive(Debug, Clone, PartialEq)]
pub struct Disagreement {
    /// Its position among the trials.
    pub trial: usize,
    /// χ².
    pub chi_square: f64,
    /// Degrees of freedom.
    pub degrees: usize,
    /// The probability of such a χ² and larger ones, if it is the same person.
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

/// w.
const WIDER: f64 = 1.5;
/// A disagreement is less probable than this if all trials are of one person.
const IMPROBABLE: f64 = 1e-3;
/// And a length differs by more than this share of it.
const LEAST_SHARE: f64 = 0.03;
/// Directions in which less is known than this part of the largest are rounding.
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
    let prior = Lengths::of_prior(&body);
    let known = trials.iter().enumerate().filter_map(|(k, trial)| {
        let alone = &trial.alone;
        Some((k, Lengths::new(&body, &alone.shape, alone.covariance.as_ref()?)))
    });

    let mut left: Vec<(usize, Lengths)> = known.collect();
    let names = names(&body);
    let mut found = Vec::new();
    while let Some(odd) = oddest(&left, &prior, &names) {
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
    one_of_two(before, after, &Lengths::of_prior(body), &names(body))
}

fn one_of_two(before: Lengths, after: Lengths, prior: &Lengths, names: &[String]) -> OneBody {
    let both = [(0, before), (1, after)];
    let tested = || {
        let all = pooled(&both, prior)?;
        test(1, &both[1].1, &all, &both[0].1, names)
    };
    match tested() {
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

    fn of_prior(body: &BodyModel) -> Self {
        let prior = &body.statistics;
        Self::new(body, &Shape(prior.mean.clone()), &prior.covariance)
    }
}

impl Disagreement {
    /// Whether it is beyond chance, and more than a fold of cloth.
    fn is_sure(&self) -> bool {
        let share = (self.own_m / self.others_m - 1.0).abs();
        self.probability < IMPROBABLE && share > LEAST_SHARE
    }
}

/// The trial of the largest χ², if it is not of the person of the others.
fn oddest(trials: &[(usize, Lengths)], prior: &Lengths, names: &[String]) -> Option<Disagreement> {
    if trials.len() < 2 {
        return None;
    }
    let all = pooled(trials, prior)?;
    let tested = trials.iter().filter_map(|(k, own)| {
        let rest: Vec<_> = trials.iter().filter(|(other, _)| other != k).cloned().collect();
        let others = pooled(&rest, prior)?;
        test(*k, own, &all, &others, names)
    });
    let oddest = tested.max_by(|a, b| a.chi_square.total_cmp(&b.chi_square));
    oddest.filter(Disagreement::is_sure)
}

/// ℓ̄ and C̄; `None` where a covariance has no inverse.
fn pooled(trials: &[(usize, Lengths)], prior: &Lengths) -> Option<Lengths> {
    let times = trials.len() as f64 - 1.0;
    let of_prior = precision(&prior.covariance)?;
    let mut all = &of_prior * -times;
    let mut right = &of_prior * &prior.metres * -times;
    for (_, own) in trials {
        let precision = precision(&own.covariance)?;
        right += &precision * &own.metres;
        all += precision;
    }
    let covariance = precision(&all)?;
    Some(Lengths { metres: &covariance * right, covariance })
}

/// The inverse of a symmetric matrix, over the directions that are more than rounding.
fn precision(covariance: &DMatrix<f64>) -> Option<DMatrix<f64>> {
    let mut eigen = SymmetricEigen::new(0.5 * (covariance + covariance.transpose()));
    let floor = 1e-9 * eigen.eigenvalues.amax();
    let is_usable = floor.is_finite() && floor > 0.0;
    eigen.eigenvalues.apply(|value| *value = 1.0 / value.max(floor));
    is_usable.then(|| eigen.recompose())
}

/// χ² of a trial, and the length by which it differs most from the others.
fn test(
    trial: usize,
    own: &Lengths,
    all: &Lengths,
    others: &Lengths,
    names: &[String],
) -> Option<Disagreement> {
    let difference = &own.metres - &all.metres;
    let less = (&own.covariance - &all.covariance) * WIDER.powi(2);
    let eigen = SymmetricEigen::new(0.5 * (&less + less.transpose()));
    let least = ROUNDING * eigen.eigenvalues.amax();
    let along = eigen.eigenvectors.tr_mul(&difference);
    let known = (0..along.len()).filter(|k| eigen.eigenvalues[*k] > least);
    let squares: Vec<f64> = known.map(|k| along[k].powi(2) / eigen.eigenvalues[k]).collect();

    let (chi_square, degrees) = (squares.iter().sum::<f64>(), squares.len());
    let probability = ChiSquared::new(degrees as f64).ok()?.sf(chi_square);
    let by_sd = |k: &usize| difference[*k].abs() / less[(*k, *k)].max(least).sqrt();
    let length = (0..names.len()).max_by(|a, b| by_sd(a).total_cmp(&by_sd(b)))?;
    Some(Disagreement {
        trial,
        chi_square,
        degrees,
        probability,
        length: names[length].clone(),
        own_m: own.metres[length],
        others_m: others.metres[length],
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
        oddest(&trials, &prior(), &names())
    }

    #[test]
    fn trials_of_one_person_agree_and_one_of_another_is_named() {
        let mut rng = ChaCha8Rng::seed_from_u64(3);
        let person = DVector::from_vec(vec![0.45, 0.43, 0.32]);
        for _ in 0..200 {
            // the widened χ² is beyond 1/1000 of its own once in 10⁸ times
            let same: Vec<Lengths> = (0..4).map(|_| trial(&person, &mut rng)).collect();
            assert_eq!(oddest_of(&same), None);
        }
        let other = DVector::from_vec(vec![0.38, 0.36, 0.27]);
        for k in 0..4 {
            let mut trials: Vec<Lengths> = (0..4).map(|_| trial(&person, &mut rng)).collect();
            trials[k] = trial(&other, &mut rng);
            let odd = oddest_of(&trials).unwrap();
            assert_eq!(odd.trial, k);
            assert!(odd.own_m < odd.others_m && odd.degrees == 3, "{odd:?}");
        }
    }

    #[test]
    fn two_sessions_of_one_person_have_one_body_and_those_of_two_have_not() {
        let mut rng = ChaCha8Rng::seed_from_u64(5);
        let [person, other] =
            [vec![0.45, 0.43, 0.32], vec![0.38, 0.36, 0.27]].map(DVector::from_vec);
        let said = |a: Lengths, b: Lengths| one_of_two(a, b, &prior(), &names());
        for _ in 0..200 {
            // the widened χ² is beyond 1/1000 of its own once in 10⁸ times
            assert_eq!(said(trial(&person, &mut rng), trial(&person, &mut rng)), OneBody::Yes);
            let found = said(trial(&person, &mut rng), trial(&other, &mut rng));
            let OneBody::No(odd) = &found else { panic!("{found:?}") };
            assert!(odd.own_m < odd.others_m, "{odd:?}");
        }
    }

    #[test]
    fn all_together_are_one_measurement_with_the_prior_once() {
        let mut rng = ChaCha8Rng::seed_from_u64(4);
        let person = DVector::from_vec(vec![0.45, 0.43, 0.32]);
        let trials: Vec<_> = (0..3).map(|k| (k, trial(&person, &mut rng))).collect();
        let all = pooled(&trials, &prior()).unwrap();
        let of_data = DMatrix::from_diagonal_element(3, 3, 3.0 / 0.008_f64.powi(2));
        let expected = precision(&(of_data + precision(&prior().covariance).unwrap())).unwrap();
        approx::assert_relative_eq!(all.covariance, expected, max_relative = 1e-6);
        let one = pooled(&trials[..1], &prior()).unwrap();
        approx::assert_relative_eq!(one.metres, trials[0].1.metres, max_relative = 1e-6);
    }
}
