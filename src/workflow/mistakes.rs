//! Usual mistakes in a recording's files that are told before anything is searched, with the line of `sequence.toml` that mends them.

use super::Error;
use crate::camera::Rig;
use crate::io::recording::{ObservationFiles, Recording};
use crate::pipeline::{FitError, other_pose_form, other_scale};
use crate::silhouette::{FrameObservations, FramePeople};

/// Frames in which detections are compared with masks.
const SAMPLED: usize = 12;

/// Whether the calibration's poses may be written as they are read.
pub(super) fn check_poses(
    recording: &Recording,
    rig: &Rig,
    frames: &[FrameObservations],
) -> Result<(), FitError> {
    let form = recording.up_of_plain_poses().and_then(|up| other_pose_form(rig, up, frames));
    form.map_or(Ok(()), |form| Err(FitError::PosesWritten { form }))
}

/// Where most masks have no detection of the person whom they show: whether detections may be of pictures of the calibrated size.
pub(super) fn check_detections(
    files: &ObservationFiles,
    observed: &[FrameObservations],
) -> Result<(), Error> {
    let step = observed.len().div_ceil(SAMPLED).max(1);
    let sampled = || observed.iter().step_by(step);
    let used: usize = sampled().map(|seen| seen.detections.len()).sum();
    let masks: usize = sampled().map(|seen| seen.views.len()).sum();
    if 2 * used >= masks {
        return Ok(());
    }

    let positions = sampled().filter_map(|seen| files.frames.iter().position(|f| *f == seen.frame));
    let people: Vec<FramePeople> =
        positions.map(|position| files.load_people(position)).collect::<Result<_, _>>()?;
    Ok(check_scale(&files.rig, &people)?)
}

/// Whether the detections may be of pictures of the calibrated size.
pub(super) fn check_scale(rig: &Rig, people: &[FramePeople]) -> Result<(), FitError> {
    other_scale(rig, people).map_or(Ok(()), |scale| Err(FitError::DetectionsScaled { scale }))
}
