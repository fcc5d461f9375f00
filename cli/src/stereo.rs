//! `maquette stereo`.

use std::path::Path;

use clap::Args;
use maquette::pipeline::Progress;
use maquette::pipeline::counted;
use maquette::pipeline::stereo::{StereoMethod, StereoOptions, SurfaceSummary};
use maquette::workflow::SurfaceFiles;
use serde_json::{Value, json};

use super::choice::{Choice, one_of};
use super::error::CliError;
use super::pictures::PictureArguments;
use super::said::Said;

pub(super) const ABOUT: &str = "\
Measure points of the surface from cameras that stand side by side.

Writes OUT/points/<frame>.ply with a covariance for each point, OUT/disparity/<frame>.png (16 bits, 256 steps a pixel, \
0 unknown) and, with --tracks, OUT/trajectories.csv. Where the recording has masks, only the person is measured. \
The points go into a fit by `points = \"points/%06d.ply\"` in sequence.toml.";

pub(super) const EXAMPLES: &str = "\
Examples:
  maquette stereo my-recording --out out/points
  maquette stereo my-recording --out out/points --frames 0:99 --tracks --pictures
  maquette stereo my-recording --out out/points --method correlation --cameras left,right --depth 2:5";

/// Arguments of `maquette stereo`.
#[derive(Debug, Args)]
pub(super) struct StereoArguments {
    #[command(flatten)]
    pictures: PictureArguments,
    #[command(flatten)]
    settings: Settings,
}

/// How points are measured, and what is written.
#[derive(Debug, Clone, Args)]
struct Settings {
    /// How points are found
    #[arg(long, value_parser = one_of(METHODS), default_value = "matching")]
    method: StereoMethod,
    /// Cameras, the template first [default: the one in the middle and those beside it]
    #[arg(long, value_delimiter = ',', value_name = "NAMES")]
    cameras: Vec<String>,
    /// Nearest and farthest depth, metres [default: infinity down to where the shift is a third of the image]
    #[arg(long, value_name = "NEAR:FAR", value_parser = depth)]
    depth: Option<(f64, f64)>,
    /// Spacing of the points in the template's image, px (matching)
    #[arg(long, value_name = "PX", default_value_t = StereoOptions::default().spacing_px, value_parser = at_least_one)]
    spacing: usize,
    /// How many cameras besides the template must show a point (matching) [default: all]
    #[arg(long, value_name = "COUNT")]
    least_cameras: Option<usize>,
    /// Follow the points, ten frames at a time (matching)
    #[arg(long)]
    tracks: bool,
    /// Write pictures: disparities in colour, the cloud from the side, the motion of the surface
    #[arg(long)]
    pictures: bool,
}

impl Settings {
    fn options(&self) -> StereoOptions {
        StereoOptions {
            method: self.method,
            cameras: self.cameras.clone(),
            depth_m: self.depth,
            spacing_px: self.spacing,
            least_cameras: self.least_cameras,
            tracks: self.tracks,
        }
    }
}

/// How points are found.
pub(super) const METHODS: &[Choice<StereoMethod>] = &[
    (
        "correlation",
        StereoMethod::Correlation,
        "Disparity of each pair by correlation: fast, a point for every pixel",
    ),
    (
        "matching",
        StereoMethod::Matching,
        "Least-squares matching in all images at once: more exact",
    ),
];

fn at_least_one(text: &str) -> Result<usize, String> {
    let parsed = text.parse().ok().filter(|count| *count > 0);
    parsed.ok_or_else(|| "expected a whole number, 1 or more".into())
}

fn depth(text: &str) -> Result<(f64, f64), String> {
    let parsed = text.split_once(':').and_then(|(near, far)| {
        let (near, far): (f64, f64) = (near.trim().parse().ok()?, far.trim().parse().ok()?);
        (near > 0.0 && far > near && far.is_finite()).then_some((near, far))
    });
    parsed.ok_or_else(|| "expected NEAR:FAR, two depths in metres, the nearer first".into())
}

/// Measures and writes.
pub(super) fn run(arguments: &StereoArguments) -> Result<(), CliError> {
    let output = arguments.pictures.output;
    arguments.said(&output.progress())?.print(output);
    Ok(())
}

impl StereoArguments {
    /// What there is to say of the points, which are written.
    pub(super) fn said(&self, progress: &dyn Progress) -> Result<Said, CliError> {
        let (pictures, settings) = (&self.pictures, &self.settings);
        let recording = pictures.open()?;
        let files = SurfaceFiles {
            folder: pictures.out(),
            frames: pictures.frames(),
            options: settings.options(),
            pictures: settings.pictures,
        };
        let found = recording.write_surface(&files, progress)?;
        let (text, json) = (summary(&found, pictures.out()), as_json(&found, pictures.out()));
        Ok(Said { text, json, notes: found.notes })
    }
}

fn as_json(found: &SurfaceSummary, out: &Path) -> Value {
    json!({
        "out": out.display().to_string(), "frames": found.frames, "points": found.points,
        "trajectories": found.trajectories, "notes": found.notes,
    })
}

fn summary(found: &SurfaceSummary, out: &Path) -> String {
    let out = out.display();
    let points = found.points / found.frames.max(1);
    let frames = counted(found.frames, "frame");
    let mut text = format!("{out}: {frames}, {points} points each\n");
    if let Some(count) = found.trajectories {
        text.push_str(&format!("{out}/trajectories.csv: {count} trajectories\n"));
    }
    text
}
