//! Key points of the curves, and their distance from those of healthy people.

use maud::{Markup, html};

use super::ReportInput;
use super::identity::cautions;
use super::label;
use super::page::{Page, absent, mark, mark_legend, number};
use super::spatiotemporal::reason;
use crate::gait::{Curve, Indices, Norm, Side, VARIABLES, indices};
use crate::math::stats::mean;

pub(super) fn page(input: &ReportInput<'_>) -> Page {
    let gait = input.gait;
    let is_empty = gait.curves.is_empty();
    let indices = input.norm.and_then(|norm| indices(&gait.curves, norm));

    Page {
        id: "scores",
        title: "Key points and scores",
        body: html! {
            @if is_empty {
                (absent(&format!("No key points and no scores: {}.", reason(gait))))
            } @else {
                (key_points(&gait.curves, input.norm))
                p class="note" {
                    "Degrees; in brackets the place in the cycle, %. Fit SD: mean over the cycle. "
                    @if input.norm.is_some() { (mark_legend()) "An angle is compared with the norm at its own place in the cycle." }
                }
                h3 { "Scores against the norm" }
                @if let Some(norm) = input.norm { (cautions(norm, input.subject)) }
                @match &indices {
                    Some(indices) => (scores(indices)),
                    None => (absent("No scores: no norm has a curve in common with this recording.")),
                }
            }
        },
        is_brief: is_empty,
    }
}

/// Values at foot strike, extremes and ranges of the curves, degrees.
fn key_points(curves: &[Curve], norm: Option<&Norm>) -> Markup {
    html! {
        table class="numbers small" {
            thead { tr { @for name in
                ["Angle", "Side", "Foot strike", "Stance min", "Stance max", "Swing max", "Range", "Fit SD"]
                { th scope="col" { (name) } }
            } }

            tbody { @for curve in curves { (key_point_row(curve, norm)) } }
        }
    }
}

fn key_point_row(curve: &Curve, norm: Option<&Norm>) -> Markup {
    let key = curve.key_points();
    let degrees = |angle: f64| number(Some(angle.to_degrees()), 1);
    let beyond = |angle, percent| mark(norm.and_then(|n| n.beyond_at(curve.angle, percent, angle)));
    let with_place = |angle, percent: usize| {
        html! { td { (degrees(angle)) (beyond(angle, percent)) " " small { "(" (percent) ")" } } }
    };
    let fit_sd = curve.fit_sd.as_ref();
    let fit_sd_deg = fit_sd.and_then(|sd| mean(sd.iter().map(|sd| sd.to_degrees())));

    html! {
        tr {
            th scope="row" { (label::angle_label(curve.angle).title) }
            td class=(curve.side.name()) { (curve.side.name()) }
            td { (degrees(key.initial_contact)) (beyond(key.initial_contact, 0)) }
            (with_place(key.stance.least, key.stance.least_at_percent))
            (with_place(key.stance.greatest, key.stance.greatest_at_percent))
            (with_place(key.swing.greatest, key.swing.greatest_at_percent))
            td { (degrees(key.range)) }
            td { (number(fit_sd_deg, 1)) }
        }
    }
}

/// The Movement Analysis Profile with a bar for each score, and the Gait Profile Score.
fn scores(indices: &Indices) -> Markup {
    let variable_score = |angle, side| indices.variables.get(&(side, angle)).copied();

    html! {
        table class="numbers scores" {
            thead { tr {
                th scope="col" { "Gait Variable Score, °" }
                th scope="col" class="left" { "Left" } th scope="col" class="right" { "Right" }
            } }

            tbody {
                @for angle in VARIABLES { tr {
                    th scope="row" { (label::angle_label(angle).title) }
                    @for side in Side::BOTH { td { (bar(variable_score(angle, side), side)) } }
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
                Some(_) => { "Gait Profile Score of both sides: " (number(indices.both.map(f64::to_degrees), 1)) "°. " }
                None => { "A Gait Profile Score needs all nine variables; that of both sides is absent. " }
            }
            "Healthy people score 5–6° with the norm's own system; offsets between systems go into these scores in full."
        }
    }
}

/// Degrees that fill a bar.
const FULL_BAR_DEG: f64 = 30.0;

/// A score in degrees, and its bar.
fn bar(score: Option<f64>, side: Side) -> Markup {
    let degrees = score.map(f64::to_degrees);
    let percent = degrees.map_or(0.0, |d| (100.0 * d / FULL_BAR_DEG).clamp(0.0, 100.0));
    html! {
        span class="score" { (number(degrees, 1)) }
        span class={ "bar " (side.name()) } aria-hidden="true" { span style={ "width:" (format!("{percent:.0}")) "%" } {} }
    }
}
