//! How well points in space agree with silhouettes and with the fitted body.
//!
//! A point of the surface projects into every silhouette whose camera looks there, whatever the body is; and it lies on
//! the fitted skin. Where many do not, points and silhouettes do not speak of one scene or not of one moment.

use serde::{Deserialize, Serialize};

use super::diagnosis::LEAST_OVERLAP;
use super::{FittedFrame, Frames, Warning};
use crate::body::Posed;
use crate::inference::{Detail, Evidence};
use crate::likelihood::Source;
use crate::math::stats::median;
use crate::silhouette::{FrameIndex, FrameObservations};
use crate::stereo::CloudPoint;

/// How well the points of one frame agree with its silhouettes and its body.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct PointQuality {
    /// Number of the frame.
    pub frame: FrameIndex,
    /// How many points there are.
    pub points: usize,
    /// Which share of them lies outside a silhouette, by more than three standard deviations.
    pub outside: f64,
    /// Median of how far those lie outside, metres; `None` if none does.
    pub outside_m: Option<f64>,
    /// Median distance from the skin, without sign, metres; `None` where the points were compared with no skin.
    pub off_skin_m: Option<f64>,
}

/// Beyond this many standard deviations a point is outside, or off the skin.
const FAR: f64 = 3.0;
/// A border pixel errs by this much, px, and the surface about what a mask shows by this much, m.
const BORDER_PX: f64 = 1.0;
const SURFACE_M: f64 = 0.01;
/// A frame of which a larger share of the points lies outside is told. A bitten mask leaves a limb outside.
const MANY: f64 = 0.25;

/// The points of one frame; `None` if there are none.
pub(super) fn point_quality(
    evidence: &Evidence<'_>,
    frame: &FrameObservations,
    body: &Posed<'_>,
) -> Option<PointQuality> {
    if frame.points.is_empty() {
        return None;
    }

    let outside = frame.points.iter().map(|p| outside_m(evidence, frame, p));
    let mut outside: Vec<f64> = outside.flatten().collect();

    let terms = evidence.terms(frame, Detail::Fine);
    let mut off_skin: Vec<f64> = terms
        .iter()
        .flat_map(|term| term.placed_residuals(body))
        .filter(|r| r.source == Source::Cloud)
        .map(|r| (r.value * r.sigma).abs())
        .collect();

    Some(PointQuality {
        frame: frame.frame,
        points: frame.points.len(),
        outside: outside.len() as f64 / frame.points.len() as f64,
        outside_m: median(&mut outside),
        off_skin_m: median(&mut off_skin),
    })
}

/// How far a point lies outside the silhouette that it lies farthest out of, m; `None` if it may lie in all.
fn outside_m(
    evidence: &Evidence<'_>,
    frame: &FrameObservations,
    point: &CloudPoint,
) -> Option<f64> {
    let of_view = |(id, silhouette): &(_, crate::silhouette::Silhouette)| {
        let camera = evidence.rig.camera(*id)?;
        let pixel = camera.project_undistorted(&point.position_world)?;
        let depth = (camera.camera_from_world * point.position_world).z;
        let px_per_m = camera.intrinsics.focal_px() / depth;
        let (outside_px, _) = silhouette.outside.sample(&pixel);
        let sigma_m = sigma_m(point).hypot(BORDER_PX / px_per_m);
        let outside_m = outside_px / px_per_m;
        (outside_m > FAR * sigma_m).then_some(outside_m)
    };

    frame.views.iter().filter_map(of_view).max_by(f64::total_cmp)
}

/// What a point errs by, the surface's own mismatch included, m.
fn sigma_m(point: &CloudPoint) -> f64 {
    crate::likelihood::SurfacePoint::from(point).mean_sigma_m().hypot(SURFACE_M)
}

