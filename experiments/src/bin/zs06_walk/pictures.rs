//! Angles, errors and lengths, drawn.

use experiments::metrics::{Flexion, HIPS, KNEES, frame_error_mm, mean_distance};
use experiments::picture::{Panel, colour, svg};
use kuva::plot::LegendPosition;
use maquette::io::points::trc::Trajectories;

use crate::fit::{Fit, Scene};
use crate::report::model_lengths;

/// Fits that are drawn, with their colours.
fn drawn(fits: &[Fit]) -> impl Iterator<Item = (&'static str, &'static str, &Trajectories)> {
    let wanted = [("outline", colour::BLUE), ("published", colour::ORANGE)];
    wanted.into_iter().filter_map(|(name, colour)| {
        let fit = fits.iter().find(|f| f.name == name)?;
        Some((name, colour, &fit.keyframes.fit))
    })
}

/// Knee and hip flexion over time against the truth.
pub(crate) fn angles(scene: &Scene<'_>, fits: &[Fit]) -> String {
    let panel = |(title, flexion, top, legend): (&str, Flexion, f64, bool)| {
        let curve = |of: &Trajectories| -> Vec<(f64, f64)> {
            let at = |frame| Some((frame as f64 / scene.fps, flexion.deg(of, frame)?));
            (0..of.frames.len()).filter_map(at).collect()
        };
        let mut panel =
            Panel::new(title, "time (s)", "flexion (°)").ranges((0.0, end(scene)), (0.0, top));
        if legend {
            panel = panel.legend(LegendPosition::InsideTopRight);
        }
        let name = |name| if legend { name } else { "" };
        panel =
            drawn(fits).fold(panel, |p, (n, colour, fit)| p.curve(name(n), colour, &curve(fit)));
        panel.dashed(name("truth"), colour::BLACK, &curve(&scene.truth))
    };
    let panels = [
        ("right knee", KNEES[0], 110.0, true),
        ("left knee", KNEES[1], 110.0, false),
        ("right hip (trunk to thigh)", HIPS[0], 80.0, false),
        ("left hip (trunk to thigh)", HIPS[1], 80.0, false),
    ];
    svg(2, (480.0, 270.0), panels.map(panel).into_iter().collect())
}

fn end(scene: &Scene<'_>) -> f64 {
    scene.truth.frames.len() as f64 / scene.fps
}

/// Mean joint error of every frame, and the lengths.
pub(crate) fn errors(scene: &Scene<'_>, fits: &[Fit]) -> String {
    let frames =
        Panel::new("joint centres, every frame", "time (s)", "mean error of the limb joints (mm)")
            .ranges((0.0, end(scene)), (0.0, 40.0))
            .legend(LegendPosition::InsideTopRight);
    let frames = drawn(fits).fold(frames, |panel, (name, colour, fit)| {
        let at =
            |frame| Some((frame as f64 / scene.fps, frame_error_mm(&scene.truth, fit, frame)?));
        let points: Vec<_> = (0..fit.frames.len()).filter_map(at).collect();
        panel.curve(name, colour, &points)
    });
    let mut series = vec![("truth", colour::GREY)];
    series.extend(drawn(fits).map(|(name, colour, _)| (name, colour)));
    let group = |(name, from, to): (String, String, String)| {
        let all = std::iter::once(&scene.truth).chain(drawn(fits).map(|(_, _, fit)| fit));
        let values = all.map(|of| 1e2 * mean_distance(of, &from, &to).unwrap_or(f64::NAN));
        (name, values.collect())
    };
    let groups: Vec<(String, Vec<f64>)> = model_lengths(scene).into_iter().map(group).collect();
    let lengths = Panel::new("lengths", "", "length (cm)")
        .ranges((0.0, 1.0), (0.0, 60.0))
        .legend(LegendPosition::InsideTopLeft)
        .bars(&series, &groups);
    svg(2, (480.0, 320.0), vec![frames, lengths])
}
