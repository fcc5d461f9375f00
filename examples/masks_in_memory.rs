//! Fits masks that no file holds, here those of a synthetic walker, frame by frame from the silhouettes on.
//!
//! `cargo run --release --example masks_in_memory`

#![allow(clippy::print_stdout, clippy::print_stderr, reason = "an example prints what it found")]

use std::error::Error;
use std::path::Path;
use std::process::ExitCode;

use maquette::inference::Sequence;
use maquette::inference::search::NoJournal;
use maquette::io::model;
use maquette::pipeline::{EstimateOptions, fit};
use maquette::silhouette::{FrameIndex, FrameObservations, SilhouetteOptions, extract};
use maquette::synth::Recipe;

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
    // cameras and masks; yours come from elsewhere
    let person = model::load("walker-metaballs", Path::new(""))?;
    let recipe = Recipe { frames: Some(10), fps: 25.0, ..Recipe::default() };
    let walker = recipe.walker(&person)?;

    // what each frame shows: a silhouette for each camera whose mask shows one
    let mut frames = Vec::new();
    for number in 0..walker.frames() {
        let mut seen = FrameObservations::nothing(FrameIndex(number));
        for (id, camera) in walker.rig.iter() {
            let mask = walker.mask(seen.frame, id).ok_or("a camera without a mask")?;
            match extract(&mask, camera, &SilhouetteOptions::default()) {
                Ok(silhouette) => seen.views.push((id, silhouette)),
                Err(reason) => seen.rejected.push((id, reason)),
            }
        }
        frames.push(seen);
    }

    // the fit
    let body = model::load("human-ellipsoids", Path::new(""))?;
    let sequence = Sequence { frames: &frames, fps: walker.fps };
    let options = EstimateOptions::default();
    let found = fit(&body, &walker.rig, sequence, &options, &NoJournal)?;
    for ((name, _, _), metres) in body.lengths.iter().zip(&found.lengths_m) {
        println!("{name:<16} {:.1} cm", 100.0 * metres);
    }
    Ok(())
}
