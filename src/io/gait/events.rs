//! `events.json`: foot strikes and foot offs as a person has corrected them; docs/formats.md has every field.

use std::path::{Path, PathBuf};

use serde::Deserialize;

use crate::gait::{EventKind, Movement, Side, StatedEvent};
use crate::io::input::{self, MOST_OF_A_TEXT, shortened};

/// The name of the file in the folder of a fit.
pub const EVENTS: &str = "events.json";
const FORMAT: &str = "maquette-events";
const VERSION: u32 = 1;

/// Two frame rates that differ by less than this share are one.
const SAME_RATE: f64 = 1e-6;

/// Why corrected events cannot be used.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum EventsError {
    /// A file that cannot be read.
    #[error("{}: cannot be read: {source}", path.display())]
    Read {
        /// The file.
        path: PathBuf,
        /// Why.
        source: std::io::Error,
    },
    /// A text that does not hold corrected events.
    #[error("{}: no events as the report's page saves them: {message}", path.display())]
    Format {
        /// The file.
        path: PathBuf,
        /// What is wrong with it.
        message: String,
    },
    /// Events of another recording, or of other frames of it.
    #[error(
        "{}: {what} {found}, but what is analysed has {expected}: are these the events of another recording or of an earlier fit? Take the file away, or leave it out with --events none",
        path.display()
    )]
    OtherRecording {
        /// The file.
        path: PathBuf,
        /// `fps`, `first_frame` or `frames`.
        what: &'static str,
        /// In the file.
        found: String,
        /// In the movement.
        expected: String,
    },
    /// An event that cannot be.
    #[error("{}: event {entry}: {fault}", path.display())]
    Event {
        /// The file.
        path: PathBuf,
        /// Its place in the list, from 1.
        entry: usize,
        /// What is wrong with it.
        fault: EventFault,
    },
}

/// What is wrong with one event.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum EventFault {
    /// A side that people do not have.
    #[error("side {found:?}: expected \"left\" or \"right\"")]
    Side {
        /// In the file.
        found: String,
    },
    /// Neither strike nor off.
    #[error("kind {found:?}: expected \"strike\" or \"off\"")]
    Kind {
        /// In the file.
        found: String,
    },
    /// A time beyond the recording.
    #[error("frame {frame} lies beyond the recording: expected {first} to {last}")]
    Beyond {
        /// In the file.
        frame: f64,
        /// First frame.
        first: usize,
        /// Last frame.
        last: usize,
    },
    /// Two of a kind in turn.
    #[error(
        "the {side} foot {does} at frame {frame} and, in event {before}, at frame {frame_before}: expected {lacking} of that foot between"
    )]
    InTurn {
        /// Whose.
        side: &'static str,
        /// What it does twice.
        does: &'static str,
        /// When.
        frame: f64,
        /// The event before.
        before: usize,
        /// When that is.
        frame_before: f64,
        /// What lies between in any walk.
        lacking: &'static str,
    },
    /// A strike and an off in one instant.
    #[error("frame {frame}: event {before} of the same foot is at that frame too")]
    AtOnce {
        /// When.
        frame: f64,
        /// The other event.
        before: usize,
    },
}

/// Enough to tell what a file is.
#[derive(Debug, Deserialize)]
struct Head {
    format: String,
    version: u32,
}

/// The whole file.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
struct EventsFile {
    #[serde(rename = "format")]
    _format: String,
    #[serde(rename = "version")]
    _version: u32,
    fps: f64,
    first_frame: usize,
    frames: usize,
    events: Vec<Entry>,
}

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
struct Entry {
    side: String,
    kind: String,
    frame: f64,
}

/// Reads the corrected events of a movement.
///
/// # Errors
/// [`EventsError`] names the file and the event: one that is beyond the recording, of no side or kind, or a second one of its kind
/// in turn; and events of another recording.
pub fn read_events(path: &Path, movement: &Movement) -> Result<Vec<StatedEvent>, EventsError> {
    let bytes = input::read(path, MOST_OF_A_TEXT)
        .map_err(|source| EventsError::Read { path: path.into(), source })?;
    let file =
        parse(&bytes).map_err(|message| EventsError::Format { path: path.into(), message })?;
    check_recording(path, &file, movement)?;

    let named = |(entry, fault)| EventsError::Event { path: path.into(), entry, fault };
    let events = file.events.iter().enumerate();
    let events = events.map(|(i, entry)| entry.event(movement).map_err(|fault| (i + 1, fault)));
    let events: Vec<StatedEvent> = events.collect::<Result<_, _>>().map_err(named)?;
    for side in Side::BOTH {
        check_turns(&events, side).map_err(named)?;
    }
    Ok(events)
}

fn parse(bytes: &[u8]) -> Result<EventsFile, String> {
    let head: Head = serde_json::from_slice(bytes).map_err(|fault| fault.to_string())?;
    if head.format != FORMAT || head.version != VERSION {
        let found = shortened(&head.format);
        return Err(format!(
            "format {found:?}, version {}: expected {FORMAT:?}, version {VERSION}",
            head.version
        ));
    }
    serde_json::from_slice(bytes).map_err(|fault| fault.to_string())
}

fn check_recording(path: &Path, file: &EventsFile, movement: &Movement) -> Result<(), EventsError> {
    let other = |what, found: String, expected: String| {
        Err(EventsError::OtherRecording { path: path.into(), what, found, expected })
    };
    let rate_hz = movement.rate_hz;
    if (file.fps / rate_hz - 1.0).abs() > SAME_RATE {
        return other("fps", file.fps.to_string(), rate_hz.to_string());
    }
    for (what, found, expected) in [
        ("first_frame", file.first_frame, movement.first_frame),
        ("frames", file.frames, movement.frames),
    ] {
        if found != expected {
            return other(what, found.to_string(), expected.to_string());
        }
    }
    Ok(())
}

