//! Speed, cadence, steps and phases: left, right, norm.

use maud::{Markup, html};

use super::ReportInput;
use super::identity::age_and_sex;
use super::label;
use super::page::{Page, absent, number};
use crate::gait::{EventKind, Norm, Parameter, Statistic};
use crate::io::gait::ParameterPart;

pub(super) fn page(input: &ReportInput<'_>) -> Page {
    let file = input.file;
    Page {
        id: "spatiotemporal",
        title: "Steps and strides",
        body: html! {
            @if file.parameters.is_empty() {
                (absent(&format!("No parameters: {}.", reason(input))))
            } @else {
                (table(&file.parameters, input.norm))
                p class="note" {
                    "SD: between strides. u: standard uncertainty of one value; more strides do not make it smaller. "
                    "Normalised: mean of both sides by leg length and gravity (Hof 1996). "
                    "Norm: " (norm_in_words(input))
                }
            }
            @if !file.parameters.is_empty() { (remarks(input)) }
            @if !file.agreement.is_empty() { (agreement(input)) }
        },
        is_brief: file.parameters.is_empty(),
    }
}

/// Whose numbers the column Norm holds, or why it is empty.
fn norm_in_words(input: &ReportInput<'_>) -> String {
    let Some(norm) = input.norm else {
        return "none was asked for.".into();
    };
    if !norm.parameters.is_empty() {
        let source = norm.parameters_source.as_ref().unwrap_or(&norm.source);
        return format!("mean ± SD between people, {source}.");
    }
    let shipped = "Published tables that come with the program: ages 5 to 13, and 70 to 89 by sex; \
        --norm takes those of your laboratory.";
    let why = match input.identity.person {
        (None, _) => "as the age was not stated (--age, --sex)".into(),
        person => format!("no table for: {}", age_and_sex(person)),
    };
    format!("absent, {why}. {shipped}")
}

/// What is to be known of the strides.
pub(super) fn remarks(input: &ReportInput<'_>) -> Markup {
    let notes = &input.gait.notes;
    html! { @if !notes.is_empty() { ul class="remarks" { @for note in notes { li { (note) } } } } }
}

/// Why there are no strides.
pub(super) fn reason(input: &ReportInput<'_>) -> String {
    let first = input.gait.notes.first();
    first.map_or_else(|| "the recording holds no stride".into(), Clone::clone)
}

fn table(parameters: &[ParameterPart], norm: Option<&Norm>) -> Markup {
    html! {
        table class="numbers" {
            thead {
                tr {
                    th rowspan="2" scope="col" { "Parameter" }
                    th rowspan="2" scope="col" { "Unit" }
                    th colspan="4" scope="colgroup" class="left" { "Left" }
                    th colspan="4" scope="colgroup" class="right" { "Right" }
                    th rowspan="2" scope="col" { "R/L, %" }
                    th rowspan="2" scope="col" { "Norm" }
                    th rowspan="2" scope="col" { "Normal­ised" }
                }
                tr { @for _ in 0..2 { @for name in ["mean", "SD", "u", "n"] { th scope="col" { (name) } } } }
            }
            tbody {
                @for name in Parameter::ALL {
                    (row(name, parameters.iter().find(|part| part.name == name), norm))
                }
            }
        }
    }
}

/// One parameter; dashes where the recording holds none of it.
fn row(name: Parameter, part: Option<&ParameterPart>, norm: Option<&Norm>) -> Markup {
    let has_unit = !name.unit().starts_with('%');
    html! {
        tr {
            th scope="row" { (label::of_parameter(name)) }
            td { (name.unit()) }
            (cells(name, part.and_then(|p| p.left.as_ref())))
            (cells(name, part.and_then(|p| p.right.as_ref())))
            td { (number(part.and_then(|p| p.symmetry_percent), 0)) }
            td { (of_norm(name, norm)) }
            td { (number(part.and_then(|p| p.normalised).filter(|_| has_unit), 3)) }
        }
    }
}

fn digits(name: Parameter) -> usize {
    match name.unit() {
        "m" | "s" | "m/s" => 3,
        _ => 1,
    }
}

fn cells(name: Parameter, statistic: Option<&Statistic>) -> Markup {
    let digits = digits(name);
    html! {
        td class="mean" { (number(statistic.map(|s| s.mean), digits)) }
        td { (number(statistic.and_then(|s| s.sd), digits)) }
        td { (number(statistic.and_then(|s| s.uncertainty), digits)) }
        td { (statistic.map_or(0, |s| s.n)) }
    }
}

fn of_norm(name: Parameter, norm: Option<&Norm>) -> String {
    let of = norm.and_then(|norm| norm.parameters.get(&name));
    let digits = digits(name);
    of.map_or("–".into(), |(mean, sd)| {
        format!(
            "{} ± {}",
            number(Some(*mean), digits),
            number(Some(*sd), digits)
        )
    })
}

fn agreement(input: &ReportInput<'_>) -> Markup {
    html! {
        h3 { "Foot strike and foot off by two methods" }
        table class="facts" {
            @for of in &input.file.agreement {
                tr {
                    th scope="row" {
                        @match of.kind { EventKind::Strike => "Foot strike", EventKind::Off => "Foot off" }
                    }
                    td {
                        "found by speed " (number(Some(1e3 * of.mean_s.abs()), 0)) " ms "
                        @if of.mean_s < 0.0 { "before" } @else { "after" } " found by position"
                        @if let Some(sd_s) = of.sd_s { ", SD " (number(Some(1e3 * sd_s), 0)) " ms" }
                        ", n = " (of.n)
                    }
                }
            }
        }
        p class="note" { "The mean belongs to the methods; a small SD says that the events are sharp." }
    }
}
