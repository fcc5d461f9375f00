//! What every stage of the search is given: the body, its priors, the cameras, the likelihood.

use nalgebra::Point3;

use super::detail::Detail;
use super::hull;
use super::prior::{PosePrior, ShapePrior};
use crate::body::{BodyModel, Root};
use crate::camera::{Camera, CameraId, Rig};
use crate::likelihood::{
    EllipseOptions, EllipseSilhouette, EllipseView, KeypointView, Keypoints, LikelihoodOptions,
    Measure, PointField, RayView, SilhouetteRays, SkinScale, SurfacePoint, Term,
};
use crate::silhouette::{Detection, FrameObservations, Silhouette};

/// What one frame shows, as terms of −log p(Zᵢ | mᵢ, s).
pub type Terms<'f> = Vec<Box<dyn Term + 'f>>;

/// Body, priors, cameras and likelihood; shared by all keyframes, hypotheses and threads.
#[derive(Debug, Clone)]
pub struct Evidence<'a> {
    /// The body.
    pub model: &'a BodyModel,
    /// The cameras.
    pub rig: &'a Rig,
    /// p(s).
    pub shape_prior: ShapePrior,
    /// p(m).
    pub pose_prior: PosePrior,
    /// What silhouettes and points are compared with.
    pub measure: Measure,
    likelihood: LikelihoodOptions,
    /// Of a measure that has metaballs.
    skin_scale: Option<SkinScale>,
}

impl<'a> Evidence<'a> {
    /// The same body before other cameras.
    pub fn with_rig<'b>(&self, rig: &'b Rig) -> Evidence<'b>
    where
        'a: 'b,
    {
        Evidence { rig, ..self.clone() }
    }

    /// Puts a model's priors beside the cameras and the likelihood.
    pub fn new(
        model: &'a BodyModel,
        rig: &'a Rig,
        likelihood: LikelihoodOptions,
        measure: Measure,
    ) -> Self {
        Self {
            model,
            rig,
            shape_prior: ShapePrior::new(model),
            pose_prior: PosePrior::new(model),
            measure,
            likelihood,
            skin_scale: measure.has_metaballs().then(|| SkinScale::new(model)),
        }
    }

    /// A model's priors and the ellipse likelihood alone (ZS06, App. C).
    pub fn with_ellipses(model: &'a BodyModel, rig: &'a Rig, ellipses: EllipseOptions) -> Self {
        let likelihood = LikelihoodOptions { ellipses, ..LikelihoodOptions::default() };
        Self::new(model, rig, likelihood, Measure::Ellipses)
    }

    /// The terms of −log p(Zᵢ | mᵢ, s) of one frame.
    pub fn terms<'f>(&self, frame: &'f FrameObservations, detail: Detail) -> Terms<'f> {
        let subject = hull::subject(self.rig, frame);
        let mut terms = self.terms_of_views(&frame.views, subject, detail);
        terms.extend(self.terms_of_points(frame, detail));
        terms.extend(self.terms_of_detections(&frame.detections, subject));
        terms
    }

    /// Those of detections; none of a body that is held, whose points have other names.
    pub(super) fn terms_of_detections<'f>(
        &self,
        detections: &[(CameraId, Detection)],
        subject: Option<Point3<f64>>,
    ) -> Terms<'f> {
        if detections.is_empty() || self.model.root == Root::Fixed {
            return Vec::new();
        }
        let view = |(id, detection): &(CameraId, Detection)| {
            let camera = &self.rig.cameras[id.0];
            KeypointView::new(self.model, camera, detection, depth_m(camera, subject))
        };
        let views = detections.iter().map(view).collect();
        vec![Box::new(Keypoints::new(views, self.likelihood.keypoints))]
    }

    /// Those of some of its views; `subject` is where the body is.
    pub(super) fn terms_of_views<'f>(
        &self,
        views: &'f [(CameraId, Silhouette)],
        subject: Option<Point3<f64>>,
        detail: Detail,
    ) -> Terms<'f> {
        let options = detail.likelihood(self.likelihood);
        let spacing_m = detail.spacing_m();
        let mut terms: Terms<'f> = Vec::new();

        if self.measure.has_ellipses() {
            let view = |(id, silhouette): &'f (CameraId, Silhouette)| {
                let camera = &self.rig.cameras[id.0];
                EllipseView::new(camera, silhouette, depth_m(camera, subject), spacing_m)
            };
            let views = views.iter().map(view).collect();
            terms.push(Box::new(EllipseSilhouette::new(views, options.ellipses)));
        }

        if let Some(scale) = &self.skin_scale {
            let view = |(id, silhouette): &'f (CameraId, Silhouette)| {
                let camera = &self.rig.cameras[id.0];
                RayView::new(camera, silhouette, depth_m(camera, subject), spacing_m)
            };
            let views = views.iter().map(view).collect();
            let rays = SilhouetteRays::new(views, options.rays, scale.clone());
            terms.push(Box::new(rays));
        }
        terms
    }

    /// That of its points, if there are any.
    pub(super) fn terms_of_points<'f>(
        &self,
        frame: &'f FrameObservations,
        detail: Detail,
    ) -> Terms<'f> {
        let scale = match &self.skin_scale {
            Some(scale) if !frame.points.is_empty() => scale,
            _ => return Vec::new(),
        };
        let step = detail.point_step(frame.points.len());
        let points = frame.points.iter().step_by(step);
        let points = points.map(SurfacePoint::from).collect();
        let options = detail.likelihood(self.likelihood).points;
        vec![Box::new(PointField::new(points, options, scale.clone()))]
    }
}

/// How far before a camera the subject is; where nothing shows it, about the world's origin.
fn depth_m(camera: &Camera, subject: Option<Point3<f64>>) -> f64 {
    let depth = subject.map(|p| (camera.camera_from_world * p).z);
    depth.filter(|z| *z > 0.0).unwrap_or_else(|| camera.centre_world().coords.norm())
}
