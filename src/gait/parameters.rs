//! Spatiotemporal parameters: each with mean, spread over strides, and its own uncertainty.
//!
//! Lengths are measured between heels, or between ankles where the heels have no marker (width: always ankles), along and
//! across the direction of walking; on a treadmill, against the belt. Their standard uncertainty comes from the standard
//! deviations of the fitted points:
//!
//! - a step's length lies between two points of one frame, and the fit knows how their errors correlate;
//! - a stride's length lies between one point at two times, whose errors count as independent: this is too cautious, as
//!   an error common to both frames cancels;
//! - a step's width lies between two points at two times. How their errors correlate is not known, so it has the bound
//!   u ≤ u₁ + u₂, which holds for every correlation (Cauchy and Schwarz).
//!
//! The uncertainty of times comes from the frame rate and from the scatter between the two methods for events. Neither
//! becomes smaller with more strides, as one stride errs like the next.

use std::collections::BTreeMap;

use nalgebra::Vector3;
use serde::{Serialize, Serializer};

use super::GaitAnalysis;
use super::course::Course;
use super::cycles::Cycle;
use super::events::{Event, EventKind, agreement};
use super::filter;
use super::landmark::{Landmark, Paired, Side};
use super::movement::{Movement, Track};
use crate::math::stats::{mean, mean_and_sd};

/// A spatiotemporal parameter.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Parameter {
    /// Stride length over stride time.
    Speed,
    /// Steps a minute: 120 over stride time.
    Cadence,
    /// Way of a heel from strike to strike, along the heading.
    StrideLength,
    /// From strike to strike.
    StrideTime,
    /// How far the striking heel (ankle) is before the other one, along the heading, at the strike.
    StepLength,
    /// From the other foot's strike to the own one.
    StepTime,
    /// Distance of the two ankles across the heading, each in the middle of its stance.
    StepWidth,
    /// From strike to off.
    StanceTime,
    /// From off to strike.
    SwingTime,
    /// Stance over stride.
    Stance,
    /// 1 − stance.
    Swing,
    /// Other foot off to other foot strike, over stride.
    SingleSupport,
    /// What stance is not single support.
    DoubleSupport,
}

impl Parameter {
    /// All of them.
    pub const ALL: [Self; 13] = [
        Self::Speed,
        Self::Cadence,
        Self::StrideLength,
        Self::StrideTime,
        Self::StepLength,
        Self::StepTime,
        Self::StepWidth,
        Self::StanceTime,
        Self::SwingTime,
        Self::Stance,
        Self::Swing,
        Self::SingleSupport,
        Self::DoubleSupport,
    ];

    /// Its name in files.
    pub fn name(self) -> &'static str {
        match self {
            Self::Speed => "speed",
            Self::Cadence => "cadence",
            Self::StrideLength => "stride_length",
            Self::StrideTime => "stride_time",
            Self::StepLength => "step_length",
            Self::StepTime => "step_time",
            Self::StepWidth => "step_width",
            Self::StanceTime => "stance_time",
            Self::SwingTime => "swing_time",
            Self::Stance => "stance",
            Self::Swing => "swing",
            Self::SingleSupport => "single_support",
            Self::DoubleSupport => "double_support",
        }
    }

    /// Its unit: m/s, 1/min, m, s, or % of the cycle.
    pub fn unit(self) -> &'static str {
        match self {
            Self::Speed => "m/s",
            Self::Cadence => "steps/min",
            Self::StrideLength | Self::StepLength | Self::StepWidth => "m",
            Self::StrideTime | Self::StepTime | Self::StanceTime | Self::SwingTime => "s",
            _ => "% of cycle",
        }
    }

    /// What it is divided by to be the same for small and tall people (Hof 1996), g = 9.81 m/s²; 1 if it already is.
    ///
    /// Lengths: l. Times: √(l/g). Speed: √(g·l). Cadence: √(g/l).
    pub fn scale(self, leg_length_m: f64) -> f64 {
        const G: f64 = 9.81;
        match self.unit() {
            "m" => leg_length_m,
            "s" => (leg_length_m / G).sqrt(),
            "m/s" => (leg_length_m * G).sqrt(),
            "steps/min" => 60.0 * (G / leg_length_m).sqrt(),
            _ => 1.0,
        }
    }
}

impl Serialize for Parameter {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.serialize_str(self.name())
    }
}

/// One parameter of one side.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Statistic {
    /// Number of strides or steps.
    pub n: usize,
    /// Mean over them.
    pub mean: f64,
    /// Standard deviation over them; of two or more.
    pub sd: Option<f64>,
    /// Standard uncertainty of a single value, if anything is known of it.
    pub uncertainty: Option<f64>,
    /// Stride by stride.
    pub values: Vec<f64>,
}

/// Parameter by parameter, side by side.
pub type Parameters = BTreeMap<(Parameter, Side), Statistic>;

/// A value and its standard uncertainty.
type Measured = (f64, Option<f64>);

/// What the parameters are measured on.
pub(super) struct Walk<'a> {
    pub(super) movement: &'a Movement,
    pub(super) course: &'a Course,
    pub(super) events: &'a [Event],
    pub(super) cycles: &'a [Cycle],
}

