//! `maquette stereo`.

mod work;

use std::path::{Path, PathBuf};

use clap::{Args, ValueEnum};

use crate::error::{CliError, one_line};
use crate::progress::Progress;
use crate::summary::counted;
use crate::switches::{Overwrite, Quiet};
use crate::{complain, print};
use maquette::camera::CameraId;
use maquette::io::folder::check_out;
use maquette::io::folder::stereo::{MeasuredFrame, StereoFolder};
use maquette::io::recording::footage::Footage;
use maquette::io::recording::{Note, ObservationFiles, Recording, RecordingError};
use maquette::pipeline::{FrameRange, span};
use maquette::silhouette::FrameIndex;
use maquette::stereo::SideBySide;
use maquette::stereo::matching::MatchOptions;
use work::Work;

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

/// Frames through which a set of points is followed, before a new one begins.
const TRACKED_FRAMES: usize = 10;

/// Arguments of `maquette stereo`.
#[derive(Debug, Args)]
pub(super) struct StereoArguments {
    /// Folder of the recording, or its sequence.toml
    recording: PathBuf,
    /// Folder to write into
    #[arg(long, value_name = "DIR")]
    out: PathBuf,
    /// Only the frames of these numbers, both included [default: all]
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

/// How points are measured, and what is written of them.
#[derive(Debug, Clone, Args)]
pub(super) struct Settings {
    /// How points are found
    #[arg(long, value_enum, default_value_t = Method::Matching)]
    method: Method,
    /// Cameras, the template first [default: the one in the middle and those beside it]
    #[arg(long, value_delimiter = ',', value_name = "NAMES")]
    cameras: Vec<String>,
    /// Nearest and farthest depth, metres [default: from a shift of a third of an image to infinity]
    #[arg(long, value_name = "NEAR:FAR", value_parser = depth)]
    depth: Option<(f64, f64)>,
    /// Distance of neighbouring points in the template's image, px (matching)
    #[arg(long, value_name = "PX", default_value_t = MatchOptions::default().spacing_px, value_parser = at_least_one)]
    spacing: usize,
    /// Cameras besides the template that must show a point (matching) [default: all]
    #[arg(long, value_name = "COUNT")]
    least_cameras: Option<usize>,
    /// Follow the points through ten frames at a time (matching)
    #[arg(long)]
    tracks: bool,
    /// Write pictures: disparities in colour, the cloud from the side, the motion of the surface
    #[arg(long)]
    pictures: bool,
}

impl Settings {
    /// The defaults for one way to find points.
    pub(super) fn of(method: Method) -> Self {
        Self {
            method,
            cameras: Vec::new(),
            depth: None,
            spacing: MatchOptions::default().spacing_px,
            least_cameras: None,
            tracks: false,
            pictures: false,
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
    // 1. read and check everything
    check_out(&arguments.out, arguments.overwrite.existing())?;
    let recording = Recording::open(&arguments.recording)?.with_fps(arguments.fps);
    let footage = recording.footage()?;
    let all = footage.frames();
    let frames = arguments.frames.unwrap_or_default().select(&all)?;
    let used = cameras(&footage, &arguments.settings.cameras)?;
    let masks = masks(&recording.with_fps(footage.fps))?;
    let tell = |kind: &str, line: &str| {
        if !arguments.quiet.is_on() {
            complain(kind, &one_line(line));
        }
    };
    footage
        .notes
        .iter()
        .for_each(|note| tell("note", &note.to_string()));
    masks_notes(&footage, &used, masks.as_ref())
        .iter()
        .for_each(|note| tell("note", note));
    // 2. frame by frame
    let (out, progress) = (&arguments.out, arguments.quiet.progress());
    let masks = masks.as_ref();
    let found = measure(
        (&footage, masks),
        frames,
        out,
        &arguments.settings,
        progress,
    )?;
    // 3. what was found
    found.notes.iter().for_each(|note| tell("note", note));
    if !arguments.quiet.is_on() {
        print(&found.summary(out));
    }
    Ok(())
}

/// The recording, if it has masks; its points are what is to be measured.
fn masks(recording: &Recording) -> Result<Option<ObservationFiles>, CliError> {
    match recording.masks() {
        Ok(files) => Ok(Some(files).filter(ObservationFiles::has_masks)),
        Err(RecordingError::NoMasks { .. }) => Ok(None),
        Err(fault) => Err(fault.into()),
    }
}

/// What is odd about the masks; that pictures are not read for them is not.
fn masks_notes(
    footage: &Footage,
    used: &[CameraId],
    masks: Option<&ObservationFiles>,
) -> Vec<String> {
    let Some(masks) = masks else {
        let all = "no masks: everything that the cameras show is measured, not the person alone";
        return vec![all.into()];
    };
    let odd = masks
        .notes
        .iter()
        .filter(|note| !matches!(note, Note::Ignored { .. }));
    let template = used.first().and_then(|id| footage.rig.camera(*id));
    let bare = template.filter(|camera| masks.rig.by_name(&camera.name).is_none());
    let bare = bare.map(|camera| {
        format!(
            "camera {}: no masks: everything that it shows is measured",
            camera.name
        )
    });
    odd.map(ToString::to_string).chain(bare).collect()
}

/// What a run found.
pub(super) struct Measured {
    /// Frame by frame.
    pub(super) frames: Vec<MeasuredFrame>,
    /// Trajectories, where points were followed.
    trajectories: Option<usize>,
    /// What the user should know.
    pub(super) notes: Vec<String>,
}

impl Measured {
    fn summary(&self, out: &Path) -> String {
        let out = out.display();
        let all: usize = self.frames.iter().map(|frame| frame.points).sum();
        let points = all / self.frames.len().max(1);
        let frames = counted(self.frames.len(), "frame");
        let mut text = format!("{out}: {frames}, {points} points each\n");
        if let Some(count) = self.trajectories {
            text.push_str(&format!("{out}/trajectories.csv: {count} trajectories\n"));
        }
        text
    }
}

/// Measures the points of these frames and writes them into a folder; where there are masks, those of the person.
pub(super) fn measure(
    (footage, masks): (&Footage, Option<&ObservationFiles>),
    frames: &[FrameIndex],
    out: &Path,
    settings: &Settings,
    progress: Progress,
) -> Result<Measured, CliError> {
    let mut work = Work {
        settings,
        cameras: cameras(footage, &settings.cameras)?,
        masks,
        out: StereoFolder::open(out, footage.up)?,
        footage,
        following: None,
        trajectories: Vec::new(),
        frames: Vec::new(),
    };
    let bar = progress.bar("stereo", frames.len());
    let mut sets = footage.frame_sets(span(frames));
    for (frame, pictures) in sets.by_ref() {
        work.frame(frame, &pictures)?;
        bar.inc(1);
    }
    bar.finish_and_clear();
    let mut found = work.finish()?;
    found
        .notes
        .extend(sets.notes().iter().map(ToString::to_string));
    Ok(found)
}

/// The template's camera and the others.
fn cameras(footage: &Footage, asked: &[String]) -> Result<Vec<CameraId>, CliError> {
    if asked.is_empty() {
        let chosen =
            SideBySide::choose(&footage.rig).map_err(|e| CliError::Stereo(e.to_string()))?;
        return Ok(std::iter::once(chosen.template)
            .chain(chosen.others)
            .collect());
    }
    let known = footage.rig.names().collect::<Vec<_>>().join(", ");
    let found = asked.iter().map(|name| {
        let found = footage.rig.by_name(name.trim()).map(|(id, _)| id);
        found.ok_or_else(|| {
            CliError::Stereo(format!(
                "--cameras {name}: no such camera: the recording has {known}"
            ))
        })
    });
    let found = found.collect::<Result<Vec<_>, _>>()?;
    let different = found
        .iter()
        .collect::<std::collections::BTreeSet<_>>()
        .len()
        == found.len();
    if found.len() < 2 || !different {
        return Err(CliError::Stereo(format!(
            "--cameras {}: expected two different cameras or more",
            asked.join(",")
        )));
    }
    Ok(found)
}
