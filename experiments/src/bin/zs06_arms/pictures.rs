//! Elbows and wrists over time, drawn.

use experiments::held::{ARMS, Arm, held_s};
use experiments::picture::{Panel, colour, svg};
use kuva::plot::LegendPosition;
use maquette::io::points::trc::Trajectories;

use crate::ways::{Scene, Way};

/// Ways that are drawn, with their colours: frame by frame, and all frames at once.
const DRAWN: [[(&str, &str); 2]; 2] = [
    [("published", colour::PURPLE), ("metaballs", colour::ORANGE)],
    [("joint_ellipses", colour::GREEN), ("joint_metaballs", colour::BLUE)],
];

/// Flexion of both elbows against the truth: frame by frame, and the joint optimum with twice its standard deviation.
pub(crate) fn elbow(scene: &Scene<'_>, ways: &[Way]) -> String {
    let rows = ["frame by frame", "joint optimum ± 2 SD"];
    let mut panels = Vec::new();
    for (title, drawn) in rows.into_iter().zip(DRAWN) {
        for (side, arm) in ARMS.into_iter().enumerate() {
            let mut panel = held_marked(
                scene,
                Panel::new(&format!("{} elbow, {title}", arm.name), "time (s)", "flexion (°)")
                    .ranges((0.0, end(scene)), (0.0, 150.0)),
            );
            if side == 1 {
                panel = panel.legend(LegendPosition::InsideTopRight);
            }
            let named = |name: &'static str| if side == 1 { name } else { "" };
            for (way, colour) in chosen(ways, &drawn) {
                let curve = flexion(scene, arm, &way.fit);
                let sd = way.elbow_sd_deg.iter().map(|sd| 2.0 * sd[side]);
                let band = curve.iter().zip(sd);
                let band = band.map(|(&(t, deg), sd)| (t, (deg - sd).max(0.0), deg + sd));
                let band: Vec<_> = band.collect();
                if !band.is_empty() {
                    panel = panel.band("", colour, &band);
                }
                panel = panel.curve(named(way.title), colour, &curve);
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
        let mut panel =
            Panel::new(&format!("{} wrist", arm.name), "time (s)", "distance from the truth (mm)")
                .ranges((0.0, end(scene)), (0.0, 600.0));
        if side == 1 {
            panel = panel.legend(LegendPosition::InsideTopRight);
        }
        for (way, colour) in chosen(ways, DRAWN.as_flattened()) {
            let at = |f: usize| {
                let error = arm.error(&scene.truth, &way.fit, f)?;
                Some((f as f64 / scene.fps, 1e3 * error.wrist_m))
            };
            let curve: Vec<_> = (0..scene.frames.len()).filter_map(at).collect();
            panel = panel.curve(if side == 1 { way.title } else { "" }, colour, &curve);
        }
        held_marked(scene, panel)
    };
    let panels = ARMS.into_iter().enumerate().map(panel).collect();
    svg(2, (520.0, 320.0), panels)
}

fn chosen<'a>(
    ways: &'a [Way],
    drawn: &[(&str, &'static str)],
) -> impl Iterator<Item = (&'a Way, &'static str)> {
    drawn.iter().filter_map(|(name, colour)| {
        let way = ways.iter().find(|way| way.name == *name)?;
        Some((way, *colour))
    })
}

fn held_marked(scene: &Scene<'_>, panel: Panel) -> Panel {
    let rules = held_s(scene.frames.len());
    rules.into_iter().fold(panel, |p, at| p.rule_at(at, ""))
}

fn flexion(scene: &Scene<'_>, arm: Arm, of: &Trajectories) -> Vec<(f64, f64)> {
    let at = |f: usize| Some((f as f64 / scene.fps, arm.flexion().deg(of, f)?));
    (0..of.frames.len()).filter_map(at).collect()
}

fn end(scene: &Scene<'_>) -> f64 {
    scene.truth.frames.len() as f64 / scene.fps
}
