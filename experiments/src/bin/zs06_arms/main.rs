//! ZS06 Fig. 6: arms close to the body, where the silhouettes do not show them.
//!
//! "Human arm bends to the opposite side to cover inaccuracy of the model." A metaball man walks before four low
//! cameras, and for half of the time his right forearm lies before his belly and his left arm against his side. Four
//! ways on the same silhouettes, of one skeleton: ellipses frame by frame (Algorithm 1's winner, as published),
//! metaballs frame by frame from the same keyframe with the same shape, and the joint optimum of all frames on either.

mod arms;
mod pictures;
mod recording;
mod report;
mod ways;

use std::error::Error;
use std::path::Path;
use std::process::ExitCode;

use experiments::run::Run;
use experiments::walker;
use maquette::io::model;

use ways::{Scene, Way};

fn main() -> Result<ExitCode, Box<dyn Error>> {
    let mut run = Run::start("zs06_arms");
    let recording = recording::recording(run.seed())?;
    let model = model::load("human-metaballs", Path::new(""))?;
    let scene = Scene {
        model: &model,
        rig: &recording.rig,
        frames: walker::observe(&recording),
        truth: walker::truth(&recording),
        fps: recording.fps,
    };
    let ways: Vec<Way> = scene.ways().ok_or("nothing was found")?;
    run.setting("frames", recording::FRAMES);
    run.setting("cameras", recording::CAMERAS);
    report::report(&mut run, &recording, &scene, &ways)?;
    run.picture("elbow", &pictures::elbow(&scene, &ways))?;
    run.picture("wrist", &pictures::wrist(&scene, &ways))?;
    Ok(run.finish()?)
}
