//! Speed, cadence, steps and phases: left, right, norm.

use maud::{Markup, html};

use super::ReportInput;
use super::identity::age_and_sex;
use super::label;
use super::page::{Page, absent, footwear_note, mark, mark_legend, number};
use crate::gait::{EventKind, GaitAnalysis, Norm, Parameter, Side, Statistic};

pub(super) fn page(input: &ReportInput<'_>) -> Page {
    let gait = input.gait;
    let is_empty = gait.parameters.is_empty();

    Page {
        id: "spatiotemporal",
        title: "Steps and strides",
        body: html! {
            @if is_empty {
                (absent(&format!("No parameters: {}.", reason(gait))))
            } @else {
                (table(gait, input.norm))
                @if let Some(norm) = input.norm.filter(|norm| !norm.parameters.is_empty()) {
                    (footwear_note(norm.parameters_footwear, input.subject.footwear))
                }
                p class="note" {
                    @if input.norm.is_some_and(|norm| !norm.parameters.is_empty()) { (mark_legend()) }
                    "SD: between strides. u: standard uncertainty of one value; more strides do not make it smaller. "
                    "Normalised: mean of both sides by leg length and gravity (Hof 1996). "
                    "Norm: " (norm_in_words(input))
                }
            }
            @if !is_empty { (remarks(gait)) }
            @if !gait.agreement.is_empty() { (agreement(gait)) }
        },
        is_brief: is_empty,
    }
}

/// The source of the column Norm, or the reason why it is empty.
fn norm_in_words(input: &ReportInput<'_>) -> String {
    let Some(norm) = input.norm else {
        return "none was asked for.".into();
    };
    if !norm.parameters.is_empty() {
        let source = norm.parameters_source.as_ref().unwrap_or(&norm.source);
        return format!("mean ± SD between people, {source}.");
    }
    let shipped = "Published tables that come with the program: ages 5 to 13, 21 to 37, 50 to 69, and 70 to 89 by sex; \
        --norm takes those of your laboratory.";
    let why = match input.subject.age_years {
        None => "as the age was not stated (--age, --sex)".into(),
        Some(_) => format!("no table for: {}", age_and_sex(input.subject)),
    };
    format!("absent, {why}. {shipped}")
}

/// The notes of the analysis.
pub(super) fn remarks(gait: &GaitAnalysis) -> Markup {
    let notes = &gait.notes;
    html! { @if !notes.is_empty() { ul class="remarks" { @for note in notes { li { (note) } } } } }
}

/// Why there are no strides.
pub(super) fn reason(gait: &GaitAnalysis) -> String {
    let first = gait.notes.first();
    first.map_or_else(|| "the recording holds no stride".into(), Clone::clone)
}

fn table(gait: &GaitAnalysis, norm: Option<&Norm>) -> Markup {
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

            tbody { @for parameter in Parameter::ALL { (row(parameter, gait, norm)) } }
        }
    }
}

/// One parameter; dashes where the recording shows none of it.
fn row(parameter: Parameter, gait: &GaitAnalysis, norm: Option<&Norm>) -> Markup {
    let has_unit = !parameter.unit().starts_with('%');
    let statistic = |side| gait.parameters.get(&(parameter, side));
    html! {
        tr {
            th scope="row" { (label::parameter_name(parameter)) }
            td { (parameter.unit()) }
            (cells(parameter, statistic(Side::Left), norm))
            (cells(parameter, statistic(Side::Right), norm))
            td { (number(gait.symmetry_percent(parameter), 0)) }
            td { (norm_cell(parameter, norm)) }
            td { (number(gait.normalised(parameter).filter(|_| has_unit), 3)) }
        }
    }
}

pub(super) fn digits(parameter: Parameter) -> usize {
    match parameter.unit() {
        "m" | "s" | "m/s" => 3,
        _ => 1,
    }
}

fn cells(parameter: Parameter, statistic: Option<&Statistic>, norm: Option<&Norm>) -> Markup {
    let digits = digits(parameter);
    let beyond = statistic.and_then(|s| norm?.beyond(parameter, s.mean));
    html! {
        td class="mean" { (number(statistic.map(|s| s.mean), digits)) (mark(beyond)) }
        td { (number(statistic.and_then(|s| s.sd), digits)) }
        td { (number(statistic.and_then(|s| s.uncertainty), digits)) }
        td { (statistic.map_or(0, |s| s.n)) }
    }
}

fn norm_cell(parameter: Parameter, norm: Option<&Norm>) -> String {
    let digits = digits(parameter);
    match norm.and_then(|norm| norm.parameters.get(&parameter)) {
        Some((mean, sd)) => {
            let (mean, sd) = (number(Some(*mean), digits), number(Some(*sd), digits));
            format!("{mean} ± {sd}")
        }
        None => "–".into(),
    }
}

fn agreement(gait: &GaitAnalysis) -> Markup {
    html! {
        h3 { "Foot strike and foot off by two methods" }
        table class="facts" {
            @for agreement in &gait.agreement {
                tr {
                    th scope="row" {
                        @match agreement.kind { EventKind::Strike => "Foot strike", EventKind::Off => "Foot off" }
                    }

                    td {
                        "found by speed " (number(Some(1e3 * agreement.mean_s.abs()), 0)) " ms "
                        @if agreement.mean_s < 0.0 { "before" } @else { "after" } " found by position"
                        @if let Some(sd_s) = agreement.sd_s { ", SD " (number(Some(1e3 * sd_s), 0)) " ms" }
                        ", n = " (agreement.n)
                    }
                }
            }
        }
        p class="note" { "The mean belongs to the methods; a small SD says that the events are sharp." }
    }
}
