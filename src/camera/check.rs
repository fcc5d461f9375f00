//! The laws of projection: one check for any camera model.

use super::Camera;
use crate::math::{DerivativeFault, central_differences, compare_derivatives};
use nalgebra::{DMatrix, DVector, Matrix2x3, Point2, Point3};

/// Largest round-trip error, in pixels.
const ROUND_TRIP_PX: f64 = 1e-6;
/// Largest error of the Jacobian, relative to its largest entry.
const JACOBIAN: f64 = 1e-7;

/// The law that a camera model breaks, and where.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum ProjectionFault {
    /// A pixel of the image has no undistorted position.
    #[error("pixel ({}, {}) cannot be undistorted", pixel.x, pixel.y)]
    NotUndistorted {
        /// The pixel of the recorded image.
        pixel: Point2<f64>,
    },
    /// distort ∘ undistort is not the identity.
    #[error("pixel ({}, {}) undistorted and distorted again is {error_px:.1e} px off", pixel.x, pixel.y)]
    RoundTrip {
        /// The pixel of the recorded image.
        pixel: Point2<f64>,
        /// Distance from it.
        error_px: f64,
    },
    /// A point on the ray of a pixel is not seen at all.
    #[error("the point {depth} m along the ray of pixel ({}, {}) is not seen", pixel.x, pixel.y)]
    NotSeen {
        /// The pixel of the recorded image.
        pixel: Point2<f64>,
        /// Distance along the ray in metres.
        depth: f64,
    },
    /// A point on the ray of a pixel is seen at another pixel.
    #[error("the point {depth} m along the ray of pixel ({}, {}) is seen {error_px:.1e} px off", pixel.x, pixel.y)]
    NotOnItsRay {
        /// The pixel of the recorded image.
        pixel: Point2<f64>,
        /// Distance along the ray in metres.
        depth: f64,
        /// The larger of the distances in distorted and in undistorted pixels.
        error_px: f64,
    },
    /// The Jacobian is not the derivative of the projection.
    #[error("at pixel ({}, {}): {fault}", pixel.x, pixel.y)]
    Jacobian {
        /// The pixel of the recorded image.
        pixel: Point2<f64>,
        /// Which entry.
        fault: DerivativeFault,
    },
}

/// Checks a camera model at pixels of its recorded image and depths (metres) along their rays.
///
/// The laws, to 1e-6 px: distort(undistort(p)) = p; every point of ray(undistort(p)) projects to p, and, without
/// distortion, to undistort(p); the Jacobian is the derivative of the projection (to 1e-7 of its largest entry).
///
/// # Errors
/// The first law that does not hold, and where.
pub fn check_projection(
    camera: &Camera,
    pixels: &[Point2<f64>],
    depths: &[f64],
) -> Result<(), ProjectionFault> {
    let both = BothWays { to_image: camera, from_image: camera };
    pixels.iter().try_for_each(|pixel| both.check(pixel, depths))
}

/// The camera by which the world is seen, and the one by which pixels are followed back: the same, if no fault is planted.
struct BothWays<'a> {
    to_image: &'a Camera,
    from_image: &'a Camera,
}

impl BothWays<'_> {
    fn check(&self, pixel: &Point2<f64>, depths: &[f64]) -> Result<(), ProjectionFault> {
        let undistorted = self.check_round_trip(pixel)?;
        let ray = self.from_image.ray(&undistorted);
        for &depth in depths {
            let jacobian = self.check_on_ray(pixel, &undistorted, depth)?;
            check_jacobian(self.to_image, pixel, &ray.point_at(depth), &jacobian)?;
        }
        Ok(())
    }

    fn check_round_trip(&self, pixel: &Point2<f64>) -> Result<Point2<f64>, ProjectionFault> {
        let undistorted = self
            .from_image
            .undistort(pixel)
            .ok_or(ProjectionFault::NotUndistorted { pixel: *pixel })?;
        let error_px = (self.to_image.distort(&undistorted) - pixel).norm();
        // written so that NaN is a fault
        if error_px <= ROUND_TRIP_PX {
            Ok(undistorted)
        } else {
            Err(ProjectionFault::RoundTrip { pixel: *pixel, error_px })
        }
    }

    fn check_on_ray(
        &self,
        pixel: &Point2<f64>,
        undistorted: &Point2<f64>,
        depth: f64,
    ) -> Result<Matrix2x3<f64>, ProjectionFault> {
        let point_world = self.from_image.ray(undistorted).point_at(depth);
        let seen = self.to_image.project(&point_world);
        let seen_undistorted = self.to_image.project_undistorted_with_jacobian(&point_world);
        let (Some(seen), Some((seen_undistorted, jacobian))) = (seen, seen_undistorted) else {
            return Err(ProjectionFault::NotSeen { pixel: *pixel, depth });
        };

        // relative for undistorted pixels, which lie far outside the image for a wide fisheye
        let scale = 1.0 + undistorted.coords.norm() * f64::EPSILON / ROUND_TRIP_PX;
        let undistorted_px = (seen_undistorted - undistorted).norm() / scale;
        let back_px = self
            .from_image
            .undistort(&seen)
            .map_or(f64::INFINITY, |back| (back - seen_undistorted).norm() / scale);
        let error_px = (seen - pixel).norm().max(undistorted_px).max(back_px);

        if error_px <= ROUND_TRIP_PX {
            Ok(jacobian)
        } else {
            Err(ProjectionFault::NotOnItsRay { pixel: *pixel, depth, error_px })
        }
    }
}

