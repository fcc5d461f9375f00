//! Whether a fit can be used, and what is wrong with the recording where something is.
//!
//! | file             | holds                                                             |
//! |------------------|-------------------------------------------------------------------|
//! | `verdict.rs`     | [`Verdict`]: usable or not, and which hypothesis holds            |
//! | `seen.rs`        | what is wrong that shows without a body                           |
//! | `unusable.rs`    | why the numbers cannot be used                                    |
//! | `cause.rs`       | [`Reason`]s, [`Cause`]s, and those of the cameras                 |
//! | `text.rs`        | all of it in plain words                                          |
//! | `coherence.rs`   | whether the silhouettes agree, whatever body they show            |
//! | `joint_misses.rs` | the same of detections, where there are no silhouettes           |
//! | `fault.rs`       | what can be wrong with a camera                                   |
//! | `reading.rs`     | how the pictures of a camera are read                             |
//! | `hypotheses.rs`  | other ways to read them, and what each explains                   |
//! | `cameras.rs`     | exchanged, flipped, late, zoomed and displaced cameras            |
//! | `poses.rs`       | poses that are written in another form, before anybody is fitted  |
//! | `senseless.rs`   | what no search makes sense of, before anybody is fitted           |
//! | `strangers.rs`   | exchanged and flipped cameras, before anybody is fitted           |
//! | `astray.rs`      | a body that lies where the masks show nobody                      |
//! | `agreeing.rs`    | what the cameras show that agree, for the search                  |
//! | `cleared.rs`     | what of the masks can be used: without the five below             |
//! | `repeated.rs`    | pictures that come twice                                          |
//! | `rods.rs`        | walking aids in the masks                                         |
//! | `shadows.rs`     | shadows on the floor in the masks                                 |
//! | `things.rs`      | what never moves while the person walks, taken out of the masks   |
//! | `parts.rs`       | cameras that lack a part of the person, or hold something else    |
//! | `cropped.rs`     | masks that end at an upright line inside the picture              |
//! | `level.rs`       | cells of a level plane                                            |
//! | `room.rs`        | what stands still in the masks, and stays there                   |
//! | `volume.rs`      | what the silhouettes hold beside the body, and how tall it is     |
//! | `swollen.rs`     | a part that is as thick as nobody's                               |
//! | `thin.rs`        | whether the masks have lost arms, hands and feet                  |
//! | `upright.rs`     | whether the person stands along another axis                      |
//! | `proportions.rs` | whether the world is too large for the body                       |
//! | `stature.rs`     | whether the body is as tall as the person is known to be          |
//! | `figures.rs`     | persons before cameras, for the tests of all                      |
//!
//! Causes are hypotheses that were tested, one after the other, each against the recording as it is. The first that explains
//! what was found is named, and what would follow from it is not.

mod agreeing;
mod astray;
mod cameras;
mod cause;
mod cleared;
mod coherence;
mod cropped;
mod fault;
#[cfg(test)]
pub(super) mod figures;
mod hypotheses;
mod joint_misses;
mod level;
mod parts;
mod poses;
mod proportions;
mod reading;
mod repeated;
mod rods;
mod room;
mod seen;
mod senseless;
mod shadows;
mod stature;
mod strangers;
mod swollen;
mod text;
mod thin;
mod things;
mod unusable;
mod upright;
mod verdict;
mod volume;

use crate::silhouette::FrameObservations;

pub(super) use astray::{MOST_ASTRAY, astray_share};
pub(super) use cameras::CameraFaults;
pub(super) use cause::camera_causes;
pub use cause::{Cause, LensOff, Reason};
pub(super) use cleared::Cleared;
pub(super) use parts::AGREEING;
pub use poses::other_pose_form;
pub(super) use proportions::likeliest_scale;
pub(super) use rods::WithoutRods;
pub(super) use seen::Seen;
pub(super) use stature::stature_m;
pub use strangers::{largest_people, strangers};
pub(super) use swollen::Swollen;
pub(super) use text::joined;
pub(super) use unusable::{LEAST_OVERLAP, LOST_SHARE, MOST_DISPLACED_M, lost_frames};
pub use upright::HeadAxis;
pub(super) use verdict::Diagnosis;
pub use verdict::Verdict;

/// At most so many of `count` positions, evenly: the middles of as many equal stretches.
fn evenly(count: usize, most: usize) -> impl Iterator<Item = usize> {
    let stretches = count.min(most);
    (0..stretches).map(move |i| (2 * i + 1) * count / (2 * stretches))
}

/// Positions of at most so many of the frames that two cameras show, evenly.
fn shown_by_two(frames: &[FrameObservations], most: usize) -> Vec<usize> {
    of_two(frames, most, |frame| frame.views.len())
}

/// The same of the frames in which two cameras have detections.
fn detected_by_two(frames: &[FrameObservations], most: usize) -> Vec<usize> {
    of_two(frames, most, |frame| frame.detections.len())
}

fn of_two(
    frames: &[FrameObservations],
    most: usize,
    cameras: impl Fn(&FrameObservations) -> usize,
) -> Vec<usize> {
    let shown: Vec<usize> = (0..frames.len()).filter(|i| cameras(&frames[*i]) >= 2).collect();
    evenly(shown.len(), most).map(|i| shown[i]).collect()
}
