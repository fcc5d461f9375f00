//! Foot strikes and foot offs that a person states.

use maquette::gait::{
    EventKind, EventSource, GaitAnalysis, GaitOptions, Movement, Parameter, Side, StatedEvent,
    analyse, analyse_stated,
};
use nalgebra::Vector3;

use crate::walker::{RATE_HZ, Walker};

fn stated(gait: &GaitAnalysis) -> Vec<StatedEvent> {
    let event = |e: &maquette::gait::Event| StatedEvent {
        side: e.side,
        kind: e.kind,
        frame: e.time_s * RATE_HZ,
    };
    gait.events.iter().map(event).collect()
}

fn corrected(movement: &Movement, events: &[StatedEvent]) -> GaitAnalysis {
    analyse_stated(movement, events, &GaitOptions::default()).expect("a pelvis")
}

#[test]
fn the_events_that_were_found_give_the_numbers_that_they_gave() {
    let movement = Walker::new(0.4).movement().expect("a body");
    let found = analyse(&movement, &GaitOptions::default()).expect("a pelvis");
    let mut events = stated(&found);
    events.reverse();
    let gait = corrected(&movement, &events);
    assert_eq!(
        (found.event_source, gait.event_source),
        (EventSource::Detected, EventSource::Person)
    );
    assert!(gait.notes[0].starts_with("a person corrected"), "{:?}", gait.notes);
    assert!(gait.agreement.is_empty());
    assert_eq!(gait.parameters.len(), found.parameters.len());
    for (key, statistic) in &found.parameters {
        approx::assert_relative_eq!(gait.parameters[key].mean, statistic.mean, max_relative = 1e-9);
    }
}

#[test]
fn an_off_that_is_stated_later_makes_that_stance_longer_and_no_other() {
    let movement = Walker::new(0.4).movement().expect("a body");
    let found = analyse(&movement, &GaitOptions::default()).expect("a pelvis");
    let mut events = stated(&found);
    for event in &mut events {
        if (event.side, event.kind) == (Side::Left, EventKind::Off) {
            event.frame += 5.0;
        }
    }
    let gait = corrected(&movement, &events);
    let longer = |side| {
        let mean = |gait: &GaitAnalysis| gait.parameters[&(Parameter::StanceTime, side)].mean;
        mean(&gait) - mean(&found)
    };
    approx::assert_relative_eq!(longer(Side::Left), 5.0 / RATE_HZ, epsilon = 1e-9);
    approx::assert_relative_eq!(longer(Side::Right), 0.0, epsilon = 1e-9);
}

#[test]
fn stated_events_count_in_their_own_pass_and_where_the_program_finds_none() {
    let walker = Walker::new(0.3);
    let twice = walker.who_returns(80, Vector3::new(-1.0, 3.0, 0.0));
    let movement = twice.movement().expect("a body");
    let all: Vec<StatedEvent> = [1, 2]
        .into_iter()
        .flat_map(|pass| {
            let options = GaitOptions { pass: Some(pass), ..GaitOptions::default() };
            stated(&analyse(&movement, &options).expect("a pass"))
        })
        .collect();
    let gait = corrected(&movement, &all);
    assert!(!gait.events.is_empty() && gait.events.len() < all.len());

    let squat = Walker::squat().movement().expect("a body");
    let strike = StatedEvent { side: Side::Left, kind: EventKind::Strike, frame: 20.0 };
    let gait = corrected(&squat, &[strike]);
    assert_eq!(gait.events.len(), 1);
    assert!(!gait.notes.iter().any(|note| note.contains("no steps")), "{:?}", gait.notes);
    assert!(corrected(&squat, &[]).notes[0].contains("left none"));
}
