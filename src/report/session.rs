//! The report of a session: all strides of all trials.

use std::collections::BTreeMap;

use maud::{Markup, html};

use super::glance::glance;
use super::identity::{self, method, or_not_stated, person};
use super::label::part_name;
use super::page::{self, Page};
use super::variation::{self, digits_of, title};
use super::{
    ReportInput, Subject, Words, kinematics, motion, scene, scores, shape, spatiotemporal,
};
use crate::gait::trials::{Measure, Quantity, Spread};
use crate::gait::{Angle, GaitAnalysis, Norm, Parameter, Side};
use crate::io::session::{SessionFile, TrialPart};

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
    let words = first.words;
    let names: Vec<&str> = input.trials.iter().map(|trial| trial.name).collect();
    let scene = serde_json::to_string(&scene::Scene::new(first))?;
    let moving = motion::page(first, None);
    let pages = [
        summary(input, &all),
        trials(input, words),
        variation::page(&names, input.spreads, words),
        spatiotemporal::page(&all),
        kinematics::page(&all),
        kinematics::consistency(&all),
        scores::page(&all),
        shape::page(&all),
        Page {
            body: html! { p class="note" { (words.fill("Trial {name}.", &[("name", &names[0])])) } (moving.body) },
            ..moving
        },
    ];
    let odd = input
        .file
        .disagreements
        .first()
        .map(|odd| html! { p class="verdict" role="alert" { (words.line(&odd.line)) } });
    Ok(page::document(input.subject, odd.as_ref(), &pages, Some(&scene), words))
}

/// The numbers of page one.
const HEADLINES: [Quantity; 8] = [
    Quantity::Parameter(Parameter::Speed),
    Quantity::Parameter(Parameter::Cadence),
    Quantity::Parameter(Parameter::StepLength),
    Quantity::Parameter(Parameter::StepWidth),
    Quantity::Parameter(Parameter::Stance),
    Quantity::Range(Angle::KneeFlexion),
    Quantity::ProfileScore,
    Quantity::ProfileScoreWithoutOffset,
];

/// Who it was, what was found, and how it was measured.
fn summary<'a>(input: &SessionInput<'_>, all: &ReportInput<'a>) -> Page<'a> {
    let words = all.words;
    let file = input.file;
    let mut rows = person(input.subject, words);
    let stated = &file.person;
    let side = stated.affected_side.map(|side| words.known(side.words()).to_owned());
    rows.extend([
        (words.of("Diagnosis"), or_not_stated(stated.diagnosis.as_ref(), words)),
        (words.of("Affected side"), or_not_stated(side.as_ref(), words)),
        (words.of("Height, mass"), size(stated.height_m, stated.mass_kg, words)),
        (words.of("Operator"), or_not_stated(file.operator.as_ref(), words)),
    ]);
    Page {
        id: "identity",
        title: words.of("Person and summary"),
        body: html! {
            (identity::table(&rows))
            h3 { (words.fill("Summary of {n} trials", &[("n", &input.trials.len())])) }
            (headlines(input.spreads, words))
            p class="note" { (words.of("Mean of the trials ± SD between trials (SD between strides within a trial).")) }
            @if !file.notes.is_empty() {
                h3 { (words.of("Before reading on")) }
                ul class="remarks" { @for note in &file.notes { li { (words.line(note)) } } }
            }
            h3 { (words.of("Method")) }
            (identity::table(&method(all)))
            p class="note" {
                (words.of("All trials have one body: its lengths, its clothes and the places of the cameras are one, the motion is each trial's own.")) " "
                (words.of("Every number is defined, with its source, in docs/gait.md and docs/session.md of Maquette.")) " "
                (words.of("This report is a measurement, no diagnosis."))
            }
        },
        is_brief: false,
    }
}

fn size(height_m: Option<f64>, mass_kg: Option<f64>, words: &Words) -> String {
    let height = height_m.map(|height_m| format!("{} m", words.number(Some(height_m), 2)));
    let mass = mass_kg.map(|mass_kg| format!("{mass_kg:.0} kg"));
    let stated: Vec<String> = height.into_iter().chain(mass).collect();
    if stated.is_empty() { words.of("not stated").into() } else { stated.join(", ") }
}

