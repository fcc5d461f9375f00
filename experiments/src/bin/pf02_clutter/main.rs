//! PF02 Figs. 3 to 6: silhouettes of a person who walks and waves before clutter, by the simple and by the joint pipeline,
//! ours and as published.
//!
//! Two sequences of 300 frames, photographed by three cameras side by side (`maquette synth --clutter`), each given to
//! `maquette silhouettes` with all three. A frame is in error where, in any camera, the overlap with the true mask is less
//! than 0.9 or the contour is more than 4 px off on average. `--quick`: the first six seconds of the first sequence, every other frame.
//!
//! Starts: from nothing; the paper begins with a body that is already tracked.

mod pictures;
mod sequence;
mod stages;

use std::error::Error;
use std::process::ExitCode;

use experiments::run::Run;
use experiments::table::Table;

use sequence::{PIPELINES, Sequence, Traced};

/// Anything that ends the experiment.
type Fault = Box<dyn Error>;

/// Frames, and frames per second.
const FULL: (usize, f64) = (300, 25.0);
const QUICK: (usize, f64) = (75, 12.5);
/// The frame whose stages are shown.
const STAGED: usize = 20;

fn main() -> Result<ExitCode, Fault> {
    let mut run = Run::start("pf02_clutter");
    let (sequences, length) = if run.is_quick() { (1, QUICK) } else { (2, FULL) };
    run.setting("frames", length.0);
    run.setting("fps", length.1);
    run.setting("sequences", sequences);
    let mut all: Vec<(Sequence, Vec<Traced>)> = Vec::new();
    for number in 0..sequences {
        let folder = run.folder().join(format!("sequence_{}", number + 1));
        let seed = run.seed() + number;
        let sequence = Sequence::photographed(seed, length, &folder)?;
        if all.is_empty() {
            run.photograph("stages", &stages::stages(&sequence, STAGED)?)?;
        }
        let mut traced = Vec::new();
        for pipeline in PIPELINES {
            traced.push(sequence.traced(pipeline)?);
        }
        all.push((sequence, traced));
    }
    report(&mut run, &all)?;
    pictures::draw(&run, &all)?;
    Ok(run.finish()?)
}

fn report(run: &mut Run, all: &[(Sequence, Vec<Traced>)]) -> Result<(), Fault> {
    let mut table = Table::new(
        "pipelines",
        &[
            "pipeline",
            "sequence",
            "frames",
            "in error",
            "in error, centre camera alone",
            "contour off, mean, px",
            "overlap, median",
            "overlap, least",
            "s a frame",
        ],
    );
    for (place, (pipeline, _)) in PIPELINES.iter().enumerate() {
        let (mut errors, mut centre_errors) = (0, 0);
        for (number, (_, traced)) in all.iter().enumerate() {
            let traced = &traced[place];
            let [any, centre] = [traced.errors().len(), traced.errors_of_centre()];
            errors += any;
            centre_errors += centre;
            let (distance_px, median, least) = traced.summary();
            table.row([
                (*pipeline).to_owned(),
                (number + 1).to_string(),
                traced.scores.len().to_string(),
                any.to_string(),
                centre.to_string(),
                format!("{distance_px:.2}"),
                format!("{median:.3}"),
                format!("{least:.3}"),
                format!("{:.2}", traced.seconds_a_frame),
            ]);
            run.number(format!("{pipeline}_distance_px_{}", number + 1), distance_px);
            run.number(format!("{pipeline}_overlap_{}", number + 1), median);
        }
        run.number(format!("{pipeline}_errors"), errors as f64);
        run.number(format!("{pipeline}_errors_centre"), centre_errors as f64);
    }
    run.table("Silhouettes before clutter", &table)?;
    for (number, (_, traced)) in all.iter().enumerate() {
        for traced in traced {
            let frames = traced.errors();
            run.say(&format!(
                "{}, sequence {}: frames in error {frames:?}",
                traced.pipeline,
                number + 1
            ));
        }
    }
    Ok(())
}
