//! How the right side differs from the left in the trials of one session.
//!
//! In trial k the sides differ by dₖ = right − left. What is the same in both, the speed of the walk above all, is not in dₖ. With d̄ and
//! s the mean and standard deviation of K of them, and u the fit's own of each side,
//!
//! SEM² = s²/K + u_left² + u_right²,
//!
//! the 95 % interval is d̄ ± t₀.₉₇₅(ν)·SEM, ν by Satterthwaite, u taken to be known, and the sides of a person who walks evenly
//! differ by more than 1.96·SEM once in twenty times.
//!
//! The body has the same lengths, places of joints and surface on both sides, so most of u cancels in a difference and the interval is
//! too wide; but what the cameras see of one side and not of the other does not cancel, and stays the same in all trials. Of five
//! simulated walks of one person, 16 of 25 intervals without u hold the true difference, and 24 with it. Nor are whole curves tested: by
//! chance between trials alone, 11 of 16 of them would differ.

use std::collections::BTreeMap;

use super::change::{Change, ONCE_IN_TWENTY, interval};
use super::measure::Measure;
use super::spread::Spread;
use crate::gait::Side;
use crate::math::stats::mean_and_sd;

/// What is compared with what.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Sides {
    /// Each side with the same side of another session.
    Same,
    /// The right side with the left one of the same trials.
    Opposite,
}

impl Sides {
    /// The name in files of the side of a number.
    pub fn name(self, side: Side) -> &'static str {
        match self {
            Self::Same => side.name(),
            Self::Opposite => "both",
        }
    }
}

/// Right less left, of every number that trials of a session have of both sides; `before` is the left side.
pub fn side_differences(session: &BTreeMap<Measure, Spread>) -> Vec<Change> {
    let right = session.iter().filter(|(measure, _)| measure.side == Side::Right);
    let difference = |(measure, right): (&Measure, &Spread)| {
        let left = session.get(&Measure { side: Side::Left, ..*measure })?;
        difference(*measure, left, right)
    };
    right.filter_map(difference).collect()
}

fn difference(measure: Measure, left: &Spread, right: &Spread) -> Option<Change> {
    let (before, after) = (in_trials_of(left, right)?, in_trials_of(right, left)?);
    let trials = before.values.iter().zip(&after.values);
    let differences: Vec<f64> =
        trials.filter_map(|(left, right)| Some((*right)? - (*left)?)).collect();

    let (difference, sd) = mean_and_sd(&differences)?;
    let count = differences.len() as f64;
    let of_fit = [left, right].map(|side| side.fit.unwrap_or(0.0).powi(2)).iter().sum::<f64>();
    let known = sd.map(|sd| sd * sd / count).map(|of_trials| (of_trials, of_trials + of_fit));
    let interval = known.and_then(|(of_trials, variance)| {
        interval(difference, variance, of_trials.powi(2) / (count - 1.0))
    });
    let detectable = known.map(|(_, variance)| ONCE_IN_TWENTY * variance.sqrt());
    Some(Change { measure, before, after, difference, interval, detectable })
}

/// A side in the trials that have both.
fn in_trials_of(own: &Spread, other: &Spread) -> Option<Spread> {
    let trials = own.values.iter().zip(&other.values);
    let values: Vec<Option<f64>> = trials.map(|(own, other)| other.and(*own)).collect();
    let known: Vec<f64> = values.iter().flatten().copied().collect();
    let (mean, between_trials) = mean_and_sd(&known)?;
    Some(Spread { mean, values, trials: known.len(), between_trials, ..own.clone() })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::gait::Parameter;
    use crate::gait::trials::Quantity;

    fn session(
        left: &[Option<f64>],
        right: &[Option<f64>],
        fit: Option<f64>,
    ) -> BTreeMap<Measure, Spread> {
        let of = |side: Side, values: &[Option<f64>]| {
            let measure = Measure { quantity: Quantity::Parameter(Parameter::StepLength), side };
            let spread = Spread {
                mean: f64::NAN,
                values: values.to_vec(),
                trials: values.iter().flatten().count(),
                strides: 8,
                between_strides: None,
                between_trials: None,
                fit,
            };
            (measure, spread)
        };
        BTreeMap::from([of(Side::Left, left), of(Side::Right, right)])
    }

    #[test]
    fn what_both_sides_share_in_a_trial_does_not_hide_how_they_differ() {
        // speeds from trial to trial by far more than the sides differ
        let left = [0.5, 0.7, 0.6, 0.8].map(Some);
        let right = [0.54, 0.76, 0.66, 0.84].map(Some);
        let found = side_differences(&session(&left, &right, None));
        let [change] = found.as_slice() else { panic!("{found:?}") };
        approx::assert_relative_eq!(change.difference, 0.05, epsilon = 1e-12);
        approx::assert_relative_eq!(change.before.mean, 0.65, epsilon = 1e-12);

        // s = 0.01·√(4/3), t of three degrees of freedom 3.182
        let sem = 0.01 * (4.0_f64 / 3.0).sqrt() / 2.0;
        let (low, high) = change.interval.unwrap();
        approx::assert_relative_eq!(high - low, 2.0 * 3.1824 * sem, max_relative = 1e-4);
        approx::assert_relative_eq!(change.detectable.unwrap(), 1.96 * sem, max_relative = 1e-12);
        assert!(change.is_detected());
    }

    #[test]
    fn what_the_fit_does_not_know_of_each_side_widens_the_interval() {
        let (left, right) = ([0.5, 0.7, 0.6].map(Some), [0.54, 0.76, 0.65].map(Some));
        let found = side_differences(&session(&left, &right, Some(0.03)));
        let [change] = found.as_slice() else { panic!("{found:?}") };
        // s = 0.01, K = 3: far less than u, whose degrees of freedom are many
        let sem = (1e-4 / 3.0 + 2.0 * 9e-4_f64).sqrt();
        approx::assert_relative_eq!(change.detectable.unwrap(), 1.96 * sem, max_relative = 1e-9);
        let (low, high) = change.interval.unwrap();
        approx::assert_relative_eq!(high - low, 2.0 * 1.96 * sem, max_relative = 1e-3);
        assert!(!change.is_detected());
    }

    #[test]
    fn sides_that_differ_by_the_same_in_every_trial_have_an_interval_of_no_width() {
        let (left, right) = ([0.5, 0.75].map(Some), [0.75, 1.0].map(Some));
        let found = side_differences(&session(&left, &right, None));
        assert_eq!(found[0].interval, Some((0.25, 0.25)));
    }

    #[test]
    fn a_trial_of_one_side_is_left_out_and_one_trial_says_nothing_of_chance() {
        let left = [Some(0.5), None, Some(0.6)];
        let right = [Some(0.5), Some(9.0), None];
        let found = side_differences(&session(&left, &right, None));
        let [change] = found.as_slice() else { panic!("{found:?}") };
        assert_eq!((change.difference, change.after.mean), (0.0, 0.5));
        assert_eq!((change.interval, change.detectable), (None, None));
        assert!(side_differences(&session(&left, &[None, Some(1.0), None], None)).is_empty());
    }
}
