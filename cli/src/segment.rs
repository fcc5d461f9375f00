//! `maquette segment`: pictures in, masks out.

use std::ops::RangeInclusive;
use std::path::{Path, PathBuf};
use std::time::Instant;

use clap::Args;

use super::error::{CliError, one_line};
use super::switches::{Overwrite, Quiet, Threads};
use super::table::Table;
use super::{complain, print};
use maquette::Recording;
use maquette::io::folder::segmented::{self, Extras, QualityRow};
use maquette::io::folder::{OutFolder, check_out};
use maquette::io::recording::footage::{Footage, FootageNote};
use maquette::pipeline::segment::SegmentOptions;
use maquette::pipeline::{FrameRange, Progress, span};

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
    /// Write only the frames of these numbers, both included
    #[arg(long, value_name = "FIRST:LAST")]
    frames: Option<FrameRange>,
    /// Write how probable it is that each pixel shows the person, as probability/<camera>/%06d.png
    #[arg(long)]
    probability: bool,
    /// Write the masks over the pictures, as mask-overlays/<camera>/%06d.jpg
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
    let footage = Recording::open(&arguments.recording)?
        .with_fps(arguments.fps)
        .footage()?;
    let frames = footage.frames();
    let range = span(arguments.frames.unwrap_or_default().select(&frames)?);
    let progress = arguments.quiet.progress();
    OutFolder::open(&arguments.out)?;
    let extras = Extras {
        probability: arguments.probability,
        overlays: arguments.overlays,
    };
    let (rows, notes) = masks(&footage, range, &arguments.out, extras, &progress)?;
    if !arguments.quiet.is_on() {
        for note in &notes {
            complain("note", &one_line(note));
        }
        let seconds = start.elapsed().as_secs_f64();
        print(&summary(&footage, &rows, &arguments.out, seconds));
    }
    Ok(())
}

/// Learns, segments and writes; what the user should know comes back with the figures.
pub(super) fn masks(
    footage: &Footage,
    frames: RangeInclusive<usize>,
    folder: &Path,
    extras: Extras,
    progress: &dyn Progress,
) -> Result<(Vec<QualityRow>, Vec<String>), CliError> {
    let all = footage.frames();
    progress.begin("background", all.len());
    let (segmenter, found) =
        segmented::learn(footage, SegmentOptions::default(), &|| progress.step());
    progress.end();
    let count = all.iter().filter(|frame| frames.contains(&frame.0)).count();
    progress.begin("masks", count);
    let (rows, odd) = segmented::write(folder, footage, &segmenter, frames, extras, &|| {
        progress.step()
    })?;
    progress.end();
    let mut notes: Vec<String> = footage
        .notes
        .iter()
        .chain(&found)
        .chain(&odd)
        .map(FootageNote::to_string)
        .collect();
    for (id, share) in segmented::never_left(footage, &segmenter) {
        notes.push(format!(
            "camera {}: in {:.0} % of the pixels where the person is the empty scene is never seen for sure: a picture of it (background = …) would help",
            footage.rig.cameras[id.0].name,
            100.0 * share
        ));
    }
    if !segmenter.is_consistent() && footage.rig.cameras.len() > 1 {
        notes.push("the cameras do not agree on where the person is: each is segmented by itself; check the calibration".into());
    }
    Ok((rows, notes))
}

fn summary(footage: &Footage, rows: &[QualityRow], out: &Path, seconds: f64) -> String {
    let mut table = Table::new(&[
        "camera",
        "masks",
        "empty",
        "undecided",
        "unsupported",
        "filled in",
    ]);
    for name in footage.rig.names() {
        let own: Vec<&QualityRow> = rows.iter().filter(|row| row.camera == name).collect();
        let mean = |f: fn(&QualityRow) -> f64| {
            let sum: f64 = own.iter().map(|row| f(row)).sum();
            format!("{:.3}", sum / own.len().max(1) as f64)
        };
        let empty = own.iter().filter(|row| row.area_px == 0).count();
        table.row(vec![
            name.into(),
            own.len().to_string(),
            empty.to_string(),
            mean(|row| row.undecided),
            mean(|row| row.unsupported),
            mean(|row| row.filled_in),
        ]);
    }
    let (table, folder) = (table.text(), out.join("masks"));
    let masks = rows.len();
    format!(
        "{table}\n{}: {masks} masks in {seconds:.1} s\n",
        folder.display()
    )
}
