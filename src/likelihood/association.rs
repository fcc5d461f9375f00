//! Which limb and which part a datum belongs to (PFD99 § 3.3).
//!
//! The limb whose field is largest at a point changes while a body is fitted: a point of the forearm may be pulled by the
//! trunk as long as the arm is not in its place. PFD99 assign every point to a limb at the start, and again after some
//! iterations.

use nalgebra::Point3;

use crate::body::metaball::{Field, FieldSample, Sampler};
use crate::body::{PartId, Posed};

/// The limb and the part of one point.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Association {
    /// The limb whose field is largest: index in [`BodyModel::limbs`](crate::body::BodyModel::limbs).
    pub limb: usize,
    /// The part of the metaball of largest weight.
    pub part: PartId,
}

/// Limb and part of every point; empty for a body without metaballs.
pub fn associate(
    body: &Posed<'_>,
    points_world: impl IntoIterator<Item = Point3<f64>>,
) -> Vec<Association> {
    let field = Field::from_body(body);
    let mut sampler = Sampler::new(&field);
    let mut sample = FieldSample::default();
    let association = |point: Point3<f64>| {
        sampler.sample(&point.coords, None, &mut sample);
        let primitive = field.source(sample.heaviest()?)?;
        Some(Association { limb: sample.limb, part: body.model.metaballs[primitive].part })
    };
    points_world.into_iter().filter_map(association).collect()
}
