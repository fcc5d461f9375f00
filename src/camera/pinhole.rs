//! One calibrated camera.

use super::{Distortion, Intrinsics, Ray};
use crate::math::Rigid3;
use nalgebra::{Matrix2x3, Matrix3x4, Point2, Point3, Unit, Vector2, Vector3};
use serde::{Deserialize, Serialize};

/// A camera whose lens, sensor and pose are known.
///
/// x̃ = K·\[R|t\]·X̃ gives the undistorted pixel of a world point X, with \[R|t\] = `camera_from_world`.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Camera {
    /// Name in files and messages.
    pub name: String,
    /// Width of the image.
    pub width_px: u32,
    /// Height of the image.
    pub height_px: u32,
    /// The camera matrix K.
    pub intrinsics: Intrinsics,
    /// What the lens does to the image.
    pub distortion: Distortion,
    /// Pose: takes world points (metres, Z up) to the camera frame (x right, y down, z forward).
    pub camera_from_world: Rigid3,
}

impl Camera {
    /// P = K·\[R|t\], 3 × 4, to undistorted pixels.
    pub fn projection(&self) -> Matrix3x4<f64> {
        let mut pose = Matrix3x4::zeros();
        pose.fixed_columns_mut::<3>(0)
            .copy_from(self.camera_from_world.rotation.to_rotation_matrix().matrix());
        pose.set_column(3, &self.camera_from_world.translation.vector);
        self.intrinsics.matrix() * pose
    }

    /// Position of the camera: −Rᵀt.
    pub fn centre_world(&self) -> Point3<f64> {
        self.camera_from_world.inverse_transform_point(&Point3::origin())
    }

    /// With a focal length that is so many times as long, about the same principal point.
    ///
    /// What silhouettes and rays were undistorted by is the lens as it was: the distortion moves every undistorted pixel as before.
    #[must_use]
    pub fn zoomed(&self, factor: f64) -> Self {
        Self {
            intrinsics: self.intrinsics.zoomed(factor),
            distortion: self.distortion.zoomed(factor),
            ..self.clone()
        }
    }

    /// The undistorted pixel at which a point is seen; `None` if it is not in front of the camera.
    pub fn project_undistorted(&self, point_world: &Point3<f64>) -> Option<Point2<f64>> {
        let point_camera = self.camera_from_world * point_world;
        let normalized = in_front(&point_camera)?;
        finite(self.intrinsics.pixel(&normalized))
    }

    /// The undistorted pixel u and ∂u/∂X, in pixels per metre.
    ///
    /// ∂u/∂X = K₂·\[1/Z 0 −X/Z²; 0 1/Z −Y/Z²\]·R with (X, Y, Z) in the camera frame and K₂ the left upper 2 × 2 of K.
    pub fn project_undistorted_with_jacobian(
        &self,
        point_world: &Point3<f64>,
    ) -> Option<(Point2<f64>, Matrix2x3<f64>)> {
        let point_camera = self.camera_from_world * point_world;
        let normalized = in_front(&point_camera)?;
        let pixel = finite(self.intrinsics.pixel(&normalized))?;

        let Intrinsics { fx_px, fy_px, skew_px, .. } = self.intrinsics;
        let (x, y) = (normalized.x, normalized.y);
        let by_camera =
            Matrix2x3::new(fx_px, skew_px, -fx_px * x - skew_px * y, 0.0, fy_px, -fy_px * y)
                / point_camera.z;

        let rotation = self.camera_from_world.rotation.to_rotation_matrix();
        Some((pixel, by_camera * rotation.matrix()))
    }

    /// The pixel of the recorded image at which a point is seen.
    ///
    /// `None` if the point is not in front of the camera, or so far outside the view that the lens model folds.
    pub fn project(&self, point_world: &Point3<f64>) -> Option<Point2<f64>> {
        let point_camera = self.camera_from_world * point_world;
        let distorted = self.distortion.distort_in_view(&in_front(&point_camera)?)?;
        finite(self.intrinsics.pixel(&distorted))
    }

