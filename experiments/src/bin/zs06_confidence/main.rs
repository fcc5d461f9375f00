//! ZS06's p_ε,σ(K) against what came true, on 500 simulated recordings of an arm.
//!
//! Each recording: another arm of two bars (a, thickness), twelve bent poses, ragged silhouettes. Every frame
//! is a keyframe with its own estimate a*ₖ. Stated: p_ε,σ(K), σ by maximum likelihood from the K estimates
//! (from all twelve for K = 1, where K tell nothing). True: one of the K is within ε
//!
//! - of the model's own optimum ā = argmax p(a | Z₁ … Z₁₂), which is what the paper speaks of;
//! - of the true a, which a user means.
//!
//! The bars are no ellipses, so all keyframes err to the same side.
//!
//! Starts: every frame begins at a = 0.5 and its true angle + 0.05 rad. Not from nothing: what is tested is the statement about
//! optima, not how they are found (`zs06_arm` finds them).

mod recording;

use std::error::Error;
use std::path::Path;
use std::process::ExitCode;

use experiments::picture::{Panel, colour, svg};
use experiments::run::Run;
use experiments::table::Table;
use kuva::plot::LegendPosition;
use maquette::inference::confidence::{maximum_likelihood_sigma, p_at_least_one, p_within};
use maquette::io::model;
use maquette::math::stats::mean;
use rayon::prelude::*;

use recording::{Estimates, estimate};

const RECORDINGS: u64 = 500;
const KEYFRAMES: [(usize, &str); 4] =
    [(1, colour::GREY), (2, colour::ORANGE), (5, colour::GREEN), (10, colour::BLUE)];
/// Tolerances ε of a, from far below to far above the scatter of the estimates.
const TOLERANCES: [f64; 8] = [0.0005, 0.001, 0.002, 0.004, 0.007, 0.012, 0.02, 0.04];

fn main() -> Result<ExitCode, Box<dyn Error>> {
    let mut run = Run::start("zs06_confidence");
    run.setting("recordings", RECORDINGS);
    run.setting("tolerances", TOLERANCES);
    let arm = model::load("arm-2d", Path::new(""))?;
    let seed = run.seed() * RECORDINGS;
    let recordings: Vec<Estimates> =
        (0..RECORDINGS).into_par_iter().map(|i| estimate(&arm, seed + i)).collect();
    let points: Vec<Point> = KEYFRAMES
        .iter()
        .flat_map(|&(k, _)| TOLERANCES.map(|epsilon| Point::of(&recordings, k, epsilon)))
        .collect();
    report(&mut run, &recordings, &points)?;
    run.picture("reliability", &reliability(&points))?;
    Ok(run.finish()?)
}

/// What was stated and what came true for one K and one ε, over all recordings.
struct Point {
    k: usize,
    epsilon: f64,
    stated: f64,
    of_optimum: f64,
    of_truth: f64,
}

impl Point {
    fn of(recordings: &[Estimates], k: usize, epsilon: f64) -> Self {
        let mean = |value: &dyn Fn(&Estimates) -> f64| {
            mean(recordings.iter().map(value)).unwrap_or(f64::NAN)
        };
        let share_within = |target: &dyn Fn(&Estimates) -> f64| {
            mean(&|r| {
                let near = r.keyframes[..k].iter().any(|a| (a - target(r)).abs() <= epsilon);
                f64::from(u8::from(near))
            })
        };
        let sigma = |r: &Estimates| {
            let keyframes = if k == 1 { &r.keyframes[..] } else { &r.keyframes[..k] };
            maximum_likelihood_sigma(keyframes, r.optimum)
        };
        Self {
            k,
            epsilon,
            stated: mean(&|r| {
                p_at_least_one(p_within(epsilon, sigma(r).unwrap_or(f64::INFINITY)), k)
            }),
            of_optimum: share_within(&|r| r.optimum),
            of_truth: share_within(&|r| r.truth),
        }
    }
}

fn report(run: &mut Run, recordings: &[Estimates], points: &[Point]) -> Result<(), Box<dyn Error>> {
    let mut table =
        Table::new("reliability", &["K", "ε", "stated", "of the optimum", "of the truth"]);
    for p in points {
        let numbers = [p.stated, p.of_optimum, p.of_truth].map(|v| format!("{v:.3}"));
        table.row([p.k.to_string(), p.epsilon.to_string()].into_iter().chain(numbers));
    }
    run.table("stated probability and the share that came true", &table)?;
    // mean gap over ε: how much more, or less, came true than was stated
    for (k, _) in KEYFRAMES {
        let gap = |value: &dyn Fn(&Point) -> f64| {
            let of_k = points.iter().filter(|p| p.k == k);
            of_k.map(|p| value(p) - p.stated).sum::<f64>() / TOLERANCES.len() as f64
        };
        run.number(format!("gap_to_optimum_k{k}"), gap(&|p| p.of_optimum));
        run.number(format!("gap_to_truth_k{k}"), gap(&|p| p.of_truth));
    }
    let count = recordings.len() as f64;
    let bias = recordings.iter().map(|r| r.optimum - r.truth).sum::<f64>() / count;
    let off = recordings.iter().map(|r| (r.optimum - r.truth).abs()).sum::<f64>() / count;
    let sigma = recordings
        .iter()
        .filter_map(|r| maximum_likelihood_sigma(&r.keyframes, r.optimum))
        .sum::<f64>()
        / count;
    run.number("sigma_of_keyframes", sigma);
    run.number("optimum_minus_truth", bias);
    run.number("optimum_off_truth", off);
    Ok(())
}

/// Stated against true, one curve for each K.
fn reliability(points: &[Point]) -> String {
    let panel = |title: &str, value: &dyn Fn(&Point) -> f64| {
        let empty = Panel::new(title, "stated p_ε,σ(K)", "share that came true")
            .ranges((0.0, 1.0), (0.0, 1.0))
            .dashed("as stated", colour::BLACK, &[(0.0, 0.0), (1.0, 1.0)])
            .legend(LegendPosition::OutsideRightTop);
        KEYFRAMES.iter().fold(empty, |panel, &(k, colour)| {
            let of_k = points.iter().filter(|p| p.k == k);
            let curve: Vec<(f64, f64)> = of_k.map(|p| (p.stated, value(p))).collect();
            panel.curve(&format!("K = {k}"), colour, &curve).marks("", colour, &curve)
        })
    };
    let panels = vec![
        panel("within ε of the model's optimum", &|p| p.of_optimum),
        panel("within ε of the true length", &|p| p.of_truth),
    ];
    svg(2, (460.0, 360.0), panels)
}
