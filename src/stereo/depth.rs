//! From disparities to points.

use nalgebra::Point2;

use super::correlation::{CorrelationError, CorrelationOptions, DisparityRange, correlate};
use super::intersection::{Sighting, intersect};
use super::rectify::{RectifiedPair, RectifyError, bytes, rectify};
use super::view::View;
use super::{CloudPoint, Spread};
use crate::image::{Mask, Plane};

/// Standard deviation of a place in either image, px: a disparity has √2 times that, 0.3 px, as on `stereo/cones`.
const SIGMA_PX: f64 = 0.2;
/// Disparities at most.
const MOST_DISPARITIES: f64 = 256.0;

/// What correlation of a pair gives.
#[derive(Debug, Clone, PartialEq)]
pub struct DepthMap {
    /// The rectified images.
    pub pair: RectifiedPair,
    /// u_left − u_right of each pixel of the left one, px; NaN where none is sure or the subject is not.
    pub disparities: Plane<f32>,
    /// A point for each disparity, row by row.
    pub points: Vec<CloudPoint>,
}

/// Why there is no depth map.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum DepthError {
    /// The pair.
    #[error(transparent)]
    Rectify(#[from] RectifyError),
    /// The disparities.
    #[error(transparent)]
    Correlation(#[from] CorrelationError),
}

impl RectifiedPair {
    /// The disparities of points between two depths (nearest, farthest), m; 256 at most, of the far ones.
    ///
    /// Without depths those of a shift of a third of an image to infinity.
    pub fn range(&self, depth: Option<(f64, f64)>) -> DisparityRange {
        let infinity = self.left.camera.intrinsics.cx_px - self.right.camera.intrinsics.cx_px;
        let base = self.left.camera.intrinsics.fx_px * self.baseline();
        let third = f64::from(self.left.camera.width_px.min(self.right.camera.width_px)) / 3.0;
        let third = third * base.signum();
        let (far, near) = depth.map_or((0.0, third), |(near, far)| (base / far, base / near));
        let count = (near - far).abs().ceil().clamp(0.0, MOST_DISPARITIES - 3.0) + 3.0;
        let least = if near > far {
            far - 1.0
        } else {
            far + 2.0 - count
        };
        DisparityRange {
            first: (infinity + least).floor() as i32,
            count: count as usize,
        }
    }

    /// How far the second camera stands to the right of the first, m; negative to the left.
    pub fn baseline(&self) -> f64 {
        (self.left.camera.camera_from_world * self.right.camera.centre_world()).x
    }
}

/// Rectifies two views, correlates them, and intersects the lines of sight of every disparity.
///
/// `mask` shows the subject in the first view. `depth` as in [`RectifiedPair::range`], which replaces the options' range.
///
/// # Errors
/// [`DepthError`] for cameras that do not stand side by side, and options that make no sense.
pub fn depth_map(
    first: &View,
    second: &View,
    mask: Option<&Mask>,
    depth: Option<(f64, f64)>,
    options: &CorrelationOptions,
) -> Result<DepthMap, DepthError> {
    let pair = rectify(first, second)?;
    let options = CorrelationOptions {
        range: pair.range(depth),
        ..*options
    };
    let mut disparities = correlate(
        &bytes(&pair.left.image),
        &bytes(&pair.right.image),
        &options,
    )?;
    let mut points = Vec::new();
    for y in 0..disparities.height() {
        for (x, disparity) in disparities.row_mut(y).iter_mut().enumerate() {
            let point = point(&pair, (x, y), *disparity);
            let point = point.filter(|point| shows(first, mask, point));
            *disparity = if point.is_some() {
                *disparity
            } else {
                f32::NAN
            };
            points.extend(point);
        }
    }
    Ok(DepthMap {
        pair,
        disparities,
        points,
    })
}

/// The point of one disparity; `None` for none, and for a point that is not before both cameras.
fn point(pair: &RectifiedPair, (x, y): (usize, usize), disparity: f32) -> Option<CloudPoint> {
    let recorded = pair.left.image.get(x, y)?.is_finite();
    let (u, v) = (x as f64, y as f64);
    let disparity = Some(f64::from(disparity)).filter(|d| d.is_finite() && recorded)?;
    let seen = [(&pair.left, u), (&pair.right, u - disparity)];
    let sightings = seen.map(|(view, u)| Sighting {
        camera: &view.camera,
        pixel: Point2::new(u, v),
        sigma_px: SIGMA_PX,
    });
    let found = intersect(&sightings)?;
    Some(CloudPoint {
        position_world: found.position_world,
        spread: Spread::Full(found.covariance),
    })
}

fn shows(view: &View, mask: Option<&Mask>, point: &CloudPoint) -> bool {
    let Some(pixel) = view.camera.project_undistorted(&point.position_world) else {
        return false;
    };
    let inside = pixel.x > -0.5 && pixel.y > -0.5;
    mask.is_none_or(|m| {
        inside && m.is_foreground(pixel.x.round() as usize, pixel.y.round() as usize)
    })
}