    /// The undistorted pixel of a pixel of the recorded image; `None` where no line of sight has that image.
    pub fn undistort(&self, pixel: &Point2<f64>) -> Option<Point2<f64>> {
        if self.distortion == Distortion::None {
            return finite(*pixel);
        }
        let undistorted = self.distortion.undistort(&self.intrinsics.normalized(pixel))?;
        finite(self.intrinsics.pixel(&undistorted))
    }

    /// The pixel of the recorded image that belongs to an undistorted pixel.
    ///
    /// By the lens model's formula alone: far outside the view, where the model folds, the result means nothing
    /// and can be NaN. [`Camera::project`] checks that.
    pub fn distort(&self, pixel: &Point2<f64>) -> Point2<f64> {
        if self.distortion == Distortion::None {
            return *pixel;
        }
        let distorted = self.distortion.distort(&self.intrinsics.normalized(pixel));
        self.intrinsics.pixel(&distorted)
    }

    /// The line of sight through an undistorted pixel, from the camera's centre.
    pub fn ray(&self, undistorted_px: &Point2<f64>) -> Ray {
        let normalized = self.intrinsics.normalized(undistorted_px);
        let direction_camera = Vector3::new(normalized.x, normalized.y, 1.0);
        let direction_world = self.camera_from_world.inverse().rotation * direction_camera;
        Ray {
            origin_world: self.centre_world(),
            // the z component is 1: the norm is at least 1
            direction_world: Unit::new_normalize(direction_world),
        }
    }

    /// The line of sight through the principal point.
    pub fn optical_axis(&self) -> Ray {
        self.ray(&Point2::new(self.intrinsics.cx_px, self.intrinsics.cy_px))
    }

    /// Whether a pixel of the recorded image lies on the sensor, whose edges are half a pixel beyond the outermost pixel centres.
    pub fn contains(&self, pixel: &Point2<f64>) -> bool {
        let inside = |x: f64, size: u32| (-0.5..=f64::from(size) - 0.5).contains(&x);
        inside(pixel.x, self.width_px) && inside(pixel.y, self.height_px)
    }

    /// Pixels in `columns` × `rows` equal steps from corner to corner of the image, row by row.
    pub fn pixel_grid(&self, columns: u32, rows: u32) -> Vec<Point2<f64>> {
        let at = |i: u32, n: u32, size: u32| {
            f64::from(size) * f64::from(i) / f64::from(n.max(2) - 1) - 0.5
        };
        (0..rows)
            .flat_map(|row| (0..columns).map(move |column| (column, row)))
            .map(|(column, row)| {
                Point2::new(at(column, columns, self.width_px), at(row, rows, self.height_px))
            })
            .collect()
    }
}

/// Depths below this many metres are rounding errors of the pose.
const NEAREST: f64 = 1e-9;

/// (X/Z, Y/Z) of a point before the camera.
fn in_front(point_camera: &Point3<f64>) -> Option<Vector2<f64>> {
    (point_camera.z > NEAREST).then(|| point_camera.coords.xy() / point_camera.z)
}

