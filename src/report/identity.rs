//! Who was recorded, how it was measured, and what to know before reading on.

use std::fmt::Display;

use maud::{Markup, html};

use super::joints::stand_alone;
use super::page::{Page, footwear_note};
use super::{ReportInput, Subject, Words};
use crate::gait::{EventSource, NeutralPose, Norm, Side, Surface};
use crate::io::gait::Sex;
use crate::io::result::ResultFile;

pub(super) fn page<'a>(input: &ReportInput<'a>) -> Page<'a> {
    let words = input.words;
    let mut rows = vec![(words.of("Duration"), duration(input))];
    rows.extend(method(input));
    Page {
        id: "identity",
        title: words.of("Identity and method"),
        body: html! {
            (table(&person(input.subject, words)))
            h3 { (words.of("Method")) }
            (table(&rows))
            (remarks(input))
            p class="note" {
                (words.of("Angles follow the ISB and Grood–Suntay; signs are the same for both sides and stand on each axis.")) " "
                (words.of("Every number is defined, with its source, in docs/gait.md of Maquette; every page is explained in docs/report.md.")) " "
                (words.of("This report is a measurement, no diagnosis."))
            }
        },
        is_brief: false,
    }
}

/// What to know before a person is compared with the curves of a norm.
pub(super) fn cautions(norm: &Norm, subject: &Subject, words: &Words) -> Markup {
    html! {
        @if !norm.curves.is_empty() { (footwear_note(norm.footwear, subject.footwear, words)) }
        @for remark in &norm.remarks { p class="absent" { (words.of("Before comparing with the norm:")) " " (words.line(remark)) "." } }
    }
}

pub(super) type Row<'a> = (&'a str, String);

pub(super) fn table(rows: &[Row<'_>]) -> Markup {
    html! {
        table class="facts" {
            @for (name, value) in rows { tr { th scope="row" { (name) } td { (value) } } }
        }
    }
}

pub(super) fn person<'a>(subject: &Subject, words: &'a Words) -> Vec<Row<'a>> {
    let footwear = subject.footwear.map(|footwear| words.known(footwear.words()).to_owned());
    vec![
        (words.of("Person"), or_not_stated(subject.name.as_ref(), words)),
        (words.of("Age, sex"), age_and_sex(subject, words)),
        (words.of("Date of recording"), or_not_stated(subject.date.as_ref(), words)),
        (words.of("Condition"), or_not_stated(subject.condition.as_ref(), words)),
        (words.of("Footwear"), or_not_stated(footwear.as_ref(), words)),
        (words.of("Recording"), subject.recording.clone()),
    ]
}

pub(super) fn or_not_stated(text: Option<&String>, words: &Words) -> String {
    text.cloned().unwrap_or_else(|| words.of("not stated").into())
}

/// In words; `not stated` for neither.
pub(super) fn age_and_sex(subject: &Subject, words: &Words) -> String {
    let age = subject.age_years.map(|years| words.fill("{years} years", &[("years", &years)]));
    let sex = subject.sex.map(|sex| match sex {
        Sex::Female => words.of("female").to_owned(),
        Sex::Male => words.of("male").to_owned(),
    });
    let stated: Vec<String> = age.into_iter().chain(sex).collect();
    match stated.is_empty() {
        true => words.of("not stated").into(),
        false => stated.join(", "),
    }
}

fn duration(input: &ReportInput<'_>) -> String {
    let (frames, rate_hz) = (input.movement.frames, input.movement.rate_hz);
    let (hz, seconds) =
        (input.words.decimal(rate_hz), input.words.number(Some(frames as f64 / rate_hz), 1));
    let values: [(&str, &dyn Display); 3] = [("frames", &frames), ("hz", &hz), ("s", &seconds)];
    input.words.fill("{frames} frames at {hz} Hz, {s} s", &values)
}

