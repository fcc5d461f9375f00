//! The grids of joint angles: a row for each joint, a column for each plane.

use std::fmt::Display;

use maud::{Markup, html};

use super::figure::{Axis, Colour, Figure, NORM, axis_range};
use super::identity::cautions;
use super::label;
use super::page::{Page, key};
use super::spatiotemporal::{missing, remarks};
use super::{ReportInput, Words};
use crate::gait::{Angle, Curve, GaitAnalysis, Norm, Side};

pub(super) type Row<'a> = (&'a str, [Option<Angle>; 3]);

/// The rows of the grid: pelvis, legs, and trunk.
pub(super) fn legs(words: &Words) -> [Row<'_>; 5] {
    [
        (
            words.of("Pelvis"),
            [Some(Angle::PelvisTilt), Some(Angle::PelvisObliquity), Some(Angle::PelvisRotation)],
        ),
        (
            words.of("Hip"),
            [Some(Angle::HipFlexion), Some(Angle::HipAdduction), Some(Angle::HipRotation)],
        ),
        (
            words.of("Knee"),
            [Some(Angle::KneeFlexion), Some(Angle::KneeAdduction), Some(Angle::KneeRotation)],
        ),
        (
            words.of("Ankle, foot"),
            [Some(Angle::AnkleDorsiflexion), None, Some(Angle::FootProgression)],
        ),
        (
            words.of("Trunk"),
            [Some(Angle::TrunkTilt), Some(Angle::TrunkObliquity), Some(Angle::TrunkRotation)],
        ),
    ]
}

pub(super) fn arms(words: &Words) -> [Row<'_>; 2] {
    [
        (
            words.of("Shoulder"),
            [
                Some(Angle::ShoulderFlexion),
                Some(Angle::ShoulderAdduction),
                Some(Angle::ShoulderRotation),
            ],
        ),
        (words.of("Elbow"), [Some(Angle::ElbowFlexion), None, None]),
    ]
}

/// What a grid draws for each angle.
#[derive(Debug, Clone, Copy)]
enum Drawn {
    /// Mean over strides with the fit's band, over the cycle.
    Means,
    /// Every stride, over the cycle.
    Strides,
    /// Every frame, over time.
    Time,
}

/// Means over the cycle, or everything over time where nobody walks.
pub(super) fn page<'a>(input: &ReportInput<'a>) -> Page<'a> {
    let words = input.words;
    let gait = input.gait;
    let walks = !gait.curves.is_empty();
    let compared = input.norm.filter(|_| walks);
    let norm = compared.filter(|norm| !norm.curves.is_empty()).map(|norm| norm.name.as_str());
    let drawn = match walks {
        true => Drawn::Means,
        false => Drawn::Time,
    };

    Page {
        id: "kinematics",
        title: words.of("Kinematics"),
        body: html! {
            @if !walks {
                (missing(words.of("Angles over time, not over the gait cycle:"), gait, words))
            }
            (key(norm, words))
            @if let Some(norm) = compared { (cautions(norm, input.subject, words)) }
            @if walks { (remarks(gait, words)) }
            (grid(&legs(words), words, |angle| panel(input, angle, drawn)))
            p class="note" {
                @if walks {
                    (words.of("From foot strike to foot strike of the same side. Line: mean over strides. Tint: ± 1 SD of the fit, where it is known, \
                        as the norm's band is ± 1 SD between people. Dashed: foot off.")) " "
                }
                (words.of("Between systems a constant offset of some degrees is the rule: compare shapes and ranges first."))
            }
            h3 class="arms" { (words.of("Arms")) }
            (grid(&arms(words), words, |angle| panel(input, angle, drawn)))
        },
        is_brief: false,
    }
}

