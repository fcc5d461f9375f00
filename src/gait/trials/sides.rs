//! How the right side differs from the left in the trials of one session.
//!
//! In trial k the sides differ by dₖ = right − left. What is the same in both, the speed of the walk above all, is not in dₖ. With d̄ and
//! s the mean and standard deviation of K of them, SEM² = s²/K: the 95 % interval is d̄ ± t₀.₉₇₅(K − 1)·SEM, and the sides of a person
//! who walks evenly differ by more than 1.96·SEM once in twenty times.
//!
//! No standard deviation of the fit is added. Both sides of the body have the same lengths, the same places of joints and the same
//! surface, so what it has wrong of a person whose sides are alike is the same on both. **Differs** where they are not: half of a difference
//! between the legs' own lengths is taken for motion of each.

use std::collections::BTreeMap;

use super::change::{Change, ONCE_IN_TWENTY, reach};
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
    let sem = sd.map(|sd| sd / count.sqrt());
    let interval = sem.and_then(|sem| {
        let half = reach(count - 1.0)? * sem;
        Some((difference - half, difference + half))
    });
    let detectable = sem.map(|sem| ONCE_IN_TWENTY * sem);
    Some(Change { measure, before, after, difference, interval, detectable })
}

/// A side in the trials that have both, without what the fit has alike on both.
fn in_trials_of(own: &Spread, other: &Spread) -> Option<Spread> {
    let trials = own.values.iter().zip(&other.values);
    let values: Vec<Option<f64>> = trials.map(|(own, other)| other.and(*own)).collect();
    let known: Vec<f64> = values.iter().flatten().copied().collect();
    let (mean, between_trials) = mean_and_sd(&known)?;
    Some(Spread { mean, values, trials: known.len(), between_trials, fit: None, ..own.clone() })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::gait::Parameter;
    use crate::gait::trials::Quantity;

    fn session(left: &[Option<f64>], right: &[Option<f64>]) -> BTreeMap<Measure, Spread> {
        let of = |side: Side, values: &[Option<f64>]| {
            let measure = Measure { quantity: Quantity::Parameter(Parameter::StepLength), side };
            let spread = Spread {
                mean: f64::NAN,
                values: values.to_vec(),
                trials: values.iter().flatten().count(),
                strides: 8,
                between_strides: None,
                between_trials: None,
                fit: Some(0.1),
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
        let found = side_differences(&session(&left, &right));
        let [change] = found.as_slice() else { panic!("{found:?}") };
        approx::assert_relative_eq!(change.difference, 0.05, epsilon = 1e-12);
        approx::assert_relative_eq!(change.before.mean, 0.65, epsilon = 1e-12);

        // s = 0.01·√(4/3), t of three degrees of freedom 3.182
        let sem = 0.01 * (4.0_f64 / 3.0).sqrt() / 2.0;
        let (low, high) = change.interval.unwrap();
        approx::assert_relative_eq!(high - low, 2.0 * 3.1824 * sem, max_relative = 1e-4);
        approx::assert_relative_eq!(change.detectable.unwrap(), 1.96 * sem, max_relative = 1e-12);
        assert!(change.is_detected() && change.before.fit.is_none());
    }

    #[test]
    fn a_trial_of_one_side_is_left_out_and_one_trial_says_nothing_of_chance() {
        let left = [Some(0.5), None, Some(0.6)];
        let right = [Some(0.5), Some(9.0), None];
        let found = side_differences(&session(&left, &right));
        let [change] = found.as_slice() else { panic!("{found:?}") };
        assert_eq!((change.difference, change.after.mean), (0.0, 0.5));
        assert_eq!((change.interval, change.detectable), (None, None));
        assert!(side_differences(&session(&left, &[None, Some(1.0), None])).is_empty());
    }
}
