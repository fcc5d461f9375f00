//! ZS06, Figs. 3–5: an arm whose length ratio a only bending can show.
//!
//! Six frames, φ = 0, 0.1 … 0.5 rad, a = 0.5, ragged silhouettes of two bars; every frame is a keyframe.
//! Algorithm 1 as published: no hypothesis from several frames together. Likelihoods:
//!
//! | name        | border pixel to …        | distance                     | back term |
//! |-------------|--------------------------|------------------------------|-----------|
//! | published   | nearest ellipse          | radial (CTU–CMP–2005–23)     | no        |
//! | nearest     | nearest ellipse          | orthogonal                   | no        |
//! | outline     | union of the ellipses    | orthogonal                   | yes       |
//! | gradient    | union of the ellipses    | first order, the default     | yes       |
//!
//! Starts: every hypothesis is found from nothing, as in the paper.

mod analysis;
mod pictures;
mod report;

use std::error::Error;
use std::path::Path;
use std::process::ExitCode;

use experiments::run::Run;
use maquette::io::model;

use analysis::{ARM, Analysis, Scene, likelihoods};

fn main() -> Result<ExitCode, Box<dyn Error>> {
    let mut run = Run::start("zs06_arm");
    let model = model::load("arm-2d", Path::new(""))?;
    let scene = Scene::new(&model, run.seed());
    run.setting("arm", ARM);
    run.setting("likelihoods", likelihoods());
    let analyses: Vec<Analysis> = likelihoods()
        .into_iter()
        .filter_map(|(name, likelihood)| scene.analyse(name, likelihood))
        .collect();
    report::report(&mut run, &analyses)?;
    run.picture("posterior", &pictures::posterior(&scene, &analyses))?;
    run.picture("hypotheses", &pictures::hypotheses(&scene, &analyses))?;
    Ok(run.finish()?)
}
