//! Whether detections of joints agree with each other, whatever body they show: where there are no silhouettes.
//!
//! Camera c sees joint k at u; the others put the joint at X, the point that most of them agree about ([`Joints`]). By
//!
//! ```text
//! miss(c, k) = max(0, ‖u − π_c(X)‖ − σ) · z_c(X)/f_c,
//! ```
//!
//! metres, the camera misses the others: σ is what published labels scatter by, for detectors that are well miss each other by as much. A joint about which the
//! others do not agree counts as missed altogether. The median over the joints of a picture counts, so that legs which one detector exchanges
//! accuse no camera.

use super::coherence::Reading;
use crate::body::Side;
use crate::camera::{Camera, CameraId, Rig};
use crate::inference::joints::Joints;
use crate::likelihood::label_sigma_px;
use crate::math::stats::median;
use crate::silhouette::{Detection, Keypoint};

/// A joint that lies farther off is missed altogether, metres.
const MOST_M: f64 = 0.3;

/// What a camera of the rig sees of the person, as a hypothesis reads it.
pub(super) type Sighted = (CameraId, Detection);

/// A detection where the calibration would have it; of a picture that shows left for right with sides exchanged.
pub(super) fn as_read(camera: &Camera, detection: &Detection, reading: &Reading) -> Detection {
    let keypoint = |keypoint: &Keypoint| {
        let pixel = reading.calibrated(camera, keypoint.pixel);
        let mirrored = Side::mirrored(keypoint.name).filter(|_| reading.mirrored);
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

/// The camera and the median miss of each view; of fewer than three cameras none, for what one sees cannot be told from two.
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
                let off_px = camera.project_undistorted(&place).map(|at| (keypoint.pixel - at).norm());
                let usual_px = label_sigma_px(keypoint.name, own.size_px, keypoint.confidence);
                let depth_m = (camera.camera_from_world * place).z;
                let metres = |px: f64| px * depth_m / camera.intrinsics.focal_px();
                off_px.map_or(MOST_M, |px| metres((px - usual_px).max(0.0)).min(MOST_M))
            }))
        };
        let miss = median(&mut own.keypoints.iter().filter_map(miss).collect())?;
        Some((id.0, miss))
    };
    sighted.iter().enumerate().filter_map(of_camera).collect()
}
