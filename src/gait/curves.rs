//! Angles over the gait cycle: 101 points from 0 to 100 % of each side's own strides.

use serde::Serialize;

use super::angle::Angle;
use super::angles::AngleTracks;
use super::cycles::Cycle;
use super::filter;
use super::landmark::Side;
use super::segments::Segments;
use crate::math::stats::{mean, mean_and_sd};

/// Points of a curve.
pub const POINTS: usize = 101;

/// One angle over the gait cycle, radians.
#[derive(Debug, Clone, PartialEq)]
pub struct Curve {
    /// Which angle.
    pub angle: Angle,
    /// Whose cycle.
    pub side: Side,
    /// Stride by stride, [`POINTS`] each.
    pub strides: Vec<Vec<f64>>,
    /// Mean over the strides.
    pub mean: Vec<f64>,
    /// Standard deviation over the strides; of two or more.
    pub sd: Option<Vec<f64>>,
    /// Standard deviation of the angle itself, from the fit: mean over the strides, as its errors return in each.
    pub fit_sd: Option<Vec<f64>>,
    /// Foot off, 0 to 1; mean over the strides.
    pub foot_off: f64,
    /// Whether the swing comes from before the stance: the curve then breaks at foot off.
    pub is_joined: bool,
}

/// What is read off a curve. Angles in radians, places in % of the cycle.
#[derive(Debug, Clone, PartialEq)]
pub struct KeyPoints {
    /// At foot strike.
    pub initial_contact: f64,
    /// Least and greatest in stance, and where.
    pub stance: Extremes,
    /// Least and greatest in swing, and where.
    pub swing: Extremes,
    /// Greatest less least over the cycle.
    pub range: f64,
}

/// Least and greatest value, and where they are.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Extremes {
    /// Least value.
    pub least: f64,
    /// Where, %.
    pub least_at_percent: usize,
    /// Greatest value.
    pub greatest: f64,
    /// Where, %.
    pub greatest_at_percent: usize,
}

impl Curve {
    /// What is read off its mean.
    pub fn key_points(&self) -> KeyPoints {
        let off = ((self.foot_off * 100.0).round() as usize).clamp(1, POINTS - 2);
        let all = extremes(&self.mean, 0..POINTS);
        KeyPoints {
            initial_contact: self.mean[0],
            stance: extremes(&self.mean, 0..off + 1),
            swing: extremes(&self.mean, off..POINTS),
            range: all.greatest - all.least,
        }
    }
}

fn extremes(values: &[f64], range: std::ops::Range<usize>) -> Extremes {
    let by = |a: &usize, b: &usize| values[*a].total_cmp(&values[*b]);
    let least = range.clone().min_by(by).unwrap_or(0);
    let greatest = range.max_by(by).unwrap_or(0);
    Extremes {
        least: values[least],
        least_at_percent: least,
        greatest: values[greatest],
        greatest_at_percent: greatest,
    }
}

/// Every angle over the strides of its side.
///
/// A stride in which the angle is not known throughout is left out.
pub(super) fn curves(tracks: &AngleTracks, segments: &Segments, cycles: &[Cycle]) -> Vec<Curve> {
    let curve = |(&(side, angle), track): (&(Side, Angle), &Vec<f64>)| {
        let own = cycles.iter().filter(|c| c.side == side);
        let sampled = own.map(|cycle| (cycle, over_cycle(track, cycle)));
        let whole = sampled.filter(|(_, values)| values.iter().all(|v| v.is_finite()));
        let (cycles, strides): (Vec<&Cycle>, Vec<Vec<f64>>) = whole.unzip();
        let (average, sd) = mean_curve(&strides)?;

        let fit_sd = segments.angle_sd.get(&(side, angle)).and_then(|sd| {
            let strides: Vec<_> = cycles.iter().map(|cycle| over_cycle(sd, cycle)).collect();
            Some(mean_curve(&strides)?.0)
        });

        Some(Curve {
            angle,
            side,
            mean: average,
            sd,
            fit_sd,
            foot_off: mean(cycles.iter().map(|cycle| cycle.stance()))?,
            is_joined: cycles.iter().any(|cycle| cycle.is_joined),
            strides,
        })
    };
    tracks.iter().filter_map(curve).collect()
}

/// The [`POINTS`] values of a track over a cycle.
fn over_cycle(track: &[f64], cycle: &Cycle) -> Vec<f64> {
    let last = track.len() as f64 - 1.0;
    let place = |i: usize| {
        let frame = cycle.frame_at(i as f64 / (POINTS - 1) as f64);
        // the ends of a cycle may lie a rounding error outside the recording
        let inside = frame.clamp(0.0, last);
        if (frame - inside).abs() < 1e-6 { inside } else { frame }
    };
    (0..POINTS).map(|i| filter::at(track, place(i))).collect()
}

/// Mean and standard deviation, point by point.
pub(super) fn mean_curve(strides: &[Vec<f64>]) -> Option<(Vec<f64>, Option<Vec<f64>>)> {
    let point = |i: usize| mean_and_sd(&strides.iter().map(|s| s[i]).collect::<Vec<_>>());
    let points: Vec<(f64, Option<f64>)> = (0..POINTS).map(point).collect::<Option<_>>()?;
    let sd = points.iter().map(|p| p.1).collect();
    Some((points.iter().map(|p| p.0).collect(), sd))
}

#[cfg(test)]
mod tests {
    use std::collections::BTreeMap;

    use super::*;

    #[test]
    fn a_curve_of_two_strides_has_their_mean_and_spread() {
        let track: Vec<f64> = (0..=200).map(|i| f64::from(i % 100) + f64::from(i / 100)).collect();
        let cycle = |strike| Cycle {
            side: Side::Left,
            strike,
            off: strike + 60.0,
            period: 99.0,
            opposite_off: None,
            opposite_strike: None,
            is_joined: false,
        };
        let tracks: AngleTracks = BTreeMap::from([((Side::Left, Angle::KneeFlexion), track)]);
        let found = curves(&tracks, &Segments::default(), &[cycle(0.0), cycle(100.0)]);
        assert_eq!((found.len(), found[0].strides.len()), (1, 2));
        approx::assert_relative_eq!(found[0].mean[0], 0.5, epsilon = 1e-12);
        approx::assert_relative_eq!(
            found[0].sd.as_ref().unwrap()[50],
            0.5_f64.sqrt(),
            epsilon = 1e-9
        );
        let key = found[0].key_points();
        assert_eq!((key.stance.greatest_at_percent, key.swing.greatest_at_percent), (61, 100));
    }
}
