//! How far detections lie from the fitted body.
//!
//! What a detector means by a joint is an unknown of the fit that is not exported, so a centimetre or two of these distances is no error of
//! the motion.

use serde::{Deserialize, Serialize};

use crate::body::Posed;
use crate::camera::CameraId;
use crate::inference::Evidence;
use crate::math::stats::median;
use crate::silhouette::{Detection, FrameIndex, FrameObservations, distances_px};

/// How far the detections of one picture lie from the body's points.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct DetectionQuality {
    /// Number of the frame.
    pub frame: FrameIndex,
    /// Name of the camera.
    pub camera: String,
    /// Number of keypoints that the body has too.
    pub keypoints: usize,
    /// Median of their distances, px.
    pub median_px: f64,
    /// The same over the person's size in the picture.
    pub median_of_size: f64,
}

/// How far the detections of one camera lie from the body's points: medians over the pictures.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct DetectedQuality {
    /// Number of pictures with detections of the person.
    pub pictures: usize,
    /// Of the pictures' medians, px.
    pub median_px: f64,
    /// The same over the person's size in the picture.
    pub median_of_size: f64,
}

impl DetectedQuality {
    /// Of a camera; `None` without any picture.
    pub(super) fn new(pictures: &[&DetectionQuality]) -> Option<Self> {
        Some(Self {
            pictures: pictures.len(),
            median_px: median(&mut pictures.iter().map(|p| p.median_px).collect())?,
            median_of_size: median(&mut pictures.iter().map(|p| p.median_of_size).collect())?,
        })
    }
}

/// Of every detection of a frame; `bodies` are as each of them shows the body.
pub(super) fn detection_qualities(
    evidence: &Evidence<'_>,
    frame: &FrameObservations,
    bodies: &[Posed<'_>],
) -> Vec<DetectionQuality> {
    let quality = |((id, detection), body): (&(CameraId, Detection), &Posed<'_>)| {
        let camera = evidence.rig.camera(*id)?;
        let points = body.points();
        let place = |name: &str| Some(points[body.model.point(name)?]);
        let mut all = distances_px(&detection.keypoints, camera, place);
        let keypoints = all.len();
        let median_px = median(&mut all)?;
        Some(DetectionQuality {
            frame: frame.frame,
            camera: camera.name.clone(),
            keypoints,
            median_px,
            median_of_size: median_px / detection.size_px,
        })
    };
    frame.detections.iter().zip(bodies).filter_map(quality).collect()
}
