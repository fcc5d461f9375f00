//! Lengths and girths of the person.

use maud::{Markup, html};

use super::ReportInput;
use super::label::words;
use super::page::{Page, absent, number, probability};
use crate::io::result::{LengthPart, ResultFile};
use crate::skin::{Girth, girths};

pub(super) fn page(input: &ReportInput<'_>) -> Page {
    Page {
        id: "shape",
        title: "Shape",
        body: match input.result {
            Some(result) => fitted_shape(result, input),
            None => html! {
                (absent("Points of another system: no body was fitted."))
                @if let Some(leg) = input.gait.leg_length_m {
                    p { "Leg length, hip to knee to ankle: " (number(Some(100.0 * leg), 1)) " cm." }
                }
            },
        },
        is_brief: input.result.is_none(),
    }
}

fn fitted_shape(result: &ResultFile, input: &ReportInput<'_>) -> Markup {
    let covariance = result.shape.covariance.as_deref();
    let girths = input.body.map(|body| girths(&body.model, &body.shape, covariance));

    html! {
        div class="shape" {
            div class="portraits" {
                @for (view, name) in [("front", "from the front"), ("side", "from the side")] {
                    figure {
                        img data-portrait=(view) alt={ "The fitted body, " (name) };
                        figcaption { (name) }
                    }
                }
            }
            div {
                (length_table(&result.shape.lengths))
                @if let Some(girths) = &girths { (girth_table(girths)) }
            }
        }
        p class="note" {
            "± is the standard deviation that the fit gives the length"
            @if result.shape.lengths.iter().all(|l| l.sd_m.is_none()) {
                "; it is absent because this fit was made without the joint optimum"
            }
            ". σ is how far the proposals of the keyframes scatter, p the probability that one of them lies within ε. "
            "Joint centres lie inside the body, where outlines do not show them: the lengths also rest on statistics of people. "
            "Girths: around the limb in the middle of the length and square to it."
        }
    }
}

fn length_table(lengths: &[LengthPart]) -> Markup {
    html! {
        table class="numbers" {
            thead { tr {
                th scope="col" { "Length" } th scope="col" { "cm" } th scope="col" { "± cm" }
                th scope="col" { "ε, cm" } th scope="col" { "σ, cm" } th scope="col" { "p" sub { "ε,σ" } "(K)" }
            } }
            tbody { @for length in lengths { tr {
                th scope="row" { (words(&length.name)) }
                td class="mean" { (number(Some(100.0 * length.length_m), 1)) }
                td { (number(length.sd_m.map(|sd| 100.0 * sd), 1)) }
                td { (number(Some(100.0 * length.confidence.epsilon), 1)) }
                td { (number(length.confidence.sigma.map(|s| 100.0 * s), 2)) }
                td { (probability(length.confidence.p_within)) }
            } } }
        }
    }
}

fn girth_table(girths: &[Girth]) -> Markup {
    html! {
        table class="numbers" {
            thead { tr {
                th scope="col" { "Girth, mid-length" } th scope="col" { "cm" } th scope="col" { "± cm" }
            } }
            tbody { @for girth in girths { tr {
                th scope="row" { (words(&girth.name)) }
                td class="mean" { (number(Some(100.0 * girth.girth_m), 1)) }
                td { (number(girth.sd_m.map(|sd| 100.0 * sd), 1)) }
            } } }
        }
    }
}
