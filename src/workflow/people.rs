//! What is fitted of each person of a recording.

use std::collections::{BTreeMap, BTreeSet};

use rayon::prelude::*;

use super::Error;
use super::input::FitInput;
use crate::camera::CameraId;
use crate::image::Plane;
use crate::inference::Sequence;
use crate::io::recording::{Note, ObservationFiles, RecordingError};
use crate::pipeline::{FitError, LEAST_SHARE, PeopleOptions, Progress, by_labels, people};
use crate::silhouette::{FrameObservations, Silhouette};

/// Of so many frames the masks are asked whether they have a value for each person.
const ASKED: usize = 8;

/// The person who is measured, and all others, numbered.
pub(super) struct People {
    pub(super) measured: FitInput,
    pub(super) others: Vec<(usize, FitInput)>,
}

impl People {
    /// Those whom masks or detections show; where they show one, or nothing tells, it is everything that was seen.
    pub(super) fn part(mut input: FitInput, progress: &dyn Progress) -> Result<Self, Error> {
        let PeopleOptions { most, person } = input.options.observations.people;
        let mut shares = std::mem::take(&mut input.others);
        let are_detected = !shares.is_empty();
        if are_detected {
            shares.insert(0, std::mem::take(&mut input.observations));
        } else if is_labelled(&input)? {
            shares = labelled(&input, most.unwrap_or(usize::MAX))?;
        } else if input.observations.iter().all(|frame| frame.points.is_empty()) {
            let (model, rig) = (&input.model, &input.files.rig);
            let sequence = Sequence { frames: &input.observations, fps: input.files.fps };
            shares = people(model, rig, sequence, &input.options.estimate, most, progress)?;
        }
        let of = shares.len().max(1);
        if !(1..=of).contains(&person) {
            return Err(FitError::NoPerson { person, people: of }.into());
        }
        if shares.is_empty() {
            return Ok(Self { measured: input, others: Vec::new() });
        }

        let has_detections = input.observations.iter().any(|frame| !frame.detections.is_empty());
        if has_detections && !are_detected {
            shares.iter_mut().flatten().try_for_each(|share| add_detections(&input, share))?;
        }
        let of_person = |(number, observations): (usize, Vec<FrameObservations>)| {
            let mut own = input.of_person(number, observations);
            own.files.notes.push(Note::SeveralPeople { people: of, person: number });
            (number, own)
        };
        let mut all: Vec<_> = (1..).zip(shares).map(of_person).collect();
        let (_, measured) = all.remove(person - 1);
        Ok(Self { measured, others: all })
    }
}

/// Whether the masks have a value for each person: one of some frames has; where nobody was told apart, it is white.
fn is_labelled(input: &FitInput) -> Result<bool, RecordingError> {
    let apart = input.observations.len().div_ceil(ASKED).max(1);
    let asked = input.observations.iter().step_by(apart);
    for (frame, (camera, _)) in asked.flat_map(|seen| seen.views.iter().map(|v| (seen.frame, v))) {
        if input.files.load_labels(*camera, frame)?.is_some() {
            return Ok(true);
        }
    }
    Ok(false)
}

/// The shares of the people whose values the masks have, in the order of these; empty if it is one.
fn labelled(input: &FitInput, most: usize) -> Result<Vec<Vec<FrameObservations>>, RecordingError> {
    let observed = &input.observations;
    let frames: Vec<Result<_, _>> =
        observed.par_iter().map(|seen| shares_by_value(&input.files, seen)).collect();
    let mut frames: Vec<BTreeMap<u16, FrameObservations>> =
        frames.into_iter().collect::<Result<_, RecordingError>>()?;

    // whom two cameras see in frames enough
    let everybody: BTreeSet<u16> = frames.iter().flat_map(BTreeMap::keys).copied().collect();
    let is_seen = |frame: &&BTreeMap<u16, FrameObservations>, value: &u16| {
        frame.get(value).is_some_and(|share| share.views.len() >= 2)
    };
    let shown = |value: &u16| frames.iter().filter(|frame| is_seen(frame, value)).count();
    let is_somebody = |value: &u16| shown(value) as f64 >= LEAST_SHARE * observed.len() as f64;
    let people: Vec<u16> = everybody.into_iter().filter(is_somebody).take(most).collect();
    if people.len() < 2 {
        return Ok(Vec::new());
    }

    let mut of_person = |value: &u16| -> Vec<FrameObservations> {
        let shares = frames.iter_mut().zip(observed).map(|(frame, seen)| {
            frame.remove(value).unwrap_or_else(|| FrameObservations::nothing(seen.frame))
        });
        shares.collect()
    };
    Ok(people.iter().map(&mut of_person).collect())
}

/// Each person's share of a frame, by the value that the masks have of them.
fn shares_by_value(
    files: &ObservationFiles,
    seen: &FrameObservations,
) -> Result<BTreeMap<u16, FrameObservations>, RecordingError> {
    let of_view = |(id, _): &(CameraId, Silhouette)| {
        let labels = files.load_labels(*id, seen.frame);
        labels.map(|labels| labels.map(|labels| (*id, labels))).transpose()
    };
    let labels: Vec<(CameraId, Plane<u16>)> =
        seen.views.iter().filter_map(of_view).collect::<Result<_, _>>()?;
    let values = labels.iter().flat_map(|(_, labels)| labels.values()).copied();
    let values: BTreeSet<u16> = values.filter(|value| *value > 0).collect();
    let share = |value| (value, by_labels(&files.rig, seen, &labels, value));
    Ok(values.into_iter().map(share).collect())
}

/// Adds the detections of the person whose share of the masks this is.
fn add_detections(input: &FitInput, share: &mut FrameObservations) -> Result<(), RecordingError> {
    for (id, silhouette) in &share.views {
        let people = input.files.people(*id, share.frame)?;
        share.detections.extend(silhouette.detection(people).map(|detection| (*id, detection)));
    }
    Ok(())
}
