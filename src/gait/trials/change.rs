//! What changed from one session to another, and what change can be told from chance.
//!
//! A session's value is the mean of K trials. With s the standard deviation between trials and u the fit's, which one body and one
//! calibration give all its trials alike, its standard error of measurement is
//!
//! SEM² = s²/K + u².
//!
//! The change Δ = b − a has the variance SEM_a² + SEM_b² and, of ν degrees of freedom (Welch and Satterthwaite; u is taken to be
//! known), the 95 % interval Δ ± t₀.₉₇₅(ν)·√(SEM_a² + SEM_b²). The minimal detectable change, which a person who has not
//! changed exceeds once in twenty times, is
//!
//! MDC = 1.96·√(SEM_a² + SEM_b²), with s pooled over both sessions: 1.96·√2·SEM of two sessions alike.
//!
//! A session of one trial has no s of its own and is given that of the other; of two such sessions nothing is known.
//! **Differs** from tables of reliability studies: s and u are of this person in this laboratory, and not of a group.
//!
//! # Source
//! Weir 2005, *Quantifying test-retest reliability using the intraclass correlation coefficient and the SEM*, J Strength Cond Res 19(1); the degrees of
//! freedom: Welch 1947, *The generalization of 'Student's' problem*.

use std::collections::BTreeMap;

use statrs::distribution::{ContinuousCDF, StudentsT};

use super::measure::Measure;
use super::spread::Spread;

/// A number in two sessions.
#[derive(Debug, Clone, PartialEq)]
pub struct Change {
    /// Which.
    pub measure: Measure,
    /// The first session's.
    pub before: Spread,
    /// The second session's.
    pub after: Spread,
    /// Second less first.
    pub difference: f64,
    /// Its 95 % interval; `None` where no session has two trials.
    pub interval: Option<(f64, f64)>,
    /// MDC; as for the interval.
    pub detectable: Option<f64>,
}

impl Change {
    /// Whether it exceeds what a person who has not changed shows once in twenty times.
    pub fn is_detected(&self) -> bool {
        self.detectable.is_some_and(|least| self.difference.abs() > least)
    }
}

/// Beyond ± this a standard normal number lies once in twenty times.
pub(super) const ONCE_IN_TWENTY: f64 = 1.96;

/// Every number that both sessions have.
pub fn changes(
    before: &BTreeMap<Measure, Spread>,
    after: &BTreeMap<Measure, Spread>,
) -> Vec<Change> {
    let both = before.iter().filter_map(|(measure, a)| Some((*measure, a, after.get(measure)?)));
    both.map(|(measure, a, b)| change(measure, a, b)).collect()
}

fn change(measure: Measure, before: &Spread, after: &Spread) -> Change {
    let difference = after.mean - before.mean;
    let of_fit = before.fit.unwrap_or(0.0).powi(2) + after.fit.unwrap_or(0.0).powi(2);
    let each = [(before, after), (after, before)].map(|(own, other)| of_trials(own, other));
    let pooled = pooled_variance(before, after);

    let known: Option<Vec<OfTrials>> = each.into_iter().collect();
    let interval = known.and_then(|known| {
        let variance = of_fit + known.iter().map(|own| own.variance).sum::<f64>();
        let spent: f64 = known.iter().map(|own| own.variance.powi(2) / own.freedom).sum();
        interval(difference, variance, spent)
    });
    let detectable = pooled.map(|variance| {
        let of_means = variance / before.trials as f64 + variance / after.trials as f64;
        ONCE_IN_TWENTY * (of_means + of_fit).sqrt()
    });
    let (before, after) = (before.clone(), after.clone());
    Change { measure, before, after, difference, interval, detectable }
}

/// The 95 % interval of a difference of this variance; `spent` is Σ v²/ν over the parts v of it that trials tell (Satterthwaite).
pub(super) fn interval(difference: f64, variance: f64, spent: f64) -> Option<(f64, f64)> {
    let freedom = if spent > 0.0 { variance.powi(2) / spent } else { f64::INFINITY };
    let half = reach(freedom)? * variance.sqrt();
    Some((difference - half, difference + half))
}

/// t₀.₉₇₅(ν): of many degrees of freedom by its expansion in 1/ν (Abramowitz & Stegun 26.7.5), right to 10⁻⁴ there.
fn reach(freedom: f64) -> Option<f64> {
    if freedom < 30.0 {
        return Some(StudentsT::new(0.0, 1.0, freedom).ok()?.inverse_cdf(0.975));
    }
    let z: f64 = 1.959_964;
    let (first, second) = (z.powi(3) + z, 5.0 * z.powi(5) + 16.0 * z.powi(3) + 3.0 * z);
    Some(z + first / (4.0 * freedom) + second / (96.0 * freedom.powi(2)))
}

