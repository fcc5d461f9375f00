//! What is said of a gait, for a person.

use std::path::Path;

use crate::table::Table;
use maquette::gait::{BEYOND_SD, Beyond, Footwear, Norm, Side, Statistic, Surface, Used};
use maquette::io::gait::GaitFile;
use maquette::math::stats::mean;

/// What is said at the end of an analysis.
pub(super) struct Summary<'a> {
    pub(super) input: &'a Path,
    pub(super) file: &'a GaitFile,
    pub(super) norm: Option<&'a Norm>,
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
        let file = self.file;
        let surface = match file.surface {
            Surface::Ground => "over ground".to_owned(),
            Surface::Treadmill => format!("on a treadmill at {:.2} m/s", file.belt_m_s),
        };
        let leg = file.leg_length_m.map_or(String::new(), |l| format!(", leg {l:.3} m"));
        let (frames, fps) = (file.frames, file.fps);
        let input = self.input.display();
        let named = file.used.len();
        format!(
            "{input}: {frames} frames at {fps} Hz, {surface}{leg}; {named} points of the body were found (their names are in gait.json)\n"
        )
    }

    fn parameters(&self) -> String {
        if self.file.parameters.is_empty() {
            return String::new();
        }
        let side = ["SD", "± u", "n"];
        let mut headings = vec!["parameter", "unit", "left"];
        headings.extend(side);
        headings.push("right");
        headings.extend(side);
        headings.extend(["R/L %", "norm"]);
        let mut table = Table::new(&headings);

        for part in &self.file.parameters {
            let leg = self.file.leg_length_m.filter(|_| self.is_normalised);
            let scale = leg.map_or(1.0, |leg| part.name.scale(leg));
            let unit = if leg.is_some() && !part.unit.starts_with('%') { "–" } else { part.unit };

            let mut row = vec![part.name.name().to_owned(), unit.to_owned()];
            for side in [part.left.as_ref(), part.right.as_ref()] {
                let mut side_cells = cells(side, scale);
                let beyond = side.and_then(|s| self.norm?.beyond(part.name, s.mean));
                side_cells[0] += beyond.map_or("", Beyond::mark);
                row.extend(side_cells);
            }
            row.push(part.symmetry_percent.map_or("–".into(), |s| format!("{s:.0}")));

            let norm = self.norm.and_then(|n| n.parameters.get(&part.name));
            let norm = norm.filter(|_| leg.is_none());
            row.push(
                norm.map_or("–".into(), |(mean, sd)| {
                    format!("{} ± {}", number(*mean), number(*sd))
                }),
            );
            table.row(row);
        }

        let mut text = table.text();
        text += "  SD: between strides. u: standard uncertainty of one value.\n";
        if let Some(norm) = self.norm.filter(|norm| !norm.parameters.is_empty()) {
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
        for agreement in &self.file.agreement {
            let kind = match agreement.kind {
                maquette::gait::EventKind::Strike => "foot strike",
                maquette::gait::EventKind::Off => "foot off",
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
        if self.file.curves.is_empty() {
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

        for curve in &self.file.curves {
            let sd = curve.fit_sd_deg.as_ref().and_then(|sd| mean(sd.iter().copied()));
            table.row(vec![
                curve.angle.name().into(),
                curve.side.name().into(),
                format!("{:.1}", curve.initial_contact_deg),
                format!("{:.1}", curve.stance.least),
                curve.stance.least_at_percent.to_string(),
                format!("{:.1}", curve.stance.greatest),
                curve.stance.greatest_at_percent.to_string(),
                format!("{:.1}", curve.swing.greatest),
                curve.swing.greatest_at_percent.to_string(),
                format!("{:.1}", curve.range_deg),
                sd.map_or("–".into(), |sd| format!("{sd:.1}")),
            ]);
        }

        table.text()
    }

    fn scores(&self) -> String {
        let (Some(indices), Some(norm)) = (&self.file.indices, self.norm) else {
            return String::new();
        };
        let mut table = Table::new(&["score, °", "left", "right"]);
        let score = |value: Option<f64>| value.map_or("–".into(), |v| format!("{v:.1}"));

        for angle in maquette::gait::VARIABLES {
            let of = |side: Side| {
                let mut all = indices.variables.iter();
                all.find(|v| v.angle == angle && v.side == side).map(|v| v.score)
            };
            table.row(vec![
                format!("GVS {}", angle.name()),
                score(of(Side::Left)),
                score(of(Side::Right)),
            ]);
        }

        table.row(vec!["GPS".into(), score(indices.left), score(indices.right)]);

        let both = indices
            .both
            .map_or("  GPS of both sides: – (it needs all nine variables)\n".into(), |v| {
                format!("  GPS of both sides: {v:.1}°\n")
            });

        let caution = Footwear::caution(norm.footwear, self.footwear);
        let caution = caution.map_or(String::new(), |caution| format!("  ! {caution}\n"));
        format!("{}{both}  against {}: {}\n{caution}", table.text(), norm.name, norm.source)
    }

    fn remarks(&self) -> String {
        let mut text = String::new();
        for note in &self.file.notes {
            text += &format!("  ! {note}\n");
        }
        for unknown in &self.file.unknown {
            text += &format!("  ! {}: {}\n", unknown.angle.name(), unknown.reason);
        }
        let is_made = |u: &&Used| u.from.contains(", ") || u.from.contains(": ");
        for used in self.file.used.iter().filter(is_made) {
            text += &format!("  ! {}: from {}\n", used.landmark.name(), used.from);
        }
        text
    }
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
