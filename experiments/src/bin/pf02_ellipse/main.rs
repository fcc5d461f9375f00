//! PF02 Fig. 2(b): an ellipse fitted to slightly noisy points of the side that faces the camera, with and without two
//! lines of sight that touch it.
//!
//! 400 draws: an ellipse of 5.5 and 4 cm turned at random, 40 points on the part of its border that slants at most 55°,
//! off by 4 mm along the line of sight and 0.5 mm across it; the two lines of sight by 1 mm. Each is fitted with PF02's
//! residual T − F and with the distance.
//!
//! Starts: the middle of the points, 4 cm farther from the camera, with axes of 5.5 and 5 cm. No truth enters but the long axis.

mod ellipse;

use std::error::Error;
use std::f64::consts::{FRAC_PI_2, PI, TAU};
use std::process::ExitCode;

use experiments::picture::{Panel, colour, svg};
use experiments::run::Run;
use experiments::table::Table;
use maquette::likelihood::Residual;
use maquette::math::stats::median;
use nalgebra::{Rotation2, Vector2};
use rand::{Rng, RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, StandardNormal};
use rayon::prelude::*;

use ellipse::{Ellipse, Fit, Seen, Tangent};

const DRAWS: u64 = 400;
const POINTS: usize = 40;
const AXES: [f64; 2] = [0.055, 0.04];
const DEPTH_SD: f64 = 0.004;
const ACROSS_SD: f64 = 0.0005;
const TANGENT_SD: f64 = 0.001;
const STEEPEST: f64 = 55.0 * PI / 180.0;
const AXES_SD: f64 = 1.0;
/// Fits drawn in each panel.
const SHOWN: usize = 12;

/// A way to fit.
struct Way {
    name: &'static str,
    title: &'static str,
    residual: Residual,
    with_tangents: bool,
}

const WAYS: [Way; 4] = [
    Way {
        name: "field_points",
        title: "T − F, points alone",
        residual: Residual::Field,
        with_tangents: false,
    },
    Way {
        name: "field_tangents",
        title: "T − F, points and tangents",
        residual: Residual::Field,
        with_tangents: true,
    },
    Way {
        name: "metric_points",
        title: "distance, points alone",
        residual: Residual::Metric,
        with_tangents: false,
    },
    Way {
        name: "metric_tangents",
        title: "distance, points and tangents",
        residual: Residual::Metric,
        with_tangents: true,
    },
];

fn main() -> Result<ExitCode, Box<dyn Error>> {
    let mut run = Run::start("pf02_ellipse");
    run.setting("draws", DRAWS);
    run.setting("axes_m", AXES);
    run.setting("depth_sd_m", DEPTH_SD);
    run.setting("tangent_sd_m", TANGENT_SD);
    let seed = run.seed() * DRAWS;
    let draws: Vec<(Ellipse, Seen)> = (0..DRAWS).map(|i| draw(seed + i)).collect();
    let mut table = Table::new(
        "ellipses",
        &["fit", "area / true", "9th decile", "width / true", "middle off, mm", "shape off, mm"],
    );
    let mut panels = Vec::new();
    for way in &WAYS {
        let fits: Vec<Ellipse> = draws.par_iter().map(|(_, seen)| way.fit(seen)).collect();
        report(&mut run, &mut table, way, &draws, &fits);
        panels.push(panel(way, &draws, &fits));
    }
    run.table("Fits against the truth, medians", &table)?;
    run.picture("fits", &svg(2, (420.0, 380.0), panels))?;
    Ok(run.finish()?)
}

impl Way {
    fn fit(&self, seen: &Seen) -> Ellipse {
        let mut seen = seen.clone();
        if !self.with_tangents {
            seen.tangents.clear();
        }
        let fit = Fit { seen: &seen, residual: self.residual, axes_sd: AXES_SD };
        let middle: Vector2<f64> = seen.points.iter().sum::<Vector2<f64>>() / POINTS as f64;
        let start = Ellipse {
            centre: middle + Vector2::new(0.0, 0.04),
            log_axes: Vector2::new(0.055_f64.ln(), 0.05_f64.ln()),
            angle: 0.0,
        };
        fit.solve(start).state
    }
}

