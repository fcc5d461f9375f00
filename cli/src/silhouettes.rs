//! `maquette silhouettes`.

use std::path::{Path, PathBuf};
use std::time::Instant;

use clap::Args;
use maquette::io::folder::silhouettes::{ContourRow, SilhouetteExtras};
use maquette::math::stats::mean;
use maquette::pipeline::Progress;
use maquette::pipeline::silhouettes::SilhouettePipeline;
use maquette::workflow::{DEFAULT_BODY, SilhouetteFiles, WrittenSilhouettes};
use serde_json::{Value, json};

use super::choice::{Choice, one_of};
use super::complain;
use super::error::CliError;
use super::pictures::PictureArguments;
use super::said::Said;
use super::switches::Threads;
use super::table::Table;

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

/// The pipelines of PF02.
const PIPELINES: &[Choice<SilhouettePipeline>] = &[
    (
        "simple",
        SilhouettePipeline::Simple,
        "One pass: a body from stereo alone, then active contours from its outline",
    ),
    (
        "joint",
        SilhouettePipeline::Joint,
        "By turns: active contours of all frames, and the body fitted to stereo and contours",
    ),
    (
        "frame-after-frame",
        SilhouettePipeline::FrameAfterFrame,
        "As published: contours and body of each frame from those of the frame before",
    ),
];

/// Arguments of `maquette silhouettes`.
#[derive(Debug, Args)]
pub(super) struct SilhouettesArguments {
    #[command(flatten)]
    pictures: PictureArguments,
    /// How body and contours work together
    #[arg(long, value_parser = one_of(PIPELINES), default_value = "joint")]
    pipeline: SilhouettePipeline,
    /// Begin with a result of `maquette fit` [default: fit a body to the depths of what moves]
    #[arg(long, value_name = "DIR")]
    fit: Option<PathBuf>,
    /// Body model: a shipped one or a .toml file; of metaballs
    #[arg(long, value_name = "NAME|FILE", default_value = DEFAULT_BODY)]
    body: String,
    /// Write the contours over the pictures, as overlays/<camera>/%06d.png
    #[arg(long)]
    overlays: bool,
    /// Write the filtered edges, as stages/<camera>/
    #[arg(long)]
    stages: bool,
    #[command(flatten)]
    threads: Threads,
}

/// Finds the silhouettes of a recording and writes them.
pub(super) fn run(arguments: &SilhouettesArguments) -> Result<(), CliError> {
    let output = arguments.pictures.output;
    let found = arguments.found(&output.progress())?;
    if let Some(line) = found.warning.as_ref().filter(|_| found.failure.is_none()) {
        complain("warning", line);
    }
    found.said.print(output);
    found.failure.map_or(Ok(()), |why| Err(maquette::Error::Unusable(why).into()))
}

/// Silhouettes that were written.
pub(super) struct FoundSilhouettes {
    pub(super) said: Said,
    warning: Option<String>,
    /// Why they are nobody's.
    failure: Option<String>,
}

impl SilhouettesArguments {
    /// The silhouettes, which are written.
    pub(super) fn found(&self, progress: &dyn Progress) -> Result<FoundSilhouettes, CliError> {
        self.threads.run(|| silhouettes(self, progress))
    }
}

fn silhouettes(
    arguments: &SilhouettesArguments,
    progress: &dyn Progress,
) -> Result<FoundSilhouettes, CliError> {
    let start = Instant::now();
    let pictures = &arguments.pictures;
    let recording = pictures.open()?;
    let files = SilhouetteFiles {
        folder: pictures.out(),
        body: &arguments.body,
        frames: pictures.frames(),
        pipeline: arguments.pipeline,
        start: arguments.fit.as_deref(),
        extras: SilhouetteExtras { overlays: arguments.overlays, stages: arguments.stages },
    };
    let written = recording.write_silhouettes(&files, progress)?;

    let (out, seconds) = (pictures.out(), start.elapsed().as_secs_f64());
    let (text, json) = (summary(&written, out, seconds), as_json(&written, out, seconds));
    let said = Said { text, json, notes: written.notes };
    Ok(FoundSilhouettes { said, warning: written.warning, failure: written.failure })
}

fn as_json(written: &WrittenSilhouettes, out: &Path, seconds: f64) -> Value {
    let camera = |name: &String| {
        let own = || written.rows.iter().filter(|row| row.camera == *name);
        json!({
            "camera": name, "frames": own().count(),
            "reliability": mean(own().map(|row| row.reliability)),
            "moved_px": mean(own().map(|row| row.moved_px)),
            "with_faults": own().filter(|row| !row.faults.is_empty()).count(),
        })
    };
    json!({
        "out": out.display().to_string(), "seconds": seconds, "warning": written.warning,
        "failure": written.failure,
        "cameras": written.cameras.iter().map(camera).collect::<Vec<_>>(), "notes": written.notes,
    })
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
