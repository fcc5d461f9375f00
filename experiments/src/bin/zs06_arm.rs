//! ZS06, Figs. 3–5: an arm whose length ratio a only bending can show.
//!
//! Six frames, φ = 0, 0.1 … 0.5 rad, a = 0.5, ragged silhouettes of two bars; every frame is a keyframe.
//! Algorithm 1 as published (no hypothesis from several frames together, nothing pruned), with the
//! published and with the outline likelihood.

use std::error::Error;
use std::path::Path;
use std::process::ExitCode;

use experiments::arm::{BarArm, Posterior, observe, rig, share_of};
use experiments::picture::{Panel, colour, svg};
use experiments::run::Run;
use experiments::table::Table;
use kuva::plot::LegendPosition;
use maquette::body::BodyModel;
use maquette::camera::Rig;
use maquette::inference::Evidence;
use maquette::inference::propagate::Sequence;
use maquette::inference::search::{NoJournal, Pruning, Search, SearchOptions, search};
use maquette::io::model;
use maquette::likelihood::EllipseOptions;
use maquette::silhouette::FrameObservations;
use maquette::synth::SegmentationErrors;
use rayon::prelude::*;

const ARM: BarArm = BarArm { a: 0.5, radii: [0.1; 3] };
const FRAMES: usize = 6;
const FPS: f64 = 10.0;
/// Frames after which the posterior is shown (the paper's).
const SHOWN: [usize; 3] = [1, 4, 6];
/// Cells of the grid of a.
const CELLS: usize = 200;
/// Repetitions with other noise.
const REPETITIONS: u64 = 100;

/// A ragged border: 2 px over 10 px, 1.4 cm on the arm.
const ERRORS: SegmentationErrors = SegmentationErrors {
    border_sd_px: 2.0,
    correlation_px: 10.0,
    bites: 0.0,
    holes: 0.0,
    specks: 0.0,
    blot_radius_px: (1.0, 2.0),
};

fn main() -> Result<ExitCode, Box<dyn Error>> {
    let mut run = Run::start("zs06_arm");
    let model = model::load("arm-2d", Path::new(""))?;
    let rig = rig();
    let angles: Vec<f64> = (0..FRAMES).map(|i| 0.1 * i as f64).collect();
    run.setting("arm", ARM);
    run.setting("likelihoods", likelihoods());
    let frames = observe(&ARM, &angles, &rig, &ERRORS, run.seed());
    for (name, likelihood) in likelihoods() {
        let evidence = Evidence::new(&model, &rig, likelihood);
        let sequence = Sequence { frames: &frames, fps: FPS };
        let posterior = Posterior::new(&evidence, sequence, CELLS);
        for n in 1..=FRAMES { println!("{name} {n} width {:.3} mode {:.3}", posterior.width(n), posterior.mode(n)); }
        let found = search(&evidence, sequence, &options(), &NoJournal).unwrap();
        let best = found.trials[found.winner].energy();
        for (j, t) in found.trials.iter().enumerate() {
            println!("{j} {:?} k{} a {:.3} E {:.2} p {:.4} kc {:.2} phi {:?}", t.hypothesis.origin, t.hypothesis.keyframe, share_of(&t.hypothesis.shape), t.energy(), (best - t.energy()).exp(), t.hypothesis.keyframe_cost, t.frames.iter().flatten().map(|f| (f.motion.angles[0]*1000.).round()/1000.).collect::<Vec<_>>());
        }
        // seeds
        let many: Vec<(f64, usize, f64)> = (0..REPETITIONS).into_par_iter().map(|seed| {
            let frames = observe(&ARM, &angles, &rig, &ERRORS, 1000 + seed);
            let sequence = Sequence { frames: &frames, fps: FPS };
            let found = search(&evidence, sequence, &options(), &NoJournal).unwrap();
            let w = &found.trials[found.winner].hypothesis;
            (share_of(&w.shape), w.keyframe, share_of(&found.trials[1].hypothesis.shape))
        }).collect();
        let within = many.iter().filter(|m| (m.0 - 0.5).abs() <= 0.05).count();
        let mean = many.iter().map(|m| m.0).sum::<f64>() / many.len() as f64;
        println!("within {within} mean {mean:.3} keyframes {:?} first {:?}", (0..6).map(|k| many.iter().filter(|m| m.1 == k).count()).collect::<Vec<_>>(), many.iter().map(|m| (m.2*100.).round()).collect::<Vec<_>>());
    }
    Ok(run.finish()?)
}

fn likelihoods() -> [(&'static str, EllipseOptions); 2] {
    let scale = |o: EllipseOptions| EllipseOptions { sigma_m: 0.03, correlation_m: 0.5, blend_m: 0.01, loss: maquette::solver::Loss::Squared, ..o };
    [("published", EllipseOptions{distance: maquette::likelihood::EllipseDistance::Orthogonal, ..scale(EllipseOptions::published())}), ("outline", EllipseOptions{distance: maquette::likelihood::EllipseDistance::Orthogonal, ..scale(EllipseOptions::default())})]
}

fn options() -> SearchOptions {
    SearchOptions { keyframe_every: 1, together: 0, pruning: Pruning::Off, ..SearchOptions::default() }
}