fn check_jacobian(
    camera: &Camera,
    pixel: &Point2<f64>,
    point_world: &Point3<f64>,
    analytic: &Matrix2x3<f64>,
) -> Result<(), ProjectionFault> {
    let step = 1e-3 * (point_world - camera.centre_world()).norm();
    let numeric = central_differences(3, step, |d| {
        let moved = point_world + nalgebra::Vector3::new(d[0], d[1], d[2]);
        let seen = camera.project_undistorted_with_jacobian(&moved);
        let coordinates = seen.map_or([f64::NAN; 2], |(pixel, _)| [pixel.x, pixel.y]);
        DVector::from_column_slice(&coordinates)
    });
    // a point at the very edge may leave the view: no derivative there
    if numeric.iter().any(|slope| slope.is_nan()) {
        return Ok(());
    }

    let tolerance = JACOBIAN * analytic.amax();
    let analytic = DMatrix::from_column_slice(2, 3, analytic.as_slice());
    let names = |row, column| [["u", "v"][row], ["X", "Y", "Z"][column]].map(String::from);
    compare_derivatives(&analytic, &numeric, |_| tolerance, names)
        .map_err(|fault| ProjectionFault::Jacobian { pixel: *pixel, fault })
}

#[cfg(test)]
mod tests {
    use nalgebra::Vector3;

    use super::*;
    use crate::camera::{Distortion, Intrinsics};
    use crate::math::Rigid3;

    fn camera() -> Camera {
        Camera {
            name: "sound".into(),
            width_px: 640,
            height_px: 480,
            intrinsics: Intrinsics {
                fx_px: 700.0,
                fy_px: 705.0,
                cx_px: 320.0,
                cy_px: 240.0,
                skew_px: 0.0,
            },
            distortion: Distortion::brown_conrady(&[-0.2, 0.05, 1e-3, -1e-3]).unwrap(),
            camera_from_world: Rigid3::new(
                Vector3::new(0.1, 0.2, 3.0),
                Vector3::new(1.2, 0.3, 0.1),
            ),
        }
    }

    /// What is found where pixels are followed back by another camera than the one that sees.
    fn check(from_image: &Camera) -> Result<(), ProjectionFault> {
        let camera = camera();
        let both = BothWays { to_image: &camera, from_image };
        camera.pixel_grid(7, 5).iter().try_for_each(|pixel| both.check(pixel, &[3.0]))
    }

    fn turned(radians: f64) -> Camera {
        let turn = Rigid3::rotation(Vector3::x() * radians);
        Camera { camera_from_world: turn * camera().camera_from_world, ..camera() }
    }

    #[test]
    fn a_sound_camera_passes() {
        assert_eq!(check_projection(&camera(), &camera().pixel_grid(7, 5), &[3.0]), Ok(()));
    }

    #[test]
    fn a_lens_that_is_not_inverted_is_found() {
        let fault = check(&Camera { distortion: Distortion::None, ..camera() });
        assert!(matches!(fault, Err(ProjectionFault::RoundTrip { .. })));
    }

    #[test]
    fn a_ray_that_looks_backwards_is_found() {
        let fault = check(&turned(std::f64::consts::PI));
        assert!(matches!(fault, Err(ProjectionFault::NotSeen { .. })));
    }

    #[test]
    fn a_ray_a_millionth_off_is_found() {
        let fault = check(&turned(1e-6));
        assert!(matches!(fault, Err(ProjectionFault::NotOnItsRay { .. })));
    }

    #[test]
    fn a_sign_error_in_the_jacobian_is_named() {
        let camera = camera();
        let pixel = Point2::new(200.0, 100.0);
        let point = camera.ray(&camera.undistort(&pixel).unwrap()).point_at(3.0);
        let (_, mut jacobian) = camera.project_undistorted_with_jacobian(&point).unwrap();
        assert_eq!(check_jacobian(&camera, &pixel, &point, &jacobian), Ok(()));
        jacobian[(1, 2)] *= -1.0;
        let fault = check_jacobian(&camera, &pixel, &point, &jacobian).unwrap_err().to_string();
        assert!(fault.starts_with("at pixel (200, 100): ∂v/∂Z is "), "{fault}");
    }
}
