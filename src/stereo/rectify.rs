//! Two images turned so that a point is in the same row of both.

use nalgebra::{Matrix3, Point2, Rotation3, UnitQuaternion, Vector3};

use super::view::{StereoView, resampled};
use crate::camera::{Camera, Intrinsics};
use crate::image::Plane;
use crate::math::Rigid3;

/// A rectified image is at most so many times as wide and as high as the recorded one.
const MOST_STRETCH: f64 = 2.0;

/// A pair of images whose rows correspond.
///
/// For a point X, u_left − u_right = f·B/Z + (c_left − c_right), with f the common focal length, B how far the second
/// camera stands to the right of the first (negative: to the left), Z the depth and c the principal points' columns; v is the same in both.
#[derive(Debug, Clone, PartialEq)]
pub struct RectifiedPair {
    /// The first camera, turned about its centre.
    pub left: StereoView,
    /// The second camera, turned about its centre.
    pub right: StereoView,
}

/// Why two images cannot be rectified.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum RectifyError {
    /// One place.
    #[error(
        "cameras {left} and {right} are {distance_mm:.3} mm apart: expected a distance between them, to measure depth by"
    )]
    NoBaseline {
        /// First camera.
        left: String,
        /// Second camera.
        right: String,
        /// How far they are from each other.
        distance_mm: f64,
    },
    /// One camera sees the other, or they look at different things.
    #[error(
        "cameras {left} and {right} do not look side by side ({angle_deg:.0}° between their axes, or one sees the other): expected at most 60°"
    )]
    NotSideBySide {
        /// First camera.
        left: String,
        /// Second camera.
        right: String,
        /// Between the optical axes.
        angle_deg: f64,
    },
    /// Turned, the images have no rows in common.
    #[error("cameras {left} and {right} see no common rows once rectified")]
    NoCommonRows {
        /// First camera.
        left: String,
        /// Second camera.
        right: String,
    },
}

/// Turns both cameras about their centres so that rows run along the line between them, and resamples their images.
///
/// x = ±(c₂ − c₁)/|c₂ − c₁|, the one that points to the right in the first image; z is the mean of both optical axes, made perpendicular to x; y = z × x.
///
/// # Errors
/// [`RectifyError`] for cameras in one place, and cameras that do not look side by side.
///
/// # Source
/// Fusiello, Trucco & Verri 2000, *A compact algorithm for rectification of stereo pairs*; z as the mean of both axes.
pub fn rectify(first: &StereoView, second: &StereoView) -> Result<RectifiedPair, RectifyError> {
    let (left, right) = (first.camera.name.clone(), second.camera.name.clone());
    let world_from_rectified = rotation(&first.camera, &second.camera)?;
    let focal = [first, second].map(|view| view.camera.intrinsics.fy_px);
    let focal = 0.5 * (focal[0] + focal[1]);
    let turned = [first, second].map(|view| turned(&view.camera, &world_from_rectified, focal));
    let [(Some(a), a_box), (Some(b), b_box)] = turned else {
        let angle_deg = angle_deg(&first.camera, &second.camera);
        return Err(RectifyError::NotSideBySide {
            left,
            right,
            angle_deg,
        });
    };
    let rows = (a_box.1.max(b_box.1), a_box.3.min(b_box.3));
    if rows.1 - rows.0 < 1.0 {
        return Err(RectifyError::NoCommonRows { left, right });
    }
    let rows = part(rows, first.camera.height_px);
    let cut = |view: &StereoView, camera: Camera, columns: (f64, f64)| {
        cut(view, camera, part(columns, view.camera.width_px), rows)
    };
    Ok(RectifiedPair {
        left: cut(first, a, (a_box.0, a_box.2)),
        right: cut(second, b, (b_box.0, b_box.2)),
    })
}

fn rotation(first: &Camera, second: &Camera) -> Result<Rotation3<f64>, RectifyError> {
    let (left, right) = (first.name.clone(), second.name.clone());
    let baseline = second.centre_world() - first.centre_world();
    // nearer than a thousandth of a millimetre is no distance
    let Some(along) = baseline.try_normalize(1e-6) else {
        let distance_mm = 1000.0 * baseline.norm();
        return Err(RectifyError::NoBaseline {
            left,
            right,
            distance_mm,
        });
    };
    // upright, as the first camera is: disparities are negative where the second camera stands to its left
    let right_of_first = first.camera_from_world.rotation.inverse() * Vector3::x();
    let x = along * along.dot(&right_of_first).signum();
    let axes = [first, second].map(|camera| camera.optical_axis().direction_world.into_inner());
    let mean = axes[0] + axes[1];
    let across = mean - x * mean.dot(&x);
    let angle_deg = angle_deg(first, second);
    let z = across.try_normalize(0.5).filter(|_| angle_deg <= 60.0);
    let z = z.ok_or(RectifyError::NotSideBySide {
        left,
        right,
        angle_deg,
    })?;
    let y = z.cross(&x);
    Ok(Rotation3::from_matrix_unchecked(Matrix3::from_columns(&[
        x, y, z,
    ])))
}

fn angle_deg(first: &Camera, second: &Camera) -> f64 {
    let [a, b] = [first, second].map(|camera| camera.optical_axis().direction_world);
    a.angle(&b).to_degrees()
}

/// The turned camera with its principal point at (0, 0), and the box (left, top, right, bottom) of its image.
fn turned(
    camera: &Camera,
    world_from_rectified: &Rotation3<f64>,
    focal_px: f64,
) -> (Option<Camera>, (f64, f64, f64, f64)) {
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
    let mut area = (
        f64::INFINITY,
        f64::INFINITY,
        f64::NEG_INFINITY,
        f64::NEG_INFINITY,
    );
    for corner in camera.pixel_grid(2, 2) {
        let ray = camera.ray(&corner);
        let Some(p) = turned.project_undistorted(&ray.point_at(1.0)) else {
            return (None, area);
        };
        area = (
            area.0.min(p.x),
            area.1.min(p.y),
            area.2.max(p.x),
            area.3.max(p.y),
        );
    }
    (Some(turned), area)
}

/// First pixel and number of pixels of an interval, of at most [`MOST_STRETCH`] times the recorded ones.
fn part((from, to): (f64, f64), recorded: u32) -> (f64, u32) {
    let middle = 0.5 * (from + to);
    let half = (0.5 * (to - from)).min(0.5 * MOST_STRETCH * f64::from(recorded));
    ((middle - half).floor(), (2.0 * half).ceil().max(1.0) as u32)
}

/// The turned camera with the given columns and rows of its image.
fn cut(
    view: &StereoView,
    mut camera: Camera,
    (left, width): (f64, u32),
    (top, height): (f64, u32),
) -> StereoView {
    (camera.intrinsics.cx_px, camera.intrinsics.cy_px) = (-left, -top);
    (camera.width_px, camera.height_px) = (width, height);
    let source = |p: Point2<f64>| {
        let ray = camera.ray(&p);
        view.camera.project_undistorted(&ray.point_at(1.0))
    };
    let image = resampled(&view.image, [width as usize, height as usize], source);
    StereoView { camera, image }
}

/// Brightness in bytes; what shows nothing becomes black.
pub(super) fn bytes(image: &Plane<f32>) -> Plane<u8> {
    // NaN becomes 0
    image.map(|value| (value + 0.5) as u8)
}
