//! `maquette fit`: read, fit, write.

use std::fs;
use std::path::{Path, PathBuf};
use std::str::FromStr;
use std::time::Instant;

use clap::{Args, ValueEnum};
use rayon::prelude::*;
use serde_json::{Value, json};

use super::error::{CliError, one_line};
use super::progress::{Progress, Watched};
use super::summary::Summary;
use super::{complain, print};
use crate::body::BodyModel;
use crate::inference::propagate::Sequence;
use crate::inference::search::Pruning;
use crate::io::journal::DiskJournal;
use crate::io::out_folder::{Existing, OutError, OutFolder, check_out};
use crate::io::recording::{InputChecksum, Recording};
use crate::io::result::{Provenance, ResultFile, trajectories};
use crate::io::trc::write_trc;
use crate::io::{model, overlays};
use crate::likelihood::EllipseOptions;
use crate::pipeline::{self, Fit, FitError, FitOptions, check_scene};
use crate::silhouette::FrameObservations;

/// The body that is fitted when nobody names one.
const DEFAULT_BODY: &str = "human-ellipsoids";

pub(super) const ABOUT: &str = "\
Fit a body to a recording: shape, motion and confidence.

The recording is a folder with a calibration and masks/<camera>/*.png (white where the person is, the frame number \
in the name), or a sequence.toml that says where things are. Into OUT go result.json (everything), joints.trc (joint \
centres, for OpenSim and others) and, on request, overlays/. A run that was stopped can be continued with --resume.";

pub(super) const EXAMPLES: &str = "\
Examples:
  maquette fit my-recording --fps 50 --out out/me
  maquette fit my-recording/sequence.toml --out out/me --overlays
  maquette fit my-recording --fps 50 --out out/me --resume        (go on after an interruption)
  maquette fit my-recording --fps 50 --out out/short --frames 100:300 --keyframe-every 10
  maquette fit my-recording --fps 50 --out out/me --json --quiet  (for other programs)";

/// Arguments of `maquette fit`.
#[derive(Debug, Args)]
pub(super) struct FitArguments {
    /// Folder with calibration and masks, or a sequence.toml
    recording: PathBuf,
    /// Folder for the result; it must be empty or new
    #[arg(long)]
    out: PathBuf,
    /// Frames per second; overrides sequence.toml
    #[arg(long, allow_negative_numbers = true)]
    fps: Option<f64>,
    /// Body model: a shipped one (see `maquette models`) or a .toml file [default: that of sequence.toml, or human-ellipsoids]
    #[arg(long, value_name = "NAME|FILE")]
    body: Option<String>,
    /// Fit only the frames of these numbers, both included
    #[arg(long, value_name = "FIRST:LAST")]
    frames: Option<FrameRange>,
    /// Every how many frames a keyframe proposes a body
    #[arg(long, value_name = "FRAMES", default_value_t = 20)]
    keyframe_every: usize,
    /// How outlines are compared
    #[arg(long, value_enum, default_value_t = Likelihood::Outline)]
    likelihood: Likelihood,
    /// Follow every proposed body to the end, also when it can no longer win
    #[arg(long)]
    no_pruning: bool,
    /// Threads; the result does not depend on it [default: all cores]
    #[arg(long, value_name = "N", default_value_t = 0, hide_default_value = true)]
    threads: usize,
    /// Write pictures of the fit over the masks into OUT/overlays
    #[arg(long)]
    overlays: bool,
    /// Continue a run that was stopped
    #[arg(long, conflicts_with = "overwrite")]
    resume: bool,
    /// Replace the result in OUT when the new one is complete
    #[arg(long)]
    overwrite: bool,
    /// Print nothing but errors
    #[arg(long)]
    quiet: bool,
    /// Print the summary as JSON
    #[arg(long)]
    json: bool,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
enum Likelihood {
    /// Signed distance to the outline of the whole body, and back
    Outline,
    /// Distance to the nearest ellipse, as Zimmermann and Svoboda published it
    Published,
}

/// Frame numbers, both included.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
struct FrameRange {
    first: usize,
    last: usize,
}

impl FromStr for FrameRange {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let parsed = text.split_once(':').and_then(|(first, last)| {
            let (first, last) = (first.trim().parse().ok()?, last.trim().parse().ok()?);
            (first <= last).then_some(Self { first, last })
        });
        parsed.ok_or_else(|| "expected FIRST:LAST, two frame numbers in order".into())
    }
}

impl FitArguments {
    fn options(&self) -> Result<FitOptions, CliError> {
        let mut options = FitOptions::default();
        options.search.keyframe_every = self.keyframe_every;
        if self.no_pruning {
            options.search.pruning = Pruning::Off;
        }
        if self.likelihood == Likelihood::Published {
            options.likelihood = EllipseOptions::published();
        }
        options.validate().map_err(FitError::from)?;
        Ok(options)
    }

    fn existing(&self) -> Existing {
        match (self.resume, self.overwrite) {
            (true, _) => Existing::Resume,
            (false, true) => Existing::Overwrite,
            (false, false) => Existing::Refuse,
        }
    }

    fn progress(&self) -> Progress {
        if self.quiet {
            Progress::Hidden
        } else {
            Progress::Shown
        }
    }
}

/// Fits a recording and writes the result.
pub(super) fn run(arguments: &FitArguments) -> Result<(), CliError> {
    let threads = arguments.threads;
    let pool = rayon::ThreadPoolBuilder::new()
        .num_threads(threads)
        .build()
        .map_err(|source| CliError::Threads { threads, source })?;
    pool.install(|| fit(arguments))
}

/// Everything that is read before anything is fitted.
struct Input {
    options: FitOptions,
    recording: Recording,
    model: BodyModel,
    observations: Vec<FrameObservations>,
    checksums: Vec<InputChecksum>,
}

fn fit(arguments: &FitArguments) -> Result<(), CliError> {
    let start = Instant::now();
    // 1. read and check everything; nothing is written until it is known to be usable
    let input = read(arguments)?;
    // 2. fit, keeping what is finished
    let out = OutFolder::open(&arguments.out)?;
    let journal = journal(&out, arguments.existing(), &input)?;
    let fitted = search(&input, &journal, arguments.progress()).inspect_err(|_| out.abandon())?;
    // 3. write the result, and only then replace an older one
    let result = write(&out, &input, &fitted, arguments)?;
    if let Some(fault) = journal.fault() {
        complain(
            "note",
            &one_line(&format!("the result is complete; {fault}")),
        );
    }
    // 4. say what was found
    let summary = Summary {
        result: &result,
        out: &arguments.out,
        seconds: start.elapsed().as_secs_f64(),
    };
    match (arguments.json, arguments.quiet) {
        (true, _) => print(&summary.json()),
        (false, false) => print(&summary.text()),
        (false, true) => {}
    }
    Ok(())
}

fn read(arguments: &FitArguments) -> Result<Input, CliError> {
    let options = arguments.options()?;
    check_out(&arguments.out, arguments.existing())?;
    let recording = Recording::open(&arguments.recording, arguments.fps)?;
    let (model, body) = body(arguments.body.as_deref(), &recording)?;
    let positions = positions(&recording, arguments.frames)?;
    let observations = observe(&recording, &positions, &options, arguments.progress())?;
    check_scene(&model, &recording.rig, &observations).map_err(FitError::from)?;
    let mut checksums = recording.checksums()?;
    checksums.push(body);
    Ok(Input {
        options,
        recording,
        model,
        observations,
        checksums,
    })
}

/// The body that was asked for, or that the recording names, and its fingerprint.
fn body(
    asked: Option<&str>,
    recording: &Recording,
) -> Result<(BodyModel, InputChecksum), CliError> {
    let (name, folder) = match (asked, recording.body.as_deref()) {
        (Some(name), _) => (name, Path::new("")),
        (None, Some(name)) => (name, recording.folder.as_path()),
        (None, None) => (DEFAULT_BODY, Path::new("")),
    };
    let (text, path) = model::text_of(name, folder)?;
    let model = model::parse(&text, &path)?;
    let checksum = InputChecksum::of_text(format!("body {}", model.name), &text);
    Ok((model, checksum))
}

/// Positions of the frames to be fitted.
fn positions(recording: &Recording, range: Option<FrameRange>) -> Result<Vec<usize>, CliError> {
    let frames = &recording.frames;
    let Some(range) = range else {
        return Ok((0..frames.len()).collect());
    };
    let is_in = |i: &usize| (range.first..=range.last).contains(&frames[*i].0);
    let positions: Vec<usize> = (0..frames.len()).filter(is_in).collect();
    if positions.is_empty() {
        return Err(CliError::NoFrames {
            range: format!("{}:{}", range.first, range.last),
            first: frames.first().map_or(0, |f| f.0),
            last: frames.last().map_or(0, |f| f.0),
        });
    }
    Ok(positions)
}

/// The silhouettes of the frames; masks are dropped as soon as they are traced.
fn observe(
    recording: &Recording,
    positions: &[usize],
    options: &FitOptions,
    progress: Progress,
) -> Result<Vec<FrameObservations>, CliError> {
    let bar = progress.bar("reading masks", positions.len());
    let load = |position: &usize| {
        let observed = recording.load_frame(*position, &options.silhouettes);
        bar.inc(1);
        observed
    };
    let loaded: Vec<Result<_, _>> = positions.par_iter().map(load).collect();
    bar.finish_and_clear();
    // the first fault in the order of the frames, whichever thread met one first
    Ok(loaded.into_iter().collect::<Result<_, _>>()?)
}

fn journal(out: &OutFolder, existing: Existing, input: &Input) -> Result<DiskJournal, CliError> {
    let (folder, identity) = (out.journal(), identity(input));
    match existing {
        Existing::Resume => Ok(DiskJournal::resume(&folder, &identity)?),
        Existing::Refuse | Existing::Overwrite => {
            let created = DiskJournal::create(&folder, &identity);
            Ok(created.inspect_err(|_| out.abandon())?)
        }
    }
}

/// What the result depends on: two runs of one identity have the same result.
fn identity(input: &Input) -> Value {
    let inputs: serde_json::Map<String, Value> = input
        .checksums
        .iter()
        .map(|c| (c.input.clone(), c.blake3.clone().into()))
        .collect();
    let frames = |o: Option<&FrameObservations>| o.map(|o| o.frame.0);
    json!({
        "version": env!("CARGO_PKG_VERSION"),
        "inputs": inputs,
        "fps": input.recording.fps,
        "first frame": frames(input.observations.first()),
        "last frame": frames(input.observations.last()),
        "options": input.options,
    })
}

fn search(input: &Input, journal: &DiskJournal, progress: Progress) -> Result<Fit, CliError> {
    let frames = input.observations.len();
    let keyframes = frames.div_ceil(input.options.search.keyframe_every);
    let watched = Watched::new(journal, progress, keyframes, frames);
    let sequence = Sequence {
        frames: &input.observations,
        fps: input.recording.fps,
    };
    let rig = &input.recording.rig;
    let fitted = pipeline::fit(&input.model, rig, sequence, &input.options, &watched);
    watched.finish();
    Ok(fitted?)
}

fn write(
    out: &OutFolder,
    input: &Input,
    fit: &Fit,
    arguments: &FitArguments,
) -> Result<ResultFile, CliError> {
    let Input {
        options,
        recording,
        model,
        observations,
        checksums,
    } = input;
    let result = ResultFile::new(
        fit,
        Provenance {
            recording,
            observations,
            inputs: checksums,
            model,
            options,
        },
    );
    let scratch = out.scratch()?;
    if arguments.overlays {
        let pictures = fit.frames.len() * recording.rig.cameras.len();
        let bar = arguments.progress().bar("overlays", pictures);
        let folder = scratch.path().join("overlays");
        overlays::write(&folder, recording, model, fit, &|| bar.inc(1))?;
        bar.finish_and_clear();
    }
    let joints = write_trc(&trajectories(fit, model, recording.fps), "joints.trc");
    for (name, bytes) in [
        ("joints.trc", joints.into_bytes()),
        ("result.json", result.text()?),
    ] {
        let path = scratch.path().join(name);
        fs::write(&path, bytes).map_err(|source| OutError::Write {
            path: arguments.out.join(name),
            source,
        })?;
    }
    out.publish(scratch)?;
    Ok(result)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_range_of_frames_is_two_numbers_in_order() {
        let range = FrameRange { first: 3, last: 7 };
        assert_eq!("3:7".parse(), Ok(range));
        for text in ["7:3", "3", "3:", ":", "a:b", "-1:4"] {
            assert!(text.parse::<FrameRange>().is_err(), "{text}");
        }
    }
}
