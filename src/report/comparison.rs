//! The comparison of two sessions, or of two sides: curves with bands, and a table of what differs.

use std::fmt::Display;

use maud::{Markup, html};

use super::comparison_words as said;
use super::figure::{Axis, BOTH, Colour, Figure, NORM};
use super::identity::{cautions, person};
use super::kinematics::{arms, empty_figure, grid, legs, norm_band, over_percent, without_curve};
use super::label::{angle_label, side_name};
use super::page::{Page, absent, document};
use super::variation::{digits_of, title};
use super::{Subject, Words};
use crate::gait::trials::{Change, CurveChange, Sides, Stretch};
use crate::gait::{Angle, Curve, GaitAnalysis, Norm, Side};
use crate::pipeline::OneBody;

/// One of the two sessions, or one of the sides.
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
    /// Which side is compared with which.
    pub sides: Sides,
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
    let input = &in_words(input);
    let mut pages = vec![summary(input), table_page(input)];
    match input.sides {
        Sides::Same => pages.extend(Side::BOTH.map(|side| curves(input, side))),
        Sides::Opposite => pages.push(curves(input, Side::Right)),
    }
    document(input.after.subject, None, &pages, None, input.words)
}

/// Sides have the names of the page's language.
fn in_words<'a>(input: &ComparisonInput<'a>) -> ComparisonInput<'a> {
    let mut input = *input;
    if input.sides == Sides::Opposite {
        for own in [&mut input.before, &mut input.after] {
            own.name = input.words.known(own.name);
        }
    }
    input
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
                @match input.sides {
                    Sides::Same => {
                        tr { td {} td { strong { (input.before.name) } } td { strong { (input.after.name) } } }
                        @for ((name, a), (_, b)) in of(&input.before).iter().zip(&of(&input.after)) {
                            tr { th scope="row" { (name) } td { (a) } td { (b) } }
                        }
                        tr { th scope="row" { (words.of("Trials")) } td { (input.before.trials) } td { (input.after.trials) } }
                    }
                    Sides::Opposite => {
                        @for (name, value) in of(&input.before) { tr { th scope="row" { (name) } td { (value) } } }
                        tr { th scope="row" { (words.of("Trials")) } td { (input.before.trials) } }
                    }
                }
            }
            @let two_bodies = two_bodies(input);
            @if two_bodies.is_some() || !input.notes.is_empty() {
                h3 { (words.of("Before reading on")) }
                ul class="remarks" {
                    @if let Some(line) = &two_bodies { li { strong { (line) } } }
                    @for note in input.notes { li { (words.line(note)) } }
                }
            }
            h3 { (said::beyond(input.sides, words)) }
            @if known == 0 {
                (absent(words.of("Nothing is known of chance: a session of two trials or more is needed.")))
            } @else if detected.is_empty() {
                p { (words.fill("None of {n} numbers.", &[("n", &known)])) }
            } @else {
                (table(&detected, input))
                p class="note" { (said::by_chance(input.sides, (detected.len(), known), words)) }
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
        "The bodies differ: {length} {first} m in {before}, {second} m in {after} (all lengths: F({m}, {nu}) = {f}): two people, \
            a person who has grown, or a calibration of another scale. No change is to be trusted before that is known.",
        &[
            ("length", &words.known(&length)),
            ("first", &metres(odd.others_m)),
            ("before", &input.before.name),
            ("second", &metres(odd.own_m)),
            ("after", &input.after.name),
            ("m", &odd.degrees[0]),
            ("nu", &odd.degrees[1]),
            ("f", &words.number(Some(odd.f), 0)),
        ],
    ))
}

fn table_page<'a>(input: &ComparisonInput<'a>) -> Page<'a> {
    let words = input.words;
    Page {
        id: "changes",
        title: said::changes(input.sides, words),
        body: html! {
            @if let Some(norm) = input.norm { (cautions(norm, input.after.subject, words)) }
            @if let Some(line) = two_bodies(input) { p { strong { (line) } } }
            (table(&input.changes.iter().collect::<Vec<_>>(), input))
            p class="note" {
                (made_of(input)) " " (said::detectable(input.sides, words))
            }
        },
        is_brief: false,
    }
}

/// What the intervals are made of.
fn made_of(input: &ComparisonInput<'_>) -> String {
    if input.sides == Sides::Opposite {
        return said::made_of_sides(input.words).into();
    }
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
                    th scope="col" { (words.of("Number")) }
                    @if input.sides == Sides::Same { th scope="col" { (words.of("Side")) } }
                    th scope="col" { (words.of("Unit")) }
                    th scope="col" { (input.before.name) } th scope="col" { "SD" }
                    th scope="col" { (input.after.name) } th scope="col" { "SD" }
                    th scope="col" { (said::change(input.sides, words)) } th scope="col" { (words.of("95 % interval")) } th scope="col" { "MDC" } td {}
                } }
                tbody { @for change in changes { (row(change, input)) } }
            }
        }
    }
}

fn row(change: &Change, input: &ComparisonInput<'_>) -> Markup {
    let words = input.words;
    let (quantity, side) = (change.measure.quantity, change.measure.side);
    let cell = |value: Option<f64>| words.number(value, digits_of(quantity));
    html! {
        tr {
            th scope="row" { (title(quantity, words)) }
            @if input.sides == Sides::Same { td class=(side.name()) { (side_name(side, words)) } }
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

/// Mean curves of one side, or of both where they are compared, each with its band.
fn curves<'a>(input: &ComparisonInput<'a>, side: Side) -> Page<'a> {
    let words = input.words;
    let (id, title) = match (input.sides, side) {
        (Sides::Opposite, _) => ("curves", words.of("Curves")),
        (Sides::Same, Side::Left) => ("curves-left", words.of("Curves, left")),
        (Sides::Same, Side::Right) => ("curves-right", words.of("Curves, right")),
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
    let of = |own: &GaitAnalysis, side: Side| {
        own.curves.iter().find(|c| c.angle == angle && c.side == side).cloned()
    };
    let before_side = if input.sides == Sides::Same { side } else { Side::Left };
    let before = of(input.before.gait, before_side);
    let drawn = [(before, BOTH), (of(input.after.gait, side), Colour::from(side))];
    let words = input.words;
    if drawn.iter().all(|(curve, _)| curve.is_none()) {
        return without_curve(input.after.gait, angle, words);
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
    let values: [(&str, &dyn Display); 4] = [
        ("angle", &angle_label(angle, words).title),
        ("side", &side),
        ("before", &before),
        ("after", &after),
    ];
    let mut description = said::description(input.sides, &values, words);
    if let Some(test) = test {
        description += &stretches_in_words(test, words);
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

fn stretches_in_words(change: &CurveChange, words: &Words) -> String {
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
