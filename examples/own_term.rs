//! A likelihood term of one's own beside the shipped ones: two tape measures between points of the body.
//!
//! A tape between the points a and b reads ℓ ± σ. Its term is ½ ((|b − a| − ℓ)/σ)², and with the unit vector
//! u = (b − a)/|b − a| its derivative by the state is uᵀ(∂b − ∂a).
//!
//! `cargo run --release --example own_term`

#![allow(clippy::print_stdout, clippy::print_stderr, reason = "an example prints what it found")]

use std::error::Error;
use std::path::Path;
use std::process::ExitCode;

use maquette::body::{Motion, Posed, Shape, State};
use maquette::inference::frame::KeyframePosterior;
use maquette::inference::{Detail, Evidence};
use maquette::io::model;
use maquette::likelihood::{LikelihoodOptions, Measure, PlacedResidual, Term};
use maquette::silhouette::{FrameIndex, FrameObservations};
use maquette::solver::{NormalEquations, Options, check_linearization, levenberg_marquardt};
use maquette::synth::Ring;
use nalgebra::DVector;

/// A tape between two points of the body.
#[derive(Debug)]
struct Tape {
    /// Positions of the points in the model's list.
    ends: [usize; 2],
    /// What it reads, m.
    length_m: f64,
    /// Its standard deviation, m.
    sigma_m: f64,
}

impl Tape {
    /// r/σ, and its derivative by every component of the state.
    fn residual(&self, body: &Posed<'_>) -> (f64, DVector<f64>) {
        let points = body.points();
        let [a, b] = self.ends;
        let way = points[b] - points[a];
        let slope = body.point_jacobian(b) - body.point_jacobian(a);
        let value = (way.norm() - self.length_m) / self.sigma_m;
        (value, slope.tr_mul(&way) / (way.norm() * self.sigma_m))
    }
}

impl Term for Tape {
    fn name(&self) -> &'static str {
        "tape"
    }

    fn cost(&self, body: &Posed<'_>) -> f64 {
        0.5 * self.residual(body).0.powi(2)
    }

    fn observations(&self) -> f64 {
        1.0
    }

    fn linearize(&self, body: &Posed<'_>, equations: &mut NormalEquations) -> f64 {
        let (value, slope) = self.residual(body);
        // components of the state that the equations do not have are held fixed
        let slope = slope.rows(0, equations.gradient.len());
        equations.gradient += value * slope;
        equations.hessian += slope * slope.transpose();
        0.5 * value * value
    }

    fn placed_residuals(&self, _body: &Posed<'_>) -> Vec<PlacedResidual> {
        // nothing is known of how tapes repeat their errors
        Vec::new()
    }
}

fn main() -> ExitCode {
    match run() {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            eprintln!("error: {error}");
            ExitCode::FAILURE
        }
    }
}

fn run() -> Result<(), Box<dyn Error>> {
    let model = model::load("human-ellipsoids", Path::new(""))?;
    let point = |name| model.point(name).ok_or("the body has no such point");
    let tape = |from, to, length_m| -> Result<Tape, Box<dyn Error>> {
        Ok(Tape { ends: [point(from)?, point(to)?], length_m, sigma_m: 0.005 })
    };

    // the shipped terms of a frame (here one that no camera saw), and two more
    let rig = Ring::default().regular();
    let evidence = Evidence::new(&model, &rig, LikelihoodOptions::default(), Measure::Ellipses);
    let frame = FrameObservations::nothing(FrameIndex(0));
    let mut terms = evidence.terms(&frame, Detail::Fine);
    terms.push(Box::new(tape("RHip", "RKnee", 0.46)?));
    terms.push(Box::new(tape("RKnee", "RAnkle", 0.40)?));

    // −log p(m, s | Z): the law that cost and linearisation agree, then its least
    let posterior = KeyframePosterior {
        model: &model,
        shape_prior: &evidence.shape_prior,
        pose_prior: &evidence.pose_prior,
        terms: &terms,
    };
    let start = State { shape: Shape(model.statistics.mean.clone()), motion: Motion::rest(&model) };
    check_linearization(&posterior, &start, 1e-6, 1e-4)?;
    let found = levenberg_marquardt(&posterior, start, &Options::default());

    let body = Posed::new(&model, &found.state.shape, &found.state.motion);
    let points = body.points();
    for [from, to] in [["RHip", "RKnee"], ["RKnee", "RAnkle"]] {
        let way = points[point(to)?] - points[point(from)?];
        println!("{from} to {to}: {:.1} cm", 100.0 * way.norm());
    }
    Ok(())
}