fn headlines(spreads: &BTreeMap<Measure, Spread>, words: &Words) -> Markup {
    let cell = |quantity: Quantity, side: Side| {
        let digits = digits_of(quantity);
        let spread = spreads.get(&Measure { quantity, side });
        html! {
            td class="mean" { (words.number(spread.map(|s| s.mean), digits)) }
            td { "± " (words.number(spread.and_then(|s| s.between_trials), digits)) }
            td { "(" (words.number(spread.and_then(|s| s.between_strides), digits)) ")" }
        }
    };
    html! {
        div class="scroll" role="group" tabindex="0" aria-label=(words.of("Table")) {
            table class="numbers" {
                thead { tr {
                    td {} th scope="col" { (words.of("Unit")) }
                    th colspan="3" scope="colgroup" class="left" { (words.of("Left")) }
                    th colspan="3" scope="colgroup" class="right" { (words.of("Right")) }
                } }
                tbody { @for quantity in HEADLINES { tr {
                    th scope="row" { (title(quantity, words)) }
                    td { (words.known(quantity.unit())) }
                    @for side in Side::BOTH { (cell(quantity, side)) }
                } } }
            }
        }
    }
}

/// What each trial is worth.
fn trials<'a>(input: &SessionInput<'_>, words: &'a Words) -> Page<'a> {
    let file = input.file;
    let walk = |name: &str| input.trials.iter().find(|trial| trial.name == name);
    let strides = |name: &str, side| {
        Some(walk(name)?.input.gait.cycles.iter().filter(|c| c.side == side).count())
    };
    let condition = |part: &TrialPart| match (&part.condition, part.standing) {
        (_, true) => html! { (words.of("standing: the zero of all angles")) },
        (condition, false) => html! { (condition.as_deref().unwrap_or("–")) },
    };
    let names = [
        words.of("Trial"),
        words.of("From the side"),
        words.of("Condition"),
        words.of("Seconds"),
        words.of("Strides left"),
        words.of("Strides right"),
        words.of("Verdict"),
    ];
    Page {
        id: "trials",
        title: words.of("Trials"),
        body: html! {
            div class="scroll" role="group" tabindex="0" aria-label=(words.of("Table")) {
                table class="numbers" {
                    thead { tr { @for name in names { th scope="col" { (name) } } } }
                    tbody { @for part in &file.trials { tr {
                        th scope="row" { (part.name) }
                        td { @if let Some(picture) = walk(&part.name).and_then(|walk| glance(&walk.input)) { (picture) } }
                        td { (condition(part)) }
                        td { (words.number(Some(part.frames as f64 / part.fps), 1)) }
                        @for side in Side::BOTH { td { @match strides(&part.name, side) { Some(count) => (count), None => "–" } } }
                        td { (verdict(input, &part.name, part.verdict.as_deref(), words)) }
                    } } }
                }
            }
            @if !file.without.is_empty() { p class="note" { (words.fill("Left out: {names}.", &[("names", &file.without.join(", "))])) } }
            h3 { (words.of("The same lengths in every trial")) }
            (lengths(file, words))
            p class="note" { (words.of("cm. Of all trials together, ± SD; at the right what each trial says alone. They differ by what each trial shows of the body. \
                Each alone leans more on what is known of people, so what all say together may lie beyond them.")) }
        },
        is_brief: false,
    }
}

fn verdict(input: &SessionInput<'_>, name: &str, own: Option<&str>, words: &Words) -> Markup {
    let odd = input.file.disagreements.iter().find(|odd| odd.trial == name);
    match (odd, own) {
        (Some(odd), _) => words.line(&odd.line),
        (None, Some(own)) => words.line(own),
        (None, None) => html! { (words.of("usable")) },
    }
}

fn lengths(file: &SessionFile, words: &Words) -> Markup {
    let cm = |metres: f64| words.number(Some(100.0 * metres), 1);
    html! {
        div class="scroll" role="group" tabindex="0" aria-label=(words.of("Table")) {
            table class="numbers small" {
                thead { tr {
                    th scope="col" { (words.of("Length")) } th scope="col" { (words.of("All")) } th scope="col" { "± SD" }
                    @for trial in &file.trials { th scope="col" { (trial.name) } }
                } }
                tbody { @for length in &file.lengths { tr {
                    th scope="row" { (part_name(&length.name, words)) }
                    td class="mean" { (cm(length.length_m)) }
                    td { (words.number(length.sd_m.map(|sd| 100.0 * sd), 1)) }
                    @for own in &length.alone_m { td { (cm(*own)) } }
                } } }
            }
        }
    }
}
