//! What a fit says of each frame and of each hypothesis.

use nalgebra::Point3;
use serde::{Deserialize, Serialize};

use super::detected::DetectionQuality;
use super::points::PointQuality;
use super::quality::ViewQuality;
use crate::inference::covariance::FrameUncertainty;
use crate::inference::frame::FrameFit;
use crate::inference::search::Trial;
use crate::math::stats::{mean, median};
use crate::silhouette::FrameIndex;

/// One frame.
#[derive(Debug, Clone)]
pub struct FittedFrame {
    /// Which frame.
    pub frame: FrameIndex,
    /// m and its costs.
    pub fit: FrameFit,
    /// How sure m is; only of the joint optimum.
    pub uncertainty: Option<FrameUncertainty>,
    /// The model's points in the world, in the order of [`BodyModel::points`](crate::body::BodyModel::points).
    pub points_world: Vec<Point3<f64>>,
    /// How well each silhouette is covered; empty where no mask shows anything.
    pub views: Vec<ViewQuality>,
    /// How well its points agree with both; `None` if it has none.
    pub points: Option<PointQuality>,
    /// How far its detections lie from the body.
    pub detections: Vec<DetectionQuality>,
}

impl FittedFrame {
    /// Whether anything was seen of the body: a silhouette, points, or a detection.
    pub fn is_observed(&self) -> bool {
        self.cameras() > 0 || self.points.is_some()
    }

    /// Number of cameras that see the body: by a silhouette, or where there are none by a detection.
    pub fn cameras(&self) -> usize {
        self.views.len().max(self.detections.len())
    }

    /// Median over its pictures of how far detections lie off, over the person's size; `None` without any, or where silhouettes tell.
    pub(super) fn detected_off(&self) -> Option<f64> {
        let all = self.detections.iter().filter(|_| self.views.is_empty());
        median(&mut all.map(|picture| picture.median_of_size).collect())
    }

    /// Mean overlap over the views; `None` without any.
    pub fn mean_iou(&self) -> Option<f64> {
        mean(self.views.iter().map(|view| view.iou))
    }
}

/// A hypothesis and what became of it.
#[derive(Debug, Clone)]
pub struct TriedHypothesis {
    /// Its shape and its track.
    pub trial: Trial,
    /// The number of its keyframe.
    pub keyframe: FrameIndex,
    /// Frames that were fitted; fewer than there are if it was pruned.
    pub fitted: usize,
    /// Mean overlap over at most ten of them; `None` if nothing was seen there.
    pub iou: Option<f64>,
}

impl TriedHypothesis {
    /// E of the fitted frames and its parts.
    pub fn minus_log_posterior(&self) -> MinusLogPosterior {
        let frames = || self.trial.frames.iter().flatten();
        MinusLogPosterior {
            total: self.trial.energy(),
            shape: self.trial.shape_cost,
            data: frames().fold(0.0, |sum, frame| sum + frame.data),
            pose: frames().fold(0.0, |sum, frame| sum + frame.pose),
            step: frames().fold(0.0, |sum, frame| sum + frame.step),
        }
    }
}

/// E = −log of the sequence posterior up to a constant (ZS06 eq. 1), and its parts.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct MinusLogPosterior {
    /// The sum of the parts.
    pub total: f64,
    /// −log p(s).
    pub shape: f64,
    /// Σ −log p(Zᵢ | mᵢ, s).
    pub data: f64,
    /// Σ −log p of limits and rest.
    pub pose: f64,
    /// Σ −log p(mᵢ | mᵢ₋₁).
    pub step: f64,
}
