//! Strides: from one strike of a foot to the next.

use serde::Serialize;

use super::events::{Event, EventKind};
use super::landmark::Side;

/// One stride of one side. Times are in frames from the first one, and may lie between two.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Cycle {
    /// Whose.
    pub side: Side,
    /// Foot strike: 0 %.
    pub strike: f64,
    /// Foot off of the same foot.
    pub off: f64,
    /// Length of the cycle, frames.
    pub period: f64,
    /// Foot off of the other foot, between 0 and 100 %; the end of the first double support.
    pub opposite_off: Option<f64>,
    /// Foot strike of the other foot; the beginning of the second double support.
    pub opposite_strike: Option<f64>,
    /// Whether the swing comes from before the strike: the recording has no second strike, but two foot offs.
    pub is_joined: bool,
}

/// Shortest and longest stride, seconds.
const PERIOD_S: (f64, f64) = (0.4, 4.0);

impl Cycle {
    /// The frame at a part of the cycle, 0 to 1.
    pub(super) fn frame_at(&self, part: f64) -> f64 {
        let frame = self.strike + part * self.period;
        if self.is_joined && frame > self.off { frame - self.period } else { frame }
    }

    /// Stance over stride.
    pub fn stance(&self) -> f64 {
        (self.off - self.strike) / self.period
    }
}

/// The strides of both sides.
///
/// A stride goes from strike to strike, with the foot off in between. Where a side has one strike only, but a foot off
/// before and after it, the stride is joined from the stance after the strike and the swing before it.
pub(super) fn cycles(events: &[Event], rate_hz: f64) -> Vec<Cycle> {
    Side::BOTH.iter().flat_map(|side| side_cycles(events, *side, rate_hz)).collect()
}

fn side_cycles(events: &[Event], side: Side, rate_hz: f64) -> Vec<Cycle> {
    let own: Vec<&Event> = events.iter().filter(|e| e.side == side).collect();
    let is_period = |frames: f64| (PERIOD_S.0..PERIOD_S.1).contains(&(frames / rate_hz));

    let from_strike_to_strike = own.windows(3).filter_map(|three| match three {
        [a, b, c] if is_strike(a) && !is_strike(b) && is_strike(c) => {
            let period = c.frame - a.frame;
            is_period(period).then(|| cycle(events, a, b, period))
        }
        _ => None,
    });
    let whole: Vec<Cycle> = from_strike_to_strike.collect();
    if !whole.is_empty() {
        return whole;
    }

    let joined = own.windows(3).filter_map(|three| match three {
        [a, b, c] if !is_strike(a) && is_strike(b) && !is_strike(c) => {
            let period = c.frame - a.frame;
            is_period(period).then(|| Cycle { is_joined: true, ..cycle(events, b, c, period) })
        }
        _ => None,
    });
    joined.collect()
}

fn is_strike(event: &Event) -> bool {
    event.kind == EventKind::Strike
}

fn cycle(events: &[Event], strike: &Event, off: &Event, period: f64) -> Cycle {
    let other = strike.side.other();
    let find = |kind, from: f64, to: f64| {
        let mut found = events.iter().filter(|e| e.side == other && e.kind == kind);
        found.find(|e| from < e.frame && e.frame < to).map(|e| e.frame)
    };
    Cycle {
        side: strike.side,
        strike: strike.frame,
        off: off.frame,
        period,
        opposite_off: find(EventKind::Off, strike.frame, off.frame),
        opposite_strike: find(EventKind::Strike, strike.frame, off.frame),
        is_joined: false,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn event(side: Side, kind: EventKind, frame: f64) -> Event {
        Event { side, kind, time_s: frame / 100.0, by_position_s: None, by_speed_s: None, frame }
    }

    #[test]
    fn a_stride_goes_from_strike_to_strike() {
        use EventKind::{Off, Strike};
        let events = [
            event(Side::Left, Off, 8.0),
            event(Side::Right, Strike, 0.0),
            event(Side::Left, Strike, 50.0),
            event(Side::Right, Off, 60.0),
            event(Side::Right, Strike, 100.0),
        ];
        let found = cycles(&events, 100.0);
        assert_eq!(found.len(), 1);
        assert_eq!((found[0].side, found[0].period), (Side::Right, 100.0));
        assert_eq!(found[0].opposite_off, Some(8.0));
        assert_eq!(found[0].opposite_strike, Some(50.0));
        approx::assert_relative_eq!(found[0].stance(), 0.6);
    }

    #[test]
    fn a_single_strike_between_two_offs_is_joined_to_a_stride() {
        use EventKind::{Off, Strike};
        let side = Side::Left;
        let events = [event(side, Off, 10.0), event(side, Strike, 50.0), event(side, Off, 110.0)];
        let found = cycles(&events, 100.0);
        assert!(found[0].is_joined);
        approx::assert_relative_eq!(found[0].period, 100.0);
        approx::assert_relative_eq!(found[0].frame_at(0.5), 100.0);
        approx::assert_relative_eq!(found[0].frame_at(0.8), 30.0);
    }
}
