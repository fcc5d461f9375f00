//! What is said of a gait, for a person.

use std::path::Path;

use crate::table::Table;
use maquette::GaitStudy;
use maquette::gait::{
    BEYOND_SD, Beyond, Course, Curve, EventKind, Footwear, Parameter, Score, Side, Statistic,
    Surface, Used, VARIABLES,
};
use maquette::math::stats::mean;

/// What is said at the end of an analysis.
pub(super) struct Summary<'a> {
    pub(super) input: &'a Path,
    pub(super) study: &'a GaitStudy,
    pub(super) footwear: Option<Footwear>,
    pub(super) is_normalised: bool,
}

impl Summary<'_> {
    pub(super) fn text(&self) -> String {
        let sections = [
            self.head(),
            self.parameters(),
            self.events(),
            self.key_points(),
            self.scores(),
            self.remarks(),
        ];
        let sections = sections.into_iter().filter(|s| !s.is_empty());
        sections.collect::<Vec<_>>().join("\n")
    }

    fn head(&self) -> String {
        let (gait, movement) = (&self.study.analysis, &self.study.input.movement);
        let surface = surface(&gait.course);
        let leg = gait.leg_length_m.map_or(String::new(), |l| format!(", leg {l:.3} m"));
        let (frames, fps) = (movement.frames, movement.rate_hz);
        let input = self.input.display();
        let named = movement.used.len();
        let zero = gait.neutral.as_ref().map_or(String::new(), |pose| {
            format!("angles are counted from the standing pose in {}\n", pose.source)
        });
        format!(
            "{input}: {frames} frames at {fps} Hz, {surface}{leg}; {named} points of the body were found (their names are in gait.json)\n{zero}"
        )
    }

    fn parameters(&self) -> String {
        let (gait, norm) = (&self.study.analysis, self.study.norm.as_ref());
        if gait.parameters.is_empty() {
            return String::new();
        }
        let side = ["SD", "± u", "n"];
        let mut headings = vec!["parameter", "unit", "left"];
        headings.extend(side);
        headings.push("right");
        headings.extend(side);
        headings.extend(["R/L %", "norm"]);
        let mut table = Table::new(&headings);

        for parameter in Parameter::ALL {
            let [left, right] = Side::BOTH.map(|side| gait.parameters.get(&(parameter, side)));
            if left.is_none() && right.is_none() {
                continue;
            }
            let leg = gait.leg_length_m.filter(|_| self.is_normalised);
            let scale = leg.map_or(1.0, |leg| parameter.scale(leg));
            let unit = parameter.unit();
            let unit = if leg.is_some() && !unit.starts_with('%') { "–" } else { unit };

            let mut row = vec![parameter.name().to_owned(), unit.to_owned()];
            for side in [left, right] {
                let mut side_cells = cells(side, scale);
                let beyond = side.and_then(|s| norm?.beyond(parameter, s.mean));
                side_cells[0] += beyond.map_or("", Beyond::mark);
                row.extend(side_cells);
            }
            let symmetry = gait.symmetry_percent(parameter);
            row.push(symmetry.map_or("–".into(), |s| format!("{s:.0}")));

            let usual = norm.and_then(|n| n.parameters.get(&parameter)).filter(|_| leg.is_none());
            row.push(
                usual.map_or("–".into(), |(mean, sd)| {
                    format!("{} ± {}", number(*mean), number(*sd))
                }),
            );
            table.row(row);
        }

        let mut text = table.text();
        text += "  SD: between strides. u: standard uncertainty of one value.\n";
        if let Some(norm) = norm.filter(|norm| !norm.parameters.is_empty()) {
            text += &format!(
                "  {} {}: beyond the norm's mean by more than {BEYOND_SD} SD between people.\n",
                Beyond::Above.mark(),
                Beyond::Below.mark()
            );
            if let Some(caution) = Footwear::caution(norm.parameters_footwear, self.footwear) {
                text += &format!("  ! {caution}\n");
            }
        }
        text
    }

    fn events(&self) -> String {
        let mut text = String::new();
        for agreement in &self.study.analysis.agreement {
            let kind = match agreement.kind {
                EventKind::Strike => "foot strike",
                EventKind::Off => "foot off",
            };
            let sd = agreement.sd_s.map_or(String::new(), |sd| format!(" ± {:.0}", 1e3 * sd));
            let mean = 1e3 * agreement.mean_s;
            let n = agreement.n;
            text += &format!(
                "  {kind}: time by speed minus time by position: {mean:+.0}{sd} ms (n = {n})\n"
            );
        }
        text
    }

    fn key_points(&self) -> String {
        let curves = &self.study.analysis.curves;
        if curves.is_empty() {
            return String::new();
        }
        let mut table = Table::new(&[
            "angle, °",
            "side",
            "strike",
            "stance min",
            "at %",
            "stance max",
            "at %",
            "swing max",
            "at %",
            "range",
            "fit SD",
        ]);

        for curve in curves {
            table.row(key_points(curve));
        }

        table.text()
    }

    fn scores(&self) -> String {
        let Some(norm) = &self.study.norm else { return String::new() };
        let cautions = norm.cautions(self.footwear);
        let cautions: String = cautions.iter().map(|line| format!("  ! {line}\n")).collect();
        let Some(indices) = self.study.indices() else {
            return if norm.curves.is_empty() { cautions } else { String::new() };
        };
        let mut table =
            Table::new(&["score, °", "left", "right", "left, no offset", "right, no offset"]);
        let row = |name: String, [left, right]: [Option<Score>; 2]| {
            let cell = |value: Option<f64>| value.map_or("–".into(), degrees);
            let whole = [left, right].map(|score| cell(score.and_then(|s| s.whole)));
            let rest = [left, right].map(|score| cell(score.map(|s| s.without_offset)));
            [name].into_iter().chain(whole).chain(rest).collect()
        };

        for angle in VARIABLES {
            let scores = Side::BOTH.map(|side| indices.variables.get(&(side, angle)).copied());
            table.row(row(format!("GVS {}", angle.name()), scores));
        }
        table.row(row("GPS".into(), [indices.left, indices.right]));

        let both = match indices.both {
            None => "  GPS of both sides: – (it needs all nine variables)\n".into(),
            Some(Score { whole, without_offset }) => format!(
                "  GPS of both sides: {}°; {}° without the offsets of the curves\n",
                whole.map_or("– ".into(), degrees),
                degrees(without_offset)
            ),
        };

        format!("{}{both}  against {}: {}\n{cautions}", table.text(), norm.name, norm.source)
    }

    fn remarks(&self) -> String {
        let mut text = String::new();
        for note in &self.study.analysis.notes {
            text += &format!("  ! {note}\n");
        }
        for (angle, reason) in &self.study.analysis.unknown {
            text += &format!("  ! {}: {reason}\n", angle.name());
        }
        let is_made = |u: &&Used| u.from.contains(", ") || u.from.contains(": ");
        for used in self.study.input.movement.used.iter().filter(is_made) {
            text += &format!("  ! {}: from {}\n", used.landmark.name(), used.from);
        }
        text
    }
}

