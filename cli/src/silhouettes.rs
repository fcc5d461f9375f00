//! `maquette silhouettes`.

use std::path::{Path, PathBuf};
use std::time::Instant;

use clap::{Args, ValueEnum};
use maquette::Recording;
use maquette::io::folder::check_out;
use maquette::io::folder::silhouettes::{ContourRow, SilhouetteExtras};
use maquette::math::stats::mean;
use maquette::pipeline::FrameRange;
use maquette::pipeline::silhouettes::SilhouettePipeline;
use maquette::workflow::{SilhouetteFiles, WrittenSilhouettes};

use super::error::CliError;
use super::switches::{Overwrite, Quiet, Threads};
use super::table::Table;
use super::{complain, print};

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

/// Which pipeline of PF02.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub(super) enum Pipeline {
    /// One pass: a body from stereo alone, then active contours from its outline
    Simple,
    /// By turns: active contours of all frames, and the body fitted to stereo and contours
    Joint,
}

impl From<Pipeline> for SilhouettePipeline {
    fn from(pipeline: Pipeline) -> Self {
        match pipeline {
            Pipeline::Simple => Self::Simple,
            Pipeline::Joint => Self::Joint,
        }
    }
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
    /// Begin with a result of `maquette fit` [default: fit a body to the depths of what moves]
    #[arg(long, value_name = "DIR")]
    fit: Option<PathBuf>,
    /// Body model: a shipped one or a .toml file; of metaballs
    #[arg(long, value_name = "NAME|FILE", default_value = SilhouetteFiles::DEFAULT_BODY)]
    body: String,
    /// Frames per second; overrides sequence.toml
    #[arg(long, allow_negative_numbers = true)]
    fps: Option<f64>,
    /// Only these frames, first and last included [default: all]
    #[arg(long, value_name = "FIRST:LAST")]
    frames: Option<FrameRange>,
    /// Write the contours over the pictures, as overlays/<camera>/%06d.png
    #[arg(long)]
    overlays: bool,
    /// Write the filtered edges, as stages/<camera>/
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
    let recording = Recording::open(&arguments.recording)?.with_fps(arguments.fps);
    let files = SilhouetteFiles {
        folder: &arguments.out,
        body: &arguments.body,
        frames: arguments.frames.unwrap_or_default(),
        pipeline: arguments.pipeline.into(),
        start: arguments.fit.as_deref(),
        extras: SilhouetteExtras { overlays: arguments.overlays, stages: arguments.stages },
    };
    let written = recording.write_silhouettes(&files, &arguments.quiet.progress())?;

    if let Some(line) = &written.warning {
        complain("warning", line);
    }
    arguments.quiet.print_notes(&written.notes);
    if !arguments.quiet.is_on() {
        let seconds = start.elapsed().as_secs_f64();
        print(&summary(&written, &arguments.out, seconds));
    }
    Ok(())
}

fn summary(written: &WrittenSilhouettes, out: &Path, seconds: f64) -> String {
    let mut table = Table::new(&["camera", "frames", "reliability", "moved px", "with faults"]);
    for name in &written.cameras {
        let own = || written.rows.iter().filter(|row| row.camera == *name);
        let mean = |value: fn(&ContourRow) -> f64| mean(own().map(value)).unwrap_or(0.0);

        table.row(vec![
            name.clone(),
            own().count().to_string(),
            format!("{:.2}", mean(|row| row.reliability)),
            format!("{:.2}", mean(|row| row.moved_px)),
            own().filter(|row| !row.faults.is_empty()).count().to_string(),
        ]);
    }

    format!("{}\n{:.1} s, into {}\n", table.text(), seconds, out.display())
}
