//! ZS06's Figs. 4 and 5.

use experiments::picture::{Panel, colour, svg};
use kuva::plot::LegendPosition;
use maquette::body::Posed;
use maquette::camera::Camera;
use maquette::math::quadric::project;
use nalgebra::Vector2;

use crate::analysis::{ARM, Analysis, FRAMES, Scene};

/// Frames after which the paper shows the posterior.
const SHOWN: [usize; 3] = [1, 4, 6];

/// Names in legends, and colours, of the likelihoods that are drawn.
const DRAWN: [(&str, &str, &str); 3] = [
    ("outline", "outline", colour::BLUE),
    ("nearest", "nearest ellipse", colour::GREEN),
    ("published", "nearest, radial (ZS06)", colour::ORANGE),
];

fn drawn(analyses: &[Analysis]) -> impl Iterator<Item = (&Analysis, &'static str, &'static str)> {
    DRAWN.iter().filter_map(|(name, legend, colour)| {
        let analysis = analyses.iter().find(|a| a.name == *name)?;
        Some((analysis, *legend, *colour))
    })
}

/// ZS06, Fig. 4: silhouettes of frames 1, 4, 6 and the posterior of a after them.
pub(crate) fn posterior(scene: &Scene<'_>, analyses: &[Analysis]) -> String {
    let camera = &scene.rig.cameras[0];
    let silhouettes = SHOWN.map(|n| silhouette_panel(scene, camera, analyses, n));
    let highest = drawn(analyses).flat_map(|(a, _, _)| a.posterior.after(FRAMES));
    let top = highest.map(|(_, p)| p).fold(0.0, f64::max) * 1.05;
    let posteriors = SHOWN.map(|n| {
        let title =
            if n == 1 { "after frame 1".to_owned() } else { format!("after frames 1–{n}") };
        let panel = Panel::new(&title, "a", "p(a | Z), uniform prior")
            .ranges((0.0, 1.0), (0.0, if n == 1 { 8.0 } else { top }));
        let panel = if n == FRAMES { panel.legend(LegendPosition::InsideTopLeft) } else { panel };
        drawn(analyses)
            .fold(panel, |panel, (analysis, legend, colour)| {
                panel.curve(
                    if n == FRAMES { legend } else { "" },
                    colour,
                    &analysis.posterior.after(n),
                )
            })
            .rule_at(ARM.a, "")
    });
    svg(3, (340.0, 260.0), silhouettes.into_iter().chain(posteriors).collect())
}

/// The border that was seen, and the chosen hypothesis' ellipses.
fn silhouette_panel(scene: &Scene<'_>, camera: &Camera, analyses: &[Analysis], n: usize) -> Panel {
    let up = |x: f64, y: f64| (x, f64::from(camera.height_px) - y);
    let (width, height) = (f64::from(camera.width_px), f64::from(camera.height_px));
    let mut panel = Panel::new(&format!("frame {n}"), "x (px)", "y (px)")
        .ranges((0.0, width), (0.1 * height, 0.9 * height))
        .equal_aspect();
    if n == 1 {
        panel = panel.legend(LegendPosition::InsideTopLeft);
    }
    let (_, silhouette) = &scene.recordings[0][n - 1].views[0];
    let border = silhouette.contour.iter().chain(silhouette.contour.first());
    let border: Vec<_> = border.map(|p| up(p.pixel.x, p.pixel.y)).collect();
    panel = panel.curve(if n == 1 { "silhouette" } else { "" }, colour::BLACK, &border);
    let Some((analysis, legend, colour)) = drawn(analyses).next() else {
        return panel;
    };
    let trial = &analysis.found.trials[analysis.found.winner];
    let Some(fit) = &trial.frames[n - 1] else {
        return panel;
    };
    let body = Posed::new(scene.model, &trial.hypothesis.shape, &fit.motion);
    for (i, ellipsoid) in body.ellipsoids().iter().enumerate() {
        let Some(ellipse) = project(&camera.projection(), ellipsoid) else {
            continue;
        };
        let Some(root) = ellipse.shape.cholesky().map(|c| c.l()) else {
            continue;
        };
        let point = |k: usize| {
            let (sin, cos) = (std::f64::consts::TAU * k as f64 / 90.0).sin_cos();
            let x = ellipse.centre + root * Vector2::new(cos, sin);
            up(x[0], x[1])
        };
        let points: Vec<_> = (0..=90).map(point).collect();
        panel = panel.curve(if n == 1 && i == 0 { legend } else { "" }, colour, &points);
    }
    panel
}

/// ZS06, Fig. 5: the hypotheses' posteriors, and φ of the most probable one.
pub(crate) fn hypotheses(scene: &Scene<'_>, analyses: &[Analysis]) -> String {
    let series: Vec<(&str, &str)> =
        drawn(analyses).map(|(_, name, colour)| (name, colour)).collect();
    let probabilities: Vec<Vec<f64>> = drawn(analyses).map(|(a, _, _)| a.probabilities()).collect();
    let group = |j: usize| {
        let label = if j == 0 { "mean".to_owned() } else { j.to_string() };
        (label, probabilities.iter().map(|p| p[j]).collect())
    };
    let groups: Vec<(String, Vec<f64>)> = (0..=FRAMES).map(group).collect();
    let bars = Panel::new(
        "hypotheses",
        "from the prior's mean, from keyframe …",
        "sequence posterior, normalised",
    )
    .ranges((0.0, 1.0), (0.0, 1.0))
    .legend(LegendPosition::InsideTopLeft)
    .bars(&series, &groups);
    let truth: Vec<_> =
        scene.angles.iter().enumerate().map(|(i, phi)| (i as f64 + 1.0, *phi)).collect();
    let angles = Panel::new("angle of the most probable hypothesis", "frame", "φ (rad)")
        .ranges((0.5, 6.5), (-0.05, 0.6))
        .legend(LegendPosition::InsideTopLeft)
        .dashed("truth", colour::BLACK, &truth);
    let angles = drawn(analyses).fold(angles, |panel, (analysis, name, colour)| {
        let points = analysis.angles().into_iter().enumerate();
        let points: Vec<_> = points.map(|(i, phi)| (i as f64 + 1.0, phi)).collect();
        panel.marks(name, colour, &points)
    });
    svg(2, (480.0, 320.0), vec![bars, angles])
}
