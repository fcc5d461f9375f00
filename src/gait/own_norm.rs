//! A norm of one's own: mean and standard deviation between people.
//!
//! A person's curve is the mean over both sides of the mean over their trials of a trial's mean curve, at every second percent of the
//! cycle; a parameter likewise. So a person counts once, however many trials and strides they have.

use std::collections::BTreeMap;

use super::GaitAnalysis;
use super::angle::Angle;
use super::curves::POINTS;
use super::indices::{Band, SCORE_POINTS};
use super::landmark::Side;
use super::parameters::Parameter;
use crate::math::stats::{mean, mean_and_sd};

/// Of fewer people no standard deviation between people is told.
pub const LEAST_PEOPLE: usize = 3;

/// What several people have in common.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct OfPeople {
    /// Every angle that [`LEAST_PEOPLE`] have, and how many have it; radians.
    pub curves: BTreeMap<Angle, (Band, usize)>,
    /// Mean, standard deviation and number of people of each parameter that as many have.
    pub parameters: BTreeMap<Parameter, (f64, f64, usize)>,
}

/// Mean and standard deviation between people, each of whom has one trial or more.
pub fn of_people(people: &[Vec<&GaitAnalysis>]) -> OfPeople {
    let mut found = OfPeople::default();
    for angle in Angle::ALL {
        let curves: Vec<Vec<f64>> = people.iter().filter_map(|own| curve(own, angle)).collect();
        if curves.len() >= LEAST_PEOPLE {
            found.curves.insert(angle, (band(&curves), curves.len()));
        }
    }
    for parameter in Parameter::ALL {
        let values: Vec<f64> = people.iter().filter_map(|own| value(own, parameter)).collect();
        if values.len() >= LEAST_PEOPLE
            && let Some((mean, Some(sd))) = mean_and_sd(&values)
        {
            found.parameters.insert(parameter, (mean, sd, values.len()));
        }
    }
    found
}

/// Mean over the sides of the mean over trials; `None` where nothing is known.
fn both_sides(of: impl Fn(Side) -> Option<f64>) -> Option<f64> {
    mean(Side::BOTH.into_iter().filter_map(of))
}

fn curve(trials: &[&GaitAnalysis], angle: Angle) -> Option<Vec<f64>> {
    let step = (POINTS - 1) / (SCORE_POINTS - 1);
    let at = |place: usize| {
        both_sides(|side| {
            let own = trials.iter().flat_map(|gait| &gait.curves);
            let own = own.filter(|c| c.angle == angle && c.side == side);
            mean(own.map(|c| c.mean[place * step]))
        })
    };
    let values: Option<Vec<f64>> = (0..SCORE_POINTS).map(at).collect();
    values.filter(|values| values.iter().all(|v| v.is_finite()))
}

fn value(trials: &[&GaitAnalysis], parameter: Parameter) -> Option<f64> {
    let of = |side| {
        let own = trials.iter().filter_map(|gait| gait.parameters.get(&(parameter, side)));
        mean(own.map(|statistic| statistic.mean))
    };
    both_sides(of).filter(|value| value.is_finite())
}

fn band(curves: &[Vec<f64>]) -> Band {
    let at = |place: usize| {
        let values: Vec<f64> = curves.iter().map(|curve| curve[place]).collect();
        let (mean, sd) = mean_and_sd(&values).unwrap_or((f64::NAN, None));
        (mean, sd.unwrap_or(f64::NAN))
    };
    let (mean, sd) = (0..SCORE_POINTS).map(at).unzip();
    Band { mean, sd }
}