/// Every stride.
pub(super) fn consistency<'a>(input: &ReportInput<'a>) -> Page<'a> {
    let (gait, words) = (input.gait, input.words);
    Page {
        id: "consistency",
        title: words.of("Consistency"),
        body: html! {
            @if gait.curves.is_empty() {
                (missing(words.of("No strides to be compared:"), gait, words))
            } @else {
                (key(None, words))
                (remarks(gait, words))
                (grid(&legs(words), words, |angle| panel(input, angle, Drawn::Strides)))
                p class="note" { (words.of("Every stride that was used. The farther they lie apart, the less their mean tells.")) }
            }
        },
        is_brief: gait.curves.is_empty(),
    }
}

/// A chart for each joint and plane.
pub(super) fn grid(rows: &[Row<'_>], words: &Words, panel: impl Fn(Angle) -> Markup) -> Markup {
    let planes = [words.of("Sagittal"), words.of("Frontal"), words.of("Transverse")];
    html! {
        div class="grid" {
            div {} @for plane in planes { div class="plane" { (plane) } }
            @for (name, angles) in rows {
                div class="joint" { span { (name) } }
                @for angle in angles {
                    @match angle { Some(angle) => (panel(*angle)), None => div {} }
                }
            }
        }
    }
}

/// One angle, or the reason why it is absent.
fn panel(input: &ReportInput<'_>, angle: Angle, drawn: Drawn) -> Markup {
    let words = input.words;
    let figure = match drawn {
        Drawn::Time => over_time(input, angle),
        Drawn::Means | Drawn::Strides => over_cycle(input, angle, drawn),
    };
    if figure.is_empty() {
        return without_curve(input.gait, angle, words);
    }
    let description = description(input, angle);
    html! { div class="panel" { (figure.markup(&description, words)) } }
}

/// Why an angle has no curve.
pub(super) fn without_curve(gait: &GaitAnalysis, angle: Angle, words: &Words) -> Markup {
    let unknown = gait.unknown.iter().find(|(a, _)| *a == angle);
    let reason = match unknown {
        Some((_, reason)) => words.line(reason),
        None => html! { (words.of("no whole stride shows it")) },
    };
    html! {
        div class="panel empty" { strong { (label::angle_label(angle, words).title) } p class="absent" { (reason) } }
    }
}

fn degrees(values: &[f64]) -> Vec<f64> {
    values.iter().map(|v| v.to_degrees()).collect()
}

/// Values over the cycle, % and degrees.
pub(super) fn over_percent(values: &[f64]) -> Vec<(f64, f64)> {
    let step = 100.0 / (values.len() as f64 - 1.0);
    values.iter().enumerate().map(|(i, v)| (i as f64 * step, v.to_degrees())).collect()
}

/// The points of a line; it breaks at foot off if swing and stance are of two strides.
fn line_points(curve: &Curve, values: &[f64]) -> Vec<(f64, f64)> {
    let mut points = over_percent(values);
    if curve.is_joined {
        let off = 100.0 * curve.foot_off;
        let after = points.partition_point(|p| p.0 <= off);
        points.insert(after, (off, f64::NAN));
    }
    points
}

fn over_cycle(input: &ReportInput<'_>, angle: Angle, drawn: Drawn) -> Figure {
    let curves = input.gait.curves.iter();
    let curves: Vec<&Curve> = curves.filter(|c| c.angle == angle).collect();
    let band = norm_band(input.norm, angle)
        .filter(|_| matches!(drawn, Drawn::Means) && !curves.is_empty());

    let curve_values = curves.iter().flat_map(|c| match drawn {
        Drawn::Strides => degrees(&c.strides.concat()),
        _ => degrees(&c.mean),
    });
    let norm_values = band.iter().flatten().flat_map(|p| [p.1, p.2]);
    let cycle =
        Axis { label: input.words.of("gait cycle, %").into(), range: (0.0, 100.0), step: 20.0 };
    let mut figure = empty_figure((angle, input.words), cycle, curve_values.chain(norm_values));

    if let Some(band) = &band {
        figure = figure.band(NORM, 0.3, band);
    }
    for curve in curves {
        figure = figure.rule(curve.side.into(), 100.0 * curve.foot_off);
        figure = match drawn {
            Drawn::Strides => strides(figure, curve),
            _ => mean(figure, curve),
        };
    }
    figure
}

fn mean(mut figure: Figure, curve: &Curve) -> Figure {
    let colour = Colour::from(curve.side);
    if let Some(sd) = &curve.fit_sd {
        // ± 1 SD, as the norm's band
        let reach = sd.iter().map(|sd| sd.to_degrees());
        let means = over_percent(&curve.mean).into_iter();
        let rows = means.zip(reach);
        let band: Vec<_> = rows.map(|((x, mean), reach)| (x, mean - reach, mean + reach)).collect();
        figure = figure.band(colour, 0.15, &band);
    }
    figure.line(colour, 2.0, &line_points(curve, &curve.mean))
}

fn strides(figure: Figure, curve: &Curve) -> Figure {
    let all = curve.strides.iter();
    all.fold(figure, |figure, stride| {
        figure.line(curve.side.into(), 0.9, &line_points(curve, stride))
    })
}

pub(super) fn norm_band(norm: Option<&Norm>, angle: Angle) -> Option<Vec<(f64, f64, f64)>> {
    let band = norm?.band(angle)?;
    let step = 100.0 / (band.mean.len() as f64 - 1.0);
    let points = band.mean.iter().zip(&band.sd).enumerate();
    let at = |(i, (mean, sd)): (usize, (&f64, &f64))| {
        (i as f64 * step, (mean - sd).to_degrees(), (mean + sd).to_degrees())
    };
    Some(points.map(at).collect())
}

fn over_time(input: &ReportInput<'_>, angle: Angle) -> Figure {
    let rate_hz = input.movement.rate_hz;
    let tracks = Side::BOTH.map(|side| (side, input.gait.angles.get(&(side, angle))));
    let values = tracks.iter().filter_map(|(_, track)| *track).flatten();
    let last_s = (input.movement.frames.max(2) - 1) as f64 / rate_hz;
    let (_, step) = axis_range(std::iter::empty(), (0.0, last_s));
    let time = Axis { label: input.words.of("time, s").into(), range: (0.0, last_s), step };
    let mut figure = empty_figure((angle, input.words), time, values.map(|v| v.to_degrees()));

    for (side, track) in tracks {
        let at = |(i, v): (usize, &f64)| (i as f64 / rate_hz, v.to_degrees());
        let points: Vec<_> = track.into_iter().flatten().enumerate().map(at).collect();
        figure = figure.line(side.into(), 1.5, &points);
    }
    figure
}

/// A chart of an angle that has room for `values`, degrees.
pub(super) fn empty_figure(
    (angle, words): (Angle, &Words),
    x: Axis,
    values: impl Iterator<Item = f64>,
) -> Figure {
    let label = label::angle_label(angle, words);
    let (range, step) = axis_range(values, label.range);
    let y = Axis { label: label.axis(), range, step };
    Figure::new(label.title, x, y)
}

/// The chart in words.
fn description(input: &ReportInput<'_>, angle: Angle) -> String {
    let words = input.words;
    let (title, positive) = (label::angle_label(angle, words).title, words.known(angle.positive()));
    let mut text = words.fill(
        "{angle}, degrees, positive: {positive}.",
        &[("angle", &title), ("positive", &positive)],
    );
    for side in Side::BOTH {
        let mut curves = input.gait.curves.iter();
        let curve = curves.find(|c| c.angle == angle && c.side == side);
        let track = input.gait.angles.get(&(side, angle));
        let Some(values) = curve.map(|c| &c.mean).or(track) else {
            continue;
        };
        let (least, greatest) = least_and_greatest(&degrees(values));
        let side = label::side_name(side, words);
        let values: [(&str, &dyn Display); 3] = [
            ("side", &side),
            ("least", &format!("{least:.0}")),
            ("greatest", &format!("{greatest:.0}")),
        ];
        text += " ";
        text += &words.fill("{side}: {least} to {greatest}.", &values);
    }
    text
}

fn least_and_greatest(values: &[f64]) -> (f64, f64) {
    let known = values.iter().filter(|v| v.is_finite());
    known.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), v| (low.min(*v), high.max(*v)))
}
