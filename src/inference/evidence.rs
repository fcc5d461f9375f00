//! What every stage of the search is given: the body, its priors, the cameras, the likelihood.

use super::hull;
use super::prior::{PosePrior, ShapePrior};
use super::start::Detail;
use crate::body::BodyModel;
use crate::camera::Rig;
use crate::likelihood::{EllipseOptions, EllipseSilhouette, Term, View};
use crate::silhouette::FrameObservations;

/// One border point per this length in coarse and in fine evaluations, m.
const COARSE_SPACING_M: f64 = 0.05;
const FINE_SPACING_M: f64 = 0.02;

/// Coarse evaluations forgive this much mismatch, m.
const COARSE_SIGMA_M: f64 = 0.03;

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
    likelihood: EllipseOptions,
}

impl<'a> Evidence<'a> {
    /// Puts a model's priors beside the cameras and the likelihood.
    pub fn new(model: &'a BodyModel, rig: &'a Rig, likelihood: EllipseOptions) -> Self {
        let (shape_prior, pose_prior) = (ShapePrior::of(model), PosePrior::of(model));
        Self {
            model,
            rig,
            shape_prior,
            pose_prior,
            likelihood,
        }
    }

    /// The terms of −log p(Zᵢ | mᵢ, s).
    pub fn terms<'f>(
        &self,
        frame: &'f FrameObservations,
        detail: Detail,
    ) -> Vec<Box<dyn Term + 'f>> {
        vec![Box::new(self.silhouettes(frame, detail))]
    }

    /// The silhouette term alone.
    pub fn silhouettes<'f>(
        &self,
        frame: &'f FrameObservations,
        detail: Detail,
    ) -> EllipseSilhouette<'f> {
        let subject = hull::subject(self.rig, frame);
        let (spacing_m, options) = match detail {
            Detail::Fine => (FINE_SPACING_M, self.likelihood),
            Detail::Coarse => {
                let sigma_m = self.likelihood.sigma_m.max(COARSE_SIGMA_M);
                (
                    COARSE_SPACING_M,
                    EllipseOptions {
                        sigma_m,
                        back_samples: self.likelihood.back_samples.min(12),
                        ..self.likelihood
                    },
                )
            }
        };
        let view =
            |(id, silhouette): &'f (crate::camera::CameraId, crate::silhouette::Silhouette)| {
                let camera = &self.rig.cameras[id.0];
                let depth = subject
                    .map(|p| (camera.camera_from_world * p).z)
                    .filter(|z| *z > 0.0);
                let depth_m = depth.unwrap_or_else(|| camera.centre_world().coords.norm());
                View::new(camera, silhouette, depth_m, spacing_m)
            };
        EllipseSilhouette::new(frame.views.iter().map(view).collect(), options)
    }
}
