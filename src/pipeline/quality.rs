//! How well the fitted body covers what the cameras saw.

use rayon::prelude::*;
use serde::{Deserialize, Serialize};

use super::camera_found::CameraFound;
use super::detected::{DetectedQuality, DetectionQuality};
use super::overlap::overlap;
use crate::body::{Posed, Shape};
use crate::camera::{Camera, CameraId};
use crate::inference::frame::FrameFit;
use crate::inference::{Detail, Evidence, Terms};
use crate::math::stats::{mean, median};
use crate::silhouette::{FrameIndex, FrameObservations, Overlap, Silhouette};

/// How well the body covers one silhouette: distances of its border points to the model's outline, and the overlap.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct ViewQuality {
    /// Number of the frame.
    pub frame: FrameIndex,
    /// Name of the camera.
    pub camera: String,
    /// Intersection over union of silhouette and model, 0 to 1.
    pub iou: f64,
    /// Share of the model that lies more than 4 cm outside the silhouette, 0 to 1.
    #[serde(default)]
    pub astray: f64,
    /// Number of border points that were compared; 0 where the model is not before the camera.
    pub points: usize,
    /// Root mean square of their distances, px; `None` without points.
    pub rms_px: Option<f64>,
    /// Median of them, px.
    pub median_px: Option<f64>,
    /// 95th percentile of them, px.
    pub p95_px: Option<f64>,
}

/// How well the body covers all silhouettes of one camera.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct CameraQuality {
    /// Name of the camera.
    pub camera: String,
    /// Frames in which it shows a silhouette.
    pub frames: usize,
    /// Mean overlap over them; 0 without any.
    pub mean_iou: f64,
    /// Median over them of the frames' median distance of border points, px.
    pub median_px: Option<f64>,
    /// Root mean square over all border points, px.
    pub rms_px: Option<f64>,
    /// How far its detections lie from the body; `None` if it has none.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub detections: Option<DetectedQuality>,
    /// By how much it was found to be off.
    #[serde(default)]
    pub found: CameraFound,
}

impl ViewQuality {
    /// From the overlap of a view and its border points' distances to the outline, px.
    fn new(frame: FrameIndex, camera: &str, cover: Overlap, mut distances_px: Vec<f64>) -> Self {
        distances_px.sort_by(f64::total_cmp);
        let points = distances_px.len();
        let some = |value: &dyn Fn() -> f64| (points > 0).then(value);
        let quantile = |q: f64| distances_px[((points - 1) as f64 * q).round() as usize];
        let mean_square = || distances_px.iter().map(|d| d * d).sum::<f64>() / points as f64;
        Self {
            frame,
            camera: camera.into(),
            iou: cover.iou(),
            astray: cover.astray_share(),
            points,
            rms_px: some(&|| mean_square().sqrt()),
            median_px: some(&|| quantile(0.5)),
            p95_px: some(&|| quantile(0.95)),
        }
    }
}

/// The quality of every view of one frame, in the order of its views; `bodies` are as each of them shows the body.
pub(super) fn view_qualities(
    evidence: &Evidence<'_>,
    frame: &FrameObservations,
    bodies: &[Posed<'_>],
) -> Vec<ViewQuality> {
    let views = evidence.view_terms(frame, Detail::Fine);
    let quality =
        |((id, silhouette), (terms, body)): (&(CameraId, Silhouette), (Terms<'_>, &Posed<'_>))| {
            let camera = &evidence.rig.cameras[id.0];
            let cover = overlap(camera, silhouette, body, evidence.measure);
            // a border point is measured once: by the last term that looks at borders, the finest
            let each = terms.iter().rev().map(|t| t.placed_residuals(body));
            let residuals = each.into_iter().find(|all| !all.is_empty()).unwrap_or_default();
            let distances_px = residuals.iter().map(|r| (r.value * r.sigma).abs()).collect();
            ViewQuality::new(frame.frame, &camera.name, cover, distances_px)
        };
    frame.views.iter().zip(views.into_iter().zip(bodies)).map(quality).collect()
}

/// Most frames whose overlap is looked at for a hypothesis.
const SAMPLED_FRAMES: usize = 10;

/// Mean overlap over at most ten evenly spaced fitted frames of a hypothesis; `None` if nothing was seen in them.
pub(super) fn sampled_iou(
    evidence: &Evidence<'_>,
    observations: &[FrameObservations],
    shape: &Shape,
    fits: &[Option<FrameFit>],
) -> Option<f64> {
    let fitted: Vec<_> = observations
        .iter()
        .zip(fits)
        .filter_map(|(frame, fit)| Some((frame, fit.as_ref()?)))
        .collect();

    let step = fitted.len().div_ceil(SAMPLED_FRAMES).max(1);
    let overlaps: Vec<f64> = fitted
        .par_iter()
        .step_by(step)
        .flat_map_iter(|(frame, fit)| {
            let body = Posed::new(evidence.model, shape, &fit.motion);
            let of = move |(id, s): &(CameraId, Silhouette)| {
                overlap(&evidence.rig.cameras[id.0], s, &body, evidence.measure).iou()
            };
            frame.views.iter().map(of)
        })
        .collect();
    mean(overlaps)
}

impl CameraQuality {
    /// Over all frames, of what this camera saw in them.
    pub(super) fn new(
        camera: &Camera,
        found: CameraFound,
        views: &[&ViewQuality],
        detected: &[&DetectionQuality],
    ) -> Self {
        let points: usize = views.iter().map(|v| v.points).sum();
        let square = |v: &&ViewQuality| Some(v.points as f64 * v.rms_px?.powi(2));
        let squares: f64 = views.iter().filter_map(square).sum();
        let overlaps = views.iter().map(|view| view.iou);
        Self {
            camera: camera.name.clone(),
            frames: views.len(),
            mean_iou: mean(overlaps).unwrap_or(0.0),
            median_px: median(&mut views.iter().filter_map(|v| v.median_px).collect()),
            rms_px: (points > 0).then(|| (squares / points as f64).sqrt()),
            detections: DetectedQuality::new(detected),
            found,
        }
    }
}
