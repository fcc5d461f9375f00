//! A point of the surface, as the likelihood sees it.

use nalgebra::{Matrix3, Point3, Vector3};

use crate::camera::Rig;
use crate::stereo::{CloudPoint, Spread};

/// A point measured on the surface.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SurfacePoint {
    /// Where.
    pub position_world: Point3<f64>,
    /// C: covariance of its error, world, m²; 0 where it is not known.
    pub covariance: Matrix3<f64>,
    /// v: the way to the cameras that measured it; `None` where it is not known.
    pub towards_cameras: Option<Vector3<f64>>,
}

/// A point of which the variance along one direction is this many times that along any other was measured from that direction:
/// by cameras whose lines of sight meet at less than about 50°.
const ELONGATED: f64 = 4.0;
/// Cosine of the angle, 15°, by which a camera may be off that direction.
const ALONG: f64 = 0.966;

impl SurfacePoint {
    /// A point with the same standard deviation in all directions, metres.
    pub fn isotropic(position_world: Point3<f64>, sigma_m: f64) -> Self {
        let covariance = Matrix3::from_diagonal_element(sigma_m * sigma_m);
        Self { position_world, covariance, towards_cameras: None }
    }

    /// The same point with v, which its covariance tells: depth is what cameras side by side are least sure of. Of two opposite
    /// ways it is that to the camera that is nearest to the line.
    pub fn seen_by(mut self, rig: &Rig) -> Self {
        let spread = self.covariance.symmetric_eigen();
        let widest = spread.eigenvalues.imax();
        let others = (0..3).filter(|k| *k != widest).map(|k| spread.eigenvalues[k]);
        let is_elongated = others.fold(0.0, f64::max) * ELONGATED < spread.eigenvalues[widest];

        let depth = spread.eigenvectors.column(widest).into_owned();
        let ways = rig.cameras.iter().filter_map(|camera| {
            (camera.centre_world() - self.position_world).try_normalize(f64::MIN_POSITIVE)
        });
        let cosines = ways.map(|way| way.dot(&depth));
        let nearest = cosines.max_by(|a, b| a.abs().total_cmp(&b.abs()));
        let cosine = nearest.filter(|cosine| is_elongated && cosine.abs() > ALONG);
        self.towards_cameras = cosine.map(|cosine| depth * cosine.signum());
        self
    }

    /// Whether a place of a surface that faces this way can be seen by the cameras that measured the point.
    pub fn may_face(&self, normal_world: &Vector3<f64>) -> bool {
        self.towards_cameras.is_none_or(|v| v.dot(normal_world) > 0.0)
    }

    /// Root mean square of its error along a direction, over all directions, metres.
    pub fn mean_sigma_m(&self) -> f64 {
        (self.covariance.trace() / 3.0).sqrt()
    }
}

impl From<&CloudPoint> for SurfacePoint {
    fn from(point: &CloudPoint) -> Self {
        let CloudPoint { position_world, spread } = *point;
        match spread {
            Spread::Unknown => Self::isotropic(position_world, 0.0),
            Spread::Isotropic(sigma_m) => Self::isotropic(position_world, sigma_m),
            Spread::Full(covariance) => Self { position_world, covariance, towards_cameras: None },
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::camera::{Camera, Distortion, Intrinsics};
    use crate::math::Rigid3;

    /// A camera at a place; it looks along Z.
    fn camera(x: f64, z: f64) -> Camera {
        Camera {
            name: "a".into(),
            width_px: 64,
            height_px: 48,
            intrinsics: Intrinsics {
                fx_px: 60.0,
                fy_px: 60.0,
                cx_px: 32.0,
                cy_px: 24.0,
                skew_px: 0.0,
            },
            distortion: Distortion::None,
            camera_from_world: Rigid3::translation(-x, 0.0, -z),
        }
    }

    #[test]
    fn an_elongated_covariance_tells_from_where_a_point_was_seen() {
        let rig = Rig { cameras: vec![camera(0.1, -2.0), camera(-0.1, -2.0), camera(2.0, 0.0)] };
        let of = |variances| SurfacePoint {
            position_world: Point3::origin(),
            covariance: Matrix3::from_diagonal(&variances),
            towards_cameras: None,
        };
        let seen = of(Vector3::new(1e-6, 1e-6, 1e-4)).seen_by(&rig);
        approx::assert_relative_eq!(seen.towards_cameras.unwrap(), -Vector3::z());
        assert!(seen.may_face(&Vector3::new(0.6, 0.0, -0.8)));
        assert!(!seen.may_face(&Vector3::new(0.6, 0.0, 0.8)));

        // as sure in depth as across it, or along a line on which no camera stands: any side
        for variances in [Vector3::repeat(1e-4), Vector3::new(1e-6, 1e-4, 1e-6)] {
            let seen = of(variances).seen_by(&rig);
            assert_eq!(seen.towards_cameras, None);
            assert!(seen.may_face(&Vector3::z()));
        }
    }
}
