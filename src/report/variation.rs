//! How far numbers vary between strides and between trials, and how sure the fit is of them.

use std::collections::BTreeMap;

use maud::{Markup, html};

use super::label::{angle_label, parameter_name};
use super::page::{Page, number};
use super::spatiotemporal::digits;
use crate::gait::trials::{Measure, Quantity, Spread};

pub(super) fn page(names: &[&str], spreads: &BTreeMap<Measure, Spread>) -> Page {
    Page {
        id: "variation",
        title: "Between strides and between trials",
        body: html! {
            ul class="remarks" {
                li { strong { "SD between strides" } " says how evenly the person walks within a trial." }
                li { strong { "SD between trials" } " says how well the same walk is found again; a change that is smaller may be chance." }
                li { strong { "u, the fit's own SD" } " says how far the measurement may be off in the same way in every trial; more trials do not make it smaller." }
            }
            (table(names, spreads))
            p class="note" {
                "Mean: of the trials' values, which stand at the right in the order of the trials. A range is that of the mean curve, a score is against the norm. "
                "All strides are counted, of all trials."
            }
        },
        is_brief: false,
    }
}

fn table(names: &[&str], spreads: &BTreeMap<Measure, Spread>) -> Markup {
    html! {
        table class="numbers small" {
            thead { tr {
                @for name in ["Number", "Side", "Unit", "Mean", "SD strides", "SD trials", "u", "Strides"] { th scope="col" { (name) } }
                @for name in names { th scope="col" { (name) } }
            } }
            tbody { @for (measure, spread) in spreads { (row(*measure, spread)) } }
        }
    }
}

fn row(measure: Measure, spread: &Spread) -> Markup {
    let Measure { quantity, side } = measure;
    let cell = |value: Option<f64>| number(value, digits_of(quantity));
    html! {
        tr {
            th scope="row" { (title(quantity)) }
            td class=(side.name()) { (side.name()) }
            td { (quantity.unit()) }
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
pub(super) fn title(quantity: Quantity) -> String {
    match quantity {
        Quantity::Parameter(parameter) => parameter_name(parameter).into(),
        Quantity::Range(angle) => format!("{}, range", angle_label(angle).title),
        Quantity::VariableScore(angle) => {
            format!("{}, Gait Variable Score", angle_label(angle).title)
        }
        Quantity::ProfileScore => "Gait Profile Score".into(),
    }
}

/// Digits after the point.
pub(super) fn digits_of(quantity: Quantity) -> usize {
    match quantity {
        Quantity::Parameter(parameter) => digits(parameter),
        _ => 1,
    }
}
