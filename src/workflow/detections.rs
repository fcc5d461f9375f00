//! What detections show of each person where there are no masks.

use rayon::prelude::*;

use super::mistakes::{check_poses, check_scale};
use super::{Error, FitOptions};
use crate::io::recording::{Note, ObservationFiles, Recording, RecordingError};
use crate::pipeline::{
    FitError, FitTo, Person, Progress, detected_people, largest_people, strangers,
};
use crate::silhouette::{FrameObservations, FramePeople};

/// So many people are fitted, unless more are asked for.
pub(super) const MOST_PEOPLE: usize = 4;

/// Whether detections alone are fitted to.
pub(super) fn stand_alone(files: &ObservationFiles, fit_to: FitTo) -> bool {
    let is_wanted = match fit_to {
        FitTo::Detections => true,
        FitTo::All => !files.has_masks(),
        FitTo::Silhouettes | FitTo::Points => false,
    };
    is_wanted && files.has_detections()
}

/// The detections of each person, the one who is measured first, in the frames that were asked for, and points where there are any; what is
/// odd is noted.
pub(super) fn load(
    recording: &Recording,
    files: &mut ObservationFiles,
    options: &FitOptions,
    progress: &dyn Progress,
) -> Result<Vec<Vec<FrameObservations>>, Error> {
    let positions = options.frames.positions(&files.frames)?;
    progress.begin("reading detections", positions.len());
    let load = |position: usize| {
        let people = files.load_people(position);
        progress.step();
        people
    };
    let loaded: Vec<Result<_, _>> = positions.into_par_iter().map(load).collect();
    progress.end();

    // the first fault in the order of the frames, whichever thread met one first
    let people: Vec<FramePeople> = loaded.into_iter().collect::<Result<_, _>>()?;
    check_poses(recording, &files.rig, &largest_people(&people))?;
    check_scale(&files.rig, &people)?;
    let most = options.observations.people.most.unwrap_or(MOST_PEOPLE);
    let found = detected_people(&files.rig, &people, files.fps, most);
    check(&found[0], files, &people)?;
    note(&found, files);
    let mut all: Vec<_> = found.into_iter().map(Person::into_observations).collect();
    if let [only] = all.as_mut_slice() {
        add_points(files, options.observations.fit_to, only)?;
    }
    Ok(all)
}

/// Adds points to the observations of the only person.
fn add_points(
    files: &ObservationFiles,
    fit_to: FitTo,
    observed: &mut [FrameObservations],
) -> Result<(), RecordingError> {
    if fit_to == FitTo::All {
        observed.iter_mut().try_for_each(|frame| files.load_points(frame))?;
    }
    Ok(())
}

/// Whether two cameras see one person, or there are points; and no camera sees nobody of them because its pictures are another's.
fn check(found: &Person, files: &ObservationFiles, people: &[FramePeople]) -> Result<(), FitError> {
    let is_found = found.detections.iter().any(|(_, seen)| seen.len() >= 2);
    let frames = people.len();
    if !is_found || !found.beside.cameras.is_empty() {
        let causes = strangers(&files.rig, people);
        if !causes.is_empty() {
            return Err(FitError::Cameras(causes));
        }
    }
    match (is_found || files.has_points(), found.beside.pictures) {
        (true, _) => Ok(()),
        (false, 0) => Err(FitError::NobodyDetected { frames }),
        (false, pictures) => Err(FitError::DetectionsApart { pictures, frames }),
    }
}

fn note(found: &[Person], files: &mut ObservationFiles) {
    let beside = &found[0].beside;
    let others = (beside.others + 1).saturating_sub(found.len());
    files.notes.extend((others > 0).then_some(Note::OtherPeople { others }));
    let elsewhere = beside.cameras.iter();
    let elsewhere = elsewhere.map(|camera| Note::DetectedElsewhere { camera: camera.clone() });
    files.notes.extend(elsewhere);
}