impl Entry {
    fn event(&self, movement: &Movement) -> Result<StatedEvent, EventFault> {
        let side = Side::BOTH.into_iter().find(|side| side.name() == self.side);
        let side = side.ok_or_else(|| EventFault::Side { found: shortened(&self.side) })?;
        let kind = match self.kind.as_str() {
            "strike" => EventKind::Strike,
            "off" => EventKind::Off,
            found => return Err(EventFault::Kind { found: shortened(found) }),
        };

        let first = movement.first_frame;
        let last = first + movement.frames.saturating_sub(1);
        let frame = self.frame;
        if !(first as f64..=last as f64).contains(&frame) {
            return Err(EventFault::Beyond { frame, first, last });
        }
        Ok(StatedEvent { side, kind, frame })
    }
}

/// Checks that a foot strikes and leaves in turn; a fault has the place of its event in the list.
fn check_turns(events: &[StatedEvent], side: Side) -> Result<(), (usize, EventFault)> {
    let mut own: Vec<(usize, &StatedEvent)> =
        (1..).zip(events).filter(|(_, event)| event.side == side).collect();
    own.sort_by(|a, b| a.1.frame.total_cmp(&b.1.frame));

    for pair in own.windows(2) {
        let [(before, earlier), (entry, later)] = [pair[0], pair[1]];
        let frame = later.frame;
        if earlier.kind == later.kind {
            let (does, lacking) = match later.kind {
                EventKind::Strike => ("strikes", "an off"),
                EventKind::Off => ("leaves", "a strike"),
            };
            let (side, frame_before) = (side.name(), earlier.frame);
            let fault = EventFault::InTurn { side, does, frame, before, frame_before, lacking };
            return Err((entry, fault));
        }
        if earlier.frame >= frame {
            return Err((entry, EventFault::AtOnce { frame, before }));
        }
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::collections::BTreeMap;

    /// Frames 10 to 69 at 50 Hz.
    fn movement() -> Movement {
        Movement {
            rate_hz: 50.0,
            first_frame: 10,
            frames: 60,
            tracks: BTreeMap::new(),
            sd_m: BTreeMap::new(),
            apart_sd_m: BTreeMap::new(),
            segments: None,
            used: Vec::new(),
        }
    }

    const EVENT_LIST: &str = r#"{"side": "left", "kind": "strike", "frame": 12.25},
        {"side": "right", "kind": "off", "frame": 10}, {"side": "left", "kind": "off", "frame": 69}"#;

    fn text(events: &str) -> String {
        format!(
            r#"{{"format": "maquette-events", "version": 1, "fps": 50, "first_frame": 10, "frames": 60, "events": [{events}]}}"#
        )
    }

    fn read(text: &str) -> Result<Vec<StatedEvent>, String> {
        let folder = tempfile::tempdir().expect("a folder");
        let path = folder.path().join(EVENTS);
        std::fs::write(&path, text).expect("written");
        let read = read_events(&path, &movement());
        read.map_err(|fault| {
            let line = fault.to_string();
            assert!(line.contains("events.json: ") && !line.contains('\n'), "{line}");
            line
        })
    }

    #[test]
    fn events_are_read_with_their_frames_whichever_order_they_stand_in() {
        let events = read(&text(EVENT_LIST)).unwrap();
        let first = StatedEvent { side: Side::Left, kind: EventKind::Strike, frame: 12.25 };
        assert_eq!((events.len(), events[0]), (3, first));
        assert_eq!(read(&text("")).unwrap(), []);
    }

    #[test]
    fn each_event_that_cannot_be_is_named() {
        for (from, to, expected) in [
            ("left", "middle", "event 1: side \"middle\": expected \"left\" or"),
            ("strike", "jump", "event 1: kind \"jump\""),
            ("12.25", "9.9", "event 1: frame 9.9 lies beyond the recording: expected 10 to 69"),
            ("69", "69.5", "event 3: frame 69.5 lies beyond"),
            (
                "strike",
                "off",
                "event 3: the left foot leaves at frame 69 and, in event 1, at frame 12.25",
            ),
            ("69", "12.25", "event 3: frame 12.25: event 1 of the same foot"),
        ] {
            let fault = read(&text(&EVENT_LIST.replacen(from, to, 1))).unwrap_err();
            assert!(fault.contains(expected), "{fault}");
        }
        // in turn by their times, not by their places in the list
        let between = r#", {"side": "left", "kind": "off", "frame": 30}, {"side": "left", "kind": "strike", "frame": 40}"#;
        assert_eq!(read(&text(&format!("{EVENT_LIST}{between}"))).unwrap().len(), 5);
    }

    #[test]
    fn events_of_another_recording_or_another_format_are_refused() {
        let good = text(EVENT_LIST);
        for (from, to, expected) in [
            ("\"fps\": 50", "\"fps\": 25", "fps 25, but what is analysed has 50"),
            ("\"first_frame\": 10", "\"first_frame\": 0", "first_frame 0, but"),
            ("\"frames\": 60", "\"frames\": 61", "frames 61, but"),
            ("maquette-events", "maquette-gait", "format \"maquette-gait\", version 1: expected"),
            ("\"version\": 1", "\"version\": 7", "version 7: expected"),
            ("\"fps\"", "\"hz\"", "unknown field `hz`"),
            ("\"frame\": 69", "\"time_s\": 1.2", "unknown field `time_s`"),
            ("]", "", "expected `,` or `]`"),
        ] {
            let fault = read(&good.replacen(from, to, 1)).unwrap_err();
            assert!(fault.contains(expected), "{fault}");
        }
    }
}
