//! Everything that `maquette fit` reads.

use std::ops::Range;
use std::path::Path;

use rayon::prelude::*;
use serde_json::{Value, json};

use super::arguments::FitArguments;
use crate::body::BodyModel;
use crate::cli::error::{CliError, one_line};
use crate::cli::frame_range::{FrameRange, span};
use crate::cli::progress::Progress;
use crate::cli::{complain, segment};
use crate::io::frames::{Footage, FramesError};
use crate::io::model;
use crate::io::out_folder::{Existing, OutFolder, check_out};
use crate::io::recording::{InputChecksum, Recording, RecordingError};
use crate::io::segmented::Extras;
use crate::pipeline::{FitError, FitOptions, check_measure, check_scene};
use crate::silhouette::FrameObservations;

/// The body that is fitted when nobody names one.
const DEFAULT_BODY: &str = "human-ellipsoids";

/// Everything that is read before anything is fitted.
pub(super) struct Input {
    pub(super) options: FitOptions,
    pub(super) recording: Recording,
    pub(super) model: BodyModel,
    pub(super) observations: Vec<FrameObservations>,
    pub(super) checksums: Vec<InputChecksum>,
}

/// Reads and checks everything; nothing is written but masks, where there are none.
pub(super) fn read(arguments: &FitArguments) -> Result<Input, CliError> {
    let options = arguments.options()?;
    check_out(&arguments.out, arguments.existing())?;
    let mut recording = open(arguments)?;
    let (model, body) = body(arguments.body.as_deref(), &recording)?;
    check_measure(&model, options.measure)?;
    let positions = FrameRange::positions(arguments.frames, &recording.frames)?;
    let observations = observe(&recording, positions, &options, arguments.quiet.progress())?;
    let notes = recording.notes_of_points(&observations);
    recording.notes.extend(notes);
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

/// The recording; where it has no masks but pictures, with masks made of them and kept in OUT.
fn open(arguments: &FitArguments) -> Result<Recording, CliError> {
    let (path, out) = (&arguments.recording, &arguments.out);
    let fault = match Recording::open(path, arguments.fps) {
        Err(fault @ (RecordingError::NoMasks { .. } | RecordingError::PointsOnly { .. })) => fault,
        opened => return Ok(opened?),
    };
    let footage = match Footage::open(path, arguments.fps) {
        Err(FramesError::NoPictures { .. }) => return Err(fault.into()),
        opened => opened?,
    };
    // quality.csv is written last: where it stands the masks are complete
    let is_kept = arguments.existing() == Existing::Resume && out.join("quality.csv").is_file();
    if !is_kept {
        let frames = footage.frames();
        let range = span(FrameRange::of(arguments.frames, &frames)?);
        OutFolder::open(out)?;
        let made = segment::masks(
            &footage,
            range,
            out,
            Extras::default(),
            arguments.quiet.progress(),
        );
        let (_, notes) = made?;
        for note in notes.iter().filter(|_| !arguments.quiet.is_on()) {
            complain("note", &one_line(note));
        }
    }
    Ok(Recording::open_segmented(path, &footage, out)?)
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

/// The silhouettes of the frames; masks are dropped as soon as they are traced.
fn observe(
    recording: &Recording,
    positions: Range<usize>,
    options: &FitOptions,
    progress: Progress,
) -> Result<Vec<FrameObservations>, CliError> {
    let bar = progress.bar("reading masks", positions.len());
    let load = |position: usize| {
        let observed = recording.load_frame(position, &options.silhouettes);
        bar.inc(1);
        observed
    };
    let loaded: Vec<Result<_, _>> = positions.into_par_iter().map(load).collect();
    bar.finish_and_clear();
    // the first fault in the order of the frames, whichever thread met one first
    Ok(loaded.into_iter().collect::<Result<_, _>>()?)
}

/// What the result depends on: two runs of one identity have the same result.
pub(super) fn identity(input: &Input) -> Value {
    // numbered, for two files elsewhere may have one name
    let inputs: serde_json::Map<String, Value> = (1..)
        .zip(&input.checksums)
        .map(|(i, c)| (format!("{i}: {}", c.input), c.blake3.clone().into()))
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
