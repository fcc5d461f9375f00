//! The report of a session: all strides of all trials.

use std::collections::BTreeMap;

use maud::{Markup, html};

use super::identity::{self, method, person};
use super::page::{self, Page, number};
use super::variation::{self, digits_of, title};
use super::{ReportInput, Subject, kinematics, motion, scene, scores, shape, spatiotemporal};
use crate::gait::trials::{Measure, Quantity, Spread};
use crate::gait::{Angle, GaitAnalysis, Norm, Parameter, Side};
use crate::io::session::SessionFile;

/// A trial and what its own report shows.
#[derive(Debug, Clone, Copy)]
pub struct ReportedTrial<'a> {
    /// Its name.
    pub name: &'a str,
    /// What its report shows.
    pub input: ReportInput<'a>,
}

/// What the report of a session shows.
#[derive(Debug, Clone, Copy)]
pub struct SessionInput<'a> {
    /// Who and when.
    pub subject: &'a Subject,
    /// The session.
    pub file: &'a SessionFile,
    /// Trial by trial.
    pub trials: &'a [ReportedTrial<'a>],
    /// All strides together.
    pub pooled: &'a GaitAnalysis,
    /// How far numbers vary.
    pub spreads: &'a BTreeMap<Measure, Spread>,
    /// Healthy people.
    pub norm: Option<&'a Norm>,
}

/// The report of a session as the text of one file; the body in motion is that of the first trial.
///
/// # Errors
/// The serialiser's, if it has any.
///
/// # Panics
/// Without any trial.
pub fn session_html(input: &SessionInput<'_>) -> Result<String, serde_json::Error> {
    let first = &input.trials.first().expect("a session has a trial").input;
    let all =
        ReportInput { gait: input.pooled, subject: input.subject, norm: input.norm, ..*first };
    let names: Vec<&str> = input.trials.iter().map(|trial| trial.name).collect();
    let scene = serde_json::to_string(&scene::Scene::new(first))?;
    let moving = motion::page(first, None);
    let pages = [
        summary(input, &all),
        trials(input),
        variation::page(&names, input.spreads),
        spatiotemporal::page(&all),
        kinematics::page(&all),
        kinematics::consistency(&all),
        scores::page(&all),
        shape::page(&all),
        Page { body: html! { p class="note" { "Trial " (names[0]) "." } (moving.body) }, ..moving },
    ];
    let odd = input
        .file
        .disagreements
        .first()
        .map(|odd| html! { p class="verdict" role="alert" { (odd.line) } });
    Ok(page::document(input.subject, odd.as_ref(), &pages, Some(&scene)))
}

/// The numbers of page one.
const HEADLINES: [Quantity; 7] = [
    Quantity::Parameter(Parameter::Speed),
    Quantity::Parameter(Parameter::Cadence),
    Quantity::Parameter(Parameter::StepLength),
    Quantity::Parameter(Parameter::StepWidth),
    Quantity::Parameter(Parameter::Stance),
    Quantity::Range(Angle::KneeFlexion),
    Quantity::ProfileScore,
];

/// Who it was, what was found, and how it was measured.
fn summary(input: &SessionInput<'_>, all: &ReportInput<'_>) -> Page {
    let file = input.file;
    let mut rows = person(input.subject);
    let stated = &file.person;
    let words = |text: &Option<String>| text.clone().unwrap_or_else(|| "not stated".into());
    rows.extend([
        ("Diagnosis", words(&stated.diagnosis)),
        ("Affected side", stated.affected_side.map_or("not stated", |side| side.words()).into()),
        ("Height, mass", size(stated.height_m, stated.mass_kg)),
        ("Operator", words(&file.operator)),
    ]);
    Page {
        id: "identity",
        title: "Person and summary",
        body: html! {
            (identity::table(&rows))
            h3 { "Summary of " (input.trials.len()) " trials" }
            (headlines(input.spreads))
            p class="note" { "Mean of the trials ± SD between trials (SD between strides within a trial)." }
            @if !file.notes.is_empty() {
                h3 { "Before reading on" }
                ul class="remarks" { @for note in &file.notes { li { (note) } } }
            }
            h3 { "Method" }
            (identity::table(&of_all_trials(all)))
            p class="note" {
                "All trials have one body: its lengths, its clothes and the places of the cameras are one, the motion is each trial's own. "
                "Every number is defined, with its source, in docs/gait.md and docs/session.md of Maquette. This report is a measurement, no diagnosis."
            }
        },
        is_brief: false,
    }
}

