//! When a foot strikes and leaves the floor, by two published methods.
//!
//! | method | foot strike | foot off |
//! |---|---|---|
//! | position (Zeni 2008) | heel farthest in front of the pelvis | toe farthest behind it |
//! | speed (Ghoussayni 2004) | heel slower than 0.5 m/s | toe faster than 1 m/s |
//!
//! Speeds are those of the sagittal plane (forwards and up) against the floor or belt. The strike is taken from the
//! speed, as the foremost heel is still moving down (10–20 ms too early), and the off from the position, which scales
//! with the speed of walking. A strike that speed does not show is taken from the position. The distance between the two
//! methods tells the quality of the events: its mean belongs to the methods, its spread to the recording.
//!
//! # Source
//! Zeni, Richards & Higginson, Gait Posture 27 (2008) 710–714. Speed of the sagittal plane against a threshold: Ghoussayni
//! et al., Gait Posture 20 (2004) 266–272; Bruening & Ridge, Gait Posture 39 (2014) 472–477 found it and Zeni's the most
//! versatile of nine. The heel's threshold is Ghoussayni's; Bruening & Ridge scale theirs with the speed of walking, which
//! moves strikes of slow and fast walks against each other. **Differs**: the toe's is Pose2Sim's, Ghoussayni's is 0.5 m/s.

use nalgebra::Vector3;
use serde::Serialize;

use super::GaitOptions;
use super::course::Course;
use super::filter;
use super::landmark::{Landmark, Paired, Side};
use super::movement::{Movement, Track, by_axis};
use super::peaks::{Peak, peaks};
use crate::math::stats::mean_and_sd;

/// What a foot does.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum EventKind {
    /// It comes down.
    Strike,
    /// It leaves.
    Off,
}

/// One foot strike or foot off. Times count from the recording's frame 0.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Event {
    /// Whose foot.
    pub side: Side,
    /// What it does.
    pub kind: EventKind,
    /// When, as used.
    pub time_s: f64,
    /// When, by position.
    pub by_position_s: Option<f64>,
    /// When, by speed.
    pub by_speed_s: Option<f64>,
    /// The same as `time_s`, in frames from the first one.
    #[serde(skip)]
    pub frame: f64,
}

/// How far the two methods lie apart: speed minus position.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Agreement {
    /// Of which events.
    pub kind: EventKind,
    /// Number of events that both methods found.
    pub n: usize,
    /// Mean difference.
    pub mean_s: f64,
    /// Its standard deviation; of two or more.
    pub sd_s: Option<f64>,
}

/// Least time between two events of one kind and side, seconds (more than 150 strides a minute do not occur).
const NEAREST_S: f64 = 0.4;
/// How far from the event by position the one by speed is looked for, seconds.
const REACH_S: f64 = 0.15;
/// Speed near its event that only a swinging foot reaches, m/s.
const SWINGS_M_S: f64 = 0.6;

/// All events, by time; none if one foot strikes repeatedly and the other never, which is no walk.
pub(super) fn events(movement: &Movement, course: &Course, options: &GaitOptions) -> Vec<Event> {
    let mut found = Vec::new();
    for side in Side::BOTH {
        if let Some(foot) = Foot::new(movement, course, side) {
            found.extend(foot.events(EventKind::Strike, movement, options));
            found.extend(foot.events(EventKind::Off, movement, options));
        }
    }
    found.sort_by(|a, b| a.time_s.total_cmp(&b.time_s));
    if feet_take_turns(&found) { found } else { Vec::new() }
}

fn feet_take_turns(events: &[Event]) -> bool {
    let strikes = Side::BOTH.map(|side| {
        let own = events.iter().filter(|e| e.side == side && e.kind == EventKind::Strike);
        own.count()
    });
    let [fewer, more] = [strikes[0].min(strikes[1]), strikes[0].max(strikes[1])];
    fewer > 0 || more < 2
}

/// One foot's signals.
struct Foot {
    side: Side,
    /// Heel before the pelvis, along the heading.
    heel_ahead: Vec<f64>,
    /// Pelvis before the toe.
    toe_behind: Vec<f64>,
    heel_speed: Vec<f64>,
    toe_speed: Vec<f64>,
}

impl Foot {
    /// The signals of a foot; `None` if its heel or toe is nowhere known.
    fn new(movement: &Movement, course: &Course, side: Side) -> Option<Self> {
        let pelvis = reference(movement)?;
        let heel = movement.paired_track(side, Paired::Heel)?;
        let toe = movement.paired_track(side, Paired::Toe)?;

        let ahead = |track: &Track| -> Vec<f64> {
            let rows = track.iter().zip(&pelvis).zip(&course.heading);
            rows.map(|((p, pelvis), heading)| (p - pelvis).dot(heading)).collect()
        };

        let speed = |track: &Track| -> Vec<f64> {
            let velocity = by_axis(track, |values| filter::slope(values, movement.rate_hz));
            let rows = velocity.iter().zip(&course.heading);
            rows.map(|(v, heading)| v.z.hypot(v.dot(heading) + course.belt_m_s)).collect()
        };

        Some(Self {
            side,
            heel_ahead: ahead(heel),
            toe_behind: ahead(toe).iter().map(|v| -v).collect(),
            heel_speed: speed(heel),
            toe_speed: speed(toe),
        })
    }

