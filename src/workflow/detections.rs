//! What detections show of one person where there are no masks.

use rayon::prelude::*;

use super::{Error, FitOptions};
use crate::io::recording::{Note, ObservationFiles, RecordingError};
use crate::pipeline::{Beside, FitError, FitTo, Person, Progress, person, strangers};
use crate::silhouette::{FrameObservations, FramePeople};

/// Whether detections are fitted to, and no mask says whose they are.
pub(super) fn stand_alone(files: &ObservationFiles, fit_to: FitTo) -> bool {
    let is_wanted = matches!(fit_to, FitTo::All | FitTo::Detections);
    is_wanted && !files.has_masks() && files.has_detections()
}

/// The detections of the person who is seen longest, in the frames that were asked for, and points where there are any; what is odd is noted.
pub(super) fn load(
    files: &mut ObservationFiles,
    options: &FitOptions,
    progress: &dyn Progress,
) -> Result<Vec<FrameObservations>, Error> {
    let positions = options.frames.positions(&files.frames)?;
    let fit_to = options.observations.fit_to;

    progress.begin("reading detections", positions.len());
    let load = |position: usize| -> Result<(FramePeople, FrameObservations), RecordingError> {
        let people = files.load_people(position)?;
        let mut seen = FrameObservations::nothing(people.frame);
        files.load_points(&mut seen)?;
        progress.step();
        Ok((people, fit_to.select(seen)))
    };
    let loaded: Vec<Result<_, _>> = positions.into_par_iter().map(load).collect();
    progress.end();

    // the first fault in the order of the frames, whichever thread met one first
    let loaded: Vec<_> = loaded.into_iter().collect::<Result<_, _>>()?;
    let (people, mut observed): (Vec<_>, Vec<_>) = loaded.into_iter().unzip();
    let found = person(&files.rig, &people, files.fps);
    check(&found, files, &people)?;
    note(&found.beside, files);
    found.into_observations(&mut observed);
    Ok(observed)
}

/// Whether two cameras see one person, or there are points; and no camera sees nobody of them because its pictures are another's.
fn check(found: &Person, files: &ObservationFiles, people: &[FramePeople]) -> Result<(), FitError> {
    let is_found = found.detections.iter().any(|(_, seen)| seen.len() >= 2);
    let frames = people.len();
    if !is_found || !found.beside.cameras.is_empty() {
        let mut causes = strangers(&files.rig, people).into_iter();
        causes.next().map_or(Ok(()), |cause| Err(FitError::Cameras(cause)))?;
    }
    match (is_found || files.has_points(), found.beside.pictures) {
        (true, _) => Ok(()),
        (false, 0) => Err(FitError::NobodyDetected { frames }),
        (false, pictures) => Err(FitError::DetectionsApart { pictures, frames }),
    }
}

fn note(beside: &Beside, files: &mut ObservationFiles) {
    if beside.others > 0 {
        files.notes.push(Note::OtherPeople { others: beside.others });
    }
    let elsewhere = beside.cameras.iter();
    let elsewhere = elsewhere.map(|camera| Note::DetectedElsewhere { camera: camera.clone() });
    files.notes.extend(elsewhere);
}
