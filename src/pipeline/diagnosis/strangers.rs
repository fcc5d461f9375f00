//! Cameras whose detections show nobody whom the others see: whether their pictures are another's, or mirrored.

use super::cameras::CameraFaults;
use super::cause::{Cause, camera_causes};
use crate::camera::{CameraId, Rig};
use crate::silhouette::{Detection, FrameObservations, FramePeople, Keypoint};

/// The cameras whose pictures are exchanged or mirrored, as the largest person of each picture tells it.
pub fn strangers(rig: &Rig, frames: &[FramePeople]) -> Vec<Cause> {
    let causes = camera_causes(rig, &CameraFaults::of(rig, &largest_people(frames)));
    causes.into_iter().filter(|cause| cause.wrong_pictures(rig) > 0).collect()
}

/// What is seen of the largest person of each picture.
pub fn largest_people(frames: &[FramePeople]) -> Vec<FrameObservations> {
    let largest = |(id, people): &(CameraId, Vec<Vec<Keypoint>>)| {
        let people = people.iter().cloned().filter_map(Detection::new);
        let person = people.max_by(|a, b| a.size_px.total_cmp(&b.size_px));
        person.map(|person| (*id, person))
    };
    let observed = |frame: &FramePeople| FrameObservations {
        detections: frame.pictures.iter().filter_map(largest).collect(),
        ..FrameObservations::nothing(frame.frame)
    };
    frames.iter().map(observed).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::pipeline::diagnosis::figures::detected_walker;

    #[test]
    fn exchanged_files_are_named_whoever_else_is_small_in_the_pictures() {
        let (mut rig, frames) = detected_walker();
        let people = |frame: &FrameObservations| FramePeople {
            frame: frame.frame,
            pictures: frame.detections.iter().map(|(id, d)| (*id, beside(d))).collect(),
        };
        let frames: Vec<FramePeople> = frames.iter().map(people).collect();
        assert_eq!(strangers(&rig, &frames), []);
        rig.cameras.swap(0, 2);
        assert!(matches!(strangers(&rig, &frames)[..], [Cause::Exchanged { .. }]));
    }

    /// A person, and a small one in a corner.
    fn beside(detection: &Detection) -> Vec<Vec<Keypoint>> {
        let small = |keypoint: &Keypoint| Keypoint { pixel: keypoint.pixel / 5.0, ..*keypoint };
        vec![detection.keypoints.iter().map(small).collect(), detection.keypoints.clone()]
    }
}
