//! `maquette segment`: pictures in, masks out.

use std::path::{Path, PathBuf};
use std::time::Instant;

use clap::Args;
use maquette::Recording;
use maquette::io::folder::check_out;
use maquette::io::folder::segmented::{MaskExtras, QualityRow};
use maquette::pipeline::FrameRange;
use maquette::workflow::{MaskFiles, WrittenMasks};

use super::error::CliError;
use super::print;
use super::switches::{Overwrite, Quiet, Threads};
use super::table::Table;

pub(super) const ABOUT: &str = "\
Cut the person out of the pictures of a recording.

The recording is a folder with a calibration and videos/<camera>.* or images/<camera>/*, or a sequence.toml that says \
where images, videos and pictures of the empty scene (background) are. Into OUT go masks/<camera>/%06d.png and \
quality.csv; `maquette fit` does the same by itself where a recording has no masks.";

pub(super) const EXAMPLES: &str = "\
Examples:
  maquette segment my-recording --out out/cut
  maquette segment my-recording --out out/look --frames 0:1 --probability --overlays";

/// Arguments of `maquette segment`.
#[derive(Debug, Args)]
pub(super) struct SegmentArguments {
    /// Folder with calibration and pictures, or a sequence.toml
    recording: PathBuf,
    /// Folder for the masks; it must be empty or new
    #[arg(long)]
    out: PathBuf,
    /// Frames per second; overrides sequence.toml
    #[arg(long, allow_negative_numbers = true)]
    fps: Option<f64>,
    /// Only these frames, first and last included [default: all]
    #[arg(long, value_name = "FIRST:LAST")]
    frames: Option<FrameRange>,
    /// Also write each pixel's probability of showing the person, as probability/<camera>/%06d.png
    #[arg(long)]
    probability: bool,
    /// Draw the masks over the pictures, as mask-overlays/<camera>/%06d.jpg
    #[arg(long)]
    overlays: bool,
    #[command(flatten)]
    threads: Threads,
    #[command(flatten)]
    overwrite: Overwrite,
    #[command(flatten)]
    quiet: Quiet,
}

/// Segments a recording and writes the masks.
pub(super) fn run(arguments: &SegmentArguments) -> Result<(), CliError> {
    arguments.threads.run(|| segment(arguments))
}

fn segment(arguments: &SegmentArguments) -> Result<(), CliError> {
    let start = Instant::now();
    check_out(&arguments.out, arguments.overwrite.existing())?;
    let recording = Recording::open(&arguments.recording)?.with_fps(arguments.fps);
    let files = MaskFiles {
        folder: &arguments.out,
        frames: arguments.frames.unwrap_or_default(),
        extras: MaskExtras { probability: arguments.probability, overlays: arguments.overlays },
    };
    let written = recording.write_masks(&files, &arguments.quiet.progress())?;

    arguments.quiet.print_notes(&written.notes);
    if !arguments.quiet.is_on() {
        let seconds = start.elapsed().as_secs_f64();
        print(&summary(&written, &arguments.out, seconds));
    }
    Ok(())
}

fn summary(written: &WrittenMasks, out: &Path, seconds: f64) -> String {
    let mut table =
        Table::new(&["camera", "masks", "empty", "undecided", "unsupported", "filled in"]);
    for name in &written.cameras {
        let rows = written.rows.iter();
        let own: Vec<&QualityRow> = rows.filter(|row| row.camera == *name).collect();
        let empty = own.iter().filter(|row| row.area_px == 0).count();
        let mean = |f: fn(&QualityRow) -> f64| {
            let sum: f64 = own.iter().map(|row| f(row)).sum();
            format!("{:.3}", sum / own.len().max(1) as f64)
        };

        table.row(vec![
            name.clone(),
            own.len().to_string(),
            empty.to_string(),
            mean(|row| row.undecided),
            mean(|row| row.unsupported),
            mean(|row| row.filled_in),
        ]);
    }

    let (table, folder) = (table.text(), out.join("masks"));
    let masks = written.rows.len();
    format!("{table}\n{}: {masks} masks in {seconds:.1} s\n", folder.display())
}
