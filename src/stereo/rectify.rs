//! Two images turned so that a point is in the same row of both.

use nalgebra::{Matrix3, Point2, Rotation3, UnitQuaternion, Vector2, Vector3};

use super::DepthError;
use super::view::{StereoView, resampled};
use crate::camera::{Camera, InfiniteHomography, Intrinsics};
use crate::image::Plane;
use crate::math::Rigid3;

/// Largest width and height of a rectified image, over those of the recorded one.
const MOST_STRETCH: f64 = 2.0;

/// A pair of images whose rows correspond.
///
/// A point X has the same row v in both, and u_left − u_right = f·B/Z + (c_left − c_right), with f the common focal length,
/// B how far the second camera stands to the right of the first (negative: to the left), Z the depth and c the columns of
/// the principal points.
#[derive(Debug, Clone, PartialEq)]
pub struct RectifiedPair {
    /// The first camera, turned about its centre.
    pub left: StereoView,
    /// The second camera, turned about its centre.
    pub right: StereoView,
}

/// Turns both cameras about their centres so that rows run along the line between them, and resamples their images.
///
/// x = ±(c₂ − c₁)/|c₂ − c₁|, the one that points to the right in the first image; z is the mean of both optical axes, made
/// perpendicular to x; y = z × x.
///
/// # Errors
/// [`DepthError`] for cameras in one place, and cameras that do not look side by side.
///
/// # Source
/// Fusiello, Trucco & Verri 2000, *A compact algorithm for rectification of stereo pairs*; z as the mean of both axes.
pub fn rectify(first: &StereoView, second: &StereoView) -> Result<RectifiedPair, DepthError> {
    // both cameras are turned alike and get one focal length
    let world_from_rectified = rotation(&first.camera, &second.camera)?;
    let focal = [first, second].map(|view| view.camera.intrinsics.fy_px);
    let focal = 0.5 * (focal[0] + focal[1]);
    let turned = [first, second].map(|view| turned(&view.camera, &world_from_rectified, focal));
    let [Some(left), Some(right)] = turned else {
        return Err(not_side_by_side(&first.camera, &second.camera));
    };

    // the rows that both see, and of each the columns that it sees
    let top = left.low.y.max(right.low.y);
    let bottom = left.high.y.min(right.high.y);
    if bottom - top < 1.0 {
        return Err(DepthError::NoCommonRows { left: left.camera.name, right: right.camera.name });
    }
    let rows = PixelRange::new(top, bottom, first.camera.height_px);
    let left_columns = PixelRange::new(left.low.x, left.high.x, first.camera.width_px);
    let right_columns = PixelRange::new(right.low.x, right.high.x, second.camera.width_px);

    Ok(RectifiedPair {
        left: cut(first, left.camera, left_columns, rows),
        right: cut(second, right.camera, right_columns, rows),
    })
}

/// The orientation that both cameras are turned to.
fn rotation(first: &Camera, second: &Camera) -> Result<Rotation3<f64>, DepthError> {
    let baseline = second.centre_world() - first.centre_world();
    // nearer than a thousandth of a millimetre is no distance
    let Some(along) = baseline.try_normalize(1e-6) else {
        return Err(DepthError::NoBaseline {
            left: first.name.clone(),
            right: second.name.clone(),
            distance_mm: 1000.0 * baseline.norm(),
        });
    };

    // upright, as the first camera is: disparities are negative where the second camera stands to its left
    let right_of_first = first.camera_from_world.rotation.inverse() * Vector3::x();
    let x = along * along.dot(&right_of_first).signum();

    let axes = [first, second].map(|camera| camera.optical_axis().direction_world.into_inner());
    let mean = axes[0] + axes[1];
    let across = mean - x * mean.dot(&x);
    let z = across.try_normalize(0.5);
    let z = z.filter(|_| angle_deg(first, second) <= 60.0);
    let z = z.ok_or_else(|| not_side_by_side(first, second))?;
    let axes = Matrix3::from_columns(&[x, z.cross(&x), z]);
    Ok(Rotation3::from_matrix_unchecked(axes))
}

fn not_side_by_side(first: &Camera, second: &Camera) -> DepthError {
    DepthError::NotSideBySide {
        left: first.name.clone(),
        right: second.name.clone(),
        angle_deg: angle_deg(first, second),
    }
}

fn angle_deg(first: &Camera, second: &Camera) -> f64 {
    let [a, b] = [first, second].map(|camera| camera.optical_axis().direction_world);
    a.angle(&b).to_degrees()
}

/// A camera turned about its centre, its principal point at (0, 0).
struct TurnedCamera {
    camera: Camera,
    /// Least and greatest coordinates of its image, px.
    low: Point2<f64>,
    high: Point2<f64>,
}

/// The turned camera; `None` if a corner of the recorded image is behind it.
fn turned(
    camera: &Camera,
    world_from_rectified: &Rotation3<f64>,
    focal_px: f64,
) -> Option<TurnedCamera> {
    let rotation = UnitQuaternion::from_rotation_matrix(&world_from_rectified.inverse());
    let centre = rotation * camera.centre_world();
    let turned = Camera {
        intrinsics: Intrinsics {
            fx_px: focal_px,
            fy_px: focal_px,
            cx_px: 0.0,
            cy_px: 0.0,
            skew_px: 0.0,
        },
        camera_from_world: Rigid3::from_parts((-centre.coords).into(), rotation),
        ..camera.clone()
    };

    let (mut low, mut high) = (
        Point2::from(Vector2::repeat(f64::INFINITY)),
        Point2::from(Vector2::repeat(f64::NEG_INFINITY)),
    );
    for corner in camera.pixel_grid(2, 2) {
        let ray = camera.ray(&corner);
        let pixel = turned.project_undistorted(&ray.point_at(1.0))?;
        (low, high) = (low.inf(&pixel), high.sup(&pixel));
    }
    Some(TurnedCamera { camera: turned, low, high })
}

/// Columns or rows of a rectified image.
#[derive(Debug, Clone, Copy)]
struct PixelRange {
    first: f64,
    count: u32,
}

impl PixelRange {
    /// The pixels between two places; of more than [`MOST_STRETCH`] times the recorded ones, those in the middle.
    fn new(from: f64, to: f64, recorded: u32) -> Self {
        let middle = 0.5 * (from + to);
        let half = (0.5 * (to - from)).min(0.5 * MOST_STRETCH * f64::from(recorded));
        Self { first: (middle - half).floor(), count: (2.0 * half).ceil().max(1.0) as u32 }
    }
}

/// The view of a turned camera, cut to columns and rows.
fn cut(view: &StereoView, mut camera: Camera, columns: PixelRange, rows: PixelRange) -> StereoView {
    (camera.intrinsics.cx_px, camera.intrinsics.cy_px) = (-columns.first, -rows.first);
    (camera.width_px, camera.height_px) = (columns.count, rows.count);
    let (width, height) = (columns.count as usize, rows.count as usize);
    let recorded_from_rectified = InfiniteHomography::new(&camera, &view.camera);
    let image =
        resampled(&view.image, width, height, |pixel| recorded_from_rectified.pixel(&pixel));
    StereoView { camera, image }
}

/// Brightness in bytes; pixels that show nothing become black.
pub(super) fn bytes(image: &Plane<f32>) -> Plane<u8> {
    // NaN becomes 0
    image.map(|value| (value + 0.5) as u8)
}