/// An ellipse and what a camera far away at −y sees of it.
fn draw(seed: u64) -> (Ellipse, Seen) {
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    let truth = Ellipse {
        centre: Vector2::zeros(),
        log_axes: Vector2::from(AXES).map(f64::ln),
        angle: rng.random_range(-FRAC_PI_2..FRAC_PI_2),
    };
    let mut normal = |sd: f64| sd * gaussian(&mut rng);
    let tangents = [Vector2::x(), -Vector2::x()].map(|direction| Tangent {
        normal: direction,
        offset: truth.half_extent(&direction) + normal(TANGENT_SD),
    });
    let mut points = Vec::new();
    while points.len() < POINTS {
        let turn = rng.random_range(0.0..TAU);
        if slant(&truth, turn) < STEEPEST {
            let error = Vector2::new(ACROSS_SD * gaussian(&mut rng), DEPTH_SD * gaussian(&mut rng));
            points.push(truth.border(turn) + error);
        }
    }
    let seen =
        Seen { points, tangents: tangents.to_vec(), point_sd: DEPTH_SD, tangent_sd: TANGENT_SD };
    (truth, seen)
}

fn gaussian(rng: &mut impl Rng) -> f64 {
    StandardNormal.sample(rng)
}

/// Angle between the border's outward normal and the direction to the camera.
fn slant(ellipse: &Ellipse, turn: f64) -> f64 {
    let axes = ellipse.log_axes.map(f64::exp);
    let (sin, cos) = turn.sin_cos();
    let normal = Rotation2::new(ellipse.angle) * Vector2::new(cos / axes.x, sin / axes.y);
    normal.angle(&-Vector2::y())
}

/// Root mean square over directions of the difference of the half extents: what shape alone is off.
fn shape_off(a: &Ellipse, b: &Ellipse) -> f64 {
    let each = (0..180).map(|k| {
        let direction = Rotation2::new(f64::from(k) * PI / 180.0) * Vector2::x();
        (a.half_extent(&direction) - b.half_extent(&direction)).powi(2)
    });
    (each.sum::<f64>() / 180.0).sqrt()
}

fn report(
    run: &mut Run,
    table: &mut Table,
    way: &Way,
    draws: &[(Ellipse, Seen)],
    fits: &[Ellipse],
) {
    let pairs = || draws.iter().map(|(truth, _)| truth).zip(fits);
    let middle = |value: &dyn Fn((&Ellipse, &Ellipse)) -> f64| {
        median(&mut pairs().map(value).collect()).unwrap_or(f64::NAN)
    };
    let mut areas: Vec<f64> = pairs().map(|(truth, fit)| fit.area() / truth.area()).collect();
    areas.sort_by(f64::total_cmp);
    let area = middle(&|(truth, fit)| fit.area() / truth.area());
    let ninth = areas[areas.len() * 9 / 10];
    let x = Vector2::x();
    let width = middle(&|(truth, fit)| fit.half_extent(&x) / truth.half_extent(&x));
    let centre_mm = 1000.0 * middle(&|(truth, fit)| (fit.centre - truth.centre).norm());
    let shape_mm = 1000.0 * middle(&|(truth, fit)| shape_off(truth, fit));
    let numbers = [
        ("area_ratio", area),
        ("area_ratio_ninth_decile", ninth),
        ("width_ratio", width),
        ("middle_off_mm", centre_mm),
        ("shape_off_mm", shape_mm),
    ];
    for (name, value) in numbers {
        run.number(format!("{}_{name}", way.name), value);
    }
    let cells = numbers.iter().map(|(_, value)| format!("{value:.2}"));
    table.row(std::iter::once(way.title.to_owned()).chain(cells));
}

/// Some of the fits over the points of the first draw, each turned as the first ellipse is.
fn panel(way: &Way, draws: &[(Ellipse, Seen)], fits: &[Ellipse]) -> Panel {
    let outline = |ellipse: &Ellipse| -> Vec<(f64, f64)> {
        let points = (0..=120).map(|k| ellipse.border(TAU * f64::from(k) / 120.0) * 100.0);
        points.map(|p| (p.x, -p.y)).collect()
    };
    let (truth, seen) = &draws[0];
    let points: Vec<(f64, f64)> = seen.points.iter().map(|p| (p.x * 100.0, -p.y * 100.0)).collect();
    let mut panel = Panel::new(way.title, "across, cm", "towards the camera, cm")
        .ranges((-12.0, 12.0), (-16.0, 7.0))
        .equal_aspect();
    // other noise of the same ellipse would be seen alike: take the draws whose ellipse is turned nearly as this one
    let mut near: Vec<usize> = (1..draws.len()).collect();
    let off = |i: &usize| (draws[*i].0.angle - truth.angle).abs();
    near.sort_by(|a, b| off(a).total_cmp(&off(b)));
    for &i in near.iter().take(SHOWN) {
        panel = panel.curve("", colour::ORANGE, &outline(&fits[i]));
    }
    if way.with_tangents {
        for tangent in &seen.tangents {
            let x = 100.0 * tangent.offset * tangent.normal.x;
            panel = panel.curve("", colour::GREY, &[(x, -16.0), (x, 7.0)]);
        }
    }
    panel.curve("", colour::BLACK, &outline(truth)).marks("", colour::BLUE, &points)
}