    fn events(&self, kind: EventKind, movement: &Movement, options: &GaitOptions) -> Vec<Event> {
        let (signal, speed) = match kind {
            EventKind::Strike => (&self.heel_ahead, &self.heel_speed),
            EventKind::Off => (&self.toe_behind, &self.toe_speed),
        };

        // by position: a peak beside which the foot is fast enough to swing
        let reach = REACH_S * movement.rate_hz;
        let swings = |peak: &Peak| {
            let near = (peak.frame - 2.0 * reach).max(0.0) as usize;
            let far = ((peak.frame + 2.0 * reach) as usize + 1).min(speed.len());
            speed[near..far].iter().any(|v| *v > SWINGS_M_S)
        };
        let nearest = NEAREST_S * movement.rate_hz;
        let mut found = peaks(signal, options.prominence_m, nearest);
        found.retain(swings);

        // by speed: where it passes the threshold near that peak
        let event = |peak: &Peak| {
            let by_speed = match kind {
                EventKind::Strike => crossing(speed, peak.frame, reach, -options.strike_speed_m_s),
                EventKind::Off => crossing(speed, peak.frame, reach, options.off_speed_m_s),
            };
            let frame = match kind {
                EventKind::Strike => by_speed.unwrap_or(peak.frame),
                EventKind::Off => peak.frame,
            };
            let seconds = |frame: f64| (frame + movement.first_frame as f64) / movement.rate_hz;
            Event {
                side: self.side,
                kind,
                time_s: seconds(frame),
                by_position_s: Some(seconds(peak.frame)),
                by_speed_s: by_speed.map(seconds),
                frame,
            }
        };
        found.iter().map(event).collect()
    }
}

/// The point of the pelvis that Zeni's method looks from: the sacrum, or what is nearest to it.
fn reference(movement: &Movement) -> Option<Track> {
    let backs = Side::BOTH.map(|side| movement.paired_track(side, Paired::Psis));
    match (backs, movement.track(Landmark::Sacrum)) {
        ([Some(left), Some(right)], _) => {
            let middle = |(l, r): (&Vector3<f64>, &Vector3<f64>)| (l + r) * 0.5;
            Some(left.iter().zip(right).map(middle).collect())
        }
        (_, Some(sacrum)) => Some(sacrum.clone()),
        _ => movement.track(Landmark::MidHip).cloned(),
    }
}

/// Where a speed passes a threshold, nearest to `frame` and within `reach` frames; a negative one downwards.
fn crossing(speed: &[f64], frame: f64, reach: f64, threshold: f64) -> Option<f64> {
    let first = (frame - reach).max(0.0) as usize;
    let last = ((frame + reach) as usize).min(speed.len().checked_sub(2)?);
    let at = |i: usize| {
        let above = |v: f64| threshold.signum() * (v - threshold.abs());
        let (a, b) = (above(speed[i]), above(speed[i + 1]));
        (a < 0.0 && b >= 0.0).then(|| i as f64 + a / (a - b))
    };
    let all = (first..=last).filter_map(at);
    all.min_by(|a, b| (a - frame).abs().total_cmp(&(b - frame).abs()))
}

/// How far the methods agree on one kind of event.
pub(super) fn agreement(events: &[Event], kind: EventKind) -> Option<Agreement> {
    let own = events.iter().filter(|e| e.kind == kind);
    let differences = own.filter_map(|e| Some(e.by_speed_s? - e.by_position_s?));
    let differences: Vec<f64> = differences.collect();
    let (mean_s, sd_s) = mean_and_sd(&differences)?;
    Some(Agreement { kind, n: differences.len(), mean_s, sd_s })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_foot_that_strikes_twice_while_the_other_stands_is_no_walk() {
        let strike = |side| Event {
            side,
            kind: EventKind::Strike,
            time_s: 0.0,
            by_position_s: None,
            by_speed_s: None,
            frame: 0.0,
        };
        let (left, right) = (strike(Side::Left), strike(Side::Right));
        assert!(!feet_take_turns(&[right.clone(), right.clone()]));
        assert!(feet_take_turns(&[right.clone(), left, right]));
    }

    #[test]
    fn a_crossing_is_found_between_frames_and_in_its_direction() {
        let speed = [2.0, 1.0, 0.0, 0.0, 1.0, 2.0];
        approx::assert_relative_eq!(crossing(&speed, 1.0, 2.0, -0.5).unwrap(), 1.5);
        approx::assert_relative_eq!(crossing(&speed, 4.0, 2.0, 0.5).unwrap(), 3.5);
        assert_eq!(crossing(&speed, 0.0, 1.0, 0.5), None);
    }
}
