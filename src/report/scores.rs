//! Key points of the curves, and their distance from those of healthy people.

use maud::{Markup, html};

use super::identity::cautions;
use super::label;
use super::page::{Page, absent, mark, mark_legend};
use super::spatiotemporal::missing;
use super::{ReportInput, Words};
use crate::gait::{Curve, Indices, Norm, Score, Side, VARIABLES, indices};
use crate::math::stats::mean;

pub(super) fn page<'a>(input: &ReportInput<'a>) -> Page<'a> {
    let (gait, words) = (input.gait, input.words);
    let is_empty = gait.curves.is_empty();
    let indices = input.norm.and_then(|norm| indices(&gait.curves, norm));

    Page {
        id: "scores",
        title: words.of("Key points and scores"),
        body: html! {
            @if is_empty {
                (missing(words.of("No key points and no scores:"), gait, words))
            } @else {
                (key_points(&gait.curves, input.norm, words))
                p class="note" {
                    (words.of("Degrees; in brackets the place in the cycle, %. Fit SD: mean over the cycle.")) " "
                    @if input.norm.is_some() { (mark_legend(words)) (words.of("An angle is compared with the norm at its own place in the cycle.")) }
                }
                h3 { (words.of("Scores against the norm")) }
                @if let Some(norm) = input.norm { (cautions(norm, input.subject, words)) }
                @match &indices {
                    Some(indices) => (scores(indices, words)),
                    None => (absent(words.of("No scores: no norm has a curve in common with this recording."))),
                }
            }
        },
        is_brief: is_empty,
    }
}

/// Values at foot strike, extremes and ranges of the curves, degrees.
fn key_points(curves: &[Curve], norm: Option<&Norm>, words: &Words) -> Markup {
    let extremes = [words.of("Stance min"), words.of("Stance max"), words.of("Swing max")];
    let end = [words.of("Range"), words.of("Fit SD")];
    let names = [words.of("Angle"), words.of("Side"), words.of("Foot strike")];
    html! {
        div class="scroll" role="group" tabindex="0" aria-label=(words.of("Table")) {
            table class="numbers small" {
                thead { tr { @for name in names.into_iter().chain(extremes).chain(end) { th scope="col" { (name) } } } }

                tbody { @for curve in curves { (key_point_row(curve, norm, words)) } }
            }
        }
    }
}

fn key_point_row(curve: &Curve, norm: Option<&Norm>, words: &Words) -> Markup {
    let key = curve.key_points();
    let degrees = |angle: f64| words.number(Some(angle.to_degrees()), 1);
    let beyond =
        |angle, percent| mark(norm.and_then(|n| n.beyond_at(curve.angle, percent, angle)), words);
    let with_place = |angle, percent: usize| {
        html! { td { (degrees(angle)) (beyond(angle, percent)) " " small { "(" (percent) ")" } } }
    };
    let fit_sd = curve.fit_sd.as_ref();
    let fit_sd_deg = fit_sd.and_then(|sd| mean(sd.iter().map(|sd| sd.to_degrees())));

    html! {
        tr {
            th scope="row" { (label::angle_label(curve.angle, words).title) }
            td class=(curve.side.name()) { (label::side_name(curve.side, words)) }
            td { (degrees(key.initial_contact)) (beyond(key.initial_contact, 0)) }
            (with_place(key.stance.least, key.stance.least_at_percent))
            (with_place(key.stance.greatest, key.stance.greatest_at_percent))
            (with_place(key.swing.greatest, key.swing.greatest_at_percent))
            td { (degrees(key.range)) }
            td { (words.number(fit_sd_deg, 1)) }
        }
    }
}

/// The Movement Analysis Profile with a bar for each score, and the Gait Profile Score.
fn scores(indices: &Indices, words: &Words) -> Markup {
    let variable_score = |angle, side| indices.variables.get(&(side, angle)).copied();

    html! {
        div class="scroll" role="group" tabindex="0" aria-label=(words.of("Table")) {
            table class="numbers scores" {
                thead { tr {
                    th scope="col" { (words.of("Gait Variable Score, ° (without offset)")) }
                    th scope="col" class="left" { (words.of("Left")) } th scope="col" class="right" { (words.of("Right")) }
                } }

                tbody {
                    @for angle in VARIABLES { tr {
                        th scope="row" { (label::angle_label(angle, words).title) }
                        @for side in Side::BOTH { td { (bar(variable_score(angle, side), side, words)) } }
                    } }
                    tr class="total" {
                        th scope="row" { (words.of("Gait Profile Score")) }
                        td { (bar(indices.left, Side::Left, words)) }
                        td { (bar(indices.right, Side::Right, words)) }
                    }
                }
            }
        }

        p class="note" {
            (words.fill("Root mean square distance from the norm's mean (Baker 2009); a full bar is {n}°.", &[("n", &FULL_BAR_DEG)])) " "
            @match indices.both {
                Some(both) => (words.fill("Gait Profile Score of both sides: {n}° ({rest}°).", &[
                    ("n", &degrees(both.whole, words)), ("rest", &degrees(Some(both.without_offset), words))
                ])),
                None => (words.of("A Gait Profile Score needs all nine variables; that of both sides is absent.")),
            }
            " " (words.of("Healthy people score 5–6° with the norm's own system; offsets between systems go into these scores in full.")) " "
            (words.of("In brackets: the same after the mean over the cycle is taken from each curve and from the norm. An offset does not count there, and neither does a joint that is held differently all the time."))
        }
    }
}

/// Degrees that fill a bar.
const FULL_BAR_DEG: f64 = 30.0;

fn degrees(angle: Option<f64>, words: &Words) -> String {
    words.number(angle.map(f64::to_degrees), 1)
}

/// A score in degrees, and its bar.
fn bar(score: Option<Score>, side: Side, words: &Words) -> Markup {
    let whole_deg = score.and_then(|score| score.whole).map_or(0.0, f64::to_degrees);
    let percent = (100.0 * whole_deg / FULL_BAR_DEG).clamp(0.0, 100.0);
    html! {
        @match score {
            Some(score) => span class="score" { (degrees(score.whole, words)) " " small { "(" (degrees(Some(score.without_offset), words)) ")" } },
            None => span class="score" { (words.number(None, 1)) },
        }
        span class={ "bar " (side.name()) } aria-hidden="true" { span style={ "width:" (format!("{percent:.0}")) "%" } {} }
    }
}
