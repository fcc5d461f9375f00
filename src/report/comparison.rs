//! The comparison of two sessions: curves with bands, and a table of what changed.

use std::fmt::Display;

use maud::{Markup, html};

use super::figure::{Axis, BOTH, Colour, Figure, NORM};
use super::identity::{cautions, person};
use super::kinematics::{arms, empty_figure, grid, legs, norm_band, over_percent};
use super::label::{angle_label, side_name};
use super::page::{Page, absent, document};
use super::variation::{digits_of, title};
use super::{Subject, Words};
use crate::gait::trials::{Change, CurveChange, Stretch};
use crate::gait::{Angle, Curve, GaitAnalysis, Norm, Side};
use crate::pipeline::OneBody;

/// One of the two sessions.
#[derive(Debug, Clone, Copy)]
pub struct Compared<'a> {
    /// Its name.
    pub name: &'a str,
    /// Who, when, and how.
    pub subject: &'a Subject,
    /// Number of its trials.
    pub trials: usize,
    /// All strides together.
    pub gait: &'a GaitAnalysis,
}

/// What a comparison shows.
#[derive(Debug, Clone, Copy)]
pub struct ComparisonInput<'a> {
    /// The first session.
    pub before: Compared<'a>,
    /// The second one.
    pub after: Compared<'a>,
    /// What changed.
    pub changes: &'a [Change],
    /// Where over the cycle curves differ.
    pub curves: &'a [CurveChange],
    /// Whether both have one body.
    pub one_body: &'a OneBody,
    /// What else a person should know, each in one line.
    pub notes: &'a [String],
    /// Healthy people.
    pub norm: Option<&'a Norm>,
    /// What the page says.
    pub words: &'a Words,
}

/// The comparison as the text of one file.
pub fn comparison_html(input: &ComparisonInput<'_>) -> String {
    let pages =
        [summary(input), table_page(input), curves(input, Side::Left), curves(input, Side::Right)];
    document(input.after.subject, None, &pages, None, input.words)
}

fn summary<'a>(input: &ComparisonInput<'a>) -> Page<'a> {
    let words = input.words;
    let detected: Vec<&Change> = input.changes.iter().filter(|c| c.is_detected()).collect();
    let known = input.changes.iter().filter(|c| c.detectable.is_some()).count();
    let of = |own: &Compared<'_>| person(own.subject, words);
    Page {
        id: "identity",
        title: words.of("What is compared"),
        body: html! {
            table class="facts" {
                tr { td {} td { strong { (input.before.name) } } td { strong { (input.after.name) } } }
                @for ((name, a), (_, b)) in of(&input.before).iter().zip(&of(&input.after)) {
                    tr { th scope="row" { (name) } td { (a) } td { (b) } }
                }
                tr { th scope="row" { (words.of("Trials")) } td { (input.before.trials) } td { (input.after.trials) } }
            }
            @let two_bodies = two_bodies(input);
            @if two_bodies.is_some() || !input.notes.is_empty() {
                h3 { (words.of("Before reading on")) }
                ul class="remarks" {
                    @if let Some(line) = &two_bodies { li { strong { (line) } } }
                    @for note in input.notes { li { (words.line(note)) } }
                }
            }
            h3 { (words.of("Changes that exceed the minimal detectable change")) }
            @if known == 0 {
                (absent(words.of("Nothing is known of chance: a session of two trials or more is needed.")))
            } @else if detected.is_empty() {
                p { (words.fill("None of {n} numbers.", &[("n", &known)])) }
            } @else {
                (table(&detected, input))
                p class="note" {
                    (words.fill("{n} of {all} numbers. Of a person who has not changed, one in twenty exceeds it.", &[("n", &detected.len()), ("all", &known)]))
                }
            }
        },
        is_brief: false,
    }
}

/// That the two have two bodies, where it is so.
fn two_bodies(input: &ComparisonInput<'_>) -> Option<String> {
    let OneBody::No(odd) = input.one_body else {
        return None;
    };
    let words = input.words;
    let metres = |length: f64| words.number(Some(length), 3);
    let length = odd.length.replace('_', " ");
    Some(words.fill(
        "The bodies differ: the {length} is {first} m in {before} and {second} m in {after} (all lengths: χ² {chi} of {degrees}): two people, \
            a person who has grown, or a calibration of another scale. No change is to be trusted before that is known.",
        &[
            ("length", &words.known(&length)),
            ("first", &metres(odd.others_m)),
            ("before", &input.before.name),
            ("second", &metres(odd.own_m)),
            ("after", &input.after.name),
            ("chi", &words.number(Some(odd.chi_square), 0)),
            ("degrees", &odd.degrees),
        ],
    ))
}

