//! The pictures of this experiment.

use experiments::limb::{LimbErrors, edges, front_pair, joints};
use experiments::picture::{Panel, colour, svg};
use kuva::plot::LegendPosition;
use maquette::body::{BodyModel, Posed, State};
use nalgebra::{Point3, Vector3};

use super::{BASELINE, Draw, Way};

type Fits<'a> = (&'a Way, Vec<State>, Vec<LimbErrors>);

/// Bars of the medians.
pub(super) fn errors(all: &[Fits<'_>]) -> String {
    let middle = |errors: &[LimbErrors], value: &dyn Fn(&LimbErrors) -> f64| {
        let mut values: Vec<f64> = errors.iter().map(value).collect();
        maquette::math::stats::median(&mut values).unwrap_or(0.0)
    };
    let pairs = [("T − F", 0), ("distance", 2), ("distance, p(s)", 4)];
    let series = [("stereo", colour::ORANGE), ("stereo and silhouettes", colour::BLUE)];
    let panel = |title: &str, label: &str, range, value: &dyn Fn(&LimbErrors) -> f64| {
        let groups: Vec<(String, Vec<f64>)> = pairs
            .iter()
            .map(|(name, first)| {
                let both = [0, 1].map(|k| middle(&all[first + k].2, value));
                ((*name).to_owned(), both.to_vec())
            })
            .collect();
        Panel::new(title, "", label)
            .ranges((0.0, 3.0), range)
            .legend(LegendPosition::OutsideRightTop)
            .bars(&series, &groups)
    };
    let most = |value: &dyn Fn(&LimbErrors) -> f64| {
        let each = all.iter().map(|(_, _, errors)| middle(errors, value));
        1.15 * each.fold(1.0, f64::max)
    };
    let width = |e: &LimbErrors| 0.5 * (e.width_pct[0] + e.width_pct[1]);
    let panels = vec![
        panel("bones off the true ones", "median, mm", (0.0, most(&|e| e.axis_mm)), &|e| e.axis_mm),
        panel("inflation of the widths", "median, %", (0.0, most(&width)), &width),
    ];
    svg(2, (470.0, 340.0), panels)
}

/// One arm from the side: the camera looks from the left.
pub(super) fn side(arm: &BodyModel, draw: &Draw, all: &[Fits<'_>]) -> String {
    let camera = &front_pair(BASELINE).cameras[0];
    let sight = camera.optical_axis().direction_world.into_inner();
    let depth = Vector3::new(sight.x, sight.y, 0.0);
    let depth = depth.try_normalize(1e-9).unwrap_or(Vector3::x());
    let middle = joints(&draw.truth.posed())[1];
    let flat = |p: &Point3<f64>| {
        let off = p - middle;
        (100.0 * off.dot(&depth), 100.0 * off.z)
    };
    let truth = draw.truth.posed();
    let points: Vec<(f64, f64)> = draw.points.iter().map(|p| flat(&p.position_world)).collect();
    let panels = all.iter().take(4).map(|(way, fits, _)| {
        let fit = Posed::new(arm, &fits[0].shape, &fits[0].motion);
        let panel = Panel::new(way.title, "away from the camera, cm", "up, cm")
            .ranges((-45.0, 45.0), (-45.0, 45.0))
            .equal_aspect()
            .marks("", colour::BLUE, &points);
        [(&truth, colour::BLACK), (&fit, colour::ORANGE)].into_iter().fold(
            panel,
            |panel, (body, colour)| {
                let bones: Vec<(f64, f64)> = joints(body).iter().map(&flat).collect();
                edges(body, &depth)
                    .into_iter()
                    .fold(panel, |panel, edge| {
                        let edge: Vec<(f64, f64)> = edge.iter().map(&flat).collect();
                        panel.curve("", colour, &edge)
                    })
                    .dashed("", colour, &bones)
            },
        )
    });
    svg(2, (430.0, 400.0), panels.collect())
}
