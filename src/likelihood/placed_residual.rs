//! Residuals, and where on the body they were measured.

use nalgebra::{Vector2, Vector3};

use crate::body::PartId;

/// Where an observation comes from.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum Source {
    /// A silhouette: its position among the frame's views.
    View(usize),
    /// A cloud of points.
    Cloud,
    /// A keypoint.
    Keypoint {
        /// The position of its camera among those of the frame.
        camera: usize,
        /// Which of the body's it is.
        keypoint: usize,
    },
}

/// One residual, and where on the body it was measured.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PlacedResidual {
    /// Where it comes from.
    pub source: Source,
    /// r/σ.
    pub value: f64,
    /// ρ′: the part of its weight that the robust loss leaves, 1 for an inlier.
    pub trust: f64,
    /// σ, px for a view or keypoints, metres for a cloud.
    pub sigma: f64,
    /// w: the number of independent observations that it stands for.
    pub weight: f64,
    /// Unit normal of the border there, away from the person, in undistorted pixels; 0 for a cloud.
    pub outward_px: Vector2<f64>,
    /// The part on which it was measured.
    pub part: PartId,
    /// Where on it, in the part's frame, metres.
    pub place_part: Vector3<f64>,
}

/// Edge of the cubes into which a part's frame is divided, metres; each is a place of the body.
pub(super) const PLACE_M: f64 = 0.03;

/// A place of the body: a part, and a cube of its frame.
pub type Place = (PartId, [i32; 3]);

/// The place of a point in a part's frame.
pub(super) fn place(part: PartId, point_part: &Vector3<f64>) -> Place {
    let point: [f64; 3] = (*point_part).into();
    (part, point.map(|length| (length / PLACE_M).floor() as i32))
}

impl PlacedResidual {
    /// The place of the body.
    pub fn place(&self) -> Place {
        place(self.part, &self.place_part)
    }
}
