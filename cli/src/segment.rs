//! `maquette segment`: pictures in, masks out.

use std::path::Path;
use std::time::Instant;

use clap::Args;
use maquette::io::folder::segmented::{MaskExtras, QualityRow};
use maquette::workflow::{MaskFiles, WrittenMasks};

use super::error::CliError;
use super::pictures::PictureArguments;
use super::print;
use super::switches::{Threads, print_notes};
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
    #[command(flatten)]
    pictures: PictureArguments,
    /// Also write each pixel's probability of showing the person, as probability/<camera>/%06d.png
    #[arg(long)]
    probability: bool,
    /// Draw the masks over the pictures, as mask-overlays/<camera>/%06d.jpg
    #[arg(long)]
    overlays: bool,
    #[command(flatten)]
    threads: Threads,
}

/// Segments a recording and writes the masks.
pub(super) fn run(arguments: &SegmentArguments) -> Result<(), CliError> {
    arguments.threads.run(|| segment(arguments))
}

fn segment(arguments: &SegmentArguments) -> Result<(), CliError> {
    let start = Instant::now();
    let (pictures, quiet) = (&arguments.pictures, arguments.pictures.quiet);
    let recording = pictures.open()?;
    let files = MaskFiles {
        folder: pictures.out(),
        frames: pictures.frames(),
        extras: MaskExtras { probability: arguments.probability, overlays: arguments.overlays },
    };
    let written = recording.write_masks(&files, &quiet.progress())?;

    print_notes(&written.notes);
    if !quiet.is_on() {
        let seconds = start.elapsed().as_secs_f64();
        print(&summary(&written, pictures.out(), seconds));
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