impl Walk<'_> {
    /// All parameters that the events and strides allow.
    pub(super) fn parameters(&self) -> Parameters {
        let mut samples: BTreeMap<(Parameter, Side), Vec<Measured>> = BTreeMap::new();
        let mut add = |parameter, side, measured: Option<Measured>| {
            if let Some(measured) = measured.filter(|m| m.0.is_finite()) {
                samples.entry((parameter, side)).or_default().push(measured);
            }
        };

        for cycle in self.cycles {
            for (parameter, measured) in self.cycle_parameters(cycle) {
                add(parameter, cycle.side, measured);
            }
        }
        for (i, event) in self.events.iter().enumerate() {
            if event.kind == EventKind::Strike {
                add(Parameter::StepLength, event.side, self.step_length(event));
                add(Parameter::StepTime, event.side, self.step_time(i));
                add(Parameter::StepWidth, event.side, self.step_width(i));
            }
        }

        samples.into_iter().map(|(key, all)| (key, statistic(&all))).collect()
    }

    fn cycle_parameters(&self, cycle: &Cycle) -> Vec<(Parameter, Option<Measured>)> {
        let rate = self.movement.rate_hz;
        let period = cycle.period / rate;

        let (u_strike, u_off) = (self.time_u(EventKind::Strike), self.time_u(EventKind::Off));
        let (u_period, u_stance) = match cycle.is_joined {
            true => (2_f64.sqrt() * u_off, u_strike.hypot(u_off)),
            false => (2_f64.sqrt() * u_strike, u_strike.hypot(u_off)),
        };

        let percent = |part: f64| Some((100.0 * part, Some(100.0 * u_stance / period)));
        let stance = cycle.stance();
        let single = cycle
            .opposite_off
            .zip(cycle.opposite_strike)
            .map(|(off, strike)| (strike - off) / cycle.period);

        // v = l/t: (u(v)/v)² = (u(l)/l)² + (u(t)/t)²
        let length = self.stride_length(cycle);
        let speed = length.map(|(l, u)| {
            let u = u.map(|u| (u / period).hypot(l / period * u_period / period));
            (l / period, u)
        });
        let cadence = 120.0 / period;
        let cadence = Some((cadence, Some(cadence * u_period / period)));

        let stance_time = Some((stance * period, Some(u_stance)));
        let swing_time = Some(((1.0 - stance) * period, Some(u_stance)));
        let double = single.map(|single| stance - single);
        vec![
            (Parameter::StrideTime, Some((period, Some(u_period)))),
            (Parameter::Cadence, cadence),
            (Parameter::StanceTime, stance_time),
            (Parameter::SwingTime, swing_time),
            (Parameter::Stance, percent(stance)),
            (Parameter::Swing, percent(1.0 - stance)),
            (Parameter::SingleSupport, single.and_then(percent)),
            (Parameter::DoubleSupport, double.and_then(percent)),
            (Parameter::StrideLength, length),
            (Parameter::Speed, speed),
        ]
    }

    /// Way of the heel from strike to strike, or of the toe from off to off where the stride is joined.
    fn stride_length(&self, cycle: &Cycle) -> Option<Measured> {
        let (place, from) = match cycle.is_joined {
            true => (Paired::Toe, cycle.off - cycle.period),
            false => (Paired::Heel, cycle.strike),
        };
        let to = from + cycle.period;
        let landmark = Landmark::Of(cycle.side, place);
        let track = self.movement.track(landmark)?;
        let along = self.course.heading_at(0.5 * (from + to));
        let way = (at(track, to) - at(track, from)).dot(&along);
        let belt = self.course.belt_m_s * cycle.period / self.movement.rate_hz;

        let ends = [from, to].map(|frame| self.place_u(landmark, frame, &along));
        let u = ends[0].zip(ends[1]).map(|(a, b)| a.hypot(b));
        Some((way + belt, u))
    }

    /// How far the own foot is before the other one.
    fn step_length(&self, strike: &Event) -> Option<Measured> {
        let along = self.course.heading_at(strike.frame);
        let are_marked = Side::BOTH.iter().all(|s| self.movement.has_heel_marker(*s));
        let place = match are_marked {
            true => Paired::Heel,
            false => Paired::Ankle,
        };
        let own = Landmark::Of(strike.side, place);
        let other = Landmark::Of(strike.side.other(), place);
        let apart = at(self.movement.track(own)?, strike.frame)
            - at(self.movement.track(other)?, strike.frame);

        // how the errors of the two go together, or else the bound u₁ + u₂
        let sd = self.movement.apart_sd_m.get(&place);
        let u = sd.and_then(|sd| deviation(sd, strike.frame, &along));
        let bound = || {
            let own_u = self.place_u(own, strike.frame, &along)?;
            Some(own_u + self.place_u(other, strike.frame, &along)?)
        };
        Some((apart.dot(&along), u.or_else(bound)))
    }

    /// From the last strike of the other foot, if no own one lies between.
    fn step_time(&self, strike: usize) -> Option<Measured> {
        let own = &self.events[strike];
        let before = self.events[..strike].iter().rev();
        let last = before.clone().find(|e| e.kind == EventKind::Strike)?;
        let seconds = own.time_s - last.time_s;
        let u = 2_f64.sqrt() * self.time_u(EventKind::Strike);
        (last.side != own.side).then_some((seconds, Some(u)))
    }

    /// Distance across the heading of the ankles in the middles of this stance and the other foot's next one.
    fn step_width(&self, strike: usize) -> Option<Measured> {
        let own = &self.events[strike];
        let later = self.events[strike + 1..].iter();
        let next = later.clone().find(|e| e.kind == EventKind::Strike && e.side != own.side)?;

        let off_after = |event: &Event| {
            let mut offs = self.events.iter().filter(|e| e.kind == EventKind::Off);
            offs.find(|e| e.side == event.side && e.frame > event.frame).map(|e| e.frame)
        };
        let middle = |event: &Event| Some(0.5 * (event.frame + off_after(event)?));
        let (own_frame, next_frame) = (middle(own)?, middle(next)?);

        let left = Vector3::z().cross(&self.course.heading_at(0.5 * (own_frame + next_frame)));
        let ankle = |side| Landmark::Of(side, Paired::Ankle);
        let place = |side, frame| Some(at(self.movement.track(ankle(side))?, frame));
        let apart = place(own.side, own_frame)? - place(next.side, next_frame)?;

        let u = |side, frame| self.place_u(ankle(side), frame, &left);
        let ends = u(own.side, own_frame).zip(u(next.side, next_frame));
        let bound = ends.map(|(a, b)| a + b);
        Some((-own.side.sign() * apart.dot(&left), bound))
    }

    /// Standard uncertainty of an event's time: of the frame it lies in, and of the methods' scatter.
    fn time_u(&self, kind: EventKind) -> f64 {
        let frame = 1.0 / (12_f64.sqrt() * self.movement.rate_hz);
        let scatter = agreement(self.events, kind).and_then(|a| a.sd_s).unwrap_or(0.0);
        frame.hypot(scatter / 2_f64.sqrt())
    }

    /// Standard uncertainty of a place along a direction.
    fn place_u(&self, landmark: Landmark, frame: f64, direction: &Vector3<f64>) -> Option<f64> {
        deviation(self.movement.sd_m.get(&landmark)?, frame, direction)
    }
}