/// What trials say of the variance of a session's mean.
struct OfTrials {
    /// s²/K.
    variance: f64,
    /// Of s.
    freedom: f64,
}

/// `None` where neither session has two trials.
fn of_trials(own: &Spread, other: &Spread) -> Option<OfTrials> {
    let source = if own.between_trials.is_some() { own } else { other };
    let variance = source.between_trials?.powi(2) / own.trials as f64;
    Some(OfTrials { variance, freedom: source.trials as f64 - 1.0 })
}

/// s² over both sessions.
fn pooled_variance(before: &Spread, after: &Spread) -> Option<f64> {
    let known = || [before, after].into_iter().filter(|own| own.between_trials.is_some());
    let freedom: f64 = known().map(|own| own.trials as f64 - 1.0).sum();
    let squares = known()
        .map(|own| (own.trials as f64 - 1.0) * own.between_trials.map_or(0.0, |s| s.powi(2)));
    (freedom > 0.0).then(|| squares.sum::<f64>() / freedom)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::gait::trials::Quantity;
    use crate::gait::{Parameter, Side};
    use rand::SeedableRng;
    use rand_chacha::ChaCha8Rng;
    use rand_distr::{Distribution, StandardNormal};

    fn spread(values: &[f64], fit: Option<f64>) -> Spread {
        let (mean, between_trials) = crate::math::stats::mean_and_sd(values).unwrap();
        Spread {
            mean,
            values: values.iter().copied().map(Some).collect(),
            trials: values.len(),
            strides: values.len(),
            between_strides: None,
            between_trials,
            fit,
        }
    }

    fn found(before: &Spread, after: &Spread) -> Change {
        let measure = Measure { quantity: Quantity::Parameter(Parameter::Speed), side: Side::Left };
        change(measure, before, after)
    }

    #[test]
    fn the_minimal_detectable_change_of_two_sessions_alike_is_that_of_weir() {
        let a = spread(&[1.0, 1.2, 1.4, 1.2], None);
        let change = found(&a, &a);
        let sem = a.between_trials.unwrap() / 2.0;
        approx::assert_relative_eq!(
            change.detectable.unwrap(),
            1.96 * 2.0_f64.sqrt() * sem,
            max_relative = 1e-12
        );
        // the interval of two times three degrees of freedom: t = 2.447
        let (low, high) = change.interval.unwrap();
        approx::assert_relative_eq!(
            high - low,
            2.0 * 2.4469 * 2.0_f64.sqrt() * sem,
            max_relative = 1e-4
        );
        assert!(!change.is_detected());
    }

    #[test]
    fn the_quantile_is_that_of_the_tables_whatever_the_degrees_of_freedom() {
        for (freedom, expected) in [
            (1.0, 12.706),
            (4.0, 2.7764),
            (29.9, 2.0426),
            (30.0, 2.0423),
            (120.0, 1.9799),
            (f64::INFINITY, 1.95996),
        ] {
            approx::assert_relative_eq!(reach(freedom).unwrap(), expected, max_relative = 1e-4);
        }
    }

    #[test]
    fn one_trial_takes_the_spread_of_the_other_session_and_two_have_none() {
        let (one, many) = (spread(&[1.0], Some(0.01)), spread(&[1.2, 1.3, 1.4], Some(0.01)));
        let change = found(&one, &many);
        assert!(change.interval.is_some() && change.detectable.is_some());
        let change = found(&one, &spread(&[1.1], Some(0.01)));
        assert_eq!((change.interval, change.detectable), (None, None));
    }

    #[test]
    fn the_interval_holds_the_true_change_nineteen_times_in_twenty() {
        let mut rng = ChaCha8Rng::seed_from_u64(11);
        let mut normal =
            |sd: f64| -> f64 { sd * Distribution::<f64>::sample(&StandardNormal, &mut rng) };
        let (truth, mut held, all) = (0.05, 0, 2000);
        for _ in 0..all {
            // what the fit errs is the same in every trial of a session
            let mut session = |mean: f64, trials: usize| {
                let common = normal(0.02);
                let values: Vec<f64> = (0..trials).map(|_| mean + common + normal(0.05)).collect();
                spread(&values, Some(0.02))
            };
            let (low, high) = found(&session(1.2, 5), &session(1.2 + truth, 3)).interval.unwrap();
            held += usize::from((low..=high).contains(&truth));
        }
        // 4 standard deviations of a share of 0.95 of 2000, and Welch's approximation
        let share = held as f64 / f64::from(all);
        assert!((0.93..=0.975).contains(&share), "{share}");
    }
}
