//! How far a number varies between strides and between trials, and how sure the fit is of it.
//!
//! | standard deviation | says                                                                                     |
//! |--------------------|------------------------------------------------------------------------------------------|
//! | between strides    | how evenly the person walks: √(Σ(nₖ − 1)sₖ²/Σ(nₖ − 1)) over the strides within each trial   |
//! | between trials     | how well the same walk is found again: of the trials' values                              |
//! | of the fit, u      | how far the measurement may be off in the same way in every trial: mean of the trials' u     |

use std::collections::BTreeMap;

use super::measure::{Measure, Measured};
use crate::math::stats::{mean, mean_and_sd};

/// A number of a session.
#[derive(Debug, Clone, PartialEq)]
pub struct Spread {
    /// Mean of the trials' values.
    pub mean: f64,
    /// Trial by trial, in their order; `None` where it has none.
    pub values: Vec<Option<f64>>,
    /// Number of trials that have it.
    pub trials: usize,
    /// Number of all strides.
    pub strides: usize,
    /// Between strides of one trial; of two strides or more.
    pub between_strides: Option<f64>,
    /// Between trials; of two trials or more.
    pub between_trials: Option<f64>,
    /// Of the fit, u.
    pub fit: Option<f64>,
}

/// Every number of a session, from those of its trials.
pub fn spreads(trials: &[Vec<(Measure, Measured)>]) -> BTreeMap<Measure, Spread> {
    let mut all: BTreeMap<Measure, Vec<Option<Measured>>> = BTreeMap::new();
    for (k, trial) in trials.iter().enumerate() {
        for (measure, measured) in trial {
            let own = all.entry(*measure).or_insert_with(|| vec![None; trials.len()]);
            own[k] = Some(*measured);
        }
    }
    all.into_iter().filter_map(|(measure, own)| Some((measure, spread(&own)?))).collect()
}

fn spread(trials: &[Option<Measured>]) -> Option<Spread> {
    let known = || trials.iter().flatten();
    let values: Vec<f64> = known().map(|trial| trial.value).collect();
    let (average, between_trials) = mean_and_sd(&values)?;
    let freedom = |trial: &Measured| trial.strides.saturating_sub(1) as f64;
    let squares: f64 =
        known().filter_map(|trial| Some(freedom(trial) * trial.strides_sd?.powi(2))).sum();
    let all: f64 = known().filter(|trial| trial.strides_sd.is_some()).map(freedom).sum();
    Some(Spread {
        mean: average,
        values: trials.iter().map(|trial| trial.map(|t| t.value)).collect(),
        trials: values.len(),
        strides: known().map(|trial| trial.strides).sum(),
        between_strides: (all > 0.0).then(|| (squares / all).sqrt()),
        between_trials,
        fit: mean(known().filter_map(|trial| trial.fit_sd)),
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::gait::trials::Quantity;
    use crate::gait::{Parameter, Side};

    #[test]
    fn the_three_standard_deviations_are_three() {
        let speed = Measure { quantity: Quantity::Parameter(Parameter::Speed), side: Side::Left };
        let trial = |value, strides, strides_sd| {
            vec![(speed, Measured { value, strides, strides_sd, fit_sd: Some(0.02) })]
        };
        let trials =
            [trial(1.2, 3, Some(0.01)), trial(1.4, 2, Some(0.04)), trial(1.3, 1, None), Vec::new()];
        let found = &spreads(&trials)[&speed];
        approx::assert_relative_eq!(found.mean, 1.3, epsilon = 1e-12);
        approx::assert_relative_eq!(found.between_trials.unwrap(), 0.1, epsilon = 1e-12);
        let within = ((2.0 * 1e-4 + 16e-4) / 3.0_f64).sqrt();
        approx::assert_relative_eq!(found.between_strides.unwrap(), within, epsilon = 1e-12);
        assert_eq!((found.trials, found.strides, found.fit), (3, 6, Some(0.02)));
        assert_eq!(found.values[3], None);
    }
}
