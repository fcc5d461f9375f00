//! Who was recorded, how it was measured, and what to know before reading on.

use maud::{Markup, html};

use super::ReportInput;
use super::page::Page;
use crate::gait::{Side, Surface};
use crate::io::gait::Sex;

pub(super) fn page(input: &ReportInput<'_>) -> Page {
    Page {
        id: "identity",
        title: "Identity and method",
        body: html! {
            (table(&person(input)))
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

type Row = (&'static str, String);

fn table(rows: &[Row]) -> Markup {
    html! {
        table class="facts" {
            @for (name, value) in rows { tr { th scope="row" { (name) } td { (value) } } }
        }
    }
}

fn person(input: &ReportInput<'_>) -> Vec<Row> {
    let identity = input.identity;
    let said = |value: &Option<String>| value.clone().unwrap_or_else(|| "not stated".into());
    vec![
        ("Person", said(&identity.subject)),
        ("Age, sex", age_and_sex(identity.person)),
        ("Date of recording", said(&identity.date)),
        ("Condition", said(&identity.condition)),
        ("Recording", identity.recording.clone()),
    ]
}

/// In words; `not stated` for neither.
pub(super) fn age_and_sex((age_years, sex): (Option<u32>, Option<Sex>)) -> String {
    let age = age_years.map(|years| format!("{years} years"));
    let sex = sex.map(|sex| match sex {
        Sex::Female => "female".to_owned(),
        Sex::Male => "male".to_owned(),
    });
    let said: Vec<String> = age.into_iter().chain(sex).collect();
    match said.is_empty() {
        true => "not stated".into(),
        false => said.join(", "),
    }
}

fn method(input: &ReportInput<'_>) -> Vec<Row> {
    let file = input.file;
    let seconds = file.frames as f64 / file.fps;
    let surface = match file.surface {
        Surface::Ground => "over ground".to_owned(),
        Surface::Treadmill => format!("treadmill, belt at {:.2} m/s", file.belt_m_s),
    };
    let strides = |side| input.gait.cycles.iter().filter(|c| c.side == side).count();
    let [left, right] = Side::BOTH.map(strides);
    let mut rows = vec![
        (
            "Length",
            format!("{} frames at {} Hz, {seconds:.1} s", file.frames, file.fps),
        ),
        ("Surface", surface),
        ("Strides used", format!("left {left}, right {right}")),
    ];
    match input.result {
        Some(result) => rows.extend(of_fit(result)),
        None => rows.push((
            "Measured by",
            "points of another system (.trc); no body was fitted".into(),
        )),
    }
    rows.push((
        "Events",
        "foot strike by the heel's speed, foot off by the toe's place (docs/gait.md)".into(),
    ));
    rows.push(("Filter", filter(input)));
    if let Some(norm) = input.norm {
        rows.push(("Norm", format!("{}: {}", norm.name, norm.source)));
        if let Some(source) = &norm.parameters_source {
            rows.push(("Norm of steps and strides", source.clone()));
        }
    }
    rows
}

fn filter(input: &ReportInput<'_>) -> String {
    let hz = input.file.cutoff_hz;
    if hz <= 0.0 {
        return "none".into();
    }
    let angles = match input.result {
        Some(_) => "; the fit's own angles are not filtered",
        None => "",
    };
    format!("places: Butterworth low pass at {hz} Hz, forwards and backwards{angles}")
}

fn of_fit(result: &crate::io::result::ResultFile) -> Vec<Row> {
    let cameras = &result.recording.cameras;
    vec![
        (
            "Measured by",
            format!(
                "{} {}: body model {} fitted to the outlines of {} cameras ({}), without markers",
                result.program.name,
                result.program.version,
                result.body,
                cameras.len(),
                cameras.join(", ")
            ),
        ),
        (
            "Joint centres",
            "places fixed to the fitted body; their standard deviations are those of the fit"
                .into(),
        ),
    ]
}

fn remarks(input: &ReportInput<'_>) -> Markup {
    let warnings = input.result.map_or(&[][..], |result| &result.warnings);
    let remarks: Vec<&String> = input.gait.notes.iter().chain(warnings).collect();
    html! {
        @if !remarks.is_empty() {
            h3 { "To be known first" }
            ul class="remarks" { @for remark in remarks { li { (remark) } } }
        }
    }
}
