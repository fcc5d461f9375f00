//! Starts without clicks: each of 20 frames of `walk7` as the only keyframe, no pose given.
//!
//! The best reading of a frame lands when its limb joints are within 50 mm of the truth on average.

use std::error::Error;
use std::path::Path;
use std::process::ExitCode;

use experiments::metrics::{frame_error_mm, only, trajectories};
use experiments::recorded::read_trajectories;
use experiments::run::{Run, shared_data};
use experiments::table::Table;
use maquette::inference::Evidence;
use maquette::inference::start::{Reading, StartOptions, readings};
use maquette::io::model;
use maquette::io::recording::Recording;
use maquette::likelihood::EllipseOptions;
use maquette::silhouette::SilhouetteOptions;
use rayon::prelude::*;

/// A frame, and the mean error of its limb joints in mm; `None` without a start.
type Landing = (usize, Option<f64>);

const STARTS: usize = 20;
const NEAR_MM: f64 = 50.0;

fn main() -> Result<ExitCode, Box<dyn Error>> {
    let mut run = Run::start("starts_walk7");
    let folder = shared_data().join("walk7");
    if !folder.is_dir() {
        run.say(&format!("skipped: no recording in {}", folder.display()));
        return Ok(ExitCode::SUCCESS);
    }
    let recording =
        Recording::open(&folder).and_then(|found| found.with_fps(50.0).observations())?;
    let truth = read_trajectories(&folder.join("truth.trc"))?;
    let body = model::load("human-ellipsoids", Path::new(""))?;
    let evidence = Evidence::with_ellipses(&body, &recording.rig, EllipseOptions::default());
    // 20 frames, evenly over the recording
    let frames: Vec<usize> = (0..STARTS).map(|i| i * recording.frames.len() / STARTS).collect();
    let starts = frames.par_iter().map(|&position| {
        let frame = recording.load_frame(position, &SilhouetteOptions::default())?;
        let best = readings(&evidence, &frame, &StartOptions::default()).into_iter().next();
        let error = best.and_then(|reading: Reading| {
            let motion = [reading.state.motion];
            let fit = trajectories(&body, &reading.state.shape, &motion, recording.fps);
            frame_error_mm(&only(&truth, frame.frame.0)?, &fit, 0)
        });
        Ok((frame.frame.0, error))
    });
    let starts: Result<Vec<Landing>, Box<dyn Error + Send + Sync>> = starts.collect();
    let mut table = Table::new("starts", &["frame", "joints, mm"]);
    let starts = starts.map_err(|e| e.to_string())?;
    for (frame, error) in &starts {
        table.row([
            frame.to_string(),
            error.map_or_else(|| "no start".to_owned(), |e| format!("{e:.1}")),
        ]);
    }
    run.table("Best reading of each frame", &table)?;
    let near = starts.iter().filter(|(_, e)| e.is_some_and(|e| e <= NEAR_MM)).count();
    run.say(&format!("{near} of {STARTS} within {NEAR_MM} mm"));
    run.number("starts_within_50_mm", near as f64);
    Ok(run.finish()?)
}
