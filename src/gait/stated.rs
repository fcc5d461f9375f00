//! Foot strikes and foot offs that a person states, in the place of those that are found.

use std::ops::Range;

use serde::Serialize;

use super::events::{Event, EventKind};
use super::landmark::Side;
use super::movement::Movement;

/// A foot strike or foot off, as a person states it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct StatedEvent {
    /// Whose foot.
    pub side: Side,
    /// What it does.
    pub kind: EventKind,
    /// When: the number of a frame of the recording, or a place between two.
    pub frame: f64,
}

/// Who says when feet strike and leave.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum EventSource {
    /// The two methods, from the motion.
    Detected,
    /// A person, in the place of both.
    Person,
}

/// The stated events within some frames of the movement, by time.
pub(super) fn events(
    movement: &Movement,
    frames: &Range<usize>,
    stated: &[StatedEvent],
) -> Vec<Event> {
    let event = |stated: &StatedEvent| Event {
        side: stated.side,
        kind: stated.kind,
        time_s: stated.frame / movement.rate_hz,
        by_position_s: None,
        by_speed_s: None,
        frame: stated.frame - movement.first_frame as f64,
    };
    let (first, end) = (frames.start as f64, frames.end as f64);
    let mut events: Vec<Event> = stated.iter().map(event).collect();
    events.retain(|event| first <= event.frame && event.frame < end);
    events.sort_by(|a, b| a.time_s.total_cmp(&b.time_s));
    events
}

/// What to know of numbers that rest on stated events.
pub(super) fn note(events: &[Event]) -> String {
    match events.len() {
        0 => "a person corrected the foot strikes and foot offs, and left none in these frames: angles over time only".into(),
        n => format!(
            "a person corrected the foot strikes and foot offs: these {n} stand in the place of those that the program finds"
        ),
    }
}