fn finite(pixel: Point2<f64>) -> Option<Point2<f64>> {
    (pixel.x.is_finite() && pixel.y.is_finite()).then_some(pixel)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::camera::check_projection;
    use nalgebra::{Point4, Translation3, UnitQuaternion};

    fn camera(distortion: Distortion) -> Camera {
        Camera {
            name: "left".into(),
            width_px: 644,
            height_px: 486,
            intrinsics: Intrinsics {
                fx_px: 486.5,
                fy_px: 487.7,
                cx_px: 336.0,
                cy_px: 228.7,
                skew_px: 0.3,
            },
            distortion,
            camera_from_world: Rigid3::from_parts(
                Translation3::new(0.78, 0.75, 3.9),
                UnitQuaternion::from_scaled_axis(Vector3::new(-0.67, 1.55, 1.87)),
            ),
        }
    }

    fn lenses() -> [Distortion; 6] {
        let brown = |c: &[f64]| Distortion::brown_conrady(c).unwrap();
        [
            Distortion::None,
            brown(&[-0.046183, 0.139983, 0.000608, 0.00069]),
            brown(&[-0.32, 0.1812, -6.7e-5, 4.9e-5, -0.0493]),
            brown(&[0.31, -0.12, 0.0011, -0.0007, 0.02, 0.65, -0.05, 0.013]),
            Distortion::fisheye(&[-0.013, 0.021, -0.017, 0.004]).unwrap(),
            Distortion::RadialCorrection {
                centre_x: 0.004,
                centre_y: -0.003,
                k1: 0.09,
                k2: 0.01,
                k3: 0.0,
            },
        ]
    }

    #[test]
    fn every_lens_obeys_the_laws_of_projection_over_the_whole_image() {
        for lens in lenses() {
            let camera = camera(lens);
            check_projection(&camera, &camera.pixel_grid(41, 31), &[0.2, 4.0]).unwrap();
        }
    }

    #[test]
    fn the_projection_matrix_gives_the_undistorted_pixel() {
        let camera = camera(Distortion::None);
        let point = Point3::new(0.4, -0.3, 1.1);
        let by_matrix = camera.projection() * Point4::new(0.4, -0.3, 1.1, 1.0).coords;
        let pixel = camera.project_undistorted(&point).unwrap();
        approx::assert_relative_eq!(pixel.coords, by_matrix.xy() / by_matrix.z, epsilon = 1e-10);
    }

    #[test]
    fn a_point_behind_the_camera_is_not_seen() {
        let camera = camera(Distortion::None);
        let behind = camera.optical_axis().point_at(-1.0);
        assert_eq!(camera.project_undistorted(&behind), None);
        assert_eq!(camera.project(&behind), None);
        assert_eq!(camera.project(&camera.centre_world()), None);
    }

    #[test]
    fn the_optical_axis_meets_the_principal_point() {
        let camera = camera(lenses()[1]);
        let pixel = camera.project(&camera.optical_axis().point_at(2.0)).unwrap();
        approx::assert_relative_eq!(pixel, Point2::new(336.0, 228.7), epsilon = 1e-9);
    }

    #[test]
    fn a_zoomed_camera_shows_what_is_nearer_by_that_factor_and_its_lens_bends_it_as_before() {
        for lens in lenses() {
            let camera = camera(lens);
            let zoomed = camera.zoomed(1.25);
            let place = Vector3::new(0.5, -0.25, 3.0);
            let at = |place: Vector3<f64>| camera.camera_from_world.inverse() * Point3::from(place);
            let nearer = at(Vector3::new(place.x, place.y, place.z / 1.25));
            let (there, here) =
                (zoomed.project_undistorted(&at(place)), camera.project_undistorted(&nearer));
            approx::assert_relative_eq!(there.unwrap(), here.unwrap(), epsilon = 1e-9);
            if !matches!(lens, Distortion::Fisheye { .. }) {
                let (there, here) = (zoomed.project(&at(place)), camera.project(&nearer));
                approx::assert_relative_eq!(there.unwrap(), here.unwrap(), epsilon = 1e-9);
            }
        }
    }

    #[test]
    fn the_image_reaches_half_a_pixel_beyond_the_outermost_centres() {
        let camera = camera(Distortion::None);
        assert!(camera.contains(&Point2::new(-0.5, 485.5)));
        assert!(!camera.contains(&Point2::new(-0.51, 0.0)));
        assert!(!camera.contains(&Point2::new(0.0, 485.51)));
        assert!(!camera.contains(&Point2::new(f64::NAN, 0.0)));
    }
}