/// Standard deviation along a direction, of those along the axes.
fn deviation(sd: &Track, frame: f64, direction: &Vector3<f64>) -> Option<f64> {
    let along = at(sd, frame).component_mul(direction).norm();
    along.is_finite().then_some(along)
}

/// A place between two frames.
fn at(track: &Track, frame: f64) -> Vector3<f64> {
    let axis = |a: usize| {
        let first = (frame.max(0.0) as usize).saturating_sub(1);
        let last = (first + 4).min(track.len());
        let values: Vec<f64> = track[first.min(last)..last].iter().map(|p| p[a]).collect();
        filter::at(&values, frame - first as f64)
    };
    Vector3::new(axis(0), axis(1), axis(2))
}

fn statistic(samples: &[Measured]) -> Statistic {
    let values: Vec<f64> = samples.iter().map(|s| s.0).collect();
    let known = samples.iter().filter_map(|s| s.1);
    let (average, sd) = mean_and_sd(&values).unwrap_or((f64::NAN, None));
    Statistic { n: values.len(), mean: average, sd, uncertainty: mean(known), values }
}

impl GaitAnalysis {
    /// Right over left, %; `None` where a side has no value or the left is 0.
    pub fn symmetry_percent(&self, parameter: Parameter) -> Option<f64> {
        let mean = |side| self.parameters.get(&(parameter, side)).map(|s| s.mean);
        let (left, right) = (mean(Side::Left)?, mean(Side::Right)?);
        (left.abs() > 1e-9).then(|| 100.0 * right / left)
    }

    /// Mean of left and right over the parameter's [scale](Parameter::scale): without unit.
    pub fn normalised(&self, parameter: Parameter) -> Option<f64> {
        let sides = Side::BOTH.iter();
        let statistics = sides.filter_map(|side| self.parameters.get(&(parameter, *side)));
        let both = mean(statistics.map(|s| s.mean))?;
        let value = both / parameter.scale(self.leg_length_m?);
        value.is_finite().then_some(value)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn cadence_and_speed_of_a_leg_length_are_numbers_without_unit() {
        let leg = 0.9;
        let walked = 1.3 / Parameter::Speed.scale(leg);
        let froude = 1.3_f64.powi(2) / (9.81 * leg);
        approx::assert_relative_eq!(walked * walked, froude, epsilon = 1e-12);
        // speed = step length times step frequency, also without units
        let (step, cadence) = (0.65, 120.0);
        let scaled =
            step / Parameter::StepLength.scale(leg) * cadence / Parameter::Cadence.scale(leg);
        approx::assert_relative_eq!(scaled, walked, epsilon = 1e-12);
    }
}
