//! What is read off the curves, and how far they lie from those of healthy people.

use maud::{Markup, html};

use super::ReportInput;
use super::label;
use super::page::{Page, absent, number};
use super::spatiotemporal::reason;
use crate::gait::{Indices, Side, VARIABLES};
use crate::io::gait::CurvePart;
use crate::math::stats::mean;

pub(super) fn page(input: &ReportInput<'_>) -> Page {
    Page {
        id: "scores",
        title: "Key points and scores",
        body: html! {
            @if input.file.curves.is_empty() {
                (absent(&format!("No key points and no scores: {}.", reason(input))))
            } @else {
                (key_points(&input.file.curves))
                p class="note" { "Degrees; in brackets the place in the cycle, %. Fit SD: mean over the cycle." }
                h3 { "Scores against the norm" }
                @match &input.file.indices {
                    Some(indices) => (scores(indices)),
                    None => (absent("No scores: no norm has a curve in common with this recording.")),
                }
            }
        },
        is_brief: input.file.curves.is_empty(),
    }
}

fn key_points(curves: &[CurvePart]) -> Markup {
    html! {
        table class="numbers small" {
            thead { tr { @for name in
                ["Angle", "Side", "Foot strike", "Stance min", "Stance max", "Swing max", "Range", "Fit SD"]
                { th scope="col" { (name) } }
            } }
            tbody { @for curve in curves { tr {
                th scope="row" { (label::of_angle(curve.angle).title) }
                td class=(curve.side.name()) { (curve.side.name()) }
                td { (number(Some(curve.initial_contact_deg), 1)) }
                (at(curve.stance.least, curve.stance.least_at_percent))
                (at(curve.stance.greatest, curve.stance.greatest_at_percent))
                (at(curve.swing.greatest, curve.swing.greatest_at_percent))
                td { (number(Some(curve.range_deg), 1)) }
                td { (number(curve.fit_sd_deg.as_ref().and_then(|sd| mean(sd.iter().copied())), 1)) }
            } } }
        }
    }
}

fn at(value: f64, percent: usize) -> Markup {
    html! { td { (number(Some(value), 1)) " " small { "(" (percent) ")" } } }
}

/// The Movement Analysis Profile with a bar for each score, and the Gait Profile Score.
fn scores(indices: &Indices) -> Markup {
    let of = |angle, side| {
        let own = |v: &&crate::gait::VariableScore| v.angle == angle && v.side == side;
        indices.variables.iter().find(own).map(|v| v.score)
    };
    html! {
        table class="numbers scores" {
            thead { tr {
                th scope="col" { "Gait Variable Score, °" }
                th scope="col" class="left" { "Left" } th scope="col" class="right" { "Right" }
            } }
            tbody {
                @for angle in VARIABLES { tr {
                    th scope="row" { (label::of_angle(angle).title) }
                    @for side in Side::BOTH { td { (bar(of(angle, side), side)) } }
                } }
                tr class="total" {
                    th scope="row" { "Gait Profile Score" }
                    td { (bar(indices.left, Side::Left)) }
                    td { (bar(indices.right, Side::Right)) }
                }
            }
        }
        p class="note" {
            "Root mean square distance from the norm's mean (Baker 2009); a full bar is " (FULL_BAR_DEG) "°. "
            @match indices.both {
                Some(_) => { "Gait Profile Score of both sides: " (number(indices.both, 1)) "°. " }
                None => { "A Gait Profile Score needs all nine variables; that of both sides is absent. " }
            }
            "Healthy people score 5–6° with the norm's own system; offsets between systems go into these scores in full."
        }
    }
}

/// Degrees that fill a bar.
const FULL_BAR_DEG: f64 = 30.0;

fn bar(score: Option<f64>, side: Side) -> Markup {
    let percent = score.map_or(0.0, |s| (100.0 * s / FULL_BAR_DEG).clamp(0.0, 100.0));
    html! {
        span class="score" { (number(score, 1)) }
        span class={ "bar " (side.name()) } aria-hidden="true" { span style={ "width:" (format!("{percent:.0}")) "%" } {} }
    }
}