/// How it was measured, whatever its duration.
pub(super) fn method<'a>(input: &ReportInput<'a>) -> Vec<Row<'a>> {
    let (gait, words) = (input.gait, input.words);
    let belt_m_s = words.number(Some(gait.course.belt_m_s), 2);
    let surface = match gait.course.surface {
        Surface::Ground => words.of("over ground").to_owned(),
        Surface::Treadmill => words.fill("treadmill, belt at {v} m/s", &[("v", &belt_m_s)]),
    };
    let strides = |side| gait.cycles.iter().filter(|c| c.side == side).count();
    let [left, right] = Side::BOTH.map(strides);
    let strides = words.fill("left {left}, right {right}", &[("left", &left), ("right", &right)]);
    let mut rows = vec![(words.of("Surface"), surface), (words.of("Strides used"), strides)];

    let measured_by = words.of("Measured by");
    match input.result {
        Some(result) => {
            let centres = words.of(
                "places fixed to the fitted body; their standard deviations are those of the fit",
            );
            rows.push((measured_by, program_and_cameras(result, words)));
            rows.push((words.of("Joint centres"), centres.into()));
        }
        None => {
            let points = words.of("points of another system (.trc); no body was fitted");
            rows.push((measured_by, points.into()));
        }
    }

    rows.push((words.of("Events"), events(gait.event_source, words).into()));
    rows.push((words.of("Filter"), filter(input)));
    if let Some(pose) = &gait.neutral {
        rows.push((words.of("Zero of angles"), zero(pose, words)));
    }

    if let Some(norm) = input.norm {
        rows.push((words.of("Norm"), format!("{}: {}", norm.name, norm.source)));
        if let Some(source) = &norm.parameters_source {
            rows.push((words.of("Norm of steps and strides"), source.clone()));
        }
    }
    rows
}

fn events(source: EventSource, words: &Words) -> &str {
    match source {
        EventSource::Detected => {
            words.of("foot strike by the heel's speed, foot off by the toe's place (docs/gait.md)")
        }
        EventSource::Person => {
            words.of("foot strikes and foot offs as a person corrected them (events.json)")
        }
    }
}

fn zero(pose: &NeutralPose, words: &Words) -> String {
    words.fill(
        "the standing pose in {trial}, but for rotation of pelvis, trunk and shoulders and for foot progression; a joint that cannot reach it does not show",
        &[("trial", &pose.source)],
    )
}

fn filter(input: &ReportInput<'_>) -> String {
    let words = input.words;
    let hz = input.gait.cutoff_hz;
    if hz <= 0.0 {
        return words.of("none").into();
    }
    let places = words.fill(
        "places: Butterworth low pass at {hz} Hz, forwards and backwards",
        &[("hz", &words.decimal(hz))],
    );
    match input.result {
        Some(_) => places + words.of("; the fit's own angles are not filtered"),
        None => places,
    }
}

/// By which program and cameras a fit was made.
fn program_and_cameras(result: &ResultFile, words: &Words) -> String {
    let cameras = &result.recording.cameras;
    let values: [(&str, &dyn Display); 3] =
        [("body", &result.body), ("n", &cameras.len()), ("names", &cameras.join(", "))];
    let fitted = if stand_alone(result) {
        words.fill(
            "body model {body} fitted to the joints that another program detected in the pictures of {n} cameras ({names}), without markers",
            &values,
        )
    } else {
        words.fill(
            "body model {body} fitted to the outlines of {n} cameras ({names}), without markers",
            &values,
        )
    };
    format!("{} {}: {fitted}", result.program.name, result.program.version)
}

fn remarks(input: &ReportInput<'_>) -> Markup {
    let warnings = input.result.map_or(&[][..], |result| &result.warnings);
    let remarks: Vec<&String> = input.gait.notes.iter().chain(warnings).collect();
    let words = input.words;
    html! {
        @if !remarks.is_empty() {
            h3 { (words.of("Before reading on")) }
            ul class="remarks" { @for remark in remarks { li { (words.line(remark)) } } }
        }
    }
}
