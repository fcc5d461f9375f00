//! What every stage of the search is given: the body, its priors, the cameras, the likelihood.

use super::hull;
use super::prior::{PosePrior, ShapePrior};
use super::start::Detail;
use crate::body::BodyModel;
use crate::camera::{Camera, CameraId, Rig};
use crate::likelihood::{
    EllipseOptions, EllipseSilhouette, LikelihoodOptions, Measure, PointField, RayView,
    SilhouetteRays, SkinScale, SurfacePoint, Term, View,
};
use crate::silhouette::{FrameObservations, Silhouette};

/// One border point per this length in coarse and in fine evaluations, m.
const COARSE_SPACING_M: f64 = 0.05;
const FINE_SPACING_M: f64 = 0.02;

/// Coarse evaluations forgive this much mismatch, m.
const COARSE_SIGMA_M: f64 = 0.03;
/// And look at so many points at most: several for each correlation length of a body.
const COARSE_POINTS: usize = 600;
/// And look at so few samples of each ellipse's outline.
const COARSE_BACK_SAMPLES: usize = 12;

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
    skin_scale: SkinScale,
}

impl<'a> Evidence<'a> {
    /// Puts a model's priors beside the cameras and the likelihood.
    pub fn new(
        model: &'a BodyModel,
        rig: &'a Rig,
        likelihood: LikelihoodOptions,
        measure: Measure,
    ) -> Self {
        let (shape_prior, pose_prior) = (ShapePrior::of(model), PosePrior::of(model));
        Self {
            model,
            rig,
            shape_prior,
            pose_prior,
            measure,
            likelihood,
            skin_scale: SkinScale::of(model),
        }
    }

    /// A model's priors and the ellipse likelihood alone (ZS06).
    pub fn of_ellipses(model: &'a BodyModel, rig: &'a Rig, ellipses: EllipseOptions) -> Self {
        let likelihood = LikelihoodOptions {
            ellipses,
            ..LikelihoodOptions::default()
        };
        Self::new(model, rig, likelihood, Measure::Ellipses)
    }

    /// The terms of −log p(Zᵢ | mᵢ, s).
    pub fn terms<'f>(&self, frame: &'f FrameObservations, detail: Detail) -> Terms<'f> {
        let (likelihood, spacing_m) = match detail {
            Detail::Fine => (self.likelihood, FINE_SPACING_M),
            Detail::Coarse => (coarse(self.likelihood), COARSE_SPACING_M),
        };
        let subject = hull::subject(self.rig, frame);
        let depth_m = |camera: &Camera| {
            let depth = subject.map(|p| (camera.camera_from_world * p).z);
            let depth = depth.filter(|z| *z > 0.0);
            depth.unwrap_or_else(|| camera.centre_world().coords.norm())
        };
        let mut terms: Terms<'f> = Vec::new();
        if self.measure.has_ellipses() {
            let view = |(id, silhouette): &'f (CameraId, Silhouette)| {
                let camera = &self.rig.cameras[id.0];
                View::new(camera, silhouette, depth_m(camera), spacing_m)
            };
            let views = frame.views.iter().map(view).collect();
            terms.push(Box::new(EllipseSilhouette::new(views, likelihood.ellipses)));
        }
        if self.measure.has_metaballs() {
            let view = |(id, silhouette): &'f (CameraId, Silhouette)| {
                let camera = &self.rig.cameras[id.0];
                RayView::new(camera, silhouette, depth_m(camera), spacing_m)
            };
            let views = frame.views.iter().map(view).collect();
            let rays = SilhouetteRays::new(views, likelihood.rays, self.skin_scale.clone());
            terms.push(Box::new(rays));
        }
        if self.measure.has_metaballs() && !frame.points.is_empty() {
            let thinned = frame.points.iter().step_by(match detail {
                Detail::Fine => 1,
                Detail::Coarse => frame.points.len().div_ceil(COARSE_POINTS),
            });
            let points = thinned.map(SurfacePoint::from).collect();
            let field = PointField::new(points, likelihood.points, self.skin_scale.clone());
            terms.push(Box::new(field));
        }
        terms
    }
}

/// The same likelihood, forgiving.
fn coarse(mut likelihood: LikelihoodOptions) -> LikelihoodOptions {
    let ellipses = &mut likelihood.ellipses;
    ellipses.sigma_m = ellipses.sigma_m.max(COARSE_SIGMA_M);
    ellipses.back_samples = ellipses.back_samples.min(COARSE_BACK_SAMPLES);
    likelihood.rays.sigma_m = likelihood.rays.sigma_m.max(COARSE_SIGMA_M);
    likelihood.points.sigma_m = likelihood.points.sigma_m.max(COARSE_SIGMA_M);
    likelihood
}
