//! `maquette segment`: pictures in, masks out.

use std::path::Path;
use std::time::Instant;

use clap::Args;
use maquette::io::folder::segmented::{MaskExtras, QualityRow};
use maquette::pipeline::Progress;
use maquette::workflow::{MaskFiles, WrittenMasks};
use serde_json::{Value, json};

use super::error::CliError;
use super::pictures::PictureArguments;
use super::said::Said;
use super::switches::Threads;
use super::table::Table;

pub(super) const ABOUT: &str = "\
Cut the person out of the pictures of a recording.

The recording is a folder with a calibration and videos/<camera>.* or images/<camera>/*, or a sequence.toml that says \
where images, videos and pictures of the empty scene (background) are. Detections of joints (pose/) beside them say \
where the person is, and who of several. Into OUT go masks/<camera>/%06d.png and \
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
    let output = arguments.pictures.output;
    arguments.said(&output.progress())?.print(output);
    Ok(())
}

impl SegmentArguments {
    /// What there is to say of the masks, which are written.
    pub(super) fn said(&self, progress: &dyn Progress) -> Result<Said, CliError> {
        self.threads.run(|| segment(self, progress))
    }
}

fn segment(arguments: &SegmentArguments, progress: &dyn Progress) -> Result<Said, CliError> {
    let start = Instant::now();
    let pictures = &arguments.pictures;
    let recording = pictures.open()?;
    let files = MaskFiles {
        folder: pictures.out(),
        frames: pictures.frames(),
        extras: MaskExtras { probability: arguments.probability, overlays: arguments.overlays },
    };
    let written = recording.write_masks(&files, progress)?;

    let (out, seconds) = (pictures.out(), start.elapsed().as_secs_f64());
    let (text, json) = (summary(&written, out, seconds), as_json(&written, out, seconds));
    Ok(Said { text, json, notes: written.notes })
}

/// A camera's masks, and the means of their quality.
struct CameraMasks<'a> {
    camera: &'a str,
    masks: usize,
    empty: usize,
    /// Undecided, unsupported, filled in.
    means: [f64; 3],
}

fn cameras(written: &WrittenMasks) -> impl Iterator<Item = CameraMasks<'_>> {
    written.cameras.iter().map(|name| {
        let rows = written.rows.iter();
        let own: Vec<&QualityRow> = rows.filter(|row| row.camera == *name).collect();
        let mean = |f: fn(&QualityRow) -> f64| {
            own.iter().map(|row| f(row)).sum::<f64>() / own.len().max(1) as f64
        };
        CameraMasks {
            camera: name,
            masks: own.len(),
            empty: own.iter().filter(|row| row.area_px == 0).count(),
            means: [
                mean(|row| row.undecided),
                mean(|row| row.unsupported),
                mean(|row| row.filled_in),
            ],
        }
    })
}

fn as_json(written: &WrittenMasks, out: &Path, seconds: f64) -> Value {
    let camera = |c: CameraMasks<'_>| {
        let [undecided, unsupported, filled_in] = c.means;
        json!({
            "camera": c.camera, "masks": c.masks, "empty": c.empty,
            "undecided": undecided, "unsupported": unsupported, "filled_in": filled_in,
        })
    };
    json!({
        "out": out.display().to_string(), "seconds": seconds, "masks": written.rows.len(),
        "cameras": cameras(written).map(camera).collect::<Vec<_>>(), "notes": written.notes,
    })
}

fn summary(written: &WrittenMasks, out: &Path, seconds: f64) -> String {
    let mut table =
        Table::new(&["camera", "masks", "empty", "undecided", "unsupported", "filled in"]);
    for camera in cameras(written) {
        let counts = [camera.masks, camera.empty].map(|count| count.to_string());
        let means = camera.means.map(|mean| format!("{mean:.3}"));
        let name = std::iter::once(camera.camera.to_owned());
        table.row(name.chain(counts).chain(means).collect());
    }

    let (table, folder) = (table.text(), out.join("masks"));
    let masks = written.rows.len();
    format!("{table}\n{}: {masks} masks in {seconds:.1} s\n", folder.display())
}
