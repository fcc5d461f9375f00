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

/// Where most detections are not of the person whom the masks show: whether they may be of pictures of the calibrated size.
pub(super) fn check_beside_masks(
    files: &ObservationFiles,
    observed: &[FrameObservations],
) -> Result<(), Error> {
    let step = observed.len().div_ceil(SAMPLED).max(1);
    let sampled = || observed.iter().step_by(step);
    let positions = sampled().filter_map(|seen| files.frames.iter().position(|f| *f == seen.frame));
    let people: Vec<FramePeople> =
        positions.map(|position| files.load_people(position)).collect::<Result<_, _>>()?;

    let used: usize = sampled().map(|seen| seen.detections.len()).sum();
    let pictures: usize = people.iter().map(|frame| frame.pictures.len()).sum();
    match 2 * used < pictures {
        true => Ok(check_scale(&files.rig, &people)?),
        false => Ok(()),
    }
}

/// Whether the detections may be of pictures of the calibrated size.
pub(super) fn check_scale(rig: &Rig, people: &[FramePeople]) -> Result<(), FitError> {
    other_scale(rig, people).map_or(Ok(()), |scale| Err(FitError::DetectionsScaled { scale }))
}
