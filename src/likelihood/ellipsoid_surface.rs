//! Where lines of sight touch the ellipsoids of a posed body, and how far the person's surface lies outside there.

use nalgebra::{Matrix3, Point3, Vector3};

use crate::body::{Offset, PartId, Posed};
use crate::camera::Ray;
use crate::math::quadric::Ellipsoid;

/// The ellipsoids of a posed body, ready for lines of sight.
pub(super) struct EllipsoidSurface<'a> {
    body: &'a Posed<'a>,
    /// Centre and A⁻¹ of each.
    inverses: Vec<(Vector3<f64>, Matrix3<f64>)>,
}

impl<'a> EllipsoidSurface<'a> {
    pub(super) fn new(body: &'a Posed<'a>, ellipsoids: &[Ellipsoid]) -> Self {
        let inverse = |e: &Ellipsoid| {
            let inverse = e.shape.cholesky().map(|c| c.inverse());
            (e.centre, inverse.unwrap_or_else(Matrix3::identity))
        };
        Self { body, inverses: ellipsoids.iter().map(inverse).collect() }
    }

    /// The part of an ellipsoid, and in its axes the point of a ray that is nearest to the ellipsoid's centre in the
    /// ellipsoid's own measure.
    pub(super) fn contact(&self, index: usize, ray: &Ray) -> (PartId, Vector3<f64>) {
        let part = self.body.model.ellipsoids[index].part;
        (part, self.body.in_part(part, &self.touched(index, ray)))
    }

    fn touched(&self, index: usize, ray: &Ray) -> Point3<f64> {
        let (centre, inverse) = &self.inverses[index];
        let pull = inverse * ray.direction_world.into_inner();
        let offset = centre - ray.origin_world.coords;
        ray.point_at(offset.dot(&pull) / ray.direction_world.dot(&pull))
    }

    /// b where a ray touches an ellipsoid; `None` for a model without offsets.
    pub(super) fn offset(&self, index: usize, ray: &Ray) -> Option<Offset> {
        let ellipsoid = &self.body.model.ellipsoids[index];
        let from_centre = self.touched(index, ray).coords - self.inverses[index].0;
        self.body.surface_offset(ellipsoid.part, &self.body.home(ellipsoid, &from_centre))
    }
}
