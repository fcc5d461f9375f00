//! ZS06 Fig. 6: arms close to the body, where the silhouettes do not show them.
//!
//! "Human arm bends to the opposite side to cover inaccuracy of the model." A metaball man walks before four low
//! cameras, and for half of the time his right forearm lies before his belly and his left arm against his side. On the
//! same silhouettes, with one skeleton: Algorithm 1 with the published likelihood and with the outline of the union;
//! metaballs frame by frame from the outline's keyframe with the outline's shape, alone and with the ellipses; and the
//! joint optimum of all frames on ellipses and on metaballs, from the outline's track.
//!
//! Starts: Algorithm 1 finds the person from nothing, as in the paper. Metaballs frame by frame and the joint optimum begin
//! where the outline's track ended. No truth enters.

mod pictures;
mod report;
mod ways;

use std::error::Error;
use std::path::Path;
use std::process::ExitCode;

use experiments::held::{CAMERAS, FRAMES, Holding};
use experiments::run::Run;
use experiments::walker;
use maquette::io::model;

use ways::{Scene, Way};

fn main() -> Result<ExitCode, Box<dyn Error>> {
    let mut run = Run::start("zs06_arms");
    let frames = FRAMES[usize::from(run.is_quick())];
    let recording = Holding::new(frames).recording(run.seed())?;
    let model = model::load("human-metaballs", Path::new(""))?;
    let scene = Scene {
        model: &model,
        rig: &recording.rig,
        frames: walker::observe(&recording),
        truth: walker::truth(&recording),
        fps: recording.fps,
    };
    let ways: Vec<Way> = scene.ways().ok_or("nothing was found")?;
    run.setting("frames", frames);
    run.setting("cameras", CAMERAS);
    report::report(&mut run, &recording, &scene, &ways)?;
    run.picture("elbow", &pictures::elbow(&scene, &ways))?;
    run.picture("wrist", &pictures::wrist(&scene, &ways))?;
    Ok(run.finish()?)
}
