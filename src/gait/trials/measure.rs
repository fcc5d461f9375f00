//! The numbers of a walk that are told of trials and compared between sessions.
//!
//! | number              | value of a trial                                   | u, the fit's own standard deviation                    |
//! |---------------------|----------------------------------------------------|--------------------------------------------------------|
//! | a parameter         | mean over its strides                              | the uncertainty of one value (docs/gait.md)             |
//! | an angle's range    | greatest less least of its mean curve              | not known: what the angle is off by in every frame, most of its SD, cancels |
//! | a Gait Variable Score | against the norm                                 | that of the angle, mean over the cycle: an offset moves the score by no more |
//! | Gait Profile Score  | root mean square of V scores                       | √Σ(GVS·u)²/(V·GPS), for variables that err by themselves |
//! | the same without offsets | likewise                                      | not known, as of a range |

use crate::gait::{Angle, Curve, GaitAnalysis, Norm, Parameter, Side, VARIABLES, indices};
use crate::math::stats::{mean, mean_and_sd};

/// What is measured.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum Quantity {
    /// Of steps and strides.
    Parameter(Parameter),
    /// How far an angle moves, degrees.
    Range(Angle),
    /// Gait Variable Score, degrees.
    VariableScore(Angle),
    /// Gait Profile Score of a side, degrees.
    ProfileScore,
    /// The same without the offsets of the curves, degrees.
    ProfileScoreWithoutOffset,
}

/// A number of one side.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub struct Measure {
    /// What.
    pub quantity: Quantity,
    /// Of which side's cycle.
    pub side: Side,
}

/// A number of one trial.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Measured {
    /// Its value, in the unit of the quantity.
    pub value: f64,
    /// Number of strides or steps.
    pub strides: usize,
    /// Standard deviation between them.
    pub strides_sd: Option<f64>,
    /// u.
    pub fit_sd: Option<f64>,
}

impl Quantity {
    /// Its unit.
    pub fn unit(self) -> &'static str {
        match self {
            Self::Parameter(parameter) => parameter.unit(),
            _ => "°",
        }
    }

    /// Its name in files.
    pub fn name(self) -> String {
        match self {
            Self::Parameter(parameter) => parameter.name().into(),
            Self::Range(angle) => format!("{}_range", angle.name()),
            Self::VariableScore(angle) => format!("{}_gvs", angle.name()),
            Self::ProfileScore => "gps".into(),
            Self::ProfileScoreWithoutOffset => "gps_without_offset".into(),
        }
    }
}

/// Angles whose range is told.
const RANGES: [Angle; 6] = [
    Angle::PelvisTilt,
    Angle::PelvisObliquity,
    Angle::HipFlexion,
    Angle::HipAdduction,
    Angle::KneeFlexion,
    Angle::AnkleDorsiflexion,
];

/// All numbers that a trial's analysis has, in the order of parameters, ranges and scores; scores only with a norm.
pub fn measured(gait: &GaitAnalysis, norm: Option<&Norm>) -> Vec<(Measure, Measured)> {
    let mut all = Vec::new();
    let sides = |quantity: Quantity| Side::BOTH.map(|side| Measure { quantity, side });
    let mut add = |quantity: Quantity, of: &dyn Fn(Side) -> Option<Measured>| {
        for measure in sides(quantity) {
            all.extend(of(measure.side).map(|measured| (measure, measured)));
        }
    };

    for parameter in Parameter::ALL {
        add(Quantity::Parameter(parameter), &|side| of_parameter(gait, parameter, side));
    }
    let curve = |angle, side| gait.curves.iter().find(|c| c.angle == angle && c.side == side);
    for angle in RANGES {
        add(Quantity::Range(angle), &|side| Some(of_range(curve(angle, side)?)));
    }

    let scores = norm.and_then(|norm| indices(&gait.curves, norm));
    let Some(scores) = scores else { return all };
    let score = |angle, side| {
        let (score, curve) = (scores.variables.get(&(side, angle))?, curve(angle, side)?);
        Some(of_score(score.whole?.to_degrees(), curve))
    };
    for angle in VARIABLES {
        add(Quantity::VariableScore(angle), &|side| score(angle, side));
    }
    let of_side = |side| match side {
        Side::Left => scores.left,
        Side::Right => scores.right,
    };
    let variables = |side| -> Option<Vec<Measured>> {
        VARIABLES.iter().map(|angle| score(*angle, side)).collect()
    };
    add(Quantity::ProfileScore, &|side| {
        Some(profile(of_side(side)?.whole?.to_degrees(), &variables(side)?))
    });
    add(Quantity::ProfileScoreWithoutOffset, &|side| {
        let strides = VARIABLES.iter().filter_map(|angle| Some(curve(*angle, side)?.strides.len()));
        Some(Measured {
            value: of_side(side)?.without_offset.to_degrees(),
            strides: strides.min().unwrap_or(0),
            strides_sd: None,
            fit_sd: None,
        })
    });
    all
}

fn of_parameter(gait: &GaitAnalysis, parameter: Parameter, side: Side) -> Option<Measured> {
    let statistic = gait.parameters.get(&(parameter, side))?;
    Some(Measured {
        value: statistic.mean,
        strides: statistic.n,
        strides_sd: statistic.sd,
        fit_sd: statistic.uncertainty,
    })
}

fn of_range(curve: &Curve) -> Measured {
    let of = |values: &Vec<f64>| {
        let ends = values
            .iter()
            .fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), v| (low.min(*v), high.max(*v)));
        (ends.1 - ends.0).to_degrees()
    };
    let ranges: Vec<f64> = curve.strides.iter().map(of).collect();
    Measured {
        value: of(&curve.mean),
        strides: curve.strides.len(),
        strides_sd: mean_and_sd(&ranges).and_then(|(_, sd)| sd),
        fit_sd: None,
    }
}

fn of_score(value: f64, curve: &Curve) -> Measured {
    Measured { value, strides: curve.strides.len(), strides_sd: None, fit_sd: mean_fit_sd(curve) }
}

/// Degrees.
fn mean_fit_sd(curve: &Curve) -> Option<f64> {
    mean(curve.fit_sd.as_ref()?.iter().map(|sd| sd.to_degrees()))
}

fn profile(value: f64, variables: &[Measured]) -> Measured {
    let squares = |v: &Measured| Some((v.value * v.fit_sd?).powi(2));
    let squares: Option<f64> = variables.iter().map(squares).sum();
    Measured {
        value,
        strides: variables.iter().map(|v| v.strides).min().unwrap_or(0),
        strides_sd: None,
        fit_sd: squares.map(|s| s.sqrt() / (variables.len() as f64 * value)),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn one_variable_alone_moves_the_profile_by_its_share() {
        let of = |value, fit_sd| Measured { value, strides: 2, strides_sd: None, fit_sd };
        // GPS of 3 and 4 is √12.5; ∂GPS/∂GVS = GVS/(2·GPS)
        let variables = [of(3.0, Some(0.0)), of(4.0, Some(0.1))];
        let found = profile(12.5_f64.sqrt(), &variables).fit_sd.unwrap();
        let moved = ((9.0 + 4.1 * 4.1) / 2.0_f64).sqrt() - 12.5_f64.sqrt();
        approx::assert_relative_eq!(found, moved, max_relative = 0.02);
        assert_eq!(profile(3.5, &[of(3.0, None), of(4.0, Some(0.1))]).fit_sd, None);
    }
}
