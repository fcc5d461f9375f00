//! What is fitted of each person of a recording.

use super::Error;
use super::input::FitInput;
use crate::inference::Sequence;
use crate::io::recording::{Note, RecordingError};
use crate::pipeline::{FitError, PeopleOptions, Progress, people};
use crate::silhouette::FrameObservations;

/// The person who is measured, and all others, numbered.
pub(super) struct People {
    pub(super) measured: FitInput,
    pub(super) others: Vec<(usize, FitInput)>,
}

impl People {
    /// Those whom the masks show; where they show one, or nothing tells, it is everything that was seen.
    pub(super) fn part(mut input: FitInput, progress: &dyn Progress) -> Result<Self, Error> {
        let PeopleOptions { most, person } = input.options.observations.people;
        let has_points = input.observations.iter().any(|frame| !frame.points.is_empty());
        let mut shares = match has_points {
            true => Vec::new(),
            false => {
                let (model, rig) = (&input.model, &input.files.rig);
                let sequence = Sequence { frames: &input.observations, fps: input.files.fps };
                people(model, rig, sequence, &input.options.estimate, most, progress)?
            }
        };
        let of = shares.len().max(1);
        if !(1..=of).contains(&person) {
            return Err(FitError::NoPerson { person, people: of }.into());
        }
        if shares.is_empty() {
            return Ok(Self { measured: input, others: Vec::new() });
        }

        let has_detections = input.observations.iter().any(|frame| !frame.detections.is_empty());
        if has_detections {
            shares.iter_mut().flatten().try_for_each(|share| add_detections(&input, share))?;
        }
        input.files.notes.push(Note::SeveralPeople { people: of, person });
        let of_person = |(number, observations): (usize, Vec<FrameObservations>)| {
            (number, input.of_person(number, observations))
        };
        let mut all: Vec<_> = (1..).zip(shares).map(of_person).collect();
        let (_, measured) = all.remove(person - 1);
        Ok(Self { measured, others: all })
    }
}

/// Adds the detections of the person whose share of the masks this is.
fn add_detections(input: &FitInput, share: &mut FrameObservations) -> Result<(), RecordingError> {
    for (id, silhouette) in &share.views {
        let people = input.files.people(*id, share.frame)?;
        share.detections.extend(silhouette.detection(people).map(|detection| (*id, detection)));
    }
    Ok(())
}
