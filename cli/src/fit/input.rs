//! Everything that `maquette fit` reads.

use std::ops::Range;
use std::path::Path;

use rayon::prelude::*;
use serde_json::{Value, json};

use super::arguments::{FitArguments, Silhouettes};
use super::contoured::{self, Observed};
use super::made::{cut, measure};
use crate::error::CliError;
use maquette::body::BodyModel;
use maquette::io::folder::check_out;
use maquette::io::model::{self, ModelText};
use maquette::io::recording::footage::FootageError;
use maquette::io::recording::{
    DerivedFiles, InputChecksum, ObservationFiles, Recording, RecordingError,
};
use maquette::pipeline::{FitError, FitOptions, Progress, check_measure, check_scene};
use maquette::silhouette::FrameObservations;

/// The body that is fitted when nobody names one.
const DEFAULT_BODY: &str = "human-ellipsoids";
/// And where there are points, which lie on a skin.
const DEFAULT_BODY_OF_POINTS: &str = "human-metaballs";

/// Everything that is read before anything is fitted.
pub(super) struct Input {
    pub(super) options: FitOptions,
    pub(super) recording: ObservationFiles,
    pub(super) model: BodyModel,
    pub(super) observations: Vec<FrameObservations>,
    pub(super) checksums: Vec<InputChecksum>,
}

/// Reads and checks everything; nothing is written but masks, where there are none.
pub(super) fn read(arguments: &FitArguments) -> Result<Input, CliError> {
    let options = arguments.options()?;
    check_out(&arguments.out, arguments.existing())?;
    let opened = Recording::open(&arguments.recording)?.with_fps(arguments.fps);
    let (mut recording, contoured) = open(&opened, arguments)?;
    let (model, bodies) = body(arguments.body.as_deref(), &opened, recording.has_points())?;
    check_measure(&model, options.measure)?;
    let observations = match contoured {
        Some(observed) => observed.into_iter().map(|o| options.fit_to.of(o)).collect(),
        None => {
            let positions = arguments
                .frames
                .unwrap_or_default()
                .positions(&recording.frames)?;
            observe(&recording, positions, &options, &arguments.quiet.progress())?
        }
    };
    let notes = recording.notes_on_points(&observations);
    recording.notes.extend(notes);
    check_scene(&model, &recording.rig, &observations).map_err(FitError::from)?;
    let mut checksums = recording.checksums()?;
    checksums.extend(bodies);
    Ok(Input {
        options,
        recording,
        model,
        observations,
        checksums,
    })
}

/// The recording; what it lacks is made of its pictures and kept in OUT: masks where there are none, points where asked for.
///
/// With it what the joint pipeline of silhouettes observed, where that was asked for or is the only good way.
fn open(
    recording: &Recording,
    arguments: &FitArguments,
) -> Result<(ObservationFiles, Observed), CliError> {
    let out = &arguments.out;
    if arguments.silhouettes.is_some_and(Silhouettes::is_joint) {
        return contoured::observe(recording, &recording.footage()?, arguments);
    }
    let opened = match arguments.stereo {
        // its points are what is to be measured
        Some(_) => recording.masks(),
        None => recording.observations(),
    };
    let given = match opened {
        Err(fault @ RecordingError::NoMasks { .. }) => Err(fault),
        opened => Ok(opened?),
    };
    let has_masks = given.as_ref().is_ok_and(ObservationFiles::has_masks);
    let is_enough = |files: &ObservationFiles| {
        files.has_masks() || arguments.fits_to_points() && files.has_points()
    };
    if arguments.stereo.is_none() && given.as_ref().is_ok_and(is_enough) {
        return Ok((given?, None));
    }
    let footage = match recording.footage() {
        Err(RecordingError::Footage(FootageError::NoPictures { .. }))
            if arguments.stereo.is_none() =>
        {
            return Ok((given?, None));
        }
        opened => opened?,
    };
    let is_free = arguments.silhouettes.is_none() && arguments.stereo.is_none();
    if is_free && given.is_err() && contoured::is_only_way(&footage) {
        return contoured::observe(recording, &footage, arguments);
    }
    let mut derived = DerivedFiles {
        footage: &footage,
        folder: out,
        has_masks: !has_masks,
        has_points: false,
    };
    if derived.has_masks {
        cut(&footage, arguments)?;
    }
    if let Some(method) = arguments.stereo {
        let masks = recording.with_derived(derived)?;
        measure(&footage, &masks, method, arguments)?;
        derived.has_points = true;
    }
    Ok((recording.with_derived(derived)?, None))
}

/// The body that was asked for, or that the recording names, and the fingerprints of all that it was read from.
fn body(
    asked: Option<&str>,
    recording: &Recording,
    has_points: bool,
) -> Result<(BodyModel, Vec<InputChecksum>), CliError> {
    let (name, folder) = match (asked, recording.body()) {
        (Some(name), _) => (name, Path::new("")),
        (None, Some(name)) => (name, recording.folder()),
        (None, None) if has_points => (DEFAULT_BODY_OF_POINTS, Path::new("")),
        (None, None) => (DEFAULT_BODY, Path::new("")),
    };
    let (model, read) = model::load_with_texts(name, folder)?;
    let checksum =
        |file: &ModelText| InputChecksum::from_text(format!("body {}", file.name), &file.text);
    Ok((model, read.iter().map(checksum).collect()))
}

/// The silhouettes of the frames; masks are dropped as soon as they are traced.
fn observe(
    recording: &ObservationFiles,
    positions: Range<usize>,
    options: &FitOptions,
    progress: &dyn Progress,
) -> Result<Vec<FrameObservations>, CliError> {
    progress.begin("reading masks", positions.len());
    let load = |position: usize| {
        let observed = recording.load_frame(position, &options.silhouettes);
        progress.step();
        observed.map(|observed| options.fit_to.of(observed))
    };
    let loaded: Vec<Result<_, _>> = positions.into_par_iter().map(load).collect();
    progress.end();
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
