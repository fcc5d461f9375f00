//! The laws of projection: one check for any camera model.

use super::{Camera, Ray};
use crate::math::central_differences;
use nalgebra::{DVector, Matrix2x3, Point2, Point3};

/// Largest round-trip error, in pixels.
const ROUND_TRIP_PX: f64 = 1e-6;
/// Largest error of the Jacobian, relative to its largest entry.
const JACOBIAN: f64 = 1e-7;

/// What [`check_projection`] examines; implemented by [`Camera`], whose methods these are.
pub trait ProjectionModel {
    /// The pixel of the recorded image.
    fn project(&self, point_world: &Point3<f64>) -> Option<Point2<f64>>;
    /// The undistorted pixel and its derivative with respect to the world point.
    fn project_undistorted_with_jacobian(
        &self,
        point_world: &Point3<f64>,
    ) -> Option<(Point2<f64>, Matrix2x3<f64>)>;
    /// From the recorded image to undistorted pixels.
    fn undistort(&self, pixel: &Point2<f64>) -> Option<Point2<f64>>;
    /// From undistorted pixels to the recorded image.
    fn distort(&self, pixel: &Point2<f64>) -> Point2<f64>;
    /// The line of sight of an undistorted pixel.
    fn ray(&self, undistorted_px: &Point2<f64>) -> Ray;
}

impl ProjectionModel for Camera {
    fn project(&self, point_world: &Point3<f64>) -> Option<Point2<f64>> {
        self.project(point_world)
    }
    fn project_undistorted_with_jacobian(
        &self,
        point_world: &Point3<f64>,
    ) -> Option<(Point2<f64>, Matrix2x3<f64>)> {
        self.project_undistorted_with_jacobian(point_world)
    }
    fn undistort(&self, pixel: &Point2<f64>) -> Option<Point2<f64>> {
        self.undistort(pixel)
    }
    fn distort(&self, pixel: &Point2<f64>) -> Point2<f64> {
        self.distort(pixel)
    }
    fn ray(&self, undistorted_px: &Point2<f64>) -> Ray {
        self.ray(undistorted_px)
    }
}

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
    #[error("∂{row}/∂{column} at pixel ({}, {}) is {analytic}, by differences {numeric}", pixel.x, pixel.y)]
    Jacobian {
        /// The pixel of the recorded image.
        pixel: Point2<f64>,
        /// `u` or `v`.
        row: char,
        /// `X`, `Y` or `Z` of the world.
        column: char,
        /// What the model says.
        analytic: f64,
        /// What central differences say.
        numeric: f64,
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
    model: &impl ProjectionModel,
    pixels: &[Point2<f64>],
    depths: &[f64],
) -> Result<(), ProjectionFault> {
    for pixel in pixels {
        let undistorted = check_round_trip(model, pixel)?;
        let ray = model.ray(&undistorted);
        for &depth in depths {
            let jacobian = check_on_ray(model, pixel, &undistorted, depth)?;
            check_jacobian(model, pixel, &ray.point_at(depth), &jacobian)?;
        }
    }
    Ok(())
}

fn check_round_trip(
    model: &impl ProjectionModel,
    pixel: &Point2<f64>,
) -> Result<Point2<f64>, ProjectionFault> {
    let undistorted =
        model.undistort(pixel).ok_or(ProjectionFault::NotUndistorted { pixel: *pixel })?;
    let error_px = (model.distort(&undistorted) - pixel).norm();
    // written so that NaN is a fault
    if error_px <= ROUND_TRIP_PX {
        Ok(undistorted)
    } else {
        Err(ProjectionFault::RoundTrip { pixel: *pixel, error_px })
    }
}

fn check_on_ray(
    model: &impl ProjectionModel,
    pixel: &Point2<f64>,
    undistorted: &Point2<f64>,
    depth: f64,
) -> Result<Matrix2x3<f64>, ProjectionFault> {
    let point_world = model.ray(undistorted).point_at(depth);
    let seen = model.project(&point_world);
    let seen_undistorted = model.project_undistorted_with_jacobian(&point_world);
    let (Some(seen), Some((seen_undistorted, jacobian))) = (seen, seen_undistorted) else {
        return Err(ProjectionFault::NotSeen { pixel: *pixel, depth });
    };

    // relative for undistorted pixels, which lie far outside the image for a wide fisheye
    let scale = 1.0 + undistorted.coords.norm() * f64::EPSILON / ROUND_TRIP_PX;
    let undistorted_px = (seen_undistorted - undistorted).norm() / scale;
    let back_px = model
        .undistort(&seen)
        .map_or(f64::INFINITY, |back| (back - seen_undistorted).norm() / scale);
    let error_px = (seen - pixel).norm().max(undistorted_px).max(back_px);

    if error_px <= ROUND_TRIP_PX {
        Ok(jacobian)
    } else {
        Err(ProjectionFault::NotOnItsRay { pixel: *pixel, depth, error_px })
    }
}

