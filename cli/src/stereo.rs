//! `maquette stereo`.

use std::path::{Path, PathBuf};

use clap::{Args, ValueEnum};
use maquette::Recording;
use maquette::io::folder::check_out;
use maquette::pipeline::stereo::{StereoMethod, StereoOptions, SurfaceSummary};
use maquette::pipeline::{FrameRange, counted};
use maquette::workflow::SurfaceFiles;

use super::error::CliError;
use super::print;
use super::switches::{Overwrite, Quiet};

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
    /// Folder of the recording, or its sequence.toml
    recording: PathBuf,
    /// Folder to write into
    #[arg(long, value_name = "DIR")]
    out: PathBuf,
    /// Only these frames, first and last included [default: all]
    #[arg(long, value_name = "FIRST:LAST")]
    frames: Option<FrameRange>,
    #[command(flatten)]
    settings: Settings,
    /// Frames per second, where the recording does not say
    #[arg(long, value_name = "HZ")]
    fps: Option<f64>,
    #[command(flatten)]
    overwrite: Overwrite,
    #[command(flatten)]
    quiet: Quiet,
}

/// How points are measured, and what is written.
#[derive(Debug, Clone, Args)]
struct Settings {
    /// How points are found
    #[arg(long, value_enum, default_value_t = Method::Matching)]
    method: Method,
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
            method: self.method.into(),
            cameras: self.cameras.clone(),
            depth_m: self.depth,
            spacing_px: self.spacing,
            least_cameras: self.least_cameras,
            tracks: self.tracks,
        }
    }
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub(super) enum Method {
    /// Disparity of each pair by correlation: fast, a point for every pixel
    Correlation,
    /// Least-squares matching in all images at once: more exact
    Matching,
}

impl From<Method> for StereoMethod {
    fn from(method: Method) -> Self {
        match method {
            Method::Correlation => Self::Correlation,
            Method::Matching => Self::Matching,
        }
    }
}

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
    check_out(&arguments.out, arguments.overwrite.existing())?;
    let recording = Recording::open(&arguments.recording)?.with_fps(arguments.fps);
    let files = SurfaceFiles {
        folder: &arguments.out,
        frames: arguments.frames.unwrap_or_default(),
        options: arguments.settings.options(),
        pictures: arguments.settings.pictures,
    };
    let found = recording.write_surface(&files, &arguments.quiet.progress())?;

    arguments.quiet.print_notes(&found.notes);
    if !arguments.quiet.is_on() {
        print(&summary(&found, &arguments.out));
    }
    Ok(())
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
