//! How far numbers vary between strides and between trials, and how sure the fit is of them.

use std::collections::BTreeMap;

use maud::{Markup, html};

use super::Words;
use super::label::{angle_label, parameter_name, side_name};
use super::page::Page;
use super::spatiotemporal::digits;
use crate::gait::trials::{Measure, Quantity, Spread};

pub(super) fn page<'a>(
    names: &[&str],
    spreads: &BTreeMap<Measure, Spread>,
    words: &'a Words,
) -> Page<'a> {
    Page {
        id: "variation",
        title: words.of("Between strides and between trials"),
        body: html! {
            ul class="remarks" {
                li { strong { (words.of("SD between strides")) } " " (words.of("says how evenly the person walks within a trial.")) }
                li { strong { (words.of("SD between trials")) } " " (words.of("says how well the same walk is found again; a change that is smaller may be chance.")) }
                li { strong { (words.of("u, the fit's own SD")) } " " (words.of("says how far the measurement may be off in the same way in every trial; more trials do not make it smaller.")) }
            }
            (table(names, spreads, words))
            p class="note" {
                (words.of("Mean: of the trials' values, which stand at the right in the order of the trials. A range is that of the mean curve, a score is against the norm.")) " "
                (words.of("All strides are counted, of all trials."))
            }
        },
        is_brief: false,
    }
}

fn table(names: &[&str], spreads: &BTreeMap<Measure, Spread>, words: &Words) -> Markup {
    let what = [words.of("Number"), words.of("Side"), words.of("Unit"), words.of("Mean")];
    let how_sure = [words.of("SD strides"), words.of("SD trials"), "u", words.of("Strides")];
    html! {
        div class="scroll" role="group" tabindex="0" aria-label=(words.of("Table")) {
            table class="numbers small" {
                thead { tr {
                    @for name in what.into_iter().chain(how_sure) { th scope="col" { (name) } }
                    @for name in names { th scope="col" { (name) } }
                } }
                tbody { @for (measure, spread) in spreads { (row(*measure, spread, words)) } }
            }
        }
    }
}

fn row(measure: Measure, spread: &Spread, words: &Words) -> Markup {
    let Measure { quantity, side } = measure;
    let cell = |value: Option<f64>| words.number(value, digits_of(quantity));
    html! {
        tr {
            th scope="row" { (title(quantity, words)) }
            td class=(side.name()) { (side_name(side, words)) }
            td { (words.known(quantity.unit())) }
            td class="mean" { (cell(Some(spread.mean))) }
            td { (cell(spread.between_strides)) }
            td { (cell(spread.between_trials)) }
            td { (cell(spread.fit)) }
            td { (spread.strides) }
            @for value in &spread.values { td { (cell(*value)) } }
        }
    }
}

/// What clinicians call it.
pub(super) fn title(quantity: Quantity, words: &Words) -> String {
    match quantity {
        Quantity::Parameter(parameter) => parameter_name(parameter, words).into(),
        Quantity::Range(angle) => {
            words.fill("{angle}, range", &[("angle", &angle_label(angle, words).title)])
        }
        Quantity::VariableScore(angle) => words
            .fill("{angle}, Gait Variable Score", &[("angle", &angle_label(angle, words).title)]),
        Quantity::ProfileScore => words.of("Gait Profile Score").into(),
        Quantity::ProfileScoreWithoutOffset => {
            words.of("Gait Profile Score without offsets").into()
        }
    }
}

/// Digits after the point.
pub(super) fn digits_of(quantity: Quantity) -> usize {
    match quantity {
        Quantity::Parameter(parameter) => digits(parameter),
        _ => 1,
    }
}
