//! Shares, and one arm from the side.

use experiments::picture::{Panel, colour, svg};
use kuva::plot::LegendPosition;

use crate::conditions::Condition;
use crate::sides::{Fit, LIKELIHOODS, Sides, Tally};

const COLOURS: [&str; 3] = [colour::PURPLE, colour::GREEN, colour::ORANGE];

/// Condition by condition: the fits that prefer the opposite side, and the held frames in which Algorithm 1 goes there.
pub(crate) fn shares(found: &[(&Condition, &Sides)]) -> String {
    let share = |count: usize, all: usize| 100.0 * count as f64 / all.max(1) as f64;
    let name = |c: &Condition| c.name.replace('_', " ");
    let prefers = found.iter().map(|(condition, sides)| {
        let each = sides.fits.each_ref().map(|fits| Tally::of(fits.iter()));
        (name(condition), each.map(|t| share(t.prefers, t.all)).to_vec())
    });
    let alone = found.iter().map(|(condition, sides)| {
        (name(condition), sides.alone.map(|t| share(t.opposite, t.held)).to_vec())
    });
    let series: Vec<(&str, &str)> = LIKELIHOODS.iter().map(|l| l.title).zip(COLOURS).collect();
    let panel =
        |title: &str, of: &str, series: &[(&str, &str)], groups: Vec<(String, Vec<f64>)>| {
            Panel::new(title, "", of)
                .ranges((0.0, groups.len() as f64), (0.0, 40.0))
                .legend(LegendPosition::OutsideRightTop)
                .bars(series, &groups)
        };
    let panels = vec![
        panel("the opposite side costs less", "of the fits, %", &series, prefers.collect()),
        panel(
            "found from nothing on the opposite side",
            "of the held frames, %",
            &series[..2],
            alone.collect(),
        ),
    ];
    svg(1, (1250.0, 300.0), panels)
}

/// The arm whose published optimum on the opposite side gains most, with what the others make of it.
pub(crate) fn example(found: &[Sides]) -> Option<String> {
    let gain = |f: &Fit| f.costs[0] - f.costs[1];
    let all = found.iter().flat_map(|s| s.fits[0].iter().enumerate().map(move |(k, f)| (s, k, f)));
    let worst = all
        .filter(|(_, _, f)| f.prefers_opposite() && !f.opposite[0])
        .max_by(|a, b| gain(a.2).total_cmp(&gain(b.2)))?;
    let (sides, k, _) = worst;
    let panels = LIKELIHOODS.iter().zip(&sides.fits).filter_map(|(likelihood, fits)| {
        let fit = fits.get(k)?;
        Some(arm(likelihood.title, fit))
    });
    Some(svg(3, (360.0, 420.0), panels.collect()))
}

/// A true arm and its two optima, seen across the plane in which it bends.
fn arm(title: &str, fit: &Fit) -> Panel {
    let [shoulder, elbow, wrist] = fit.arms[0].map(nalgebra::Vector3::from);
    let fore = wrist - elbow;
    let level = nalgebra::Vector3::new(fore.x, fore.y, 0.0);
    let forwards = level.try_normalize(1e-9).unwrap_or_else(nalgebra::Vector3::x);
    let seen = |arm: &[[f64; 3]; 3]| -> Vec<(f64, f64)> {
        let each = arm.map(|p| nalgebra::Vector3::from(p) - shoulder);
        each.iter().map(|p| (p.dot(&forwards), p.z)).collect()
    };
    let title = format!("{title}: cost {:.1}, opposite {:.1}", fit.costs[0], fit.costs[1]);
    Panel::new(&title, "towards the wrist (m)", "up (m)")
        .ranges((-0.35, 0.35), (-0.65, 0.35))
        .equal_aspect()
        .legend(LegendPosition::InsideTopRight)
        .dashed("truth", colour::BLACK, &seen(&fit.arms[0]))
        .curve("from the right start", colour::BLUE, &seen(&fit.arms[1]))
        .curve("from the opposite start", colour::ORANGE, &seen(&fit.arms[2]))
}