fn table_page<'a>(input: &ComparisonInput<'a>) -> Page<'a> {
    let words = input.words;
    Page {
        id: "changes",
        title: words.of("Changes"),
        body: html! {
            @if let Some(norm) = input.norm { (cautions(norm, input.after.subject, words)) }
            @if let Some(line) = two_bodies(input) { p { strong { (line) } } }
            (table(&input.changes.iter().collect::<Vec<_>>(), input))
            p class="note" {
                (made_of(input)) " "
                (words.of("MDC: minimal detectable change, 1.96·√2·SEM of two sessions alike (Weir 2005), \
                    which a person who has not changed exceeds once in twenty times; ● marks a change beyond it. Scores are against the norm."))
            }
        },
        is_brief: false,
    }
}

/// What the intervals are made of.
fn made_of(input: &ComparisonInput<'_>) -> String {
    let names = [("after", &input.after.name as &dyn Display), ("before", &input.before.name)];
    let has_fit = |change: &Change| change.before.fit.is_some() || change.after.fit.is_some();
    match input.changes.iter().any(has_fit) {
        true => input.words.fill(
            "SD: between the trials of a session. Change: {after} less {before}, with its 95 % interval (Welch), \
             from the SD between trials and the fit's own.",
            &names,
        ),
        false => input.words.fill(
            "SD: between the trials of each. Change: {after} less {before}, with its 95 % interval (Welch), \
             from the SD between trials.",
            &names,
        ),
    }
}

fn table(changes: &[&Change], input: &ComparisonInput<'_>) -> Markup {
    let words = input.words;
    html! {
        div class="scroll" role="group" tabindex="0" aria-label=(words.of("Table")) {
            table class="numbers small" {
                thead { tr {
                    th scope="col" { (words.of("Number")) } th scope="col" { (words.of("Side")) } th scope="col" { (words.of("Unit")) }
                    th scope="col" { (input.before.name) } th scope="col" { "SD" }
                    th scope="col" { (input.after.name) } th scope="col" { "SD" }
                    th scope="col" { (words.of("Change")) } th scope="col" { (words.of("95 % interval")) } th scope="col" { "MDC" } td {}
                } }
                tbody { @for change in changes { (row(change, words)) } }
            }
        }
    }
}

fn row(change: &Change, words: &Words) -> Markup {
    let (quantity, side) = (change.measure.quantity, change.measure.side);
    let cell = |value: Option<f64>| words.number(value, digits_of(quantity));
    html! {
        tr {
            th scope="row" { (title(quantity, words)) }
            td class=(side.name()) { (side_name(side, words)) }
            td { (words.known(quantity.unit())) }
            td class="mean" { (cell(Some(change.before.mean))) } td { (cell(change.before.between_trials)) }
            td class="mean" { (cell(Some(change.after.mean))) } td { (cell(change.after.between_trials)) }
            td class="mean" { (cell(Some(change.difference))) }
            td { @match change.interval {
                Some((low, high)) => { (words.fill("{low} to {high}", &[("low", &cell(Some(low))), ("high", &cell(Some(high)))])) }
                None => "–"
            } }
            td { (cell(change.detectable)) }
            td { @if change.is_detected() { span aria-hidden="true" { "●" } span class="spoken" { (words.of("beyond the minimal detectable change")) } } }
        }
    }
}

/// Mean curves of one side, each with its band.
fn curves<'a>(input: &ComparisonInput<'a>, side: Side) -> Page<'a> {
    let words = input.words;
    let (id, title) = match side {
        Side::Left => ("curves-left", words.of("Curves, left")),
        Side::Right => ("curves-right", words.of("Curves, right")),
    };
    Page {
        id,
        title,
        body: html! {
            p class="key" {
                span class="both" { (words.fill("{session}, grey", &[("session", &input.before.name)])) }
                span class=(side.name()) { (words.fill("{session}, in colour", &[("session", &input.after.name)])) }
                @if let Some(norm) = input.norm.filter(|norm| !norm.curves.is_empty()) { span class="norm" { (words.fill("norm: {norm}, mean ± 1 SD between people", &[("norm", &norm.name)])) } }
            }
            (grid(&legs(words), words, |angle| panel(input, angle, side)))
            p class="note" {
                (words.of("From foot strike to foot strike of the same side. Line: mean over all strides of all trials. Tint: ± 1 SD between strides. Dashed: foot off."))
                @if !input.curves.is_empty() {
                    " " (words.of("Bars on the lower edge: the sessions differ by more than chance (statistical parametric mapping, t of the trials' mean \
                        curves, α = 0.05 for each curve: one curve in twenty has a bar without any change; docs/session.md)."))
                }
            }
            h3 class="arms" { (words.of("Arms")) }
            (grid(&arms(words), words, |angle| panel(input, angle, side)))
        },
        is_brief: false,
    }
}