fn check_jacobian(
    model: &impl ProjectionModel,
    pixel: &Point2<f64>,
    point_world: &Point3<f64>,
    analytic: &Matrix2x3<f64>,
) -> Result<(), ProjectionFault> {
    let step = 1e-3 * (point_world - model.ray(pixel).origin_world).norm();
    let numeric = central_differences(3, step, |d| {
        let moved = point_world + nalgebra::Vector3::new(d[0], d[1], d[2]);
        let seen = model.project_undistorted_with_jacobian(&moved);
        let coordinates = seen.map_or([f64::NAN; 2], |(pixel, _)| [pixel.x, pixel.y]);
        DVector::from_column_slice(&coordinates)
    });

    let tolerance = JACOBIAN * analytic.amax();
    for (i, row) in ['u', 'v'].into_iter().enumerate() {
        for (j, column) in ['X', 'Y', 'Z'].into_iter().enumerate() {
            let (analytic, numeric) = (analytic[(i, j)], numeric[(i, j)]);
            // a point at the very edge may leave the view: no derivative there
            if (analytic - numeric).abs() > tolerance {
                return Err(ProjectionFault::Jacobian {
                    pixel: *pixel,
                    row,
                    column,
                    analytic,
                    numeric,
                });
            }
        }
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::camera::{Distortion, Intrinsics};
    use crate::math::Rigid3;
    use nalgebra::{Unit, Vector3};

    enum Fault {
        None,
        LensNotInverted,
        RayMirrored,
        JacobianSign,
        RayTilted,
    }

    struct Planted(Camera, Fault);

    impl ProjectionModel for Planted {
        fn project(&self, point_world: &Point3<f64>) -> Option<Point2<f64>> {
            self.0.project(point_world)
        }
        fn project_undistorted_with_jacobian(
            &self,
            point_world: &Point3<f64>,
        ) -> Option<(Point2<f64>, Matrix2x3<f64>)> {
            let (pixel, mut jacobian) = self.0.project_undistorted_with_jacobian(point_world)?;
            if matches!(self.1, Fault::JacobianSign) {
                jacobian[(1, 2)] *= -1.0;
            }
            Some((pixel, jacobian))
        }
        fn undistort(&self, pixel: &Point2<f64>) -> Option<Point2<f64>> {
            match self.1 {
                Fault::LensNotInverted => Some(*pixel),
                _ => self.0.undistort(pixel),
            }
        }
        fn distort(&self, pixel: &Point2<f64>) -> Point2<f64> {
            self.0.distort(pixel)
        }
        fn ray(&self, undistorted_px: &Point2<f64>) -> Ray {
            let mut ray = self.0.ray(undistorted_px);
            match self.1 {
                Fault::RayMirrored => ray.direction_world = -ray.direction_world,
                Fault::RayTilted => {
                    let tilted = ray.direction_world.into_inner() + Vector3::new(0.0, 0.0, 1e-6);
                    ray.direction_world = Unit::new_normalize(tilted);
                }
                _ => {}
            }
            ray
        }
    }

    fn check(fault: Fault) -> Result<(), ProjectionFault> {
        let camera = Camera {
            name: "planted".into(),
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
        };
        let pixels = camera.pixel_grid(7, 5);
        check_projection(&Planted(camera, fault), &pixels, &[3.0])
    }

    #[test]
    fn a_sound_camera_passes() {
        assert_eq!(check(Fault::None), Ok(()));
    }

    #[test]
    fn a_lens_that_is_not_inverted_is_found() {
        let fault = check(Fault::LensNotInverted);
        assert!(matches!(fault, Err(ProjectionFault::RoundTrip { .. })));
    }

    #[test]
    fn a_ray_that_looks_backwards_is_found() {
        let fault = check(Fault::RayMirrored);
        assert!(matches!(fault, Err(ProjectionFault::NotSeen { .. })));
    }

    #[test]
    fn a_ray_a_millionth_off_is_found() {
        let fault = check(Fault::RayTilted);
        assert!(matches!(fault, Err(ProjectionFault::NotOnItsRay { .. })));
    }

    #[test]
    fn a_sign_error_in_the_jacobian_is_named() {
        let fault = check(Fault::JacobianSign).unwrap_err().to_string();
        assert!(fault.starts_with("∂v/∂Z"), "{fault}");
    }
}
