//! Everything that a fit is made from.

use rayon::prelude::*;
use serde_json::{Value, json};

use super::body::body;
use super::derived::Derived;
use super::mistakes::{check_detections, check_poses};
use super::{Error, FitOptions, detections};
use crate::body::BodyModel;
use crate::inference::Sequence;
use crate::io::recording::{InputChecksum, Note, ObservationFiles, Recording};
use crate::io::result::OptionsPart;
use crate::pipeline::{FitError, FitTo, Progress, check_measure, check_scene, fits_points};
use crate::silhouette::FrameObservations;

/// Everything that a fit is made from, read and checked.
#[derive(Debug)]
pub(super) struct FitInput {
    pub(super) files: ObservationFiles,
    pub(super) model: BodyModel,
    /// What was seen in each frame that is fitted.
    pub(super) observations: Vec<FrameObservations>,
    /// What was seen of others, where detections tell who they are.
    pub(super) others: Vec<Vec<FrameObservations>>,
    pub(super) checksums: Vec<InputChecksum>,
    pub(super) options: OptionsPart,
}

impl FitInput {
    /// Reads and checks everything; what is made of pictures is kept in the folder of `derived`.
    pub(super) fn read(
        recording: &Recording,
        options: &FitOptions,
        derived: &Derived<'_>,
    ) -> Result<Self, Error> {
        options.observations.silhouettes.validate().map_err(FitError::from)?;
        let mut estimate = options.estimate.clone();
        estimate.height_m = estimate.height_m.or(recording.height_m());
        estimate.validate().map_err(FitError::from)?;

        // masks, contours or points
        let (mut files, contours) = derived.observations(recording, options)?;

        // the body
        let (model, bodies) = body(options, recording)?;
        check_measure(&model, options.estimate.measure)?;

        // what is seen in each frame
        let fit_to = options.observations.fit_to;
        let mut people = match contours {
            Some(found) => vec![found.into_iter().map(|seen| fit_to.select(seen)).collect()],
            None if detections::stand_alone(&files, fit_to) => {
                detections::load(recording, &mut files, options, derived.progress)?
            }
            None => {
                let seen = load(&files, options, derived.progress)?;
                check_poses(recording, &files.rig, &seen)?;
                if fit_to == FitTo::All && files.has_detections() {
                    check_detections(&files, &seen)?;
                }
                vec![seen]
            }
        };
        let others = people.split_off(1);
        let observations = people.remove(0);
        files.notes.extend(files.notes_on(&observations));
        let has_detections = observations.iter().any(|frame| !frame.detections.is_empty());
        if fit_to == FitTo::All && files.has_detections() && !has_detections {
            files.notes.push(Note::NobodyDetected);
        }
        if files.has_points() && !fits_points(&model, options.estimate.measure) {
            files.notes.push(Note::PointsUnfitted { body: model.name.clone() });
        }
        check_scene(&model, &files.rig, &observations)?;

        let named = files.rig.names().zip(&files.beginnings);
        let ahead = named.map(|(name, beginning)| (name.to_owned(), beginning.ahead_frames()));
        estimate.ahead_frames = ahead.filter(|(_, frames)| frames.abs() > 0.0).collect();

        let mut checksums = files.checksums()?;
        checksums.extend(bodies);
        Ok(Self {
            files,
            model,
            observations,
            others,
            checksums,
            options: OptionsPart { observations: options.observations, estimate },
        })
    }

    /// What is fitted of one person of several.
    pub(super) fn of_person(&self, person: usize, observations: Vec<FrameObservations>) -> Self {
        let mut options = self.options.clone();
        options.observations.people.person = person;
        Self {
            files: self.files.clone(),
            model: self.model.clone(),
            checksums: self.checksums.clone(),
            observations,
            others: Vec::new(),
            options,
        }
    }

    /// The frames with their time base.
    pub(super) fn sequence(&self) -> Sequence<'_> {
        Sequence { frames: &self.observations, fps: self.files.fps }
    }

    /// What the result depends on: two runs of one identity have the same result.
    pub(super) fn identity(&self) -> Value {
        let number = |seen: Option<&FrameObservations>| seen.map(|seen| seen.frame.0);
        let ends = [number(self.observations.first()), number(self.observations.last())];
        let version = env!("CARGO_PKG_VERSION");
        identity(version, &self.checksums, self.files.fps, ends, json!(self.options))
    }
}

/// What a result depends on; `ends` are the numbers of its first and last frame.
pub(super) fn identity(
    version: &str,
    inputs: &[InputChecksum],
    fps: f64,
    ends: [Option<usize>; 2],
    options: Value,
) -> Value {
    // numbered, for two files elsewhere may have one name
    let inputs: serde_json::Map<String, Value> = (1..)
        .zip(inputs)
        .map(|(i, c)| (format!("{i}: {}", c.input), c.blake3.clone().into()))
        .collect();
    json!({
        "version": version,
        "inputs": inputs,
        "fps": fps,
        "first frame": ends[0],
        "last frame": ends[1],
        "options": options,
    })
}

/// What the files show in the frames that were asked for; masks are dropped as soon as they are traced.
fn load(
    files: &ObservationFiles,
    options: &FitOptions,
    progress: &dyn Progress,
) -> Result<Vec<FrameObservations>, Error> {
    let positions = options.frames.positions(&files.frames)?;
    let wanted = options.observations;

    progress.begin("reading masks", positions.len());
    let load = |position: usize| {
        let seen = files.load_frame(position, &wanted.silhouettes);
        progress.step();
        seen.map(|seen| wanted.fit_to.select(seen))
    };
    let loaded: Vec<Result<_, _>> = positions.into_par_iter().map(load).collect();
    progress.end();

    // the first fault in the order of the frames, whichever thread met one first
    Ok(loaded.into_iter().collect::<Result<_, _>>()?)
}
