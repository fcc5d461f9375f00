//! An active contour of 400 points to rest, beside scikit-image's `active_contour` in the same run.
//!
//! `cargo bench --bench snake` (`PYTHON` names a Python with scikit-image; without one ours is measured alone). Both start
//! 6 px outside an ellipse, in a picture of 320 × 240 px with waves of a fifth of its contrast, made by the same formula
//! here and there. Rows: milliseconds, fastest and median, gradient of the picture included; mean distance from the true border, px.

#![allow(clippy::print_stdout, reason = "a benchmark reports to the terminal")]

use std::f64::consts::TAU;
use std::path::Path;
use std::process::Command;
use std::time::Instant;

use maquette::image::{Gradient, Plane};
use maquette::silhouette::snake::{Ends, Snake, SnakeOptions};
use nalgebra::Point2;

const RUNS: usize = 100;
const POINTS: usize = 400;
const SIZE: (usize, usize) = (320, 240);
const CENTRE: (f64, f64) = (160.0, 120.0);
const AXES: (f64, f64) = (95.0, 70.0);
const START_PX: f64 = 6.0;

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let picture = picture().ok_or("a picture of no size")?;
    let start = ellipse(START_PX, POINTS);
    let length: f64 =
        start.iter().zip(start.iter().cycle().skip(1)).map(|(a, b)| (b - a).norm()).sum();
    let options = SnakeOptions {
        spacing_px: length / POINTS as f64,
        search_px: 1.5 * START_PX,
        prior_px: 1.5 * START_PX,
        ..SnakeOptions::default()
    };
    let mut times = Vec::new();
    let mut found = Vec::new();
    for _ in 0..RUNS {
        let begin = Instant::now();
        let gradient = Gradient::new(std::slice::from_ref(&picture), 1.2);
        let mut snake = Snake::new(&start, Ends::Closed, options).ok_or("no contour")?;
        snake.settle(&gradient);
        found = snake.points(&gradient);
        times.push(1e3 * begin.elapsed().as_secs_f64());
    }
    times.sort_by(f64::total_cmp);
    let truth = ellipse(0.0, 50_000);
    let off = |p: &Point2<f64>| {
        let nearest = truth.iter().map(|t| (t - p).norm_squared());
        nearest.fold(f64::MAX, f64::min).sqrt()
    };
    let mean = found.iter().map(|p| off(&p.pixel)).sum::<f64>() / found.len() as f64;
    println!("name fastest_ms median_ms off_px points");
    println!("maquette {:.3} {:.3} {mean:.3} {}", times[0], times[RUNS / 2], found.len());
    let python = std::env::var("PYTHON").unwrap_or_else(|_| "python3".into());
    let script = Path::new(env!("CARGO_MANIFEST_DIR")).join("benches/snake.py");
    if let Ok(twin) = Command::new(python).arg(script).output() {
        print!("{}", String::from_utf8_lossy(&twin.stdout));
    }
    Ok(())
}

/// 200 in the ellipse and 60 around it, over a border one pixel wide; and waves.
fn picture() -> Option<Plane<f32>> {
    let value = |i: usize| {
        let (x, y) = ((i % SIZE.0) as f64, (i / SIZE.0) as f64);
        let (u, v) = ((x - CENTRE.0) / AXES.0, (y - CENTRE.1) / AXES.1);
        let outside = (u.hypot(v) - 1.0) * AXES.1;
        let waves = 28.0 * (0.35 * x + 0.2 * y).sin() * (0.3 * y - 0.1 * x).sin();
        (60.0 + 140.0 * (0.5 - outside).clamp(0.0, 1.0) + waves) as f32
    };
    Plane::from_values(SIZE.0, SIZE.1, (0..SIZE.0 * SIZE.1).map(value).collect())
}

/// The ellipse, grown; anticlockwise on the screen.
fn ellipse(grown_px: f64, count: usize) -> Vec<Point2<f64>> {
    let at = |i: usize| -TAU * i as f64 / count as f64;
    let point = |i: usize| {
        Point2::new(
            CENTRE.0 + (AXES.0 + grown_px) * at(i).cos(),
            CENTRE.1 + (AXES.1 + grown_px) * at(i).sin(),
        )
    };
    (0..count).map(point).collect()
}
