//! The strides of several trials, as if of one.

use std::collections::BTreeMap;

use crate::gait::curves::{Curve, mean_curve};
use crate::gait::parameters::{Parameters, Statistic};
use crate::gait::{Angle, EventSource, GaitAnalysis, Side};
use crate::math::stats::{mean, mean_and_sd};

/// A trial's analysis and its name.
#[derive(Debug, Clone, Copy)]
pub struct NamedTrial<'a> {
    /// Its name.
    pub name: &'a str,
    /// Its analysis.
    pub gait: &'a GaitAnalysis,
}

/// All strides of all trials; `None` of no trial.
///
/// Means are over strides: a trial of more strides counts more. The uncertainty of a value and the fit's standard deviation do not
/// become smaller with more trials, which one body and one calibration measure. Notes begin with the name of their trial. Events and
/// angles over time are those of no trial and absent.
pub fn pooled(trials: &[NamedTrial<'_>]) -> Option<GaitAnalysis> {
    let first = trials.first()?.gait;
    let noted = trials
        .iter()
        .flat_map(|trial| trial.gait.notes.iter().map(|note| format!("{}: {note}", trial.name)));
    Some(GaitAnalysis {
        cutoff_hz: first.cutoff_hz,
        course: first.course.clone(),
        leg_length_m: mean(trials.iter().filter_map(|trial| trial.gait.leg_length_m)),
        events: Vec::new(),
        event_source: source(trials),
        agreement: Vec::new(),
        cycles: trials.iter().flat_map(|trial| trial.gait.cycles.clone()).collect(),
        parameters: parameters(trials),
        angles: BTreeMap::new(),
        curves: curves(trials),
        neutral: first.neutral.clone(),
        unknown: first.unknown.clone(),
        notes: noted.collect(),
    })
}

/// A person, if one has corrected the events of any trial.
fn source(trials: &[NamedTrial<'_>]) -> EventSource {
    let is_corrected = |trial: &NamedTrial<'_>| trial.gait.event_source == EventSource::Person;
    match trials.iter().any(is_corrected) {
        true => EventSource::Person,
        false => EventSource::Detected,
    }
}

fn parameters(trials: &[NamedTrial<'_>]) -> Parameters {
    let mut all: BTreeMap<_, Vec<&Statistic>> = BTreeMap::new();
    for (key, statistic) in trials.iter().flat_map(|trial| &trial.gait.parameters) {
        all.entry(*key).or_default().push(statistic);
    }
    let together = |own: Vec<&Statistic>| {
        let values: Vec<f64> = own.iter().flat_map(|s| s.values.iter().copied()).collect();
        let (mean_value, sd) = mean_and_sd(&values)?;
        let uncertainty = mean(own.iter().filter_map(|s| s.uncertainty));
        Some(Statistic { n: values.len(), mean: mean_value, sd, uncertainty, values })
    };
    all.into_iter().filter_map(|(key, own)| Some((key, together(own)?))).collect()
}

fn curves(trials: &[NamedTrial<'_>]) -> Vec<Curve> {
    let mut all: BTreeMap<(Side, Angle), Vec<&Curve>> = BTreeMap::new();
    for curve in trials.iter().flat_map(|trial| &trial.gait.curves) {
        all.entry((curve.side, curve.angle)).or_default().push(curve);
    }
    let together = |((side, angle), own): ((Side, Angle), Vec<&Curve>)| {
        let strides: Vec<Vec<f64>> = own.iter().flat_map(|curve| curve.strides.clone()).collect();
        let (average, sd) = mean_curve(&strides)?;
        let known: Vec<Vec<f64>> = own.iter().filter_map(|curve| curve.fit_sd.clone()).collect();
        let offs = own.iter().flat_map(|c| std::iter::repeat_n(c.foot_off, c.strides.len()));
        Some(Curve {
            angle,
            side,
            mean: average,
            sd,
            fit_sd: mean_curve(&known).map(|(sd, _)| sd),
            foot_off: mean(offs)?,
            is_joined: own.iter().any(|curve| curve.is_joined),
            strides,
        })
    };
    all.into_iter().filter_map(together).collect()
}
