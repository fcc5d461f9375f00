//! Where a pixel of the template is seen in the other images, by its inverse depth.

use nalgebra::{Matrix3, Point2, Point3, Vector2, Vector3};

use crate::camera::{Camera, Intrinsics};

/// From the template's image to another one.
///
/// A pixel p of the template at inverse depth w = 1/Z is seen at h ∝ H·p̃ + w·e, with H = K·R·K₀⁻¹ (points at
/// infinity), e = K·t, and R, t from the template's camera frame to the other's. h is linear in w, and on a plane w is
/// linear in p.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Epipolar {
    at_infinity: Matrix3<f64>,
    epipole: Vector3<f64>,
}

/// The image of a point.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct ImagePoint {
    /// u.
    pub(super) pixel: Point2<f64>,
    /// ∂u/∂w, px·m.
    pub(super) by_inverse_depth: Vector2<f64>,
}

impl Epipolar {
    pub(super) fn new(template: &Camera, other: &Camera) -> Self {
        let other_from_template = other.camera_from_world * template.camera_from_world.inverse();
        let rotation = other_from_template.rotation.to_rotation_matrix();
        let k = other.intrinsics.matrix();
        Self {
            at_infinity: k * rotation.matrix() * inverse(&template.intrinsics),
            epipole: k * other_from_template.translation.vector,
        }
    }

    /// H·p̃.
    #[inline]
    pub(super) fn direction(&self, pixel: &Point2<f64>) -> Vector3<f64> {
        self.at_infinity * pixel.to_homogeneous()
    }

    /// How H·p̃ changes by one pixel to the right and by one down.
    pub(super) fn steps(&self) -> [Vector3<f64>; 2] {
        [0, 1].map(|axis| self.at_infinity.column(axis).into_owned())
    }

    /// The image of the pixel with this [`Epipolar::direction`]; `None` behind the camera.
    #[inline]
    pub(super) fn image(&self, direction: &Vector3<f64>, inverse_depth: f64) -> Option<ImagePoint> {
        let h = direction + self.epipole * inverse_depth;
        // h is over the Z of the template: of cameras with parallel axes, its z is 1 at infinity
        (h.z > 1e-6).then(|| {
            let pixel = Point2::new(h.x / h.z, h.y / h.z);
            let by_inverse_depth = (self.epipole.xy() - pixel.coords * self.epipole.z) / h.z;
            ImagePoint { pixel, by_inverse_depth }
        })
    }
}

/// K⁻¹: normalised coordinates are affine in the pixel.
fn inverse(intrinsics: &Intrinsics) -> Matrix3<f64> {
    let normalized = |x, y| intrinsics.normalized(&Point2::new(x, y));
    let origin = normalized(0.0, 0.0);
    let columns = [normalized(1.0, 0.0) - origin, normalized(0.0, 1.0) - origin];
    let [a, b] = columns.map(|c| Vector3::new(c.x, c.y, 0.0));
    Matrix3::from_columns(&[a, b, Vector3::new(origin.x, origin.y, 1.0)])
}

/// The point that the template's pixel shows at an inverse depth.
pub(in crate::stereo) fn point_world(
    template: &Camera,
    pixel: &Point2<f64>,
    inverse_depth: f64,
) -> Point3<f64> {
    let normalized = template.intrinsics.normalized(pixel);
    let point_camera = Point3::new(normalized.x, normalized.y, 1.0) / inverse_depth;
    template.camera_from_world.inverse_transform_point(&point_camera)
}
