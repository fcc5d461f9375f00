//! How well the fitted body covers what the cameras saw.

use nalgebra::Vector2;
use rayon::prelude::*;

use super::overlap::iou;
use crate::body::{Posed, Shape};
use crate::camera::{CameraId, Rig};
use crate::inference::frame::FrameFit;
use crate::inference::{Detail, Evidence};
use crate::likelihood::{PlacedResidual, Source};
use crate::math::stats::{mean, median};
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
    /// By how much all that it shows lies elsewhere than its calibration says, to the right and down, undistorted px.
    pub aim_px: Vector2<f64>,
}

/// Distances of one view's border points to the model, without sign.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ViewResiduals {
    /// Number of border points.
    pub points: usize,
    /// Root mean square, px.
    pub rms_px: f64,
    /// Median, px.
    pub median_px: f64,
    /// 95th percentile, px.
    pub p95_px: f64,
}

impl ViewResiduals {
    /// Of the residuals of one view; `None` without any.
    fn new(residuals: &[PlacedResidual], view: usize) -> Option<Self> {
        let of_view = residuals.iter().filter(|r| r.source == Source::View(view));
        let mut distances_px: Vec<f64> = of_view.map(|r| (r.value * r.sigma).abs()).collect();
        distances_px.sort_by(f64::total_cmp);
        let points = distances_px.len();
        let quantile = |q: f64| distances_px[((points - 1) as f64 * q).round() as usize];
        (points > 0).then(|| Self {
            points,
            rms_px: (distances_px.iter().map(|d| d * d).sum::<f64>() / points as f64).sqrt(),
            median_px: quantile(0.5),
            p95_px: quantile(0.95),
        })
    }
}

/// The quality of every view of one frame, in the order of its views.
pub(super) fn view_qualities(
    evidence: &Evidence<'_>,
    frame: &FrameObservations,
    body: &Posed<'_>,
) -> Vec<ViewQuality> {
    let terms = evidence.terms(frame, Detail::Fine);
    let is_of_view = |r: &PlacedResidual| matches!(r.source, Source::View(_));
    // a border point is measured once: by the last term that looks at borders, the finest
    let each = terms.iter().rev().map(|t| t.placed_residuals(body));
    let of_views = each.map(|all| all.into_iter().filter(is_of_view).collect::<Vec<_>>());
    let residuals = of_views.into_iter().find(|all| !all.is_empty()).unwrap_or_default();

    let views = frame.views.iter().enumerate();
    views
        .map(|(view, (id, silhouette))| ViewQuality {
            camera: *id,
            residuals: ViewResiduals::new(&residuals, view),
            iou: iou(&evidence.rig.cameras[id.0], silhouette, body, evidence.measure),
        })
        .collect()
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
                iou(&evidence.rig.cameras[id.0], s, &body, evidence.measure)
            };
            frame.views.iter().map(of)
        })
        .collect();
    mean(overlaps)
}

/// Each camera over all frames.
pub(super) fn camera_qualities(
    rig: &Rig,
    frames: &[&[ViewQuality]],
    aims_px: &[Vector2<f64>],
) -> Vec<CameraQuality> {
    let of = |(camera, _): (CameraId, _)| {
        let views: Vec<&ViewQuality> = frames
            .iter()
            .flat_map(|frame| frame.iter().filter(|view| view.camera == camera))
            .collect();
        let residuals: Vec<&ViewResiduals> =
            views.iter().filter_map(|v| v.residuals.as_ref()).collect();
        let points: usize = residuals.iter().map(|r| r.points).sum();
        let squares: f64 = residuals.iter().map(|r| r.points as f64 * r.rms_px.powi(2)).sum();
        let overlaps = views.iter().map(|view| view.iou);
        CameraQuality {
            camera,
            frames: views.len(),
            mean_iou: mean(overlaps).unwrap_or(0.0),
            median_px: median(&mut residuals.iter().map(|r| r.median_px).collect()),
            rms_px: (points > 0).then(|| (squares / points as f64).sqrt()),
            aim_px: aims_px[camera.0],
        }
    };
    rig.iter().map(of).collect()
}
