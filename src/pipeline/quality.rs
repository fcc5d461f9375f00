//! How well the fitted body covers what the cameras saw.

use nalgebra::{Point2, Vector2};
use rayon::prelude::*;

use crate::body::{BodyModel, Posed, Shape};
use crate::camera::{Camera, CameraId, Rig};
use crate::inference::Evidence;
use crate::inference::propagate::FrameFit;
use crate::inference::start::Detail;
use crate::likelihood::ViewResiduals;
use crate::math::quadric::{Ellipse, project};
use crate::math::stats::median;
use crate::silhouette::{FrameObservations, Silhouette};

/// How well the body covers one silhouette.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ViewQuality {
    /// Which camera.
    pub camera: CameraId,
    /// Distances of the border points to the model's outline; `None` where the model is not before the camera.
    pub residuals: Option<ViewResiduals>,
    /// Intersection over union of silhouette and model, 0 to 1.
    pub iou: f64,
}

/// How well the body covers all silhouettes of one camera.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct CameraQuality {
    /// Which camera.
    pub camera: CameraId,
    /// Frames in which it shows a silhouette.
    pub frames: usize,
    /// Mean overlap over them; 0 without any.
    pub mean_iou: f64,
    /// Median over them of the frames' median distance of border points, px.
    pub median_px: Option<f64>,
    /// Root mean square over all border points, px.
    pub rms_px: Option<f64>,
}

/// The model's ellipses in a camera, in undistorted pixels; those around or behind it are left out.
pub fn projected_ellipses(camera: &Camera, body: &Posed<'_>) -> Vec<Ellipse> {
    let projection = camera.projection();
    let ellipsoids = body.ellipsoids();
    ellipsoids
        .iter()
        .filter_map(|e| project(&projection, e))
        .collect()
}

/// The quality of every view of one frame, in the order of its views.
pub(super) fn of_frame(
    evidence: &Evidence<'_>,
    frame: &FrameObservations,
    shape: &Shape,
    fit: &FrameFit,
) -> Vec<ViewQuality> {
    let body = Posed::new(evidence.model, shape, &fit.motion);
    let residuals = evidence.silhouettes(frame, Detail::Fine).residuals(&body);
    let views = frame.views.iter().zip(residuals);
    views
        .map(|((id, silhouette), residuals)| ViewQuality {
            camera: *id,
            residuals,
            iou: iou(&evidence.rig.cameras[id.0], silhouette, &body),
        })
        .collect()
}

/// Most frames whose overlap is looked at for a hypothesis.
const SAMPLED_FRAMES: usize = 10;

/// Mean overlap over at most ten evenly spaced fitted frames of a hypothesis; `None` if nothing was seen in them.
pub(super) fn sampled_iou(
    (model, rig): (&BodyModel, &Rig),
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
            let body = Posed::new(model, shape, &fit.motion);
            let of = move |(id, s): &(CameraId, Silhouette)| iou(&rig.cameras[id.0], s, &body);
            frame.views.iter().map(of)
        })
        .collect();
    mean(&overlaps)
}

/// Intersection over union of a silhouette and the union of the model's ellipses.
fn iou(camera: &Camera, silhouette: &Silhouette, body: &Posed<'_>) -> f64 {
    let ellipses: Vec<Covering> = projected_ellipses(camera, body)
        .iter()
        .map(Covering::new)
        .collect();
    let nothing = (silhouette.bounds.0, silhouette.bounds.0);
    let bounds = ellipses
        .iter()
        .map(|e| (e.low, e.high))
        .reduce(|a, b| (a.0.inf(&b.0), a.1.sup(&b.1)))
        .unwrap_or(nothing);
    let overlap = silhouette.overlap(bounds, |pixel| ellipses.iter().any(|e| e.contains(pixel)));
    overlap.iou()
}

/// An ellipse, its box, and Σ⁻¹.
struct Covering {
    low: Point2<f64>,
    high: Point2<f64>,
    centre: Vector2<f64>,
    inverse: [f64; 3],
}

impl Covering {
    fn new(ellipse: &Ellipse) -> Self {
        let s = &ellipse.shape;
        let determinant = s[(0, 0)] * s[(1, 1)] - s[(0, 1)] * s[(0, 1)];
        let half = Vector2::new(s[(0, 0)].sqrt(), s[(1, 1)].sqrt());
        Self {
            low: Point2::from(ellipse.centre - half),
            high: Point2::from(ellipse.centre + half),
            centre: ellipse.centre,
            inverse: [s[(1, 1)], -s[(0, 1)], s[(0, 0)]].map(|v| v / determinant),
        }
    }

    fn contains(&self, pixel: &Point2<f64>) -> bool {
        let y = pixel.coords - self.centre;
        let [xx, xy, yy] = self.inverse;
        xx * y.x * y.x + 2.0 * xy * y.x * y.y + yy * y.y * y.y <= 1.0
    }
}

/// Each camera over all frames.
pub(super) fn of_cameras(rig: &Rig, frames: &[&[ViewQuality]]) -> Vec<CameraQuality> {
    let of = |(camera, _)| {
        let views: Vec<&ViewQuality> = frames
            .iter()
            .flat_map(|frame| frame.iter().filter(|view| view.camera == camera))
            .collect();
        let residuals: Vec<&ViewResiduals> =
            views.iter().filter_map(|v| v.residuals.as_ref()).collect();
        let points: usize = residuals.iter().map(|r| r.points).sum();
        let squares: f64 = residuals
            .iter()
            .map(|r| r.points as f64 * r.rms_px.powi(2))
            .sum();
        let overlaps: Vec<f64> = views.iter().map(|view| view.iou).collect();
        CameraQuality {
            camera,
            frames: views.len(),
            mean_iou: mean(&overlaps).unwrap_or(0.0),
            median_px: median(&mut residuals.iter().map(|r| r.median_px).collect()),
            rms_px: (points > 0).then(|| (squares / points as f64).sqrt()),
        }
    };
    rig.iter().map(of).collect()
}

pub(super) fn mean(values: &[f64]) -> Option<f64> {
    (!values.is_empty()).then(|| values.iter().sum::<f64>() / values.len() as f64)
}