fn surface(course: &Course) -> String {
    match course.surface {
        Surface::Ground => "over ground".to_owned(),
        Surface::Treadmill => format!("on a treadmill at {:.2} m/s", course.belt_m_s),
    }
}

/// What is read off a curve.
fn key_points(curve: &Curve) -> Vec<String> {
    let key = curve.key_points();
    let fit_sd = curve.fit_sd.as_ref().and_then(|sd| mean(sd.iter().copied()));
    vec![
        curve.angle.name().into(),
        curve.side.name().into(),
        degrees(key.initial_contact),
        degrees(key.stance.least),
        key.stance.least_at_percent.to_string(),
        degrees(key.stance.greatest),
        key.stance.greatest_at_percent.to_string(),
        degrees(key.swing.greatest),
        key.swing.greatest_at_percent.to_string(),
        degrees(key.range),
        fit_sd.map_or("–".into(), degrees),
    ]
}

/// An angle in degrees.
fn degrees(radians: f64) -> String {
    format!("{:.1}", radians.to_degrees())
}

fn cells(statistic: Option<&Statistic>, scale: f64) -> [String; 4] {
    let dash = || "–".to_owned();
    let Some(s) = statistic else {
        return [dash(), dash(), dash(), dash()];
    };
    let optional = |v: Option<f64>| v.map_or(dash(), |v| number(v / scale));
    [number(s.mean / scale), optional(s.sd), optional(s.uncertainty), s.n.to_string()]
}

fn number(value: f64) -> String {
    match value.abs() {
        v if v >= 10.0 => format!("{value:.1}"),
        _ => format!("{value:.3}"),
    }
}
