//! The grids of joint angles: a row for each joint, a column for each plane.

use maud::{Markup, html};

use super::ReportInput;
use super::figure::{Axis, Colour, Figure, LEFT, NORM, RIGHT, range_of};
use super::label;
use super::page::{Page, absent, key};
use super::spatiotemporal::{reason, remarks};
use crate::gait::{Angle, Norm, Side};
use crate::io::gait::CurvePart;

type Row = (&'static str, [Option<Angle>; 3]);

const LEGS: [Row; 5] = [
    (
        "Pelvis",
        [
            Some(Angle::PelvisTilt),
            Some(Angle::PelvisObliquity),
            Some(Angle::PelvisRotation),
        ],
    ),
    (
        "Hip",
        [
            Some(Angle::HipFlexion),
            Some(Angle::HipAdduction),
            Some(Angle::HipRotation),
        ],
    ),
    (
        "Knee",
        [
            Some(Angle::KneeFlexion),
            Some(Angle::KneeAdduction),
            Some(Angle::KneeRotation),
        ],
    ),
    (
        "Ankle, foot",
        [
            Some(Angle::AnkleDorsiflexion),
            None,
            Some(Angle::FootProgression),
        ],
    ),
    (
        "Trunk",
        [
            Some(Angle::TrunkTilt),
            Some(Angle::TrunkObliquity),
            Some(Angle::TrunkRotation),
        ],
    ),
];

const ARMS: [Row; 2] = [
    (
        "Shoulder",
        [
            Some(Angle::ShoulderFlexion),
            Some(Angle::ShoulderAdduction),
            Some(Angle::ShoulderRotation),
        ],
    ),
    ("Elbow", [Some(Angle::ElbowFlexion), None, None]),
];

/// What a grid draws of each angle.
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
pub(super) fn page(input: &ReportInput<'_>) -> Page {
    let walks = !input.file.curves.is_empty();
    let norm = input.norm.filter(|_| walks).map(|norm| norm.name.as_str());
    Page {
        id: "kinematics",
        title: "Kinematics",
        body: html! {
            @if !walks {
                (absent(&format!("Angles over time, not over the gait cycle: {}.", reason(input))))
            }
            (key(norm))
            @if walks { (remarks(input)) }
            (grid(input, &LEGS, if walks { Drawn::Means } else { Drawn::Time }))
            p class="note" {
                @if walks {
                    "From foot strike to foot strike of the same side. Line: mean over strides. Tint: 95 % band of the fit, ±1.96 SD, where it is known. Dashed: foot off. "
                }
                "Between systems a constant offset of some degrees is the rule: compare shapes and ranges first."
            }
            h3 class="arms" { "Arms" }
            (grid(input, &ARMS, if walks { Drawn::Means } else { Drawn::Time }))
        },
        is_brief: false,
    }
}

/// Every stride.
pub(super) fn consistency(input: &ReportInput<'_>) -> Page {
    Page {
        id: "consistency",
        title: "Consistency",
        body: html! {
            @if input.file.curves.is_empty() {
                (absent(&format!("No strides to be compared: {}.", reason(input))))
            } @else {
                (key(None))
                (remarks(input))
                (grid(input, &LEGS, Drawn::Strides))
                p class="note" { "Every stride that was used. Strides that lie apart make the mean less telling." }
            }
        },
        is_brief: input.file.curves.is_empty(),
    }
}

fn grid(input: &ReportInput<'_>, rows: &[Row], drawn: Drawn) -> Markup {
    html! {
        div class="grid" {
            div {} @for plane in ["Sagittal", "Frontal", "Transverse"] { div class="plane" { (plane) } }
            @for (name, angles) in rows {
                div class="joint" { span { (name) } }
                @for angle in angles {
                    @match angle { Some(angle) => (panel(input, *angle, drawn)), None => div {} }
                }
            }
        }
    }
}

/// One angle, or why it is not there.
fn panel(input: &ReportInput<'_>, angle: Angle, drawn: Drawn) -> Markup {
    let label = label::of_angle(angle);
    let figure = match drawn {
        Drawn::Time => over_time(input, angle),
        Drawn::Means | Drawn::Strides => over_cycle(input, angle, drawn),
    };
    if figure.is_empty() {
        let unknown = input.file.unknown.iter().find(|u| u.angle == angle);
        let why = unknown.map_or("no whole stride shows it", |u| u.reason);
        return html! {
            div class="panel empty" { strong { (label.title) } (absent(why)) }
        };
    }
    let description = description(input, angle);
    html! { div class="panel" { (figure.markup(&description)) } }
}

fn colour(side: Side) -> Colour {
    match side {
        Side::Left => LEFT,
        Side::Right => RIGHT,
    }
}

fn percent(values: &[f64]) -> Vec<(f64, f64)> {
    let step = 100.0 / (values.len() as f64 - 1.0);
    values
        .iter()
        .enumerate()
        .map(|(i, v)| (i as f64 * step, *v))
        .collect()
}

/// The points of a line, which breaks at foot off where a stride is joined of two.
fn points(curve: &CurvePart, values: &[f64]) -> Vec<(f64, f64)> {
    let mut points = percent(values);
    if curve.is_joined {
        let off = curve.foot_off_percent;
        let after = points.partition_point(|p| p.0 <= off);
        points.insert(after, (off, f64::NAN));
    }
    points
}

fn over_cycle(input: &ReportInput<'_>, angle: Angle, drawn: Drawn) -> Figure {
    let of_angle = |c: &&CurvePart| c.angle == angle;
    let curves: Vec<&CurvePart> = input.file.curves.iter().filter(of_angle).collect();
    let band = norm_band(input.norm, angle)
        .filter(|_| matches!(drawn, Drawn::Means) && !curves.is_empty());
    let shown = curves.iter().flat_map(|c| match drawn {
        Drawn::Strides => c.strides_deg.concat(),
        _ => c.mean_deg.clone(),
    });
    let of_norm = band.iter().flatten().flat_map(|p| [p.1, p.2]);
    let mut figure = empty_figure(
        angle,
        ("gait cycle, %", (0.0, 100.0), 20.0),
        shown.chain(of_norm),
    );
    if let Some(band) = &band {
        figure = figure.band(NORM, 0.3, band);
    }
    for curve in curves {
        figure = figure.rule(colour(curve.side), curve.foot_off_percent);
        figure = match drawn {
            Drawn::Strides => strides(figure, curve),
            _ => mean(figure, curve),
        };
    }
    figure
}

fn mean(figure: Figure, curve: &CurvePart) -> Figure {
    let colour = colour(curve.side);
    let points = percent(&curve.mean_deg);
    let figure = match &curve.fit_sd_deg {
        Some(sd) => {
            let at =
                |((x, mean), sd): (&(f64, f64), &f64)| (*x, mean - 1.96 * sd, mean + 1.96 * sd);
            figure.band(
                colour,
                0.15,
                &points.iter().zip(sd).map(at).collect::<Vec<_>>(),
            )
        }
        None => figure,
    };
    figure.line(colour, 2.0, &self::points(curve, &curve.mean_deg))
}

fn strides(figure: Figure, curve: &CurvePart) -> Figure {
    let all = curve.strides_deg.iter();
    all.fold(figure, |figure, stride| {
        figure.line(colour(curve.side), 0.9, &points(curve, stride))
    })
}

fn norm_band(norm: Option<&Norm>, angle: Angle) -> Option<Vec<(f64, f64, f64)>> {
    let band = norm?.curves.get(&angle)?;
    let step = 100.0 / (band.mean.len() as f64 - 1.0);
    let points = band.mean.iter().zip(&band.sd).enumerate();
    let at = |(i, (mean, sd)): (usize, (&f64, &f64))| {
        (
            i as f64 * step,
            (mean - sd).to_degrees(),
            (mean + sd).to_degrees(),
        )
    };
    Some(points.map(at).collect())
}

fn over_time(input: &ReportInput<'_>, angle: Angle) -> Figure {
    let rate_hz = input.file.fps;
    let tracks = Side::BOTH.map(|side| (side, input.gait.angles.get(&(side, angle))));
    let shown = tracks
        .iter()
        .filter_map(|(_, t)| *t)
        .flatten()
        .map(|v| v.to_degrees());
    let last_s = (input.file.frames.max(2) - 1) as f64 / rate_hz;
    let (_, step) = range_of(std::iter::empty(), (0.0, last_s));
    let mut figure = empty_figure(angle, ("time, s", (0.0, last_s), step), shown);
    for (side, track) in tracks {
        let at = |(i, v): (usize, &f64)| (i as f64 / rate_hz, v.to_degrees());
        let points: Vec<_> = track.into_iter().flatten().enumerate().map(at).collect();
        figure = figure.line(colour(side), 1.5, &points);
    }
    figure
}

fn empty_figure(
    angle: Angle,
    (x_label, x_range, x_step): (&str, (f64, f64), f64),
    shown: impl Iterator<Item = f64>,
) -> Figure {
    let label = label::of_angle(angle);
    let (range, step) = range_of(shown, label.range);
    let x = Axis {
        label: x_label.into(),
        range: x_range,
        step: x_step,
    };
    let y = Axis {
        label: label.axis(),
        range,
        step,
    };
    Figure::new(label.title, x, y)
}

/// The chart in words.
fn description(input: &ReportInput<'_>, angle: Angle) -> String {
    let label = label::of_angle(angle);
    let mut text = format!("{}, degrees, positive: {}.", label.title, angle.positive());
    for side in Side::BOTH {
        let curve = input
            .file
            .curves
            .iter()
            .find(|c| c.angle == angle && c.side == side);
        let range = match (curve, input.gait.angles.get(&(side, angle))) {
            (Some(curve), _) => least_and_greatest(curve.mean_deg.iter().copied()),
            (None, Some(track)) => least_and_greatest(track.iter().map(|v| v.to_degrees())),
            (None, None) => continue,
        };
        text += &format!(" {}: {:.0} to {:.0}.", side.name(), range.0, range.1);
    }
    text
}

fn least_and_greatest(values: impl Iterator<Item = f64>) -> (f64, f64) {
    let known = values.filter(|v| v.is_finite());
    known.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), v| {
        (low.min(v), high.max(v))
    })
}
