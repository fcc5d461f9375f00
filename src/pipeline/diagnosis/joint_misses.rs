//! Whether detections of joints agree with each other, whatever body they show: where there are no silhouettes.
//!
//! Camera c sees joint k at u; the others put the joint at X, the point that most of them agree about ([`Joints`]). By
//!
//! ```text
//! miss(c, k) = max(0, ‖u − π_c(X)‖ − σ) · z_c(X)/f_c,
//! ```
//!
//! metres, the camera misses the others: σ is what published labels scatter by, for detectors that are well miss each other by as much. A joint about which the
//! others do not agree counts as missed altogether.

use super::reading::{Flip, Reading};
use crate::body::Side;
use crate::camera::{Camera, CameraId, Rig};
use crate::inference::joints::Joints;
use crate::likelihood::label_sigma_px;
use crate::math::stats::mean;
use crate::silhouette::{Detection, Keypoint};

/// A joint that lies farther off is missed altogether, metres.
const MOST_M: f64 = 0.3;

/// What a camera of the rig sees of the person, as a hypothesis reads it.
pub(super) type Sighted = (CameraId, Detection);

/// A detection where the calibration would have it; of a picture that shows left for right with sides exchanged.
pub(super) fn as_read(camera: &Camera, detection: &Detection, reading: &Reading) -> Detection {
    let keypoint = |keypoint: &Keypoint| {
        let pixel = reading.calibrated(camera, keypoint.pixel);
        let is_mirrored = reading.flip == Some(Flip::Mirrored);
        let mirrored = Side::mirrored(keypoint.name).filter(|_| is_mirrored);
        let name = mirrored.and_then(|name| SIDED.into_iter().find(|known| *known == name));
        Keypoint { pixel, name: name.unwrap_or(keypoint.name), ..*keypoint }
    };
    Detection {
        keypoints: detection.keypoints.iter().map(keypoint).collect(),
        size_px: detection.size_px / reading.zoom,
    }
}

/// Joints of either side.
const SIDED: [&str; 14] = [
    "RHip",
    "LHip",
    "RKnee",
    "LKnee",
    "RAnkle",
    "LAnkle",
    "RBigToe",
    "LBigToe",
    "RShoulder",
    "LShoulder",
    "RElbow",
    "LElbow",
    "RWrist",
    "LWrist",
];

/// The camera and the mean miss of each view; of fewer than three cameras none, for what one sees cannot be told from two.
pub(super) fn frame_misses(rig: &Rig, sighted: &[Sighted]) -> Vec<(usize, f64)> {
    let of_camera = |(i, (id, own)): (usize, &Sighted)| {
        let mut others = sighted.to_vec();
        others.remove(i);
        let camera = rig.camera(*id)?;
        let joints = (others.len() >= 2).then(|| Joints::new(rig, &others))?;
        let miss = |keypoint: &Keypoint| {
            let seeing = |(_, d): &&Sighted| d.keypoints.iter().any(|k| k.name == keypoint.name);
            if others.iter().filter(seeing).count() < 2 {
                return None;
            }
            let place = joints.as_ref().and_then(|joints| joints.place(keypoint.name));
            Some(place.map_or(MOST_M, |place| {
                let off_px =
                    camera.project_undistorted(&place).map(|at| (keypoint.pixel - at).norm());
                let usual_px = label_sigma_px(keypoint.name, own.size_px, keypoint.confidence);
                let depth_m = (camera.camera_from_world * place).z;
                let metres = |px: f64| px * depth_m / camera.intrinsics.focal_px();
                off_px.map_or(MOST_M, |px| metres((px - usual_px).max(0.0)).min(MOST_M))
            }))
        };
        let miss = mean(own.keypoints.iter().filter_map(miss))?;
        Some((id.0, miss))
    };
    sighted.iter().enumerate().filter_map(of_camera).collect()
}

#[cfg(test)]
mod tests {
    use nalgebra::Vector3;

    use super::*;
    use crate::math::Rigid3;
    use crate::pipeline::diagnosis::CameraFaults;
    use crate::pipeline::diagnosis::fault::CameraFault;
    use crate::pipeline::diagnosis::figures::{detected_walker, late};
    use crate::silhouette::FrameObservations;

    fn faults(rig: &Rig, frames: &[FrameObservations]) -> Vec<CameraFault> {
        CameraFaults::of(rig, frames).faults
    }

    #[test]
    fn each_fault_of_a_camera_is_named_by_detections_and_none_where_there_is_none() {
        let (rig, frames) = detected_walker();
        assert_eq!(faults(&rig, &frames), []);

        // the files of two cameras exchanged
        let mut exchanged = rig.clone();
        exchanged.cameras.swap(0, 1);
        let found = faults(&exchanged, &frames);
        assert_eq!(found, [CameraFault::Exchanged(CameraId(0), CameraId(1))]);

        // one turned by five degrees after its calibration, and one displaced; along the walk it might be late as well
        let turn = Rigid3::rotation(Vector3::x() * 5f64.to_radians());
        for moved in [turn, Rigid3::translation(0.0, 0.3, 0.0)] {
            let mut touched = rig.clone();
            touched.cameras[1].camera_from_world = moved * touched.cameras[1].camera_from_world;
            let found = faults(&touched, &frames);
            let is_it =
                |f: &CameraFault| matches!(f, CameraFault::Elsewhere { camera: CameraId(1), .. });
            assert!(found.len() == 1 && is_it(&found[0]), "{found:?}");
        }

        // one late by five frames
        let found = faults(&rig, &late(&frames, 1, 5));
        let is_late = |f: &CameraFault| matches!(f, CameraFault::Late(CameraId(1), 4..=6));
        assert!(found.len() == 1 && is_late(&found[0]), "{found:?}");
    }

    #[test]
    fn a_picture_that_shows_left_for_right_is_named_by_detections() {
        let (rig, mut frames) = detected_walker();
        let last = f64::from(rig.cameras[2].width_px) - 1.0;
        for (id, detection) in frames.iter_mut().flat_map(|frame| &mut frame.detections) {
            if id.0 == 2 {
                for keypoint in &mut detection.keypoints {
                    keypoint.pixel.x = last - keypoint.pixel.x;
                    let twin = Side::mirrored(keypoint.name);
                    let twin = twin.and_then(|n| SIDED.into_iter().find(|known| *known == n));
                    keypoint.name = twin.unwrap_or(keypoint.name);
                }
            }
        }
        assert_eq!(faults(&rig, &frames), [CameraFault::Flipped(CameraId(2), Flip::Mirrored)]);
    }
}