/// The frames whose points disagree with their silhouettes, or with a body that the silhouettes agree with.
pub(super) fn warnings(frames: &[FittedFrame], observations: &[FrameObservations]) -> Vec<Warning> {
    let (mut outside, mut off_skin) = (Disagreement::default(), Disagreement::default());

    for (fitted, observed) in frames.iter().zip(observations) {
        let Some(quality) = &fitted.points else {
            continue;
        };
        let mut sigmas: Vec<f64> = observed.points.iter().map(sigma_m).collect();
        let far_m = FAR * median(&mut sigmas).unwrap_or(SURFACE_M);
        match (quality.outside_m, quality.off_skin_m) {
            (Some(by_m), _) if quality.outside > MANY => outside.add(fitted, quality.outside, by_m),
            (_, Some(by_m)) if by_m > far_m && covers(fitted) => off_skin.add(fitted, 0.5, by_m),
            _ => {}
        }
    }

    let outside_of = |frames, share, by_m| Warning::PointsOutside { frames, share, by_m };
    let off_skin_of = |frames, _, by_m| Warning::PointsOffSkin { frames, by_m };
    [outside.into_warning(outside_of), off_skin.into_warning(off_skin_of)]
        .into_iter()
        .flatten()
        .collect()
}

/// Whether the body covers the frame's silhouettes, so that it is the points that are off.
fn covers(fitted: &FittedFrame) -> bool {
    fitted.mean_iou().is_none_or(|iou| iou >= LEAST_OVERLAP)
}

/// Frames, which share of their points disagrees, and by how much.
#[derive(Debug, Default)]
struct Disagreement {
    frames: Vec<FrameIndex>,
    shares: Vec<f64>,
    by_m: Vec<f64>,
}

impl Disagreement {
    fn add(&mut self, fitted: &FittedFrame, share: f64, by_m: f64) {
        self.frames.push(fitted.frame);
        self.shares.push(share);
        self.by_m.push(by_m);
    }

    /// A warning of the medians over the frames; `None` without a frame.
    fn into_warning(mut self, warning: impl Fn(Frames, f64, f64) -> Warning) -> Option<Warning> {
        let (share, by_m) = (median(&mut self.shares)?, median(&mut self.by_m)?);
        Some(warning(Frames(self.frames), share, by_m))
    }
}

#[cfg(test)]
mod tests {
    use std::path::Path;

    use nalgebra::Point3;

    use super::*;
    use crate::body::Motion;
    use crate::inference::frame::FrameFit;
    use crate::stereo::Spread;

    /// What is said of two frames of points, known to 2 mm, of this quality.
    fn said(outside: Option<(f64, f64)>, off_skin_m: Option<f64>) -> Vec<String> {
        let model = crate::io::model::load("arm", Path::new("")).unwrap();
        let fitted = |number| FittedFrame {
            frame: FrameIndex(number),
            fit: FrameFit {
                motion: Motion::rest(&model),
                data: 0.0,
                pose: 0.0,
                step: 0.0,
                observations: 0.0,
                recovered: false,
            },
            uncertainty: None,
            points_world: Vec::new(),
            views: Vec::new(),
            points: Some(PointQuality {
                frame: FrameIndex(number),
                points: 1,
                outside: outside.map_or(0.0, |(share, _)| share),
                outside_m: outside.map(|(_, by_m)| by_m),
                off_skin_m,
            }),
            detections: Vec::new(),
        };
        let observed = |number| FrameObservations {
            points: vec![CloudPoint {
                position_world: Point3::origin(),
                spread: Spread::Isotropic(0.002),
            }],
            ..FrameObservations::nothing(FrameIndex(number))
        };
        let told = warnings(&[fitted(7), fitted(8)], &[observed(7), observed(8)]);
        told.iter().map(ToString::to_string).collect()
    }

    #[test]
    fn points_off_the_skin_are_told_once_they_are_far_beyond_their_deviation() {
        assert_eq!(said(None, None), [""; 0]);
        // σ is 1.02 cm with the surface's own
        assert_eq!(said(None, Some(0.03)), [""; 0]);
        let told = said(None, Some(0.12));
        let start = "points and silhouettes disagree in 2 frames (7, 8): half of the points lie 0.12 m or more off the skin";
        assert!(told.len() == 1 && told[0].starts_with(start), "{told:?}");
    }

    #[test]
    fn points_outside_are_told_once_and_not_as_off_the_skin_too() {
        let told = said(Some((0.6, 0.3)), Some(0.2));
        let start = "points and silhouettes disagree in 2 frames (7, 8): 60 % of the points lie outside a silhouette, by 0.30 m";
        assert!(told.len() == 1 && told[0].starts_with(start), "{told:?}");
        // a limb that a bitten mask lacks
        assert_eq!(said(Some((0.2, 0.3)), Some(0.01)), [""; 0]);
    }
}
