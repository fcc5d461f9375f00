//! Speed, cadence, steps and phases: left, right, norm.

use maud::{Markup, html};

use super::identity::age_and_sex;
use super::label;
use super::page::{Page, footwear_note, mark, mark_legend};
use super::{ReportInput, Words};
use crate::gait::{EventKind, GaitAnalysis, Norm, Parameter, Side, Statistic};

pub(super) fn page<'a>(input: &ReportInput<'a>) -> Page<'a> {
    let words = input.words;
    let gait = input.gait;
    let is_empty = gait.parameters.is_empty();

    Page {
        id: "spatiotemporal",
        title: words.of("Steps and strides"),
        body: html! {
            @if is_empty {
                (missing(words.of("No parameters:"), gait, words))
            } @else {
                (table(gait, input.norm, words))
                @if let Some(norm) = input.norm.filter(|norm| !norm.parameters.is_empty()) {
                    (footwear_note(norm.parameters_footwear, input.subject.footwear, words))
                }
                p class="note" {
                    @if input.norm.is_some_and(|norm| !norm.parameters.is_empty()) { (mark_legend(words)) }
                    (words.of("SD: between strides. u: standard uncertainty of one value; more strides do not make it smaller.")) " "
                    (words.of("Normalised: mean of both sides by leg length and gravity (Hof 1996).")) " "
                    (words.of("Norm:")) " " (norm_in_words(input))
                }
            }
            @if !is_empty { (remarks(gait, words)) }
            @if !gait.agreement.is_empty() { (agreement(gait, words)) }
        },
        is_brief: is_empty,
    }
}

/// The source of the column Norm, or the reason why it is empty.
fn norm_in_words(input: &ReportInput<'_>) -> String {
    let words = input.words;
    let Some(norm) = input.norm else {
        return words.of("none was asked for.").into();
    };
    if !norm.parameters.is_empty() {
        let source = norm.parameters_source.as_ref().unwrap_or(&norm.source);
        return words.fill("mean ± SD between people, {source}.", &[("source", source)]);
    }
    let why = match input.subject.age_years {
        None => words.of("absent, as the age was not stated (--age, --sex).").into(),
        Some(_) => {
            let who = age_and_sex(input.subject, words);
            words.fill("absent, no table for: {who}.", &[("who", &who)])
        }
    };
    let shipped = words.of(
        "Published tables that come with the program: ages 5 to 13, 21 to 37, 50 to 69, and 70 to 89 by sex; \
        --norm takes those of your laboratory.",
    );
    format!("{why} {shipped}")
}

/// The notes of the analysis.
pub(super) fn remarks(gait: &GaitAnalysis, words: &Words) -> Markup {
    let notes = &gait.notes;
    html! { @if !notes.is_empty() { ul class="remarks" { @for note in notes { li { (words.line(note)) } } } } }
}

/// What is missing, and why there are no strides.
pub(super) fn missing(what: &str, gait: &GaitAnalysis, words: &Words) -> Markup {
    html! {
        p class="absent" {
            (what) " "
            @match gait.notes.first() {
                Some(reason) => (words.line(reason)),
                None => (words.of("the recording holds no stride")),
            }
            "."
        }
    }
}

fn table(gait: &GaitAnalysis, norm: Option<&Norm>, words: &Words) -> Markup {
    html! {
        div class="scroll" role="group" tabindex="0" aria-label=(words.of("Table")) {
            table class="numbers" {
                thead {
                    tr {
                        th rowspan="2" scope="col" { (words.of("Parameter")) }
                        th rowspan="2" scope="col" { (words.of("Unit")) }
                        th colspan="4" scope="colgroup" class="left" { (words.of("Left")) }
                        th colspan="4" scope="colgroup" class="right" { (words.of("Right")) }
                        th rowspan="2" scope="col" { "R/L, %" }
                        th rowspan="2" scope="col" { (words.of("Norm")) }
                        th rowspan="2" scope="col" { (words.of("Normalised")) }
                    }
                    tr { @for _ in 0..2 { @for name in [words.of("mean"), "SD", "u", "n"] { th scope="col" { (name) } } } }
                }

                tbody { @for parameter in Parameter::ALL { (row(parameter, gait, norm, words)) } }
            }
        }
    }
}

/// One parameter; dashes where the recording shows none of it.
fn row(parameter: Parameter, gait: &GaitAnalysis, norm: Option<&Norm>, words: &Words) -> Markup {
    let has_unit = !parameter.unit().starts_with('%');
    let cells = |side| cells(parameter, gait.parameters.get(&(parameter, side)), norm, words);
    html! {
        tr {
            th scope="row" { (label::parameter_name(parameter, words)) }
            td { (words.known(parameter.unit())) }
            (cells(Side::Left))
            (cells(Side::Right))
            td { (words.number(gait.symmetry_percent(parameter), 0)) }
            td { (norm_cell(parameter, norm, words)) }
            td { (words.number(gait.normalised(parameter).filter(|_| has_unit), 3)) }
        }
    }
}

pub(super) fn digits(parameter: Parameter) -> usize {
    match parameter.unit() {
        "m" | "s" | "m/s" => 3,
        _ => 1,
    }
}

fn cells(
    parameter: Parameter,
    statistic: Option<&Statistic>,
    norm: Option<&Norm>,
    words: &Words,
) -> Markup {
    let digits = digits(parameter);
    let beyond = statistic.and_then(|s| norm?.beyond(parameter, s.mean));
    html! {
        td class="mean" { (words.number(statistic.map(|s| s.mean), digits)) (mark(beyond, words)) }
        td { (words.number(statistic.and_then(|s| s.sd), digits)) }
        td { (words.number(statistic.and_then(|s| s.uncertainty), digits)) }
        td { (statistic.map_or(0, |s| s.n)) }
    }
}

fn norm_cell(parameter: Parameter, norm: Option<&Norm>, words: &Words) -> String {
    let digits = digits(parameter);
    match norm.and_then(|norm| norm.parameters.get(&parameter)) {
        Some((mean, sd)) => {
            let of = |value: f64| words.number(Some(value), digits);
            format!("{} ± {}", of(*mean), of(*sd))
        }
        None => "–".into(),
    }
}

fn agreement(gait: &GaitAnalysis, words: &Words) -> Markup {
    html! {
        h3 { (words.of("Foot strike and foot off by two methods")) }
        table class="facts" {
            @for agreement in &gait.agreement {
                tr {
                    th scope="row" {
                        @match agreement.kind { EventKind::Strike => (words.of("Foot strike")), EventKind::Off => (words.of("Foot off")) }
                    }

                    td {
                        @let ms = words.number(Some(1e3 * agreement.mean_s.abs()), 0);
                        @if agreement.mean_s < 0.0 {
                            (words.fill("found by speed {ms} ms before found by position", &[("ms", &ms)]))
                        } @else {
                            (words.fill("found by speed {ms} ms after found by position", &[("ms", &ms)]))
                        }
                        @if let Some(sd_s) = agreement.sd_s { ", SD " (words.number(Some(1e3 * sd_s), 0)) " ms" }
                        ", n = " (agreement.n)
                    }
                }
            }
        }
        p class="note" { (words.of("The mean belongs to the methods; a small SD says that the events are sharp.")) }
    }
}
