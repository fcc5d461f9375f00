//! Gait analysis: from joint centres or markers over time to events, strides, parameters, curves and scores.
//!
//! [`analyse`] works on a [`Movement`], of a fitted body or of any system's points. Every definition, with formula, sign
//! and source, stands in docs/gait.md.
//!
//! | file            | holds                                                              |
//! |-----------------|--------------------------------------------------------------------|
//! | `landmark.rs`   | places of the body and their names                                 |
//! | `movement.rs`   | a moving body; `complete.rs`: places without a marker              |
//! | `course.rs`     | direction of walking, floor or belt                                |
//! | `events.rs`     | foot strike and foot off; `peaks.rs`, `filter.rs`: signals          |
//! | `stated.rs`     | the same, as a person states them                                   |
//! | `cycles.rs`     | strides                                                            |
//! | `parameters.rs` | speed, cadence, steps, phases                                      |
//! | `segments.rs`   | orientations of parts; `landmark_axes.rs`: from places of the body |
//! | `angle.rs`      | names and signs of joint angles; `angles.rs`: the angles of parts  |
//! | `curves.rs`     | angles over the gait cycle                                         |
//! | `trials/`       | several trials: spreads, and changes between sessions                |
//! | `neutral.rs`    | a standing pose as the zero of angles                              |
//! | `indices.rs`    | scores against healthy people; `beyond.rs`: numbers beyond theirs  |
//! | `own_norm.rs`   | healthy people of one's own, from several walks                    |

mod angle;
mod angles;
mod beyond;
mod complete;
mod course;
mod curves;
mod cycles;
mod events;
mod filter;
mod indices;
mod landmark;
mod landmark_axes;
mod movement;
mod neutral;
mod own_norm;
mod parameters;
mod passes;
mod peaks;
mod plausible;
mod segments;
mod stated;
pub mod trials;

pub use angle::Angle;
pub use angles::{AngleTracks, cardan_zxy};
pub use beyond::{BEYOND_SD, Beyond, Footwear, FootwearCaution};
pub use course::{Course, Surface};
pub use curves::{Curve, Extremes, KeyPoints, POINTS};
pub use cycles::Cycle;
pub use events::{Agreement, Event, EventKind};
pub use indices::{Band, Indices, Norm, SCORE_POINTS, Score, VARIABLES, indices};
pub use landmark::{Landmark, Paired, Side};
pub use movement::{Movement, MovementError, Track, Used};
pub use neutral::{NeutralError, NeutralPose, Zero};
pub use own_norm::{LEAST_PEOPLE, OfPeople, of_people};
pub use parameters::{Parameter, Parameters, Statistic};
pub use segments::{Axes, Limb, Segment, Segments};
pub use stated::{EventSource, StatedEvent};

use movement::by_axis;

/// Options of [`analyse`].
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct GaitOptions {
    /// Cutoff of the low pass on all places, Hz; 0: none. 10 (Pose2Sim's default for walking).
    pub cutoff_hz: f64,
    /// How far a foot swings past the pelvis at least, between its foremost and rearmost place, m; 0.1.
    pub prominence_m: f64,
    /// Speed below which a heel stands, m/s; 0.5 (Ghoussayni 2004).
    pub strike_speed_m_s: f64,
    /// Speed above which a toe has left, m/s; 1 (Pose2Sim).
    pub off_speed_m_s: f64,
    /// Floor or belt; `None`: found.
    pub surface: Option<Surface>,
    /// Which of the passes through the room, from 1 on, if the person leaves and comes back; `None`: the longest.
    pub pass: Option<usize>,
}

impl Default for GaitOptions {
    fn default() -> Self {
        Self {
            cutoff_hz: 10.0,
            prominence_m: 0.1,
            strike_speed_m_s: 0.5,
            off_speed_m_s: 1.0,
            surface: None,
            pass: None,
        }
    }
}

/// What an analysis finds.
#[derive(Debug, Clone, PartialEq)]
pub struct GaitAnalysis {
    /// Cutoff of the low pass that all places went through, Hz; 0: none.
    pub cutoff_hz: f64,
    /// How the body moves through the room.
    pub course: Course,
    /// Hip to knee to ankle, metres.
    pub leg_length_m: Option<f64>,
    /// Foot strikes and foot offs.
    pub events: Vec<Event>,
    /// Who says when they are.
    pub event_source: EventSource,
    /// How far the two methods for them agree.
    pub agreement: Vec<Agreement>,
    /// Strides.
    pub cycles: Vec<Cycle>,
    /// Spatiotemporal parameters.
    pub parameters: Parameters,
    /// Angles over time.
    pub angles: AngleTracks,
    /// Angles over the cycle.
    pub curves: Vec<Curve>,
    /// The standing pose that angles are counted from, if they are.
    pub neutral: Option<NeutralPose>,
    /// Angles that cannot be known, and why.
    pub unknown: Vec<(Angle, &'static str)>,
    /// What a person should know.
    pub notes: Vec<String>,
}

impl GaitAnalysis {
    /// The same without any number, and the reason as its first note: of a fit that cannot be used.
    pub fn withheld(mut self, reason: String) -> Self {
        self.leg_length_m = None;
        self.agreement.clear();
        self.events.clear();
        self.cycles.clear();
        self.parameters.clear();
        self.angles.clear();
        self.curves.clear();
        self.notes = vec![reason];
        self
    }
}

/// Why a movement has no gait.
#[derive(Debug, Clone, Copy, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum GaitError {
    /// There is no such pass.
    #[error("pass {pass}: the recording holds {passes} (--pass 1 is the first)")]
    NoPass {
        /// As asked for.
        pass: usize,
        /// How many there are.
        passes: usize,
    },
    /// The hips are nowhere known.
    #[error("the hips are missing in every frame: nothing shows where the person walks to")]
    NoPelvis,
}