fn size(height_m: Option<f64>, mass_kg: Option<f64>) -> String {
    let height = height_m.map(|height_m| format!("{height_m:.2} m"));
    let mass = mass_kg.map(|mass_kg| format!("{mass_kg:.0} kg"));
    let stated: Vec<String> = height.into_iter().chain(mass).collect();
    if stated.is_empty() { "not stated".into() } else { stated.join(", ") }
}

/// The method without what is of one trial.
fn of_all_trials(all: &ReportInput<'_>) -> Vec<identity::Row> {
    method(all).into_iter().filter(|(name, _)| *name != "Length").collect()
}

fn headlines(spreads: &BTreeMap<Measure, Spread>) -> Markup {
    let cell = |quantity: Quantity, side: Side| {
        let digits = digits_of(quantity);
        let spread = spreads.get(&Measure { quantity, side });
        html! {
            td class="mean" { (number(spread.map(|s| s.mean), digits)) }
            td { "± " (number(spread.and_then(|s| s.between_trials), digits)) }
            td { "(" (number(spread.and_then(|s| s.between_strides), digits)) ")" }
        }
    };
    html! {
        table class="numbers" {
            thead { tr {
                th scope="col" { "" } th scope="col" { "Unit" }
                th colspan="3" scope="colgroup" class="left" { "Left" }
                th colspan="3" scope="colgroup" class="right" { "Right" }
            } }
            tbody { @for quantity in HEADLINES { tr {
                th scope="row" { (title(quantity)) }
                td { (quantity.unit()) }
                @for side in Side::BOTH { (cell(quantity, side)) }
            } } }
        }
    }
}

/// What each trial is worth.
fn trials(input: &SessionInput<'_>) -> Page {
    let file = input.file;
    let strides = |gait: &GaitAnalysis, side| gait.cycles.iter().filter(|c| c.side == side).count();
    Page {
        id: "trials",
        title: "Trials",
        body: html! {
            table class="numbers" {
                thead { tr { @for name in ["Trial", "Condition", "Seconds", "Strides left", "right", "Verdict"] { th scope="col" { (name) } } } }
                tbody { @for (part, trial) in file.trials.iter().zip(input.trials) { tr {
                    th scope="row" { (part.name) }
                    td { (part.condition.as_deref().unwrap_or("–")) }
                    td { (number(Some(part.frames as f64 / part.fps), 1)) }
                    @for side in Side::BOTH { td { (strides(trial.input.gait, side)) } }
                    td { (verdict(input, &part.name, part.verdict.as_deref())) }
                } } }
            }
            @if !file.without.is_empty() { p class="note" { "Left out: " (file.without.join(", ")) "." } }
            h3 { "The same lengths in every trial" }
            (lengths(file))
            p class="note" { "cm. Of all trials together, ± SD; at the right what each trial says alone. They differ by what each trial shows of the body." }
        },
        is_brief: false,
    }
}

fn verdict(input: &SessionInput<'_>, name: &str, own: Option<&str>) -> String {
    let odd = input.file.disagreements.iter().find(|odd| odd.trial == name);
    match (odd, own) {
        (Some(odd), _) => odd.line.clone(),
        (None, Some(own)) => own.into(),
        (None, None) => "usable".into(),
    }
}

fn lengths(file: &SessionFile) -> Markup {
    let cm = |metres: f64| number(Some(100.0 * metres), 1);
    html! {
        table class="numbers small" {
            thead { tr {
                th scope="col" { "Length" } th scope="col" { "All" } th scope="col" { "± SD" }
                @for trial in &file.trials { th scope="col" { (trial.name) } }
            } }
            tbody { @for length in &file.lengths { tr {
                th scope="row" { (length.name.replace('_', " ")) }
                td class="mean" { (cm(length.length_m)) }
                td { (number(length.sd_m.map(|sd| 100.0 * sd), 1)) }
                @for own in &length.alone_m { td { (cm(*own)) } }
            } } }
        }
    }
}