fn panel(input: &ComparisonInput<'_>, angle: Angle, side: Side) -> Markup {
    let of = |own: &GaitAnalysis| {
        own.curves.iter().find(|c| c.angle == angle && c.side == side).cloned()
    };
    let drawn = [(of(input.before.gait), BOTH), (of(input.after.gait), Colour::from(side))];
    let words = input.words;
    let label = angle_label(angle, words);
    if drawn.iter().all(|(curve, _)| curve.is_none()) {
        return html! { div class="panel empty" { strong { (label.title) } (absent(words.of("no whole stride shows it"))) } };
    }

    let band = norm_band(input.norm, angle);
    let known = drawn.iter().filter_map(|(curve, _)| curve.as_ref());
    let values = known.flat_map(|curve| curve.mean.iter().map(|v| v.to_degrees()));
    let of_norm = band.iter().flatten().flat_map(|p| [p.1, p.2]);
    let cycle = Axis { label: words.of("gait cycle, %").into(), range: (0.0, 100.0), step: 20.0 };
    let mut figure = empty_figure((angle, words), cycle, values.chain(of_norm));
    if let Some(band) = &band {
        figure = figure.band(NORM, 0.2, band);
    }
    let test = input.curves.iter().find(|c| c.angle == angle && c.side == side);
    if let Some(change) = test {
        figure = with_stretches(figure, change);
    }
    for (curve, colour) in &drawn {
        if let Some(curve) = curve {
            figure = one(figure, curve, *colour);
        }
    }
    let (before, after) = (input.before.name, input.after.name);
    let side = side_name(side, words);
    let values: [(&str, &dyn Display); 4] =
        [("angle", &label.title), ("side", &side), ("before", &before), ("after", &after)];
    let mut description =
        words.fill("{angle}, {side}, degrees: mean curves of {before} and {after}.", &values);
    if let Some(test) = test {
        description += &in_words(test, words);
    }
    html! { div class="panel" { (figure.markup(&description, words)) } }
}

/// Bars on the lower edge where the sessions differ by more than chance.
fn with_stretches(mut figure: Figure, change: &CurveChange) -> Figure {
    let (low, high) = figure.height();
    for stretch in &change.test.stretches {
        // a stretch of a single place would not be seen
        let (from, to) = (stretch.from - 0.25, stretch.to + 0.25);
        let bar = [from, to].map(|x| (x.clamp(0.0, 100.0), low, low + 0.035 * (high - low)));
        figure = figure.band(BOTH, 0.95, &bar);
    }
    figure
}

fn in_words(change: &CurveChange, words: &Words) -> String {
    let stretch = |s: &Stretch| {
        let p = match s.p {
            p if p < 0.001 => format!("< {}", words.decimal(0.001)),
            p => words.number(Some(p), 3),
        };
        let (from, to) = (format!("{:.0}", s.from), format!("{:.0}", s.to));
        let values: [(&str, &dyn Display); 3] = [("from", &from), ("to", &to), ("p", &p)];
        format!(
            " {}",
            words.fill("They differ from {from} to {to} % of the cycle, p {p}.", &values)
        )
    };
    let all: String = change.test.stretches.iter().map(stretch).collect();
    match all.is_empty() {
        true => format!(" {}", words.of("They do not differ by more than chance.")),
        false => all,
    }
}

fn one(mut figure: Figure, curve: &Curve, colour: Colour) -> Figure {
    if let Some(sd) = &curve.sd {
        let rows = over_percent(&curve.mean).into_iter().zip(sd.iter().map(|sd| sd.to_degrees()));
        let band: Vec<_> = rows.map(|((x, mean), sd)| (x, mean - sd, mean + sd)).collect();
        figure = figure.band(colour, 0.15, &band);
    }
    let figure = figure.rule(colour, 100.0 * curve.foot_off);
    figure.line(colour, 2.0, &over_percent(&curve.mean))
}