/// Analyses the gait of a movement.
///
/// The person need not walk: without steps, or of somebody who walks backwards, there are angles over time only, and
/// [`GaitAnalysis::notes`] says so.
///
/// # Errors
/// [`GaitError::NoPelvis`].
pub fn analyse(movement: &Movement, options: &GaitOptions) -> Result<GaitAnalysis, GaitError> {
    analysis(movement, None, options)
}

/// The same with foot strikes and foot offs that a person states, in the place of those that are found. The two of one foot
/// take turns.
///
/// # Errors
/// As [`analyse`].
pub fn analyse_stated(
    movement: &Movement,
    events: &[StatedEvent],
    options: &GaitOptions,
) -> Result<GaitAnalysis, GaitError> {
    analysis(movement, Some(events), options)
}

fn analysis(
    movement: &Movement,
    stated: Option<&[StatedEvent]>,
    options: &GaitOptions,
) -> Result<GaitAnalysis, GaitError> {
    // 1. one pass through the room, without what is faster than a body moves
    let passes::OnePass { movement, frames, note: pass_note } =
        passes::one_pass(movement, options.pass)?;
    let movement = &smoothed(&movement, options.cutoff_hz);
    // 2. direction of walking, floor or belt
    let course = Course::find(movement, options.surface).ok_or(GaitError::NoPelvis)?;
    // 3. events by two methods or a person, and the strides between them
    let (events, event_source) = match stated {
        Some(stated) => (stated::events(movement, &frames, stated), EventSource::Person),
        None if course.is_backwards() => (Vec::new(), EventSource::Detected),
        None => (events::events(movement, &course, options), EventSource::Detected),
    };
    let cycles = cycles::cycles(&events, movement.rate_hz);
    let (cycles, refused) = plausible::strides(movement, cycles);
    // 4. parameters
    let walk = parameters::Walk { movement, course: &course, events: &events, cycles: &cycles };
    let parameters = walk.parameters();
    // 5. angles over time and over the cycle
    let from_landmarks;
    let segments = match &movement.segments {
        Some(segments) => segments,
        None => {
            from_landmarks = Segments::from_landmarks(movement);
            &from_landmarks
        }
    };
    let angles = angles::angles(segments, &course.heading);
    let curves = curves::curves(&angles, segments, &cycles);
    // 6. how far the methods for events agree, and what a person should know
    let kinds = [EventKind::Strike, EventKind::Off].into_iter();
    let agreement = kinds.filter_map(|kind| events::agreement(&events, kind));
    let mut notes = match event_source {
        EventSource::Person => vec![stated::note(&events)],
        EventSource::Detected => Vec::from_iter(why_no_events(&course, &events)),
    };
    notes.extend(stride_notes(&events, &cycles));
    notes.extend(pass_note.into_iter().chain(refused));
    notes.extend(plausible::frame_rate_note(&parameters));
    notes.extend(movement.remarks());

    Ok(GaitAnalysis {
        cutoff_hz: options.cutoff_hz,
        leg_length_m: movement.leg_length(),
        agreement: agreement.collect(),
        unknown: segments.unknown.iter().map(|(a, why)| (*a, *why)).collect(),
        course,
        events,
        event_source,
        cycles,
        parameters,
        angles,
        curves,
        neutral: None,
        notes,
    })
}

fn smoothed(movement: &Movement, cutoff_hz: f64) -> Movement {
    let mut smooth = movement.clone();
    if cutoff_hz > 0.0 {
        for track in smooth.tracks.values_mut() {
            *track = by_axis(track, |v| filter::low_pass(v, movement.rate_hz, cutoff_hz));
        }
    }
    smooth
}

/// Why no events were found.
fn why_no_events(course: &Course, events: &[Event]) -> Option<String> {
    if course.is_backwards() {
        return Some(format!(
            "walks backwards, at {:.2} m/s: foot strike and foot off are defined for walking forwards; angles over time only",
            course.speed_m_s.abs().max(course.belt_m_s.abs())
        ));
    }
    let no_steps = "no steps: the feet do not swing past the pelvis in turn; angles over time only";
    events.is_empty().then(|| no_steps.into())
}

/// Which strides the events lack.
fn stride_notes(events: &[Event], cycles: &[Cycle]) -> Vec<String> {
    let mut notes = Vec::new();
    if events.is_empty() {
        return notes;
    }

    for side in Side::BOTH {
        let name = side.name();
        let own = || cycles.iter().filter(|c| c.side == side);
        let is_own_strike = |e: &&Event| e.side == side && e.kind == EventKind::Strike;
        let strikes = events.iter().filter(is_own_strike).count();

        if own().next().is_none() {
            notes.push(format!(
                "less than one {name} stride ({strikes} foot strike{} of that side): no stride parameters and curves of it",
                if strikes == 1 { "" } else { "s" }
            ));
        } else if own().any(|c| c.is_joined) {
            notes.push(format!(
                "the recording holds no whole {name} stride from strike to strike: it is joined from a stance and the swing before it"
            ));
        }
    }
    notes
}
