//! Elbows and wrists over time, drawn.

use experiments::picture::{Panel, colour, svg};
use kuva::plot::LegendPosition;
use maquette::io::trc::Trajectories;

use crate::arms::{ARMS, Arm};
use crate::recording::HIDDEN_S;
use crate::ways::{Scene, Way};

const COLOURS: [&str; 4] = [colour::ORANGE, colour::PURPLE, colour::GREEN, colour::BLUE];

/// Flexion of both elbows against the truth: frame by frame, and the joint optimum with twice its standard deviation.
pub(crate) fn elbow(scene: &Scene<'_>, ways: &[Way]) -> String {
    let joint = ways.iter().filter(|w| !w.elbow_sd_deg.is_empty()).count();
    let (tracked, joint) = ways.split_at(ways.len() - joint);
    let rows = [
        ("frame by frame", tracked, COLOURS[0..2].to_vec()),
        ("joint optimum ± 2 SD", joint, COLOURS[2..4].to_vec()),
    ];
    let mut panels = Vec::new();
    for (title, ways, colours) in rows {
        for (side, arm) in ARMS.into_iter().enumerate() {
            let mut panel = held_marked(
                Panel::new(
                    &format!("{} elbow, {title}", arm.name),
                    "time (s)",
                    "flexion (°)",
                )
                .ranges((0.0, end(scene)), (0.0, 150.0)),
            );
            if side == 0 {
                panel = panel.legend(LegendPosition::InsideTopRight);
            }
            let named = |name: &'static str| if side == 0 { name } else { "" };
            for (way, colour) in ways.iter().zip(&colours) {
                let curve = flexion(scene, arm, &way.fit);
                let sd = way.elbow_sd_deg.iter().map(|sd| 2.0 * sd[side]);
                let band = curve.iter().zip(sd);
                let band = band.map(|(&(t, deg), sd)| (t, (deg - sd).max(0.0), deg + sd));
                panel = panel.band("", colour, &band.collect::<Vec<_>>());
                panel = panel.curve(named(short(way)), colour, &curve);
            }
            let truth = flexion(scene, arm, &scene.truth);
            panels.push(panel.dashed(named("truth"), colour::BLACK, &truth));
        }
    }
    svg(2, (520.0, 290.0), panels)
}

/// Distance of both wrists from the truth.
pub(crate) fn wrist(scene: &Scene<'_>, ways: &[Way]) -> String {
    let panel = |(side, arm): (usize, Arm)| {
        let mut panel = Panel::new(
            &format!("{} wrist", arm.name),
            "time (s)",
            "distance from the truth (mm)",
        )
        .ranges((0.0, end(scene)), (0.0, 400.0));
        if side == 0 {
            panel = panel.legend(LegendPosition::InsideTopRight);
        }
        for (way, colour) in ways.iter().zip(COLOURS) {
            let at = |f: usize| {
                let error = arm.error(&scene.truth, &way.fit, f)?;
                Some((f as f64 / scene.fps, 1e3 * error.wrist_m))
            };
            let curve: Vec<_> = (0..scene.frames.len()).filter_map(at).collect();
            panel = panel.curve(if side == 0 { way.title } else { "" }, colour, &curve);
        }
        held_marked(panel)
    };
    let panels = ARMS.into_iter().enumerate().map(panel).collect();
    svg(2, (520.0, 320.0), panels)
}

fn held_marked(panel: Panel) -> Panel {
    panel.rule_at(HIDDEN_S[1], "").rule_at(HIDDEN_S[2], "")
}

fn short(way: &Way) -> &'static str {
    way.title.split(',').next().unwrap_or(way.title)
}

fn flexion(scene: &Scene<'_>, arm: Arm, of: &Trajectories) -> Vec<(f64, f64)> {
    let at = |f: usize| Some((f as f64 / scene.fps, arm.flexion().deg(of, f)?));
    (0..of.frames.len()).filter_map(at).collect()
}

fn end(scene: &Scene<'_>) -> f64 {
    scene.truth.frames.len() as f64 / scene.fps
}
