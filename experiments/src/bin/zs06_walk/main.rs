//! ZS06's real sequence, made anew with its truth: seven cameras, 200 frames of walking, every 20th a keyframe.
//!
//! The paper shows pictures and says that all lengths came out right and that an arm was lost about frame
//! 120 and found again; here the same is measured: lengths, knee and hip angles, joint centres, joints lost
//! and found again, with the published and the outline likelihood and with what lies between them.
//!
//! Starts: Algorithm 1 finds body, pose and heading from nothing, as in the paper.

mod fit;
mod pictures;
mod report;

use std::error::Error;
use std::path::Path;
use std::process::ExitCode;

use experiments::run::Run;
use experiments::walker;
use maquette::io::model;

use fit::{Fit, Scene, variants};

const FRAMES: usize = 200;

fn main() -> Result<ExitCode, Box<dyn Error>> {
    let mut run = Run::start("zs06_walk");
    let recording = walker::recording(FRAMES, run.seed())?;
    let model = model::load("human-ellipsoids", Path::new(""))?;
    let scene = Scene {
        model: &model,
        rig: &recording.rig,
        frames: walker::observe(&recording),
        truth: walker::truth(&recording),
        fps: recording.fps,
    };
    let fits: Vec<Fit> = variants().into_iter().filter_map(|variant| scene.fit(variant)).collect();
    run.setting("search", fit::options());
    run.setting("likelihoods", variants().map(|v| (v.name, v.likelihood)));
    report::report(&mut run, &scene, &fits)?;
    run.picture("angles", &pictures::angles(&scene, &fits))?;
    run.picture("errors", &pictures::errors(&scene, &fits))?;
    Ok(run.finish()?)
}
