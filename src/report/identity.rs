//! Who was recorded, how it was measured, and what to know before reading on.

use maud::{Markup, html};

use super::joints::stand_alone;
use super::page::Page;
use super::{ReportInput, Subject};
use crate::gait::{EventSource, Footwear, Norm, Side, Surface};
use crate::io::gait::Sex;
use crate::io::result::ResultFile;

pub(super) fn page(input: &ReportInput<'_>) -> Page {
    Page {
        id: "identity",
        title: "Identity and method",
        body: html! {
            (table(&person(input.subject)))
            h3 { "Method" }
            (table(&method(input)))
            (remarks(input))
            p class="note" {
                "Angles follow the ISB and Grood–Suntay; signs are the same for both sides and stand on each axis. "
                "Every number is defined, with its source, in docs/gait.md of Maquette; every page is explained in docs/report.md. "
                "This report is a measurement, no diagnosis."
            }
        },
        is_brief: false,
    }
}

/// What to know before a person is compared with the curves of a norm.
pub(super) fn cautions(norm: &Norm, subject: &Subject) -> Markup {
    html! {
        @for caution in norm.cautions(subject.footwear) {
            p class="absent" { "Before comparing with the norm: " (caution) "." }
        }
    }
}

pub(super) type Row = (&'static str, String);

pub(super) fn table(rows: &[Row]) -> Markup {
    html! {
        table class="facts" {
            @for (name, value) in rows { tr { th scope="row" { (name) } td { (value) } } }
        }
    }
}

pub(super) fn person(subject: &Subject) -> Vec<Row> {
    let or_not_stated = |text: &Option<String>| text.clone().unwrap_or_else(|| "not stated".into());
    vec![
        ("Person", or_not_stated(&subject.name)),
        ("Age, sex", age_and_sex(subject)),
        ("Date of recording", or_not_stated(&subject.date)),
        ("Condition", or_not_stated(&subject.condition)),
        ("Footwear", subject.footwear.map_or("not stated", Footwear::words).into()),
        ("Recording", subject.recording.clone()),
    ]
}

/// In words; `not stated` for neither.
pub(super) fn age_and_sex(subject: &Subject) -> String {
    let age = subject.age_years.map(|years| format!("{years} years"));
    let sex = subject.sex.map(|sex| match sex {
        Sex::Female => "female".to_owned(),
        Sex::Male => "male".to_owned(),
    });
    let stated: Vec<String> = age.into_iter().chain(sex).collect();
    match stated.is_empty() {
        true => "not stated".into(),
        false => stated.join(", "),
    }
}

pub(super) fn method(input: &ReportInput<'_>) -> Vec<Row> {
    let (gait, rate_hz) = (input.gait, input.movement.rate_hz);
    let frames = input.movement.frames;
    let seconds = frames as f64 / rate_hz;
    let surface = match gait.course.surface {
        Surface::Ground => "over ground".to_owned(),
        Surface::Treadmill => format!("treadmill, belt at {:.2} m/s", gait.course.belt_m_s),
    };
    let strides = |side| gait.cycles.iter().filter(|c| c.side == side).count();
    let [left, right] = Side::BOTH.map(strides);
    let length = format!("{frames} frames at {rate_hz} Hz, {seconds:.1} s");
    let mut rows = vec![
        ("Length", length),
        ("Surface", surface),
        ("Strides used", format!("left {left}, right {right}")),
    ];

    match input.result {
        Some(result) => {
            let centres =
                "places fixed to the fitted body; their standard deviations are those of the fit";
            rows.push(("Measured by", measured_by(result)));
            rows.push(("Joint centres", centres.into()));
        }
        None => {
            rows.push(("Measured by", "points of another system (.trc); no body was fitted".into()))
        }
    }

    rows.push(("Events", events(gait.event_source).into()));
    rows.push(("Filter", filter(input)));

    if let Some(norm) = input.norm {
        rows.push(("Norm", format!("{}: {}", norm.name, norm.source)));
        if let Some(source) = &norm.parameters_source {
            rows.push(("Norm of steps and strides", source.clone()));
        }
    }
    rows
}

fn events(source: EventSource) -> &'static str {
    match source {
        EventSource::Detected => {
            "foot strike by the heel's speed, foot off by the toe's place (docs/gait.md)"
        }
        EventSource::Person => {
            "foot strikes and foot offs as a person corrected them (events.json)"
        }
    }
}

fn filter(input: &ReportInput<'_>) -> String {
    let hz = input.gait.cutoff_hz;
    if hz <= 0.0 {
        return "none".into();
    }
    let angles = match input.result {
        Some(_) => "; the fit's own angles are not filtered",
        None => "",
    };
    format!("places: Butterworth low pass at {hz} Hz, forwards and backwards{angles}")
}

/// By which program and cameras a fit was made.
fn measured_by(result: &ResultFile) -> String {
    let ResultFile { program, body, recording, .. } = result;
    let seen = if stand_alone(result) {
        "joints that another program detected in the pictures"
    } else {
        "outlines"
    };
    format!(
        "{} {}: body model {body} fitted to the {seen} of {} cameras ({}), without markers",
        program.name,
        program.version,
        recording.cameras.len(),
        recording.cameras.join(", ")
    )
}

fn remarks(input: &ReportInput<'_>) -> Markup {
    let warnings = input.result.map_or(&[][..], |result| &result.warnings);
    let remarks: Vec<&String> = input.gait.notes.iter().chain(warnings).collect();
    html! {
        @if !remarks.is_empty() {
            h3 { "Before reading on" }
            ul class="remarks" { @for remark in remarks { li { (remark) } } }
        }
    }
}
