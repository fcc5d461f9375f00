//! `maquette silhouettes`.

mod first;
mod work;

use std::path::{Path, PathBuf};
use std::time::Instant;

use clap::{Args, ValueEnum};

use crate::error::CliError;
use crate::switches::{Overwrite, Quiet, Threads};
use crate::table::Table;
use crate::{complain, print};
use first::First;
use maquette::Recording;
use maquette::io::folder::check_out;
use maquette::io::folder::silhouettes::{ContourRow, SilhouetteExtras, SilhouetteFolder};
use maquette::io::model;
use maquette::io::recording::footage::Footage;
use maquette::likelihood::Measure;
use maquette::math::stats::mean;
use maquette::pipeline::FrameRange;
use maquette::pipeline::check_measure;
pub(super) use work::observe;

pub(super) const ABOUT: &str = "\
Find the person's silhouettes before an unknown, cluttered, changing background.

A body is fitted first to the depths that cameras side by side see (or taken from --fit), and predicts where its outline is; \
active contours move from there to the edges near it. Into OUT go masks/<camera>/%06d.png, contours/<camera>/%06d.json and \
.svg, and quality.csv with what was wrong in which frame. `maquette fit --silhouettes joint` does the same and fits to them.";

pub(super) const EXAMPLES: &str = "\
Examples:
  maquette silhouettes my-recording --out out/contours
  maquette silhouettes my-recording --out out/contours --pipeline simple --overlays --stages
  maquette silhouettes my-recording --out out/contours --fit out/me    (begin with a body that was fitted before)";

/// The body that is followed when nobody names one: contours and depths are those of a skin.
pub(super) const DEFAULT_BODY: &str = "human-metaballs";

/// Mean reliability below which contours are not to be trusted: of people it was .54 to .70, of an arm sought in a person .17 to .38.
const UNSURE: f64 = 0.45;

/// Which pipeline of PF02.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub(super) enum Pipeline {
    /// The body by stereo alone, then active contours from its outline
    Simple,
    /// The body fitted to stereo and to each frame's contours, then active contours again
    Joint,
}

/// Arguments of `maquette silhouettes`.
#[derive(Debug, Args)]
pub(super) struct SilhouettesArguments {
    /// Folder with a calibration and videos or images, or a sequence.toml
    recording: PathBuf,
    /// Folder to write into; it must be empty or new
    #[arg(long, value_name = "DIR")]
    out: PathBuf,
    /// How body and contours work together
    #[arg(long, value_enum, default_value_t = Pipeline::Joint)]
    pipeline: Pipeline,
    /// Result of `maquette fit` to begin with [default: one is fitted to the depths of what moves]
    #[arg(long, value_name = "DIR")]
    fit: Option<PathBuf>,
    /// Body model: a shipped one or a .toml file; of metaballs
    #[arg(long, value_name = "NAME|FILE", default_value = DEFAULT_BODY)]
    body: String,
    /// Frames per second; overrides sequence.toml
    #[arg(long, allow_negative_numbers = true)]
    fps: Option<f64>,
    /// Only the frames of these numbers, both included [default: all]
    #[arg(long, value_name = "FIRST:LAST")]
    frames: Option<FrameRange>,
    /// Write the contours over the pictures, as overlays/<camera>/%06d.png
    #[arg(long)]
    overlays: bool,
    /// Write what the edges are filtered with and which pass, as stages/<camera>/
    #[arg(long)]
    stages: bool,
    #[command(flatten)]
    threads: Threads,
    #[command(flatten)]
    overwrite: Overwrite,
    #[command(flatten)]
    quiet: Quiet,
}

/// Finds the silhouettes of a recording and writes them.
pub(super) fn run(arguments: &SilhouettesArguments) -> Result<(), CliError> {
    arguments.threads.run(|| silhouettes(arguments))
}

fn silhouettes(arguments: &SilhouettesArguments) -> Result<(), CliError> {
    let start = Instant::now();
    check_out(&arguments.out, arguments.overwrite.existing())?;
    let footage = Recording::open(&arguments.recording)?
        .with_fps(arguments.fps)
        .footage()?;
    let all = footage.frames();
    let frames = arguments.frames.unwrap_or_default().select(&all)?;
    let model = model::load(&arguments.body, Path::new(""))?;
    check_measure(&model, Some(Measure::Metaballs))?;
    let progress = arguments.quiet.progress();
    let evidence = work::evidence(&model, &footage);
    // 1. where the body is
    let first = match &arguments.fit {
        Some(folder) => First::read(folder, &footage, frames, &model, &progress)?,
        None => First::found(&footage, frames, &model, &progress)?,
    };
    // 2. contours, frame by frame
    let extras = SilhouetteExtras {
        overlays: arguments.overlays,
        stages: arguments.stages,
    };
    let mut folder = SilhouetteFolder::open(&arguments.out, extras)?;
    let work = work::Work {
        footage: &footage,
        frames,
        evidence: &evidence,
        first: &first,
        pipeline: arguments.pipeline,
    };
    let skipped = work.run(&progress, |found| {
        found.write(&mut folder, &footage, &model)
    })?;
    let rows = folder.finish()?;
    // 3. what was found
    if let Some(line) = unsure(&rows, &arguments.body) {
        complain("warning", &line);
    }
    if !arguments.quiet.is_on() {
        skipped.iter().for_each(|note| complain("note", note));
        let seconds = start.elapsed().as_secs_f64();
        print(&summary(&footage, &rows, &arguments.out, seconds));
    }
    Ok(())
}

/// The contours are hardly on edges; nothing where they are.
fn unsure(rows: &[ContourRow], body: &str) -> Option<String> {
    let reliability = mean(rows.iter().map(|row| row.reliability))?;
    (reliability < UNSURE).then(|| {
        format!(
            "the contours are hardly on edges (mean reliability {reliability:.2}): does {body} look like who is seen, and is the calibration right? Look with --overlays"
        )
    })
}

fn summary(footage: &Footage, rows: &[ContourRow], out: &Path, seconds: f64) -> String {
    let mut table = Table::new(&["camera", "frames", "reliability", "moved px", "with faults"]);
    for name in footage.rig.names() {
        let of: Vec<&ContourRow> = rows.iter().filter(|row| row.camera == name).collect();
        let mean =
            |value: fn(&ContourRow) -> f64| mean(of.iter().map(|row| value(row))).unwrap_or(0.0);
        table.row(vec![
            name.to_owned(),
            of.len().to_string(),
            format!("{:.2}", mean(|row| row.reliability)),
            format!("{:.2}", mean(|row| row.moved_px)),
            of.iter()
                .filter(|row| !row.faults.is_empty())
                .count()
                .to_string(),
        ]);
    }
    format!(
        "{}\n{:.1} s, into {}\n",
        table.text(),
        seconds,
        out.display()
    )
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn contours_that_hold_on_no_edges_are_told_and_others_are_not() {
        let row = |reliability| ContourRow {
            frame: 0,
            camera: "left".into(),
            area_px: 1000,
            reliability,
            moved_px: 1.0,
            faults: String::new(),
        };
        let told = unsure(&[row(0.6), row(0.1)], "arm").expect("their mean is 0.35");
        assert!(told.contains("0.35") && told.contains("arm"), "{told}");
        assert!(!told.contains('\n'), "{told}");
        assert_eq!(unsure(&[row(0.6), row(0.5)], "arm"), None);
        assert_eq!(unsure(&[], "arm"), None);
    }
}
