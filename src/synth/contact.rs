//! Soles, and how the floor holds them.

use nalgebra::{Matrix3, Rotation3, Vector3};

use crate::body::{BodyModel, Motion, PartId, Posed, Primitive, ScaledVector, Shape};

/// A foot's part and the points of its skin that can touch the floor.
#[derive(Debug, Clone)]
pub(super) struct Foot {
    part: PartId,
    sole: Vec<ScaledVector>,
}

/// A sole's contact: a weight for each of its points; they sum to 1.
#[derive(Debug, Clone)]
pub(super) struct Contact {
    weights: Vec<f64>,
}

/// Points within this height of the lowest share the load, metres.
const SOFTNESS: f64 = 0.004;
/// Pitches of the foot for which the lowest point of each primitive is a point of the sole, degrees.
const PITCHES_DEG: [f64; 12] =
    [-80.0, -65.0, -50.0, -35.0, -25.0, -15.0, -7.0, 0.0, 7.0, 15.0, 25.0, 35.0];
/// The skin of a metaball alone, in its radii: √(½ ln 2).
const METABALL_SKIN: f64 = 0.588_705_011_257_737_4;

impl Foot {
    /// The foot whose part carries the named point; `None` if there is no such point, or the part has no primitives.
    pub(super) fn find(model: &BodyModel, shape: &Shape, toe: &str) -> Option<Self> {
        let (part, _) = model.points[model.point(toe)?].places[0];
        let rest = Motion::rest(model);
        let body = Posed::new(model, shape, &rest);
        let (primitives, skin) = match model.metaballs.is_empty() {
            true => (&model.ellipsoids, 1.0),
            false => (&model.metaballs, METABALL_SKIN),
        };
        let own = primitives.iter().filter(|p| p.part == part);
        let sole: Vec<_> = own.flat_map(|p| lowest_points(&body, p, skin)).collect();
        (!sole.is_empty()).then_some(Self { part, sole })
    }

    fn points(&self, body: &Posed<'_>) -> impl Iterator<Item = Vector3<f64>> {
        let place = |p: &ScaledVector| body.point(self.part, p).coords;
        self.sole.iter().map(place)
    }

    /// Where a level floor would touch the foot: wₖ ∝ exp(−(zₖ − min z)/softness).
    pub(super) fn contact(&self, body: &Posed<'_>) -> Contact {
        let heights: Vec<f64> = self.points(body).map(|p| p.z).collect();
        let lowest = heights.iter().copied().fold(f64::INFINITY, f64::min);
        let load = |z: &f64| (-(z - lowest) / SOFTNESS).exp();
        let total: f64 = heights.iter().map(load).sum();
        Contact { weights: heights.iter().map(|z| load(z) / total).collect() }
    }

    /// The loaded point of the foot, Σ wₖ xₖ.
    pub(super) fn loaded_point(&self, body: &Posed<'_>, contact: &Contact) -> Vector3<f64> {
        let weighted = self.points(body).zip(&contact.weights);
        weighted.map(|(point, w)| point * *w).sum()
    }
}

/// The lowest skin point of a primitive for each pitch of the foot, in the part's frame.
///
/// The lowest point of (x − c)ᵀA⁻¹(x − c) = k² against the unit vector "down" u is c + k A u/√(uᵀA u).
fn lowest_points(body: &Posed<'_>, primitive: &Primitive, skin: f64) -> Vec<ScaledVector> {
    let at = ScaledVector::fixed;
    let origin = body.point(primitive.part, &at(Vector3::zeros()));
    let axis = |k: usize| body.point(primitive.part, &at(Vector3::ith(k, 1.0))) - origin;
    let world_from_part = Matrix3::from_columns(&[axis(0), axis(1), axis(2)]);
    let ellipsoid = body.primitive(primitive);
    let lowest = |pitch_deg: &f64| {
        let pitch = Rotation3::from_axis_angle(&Vector3::y_axis(), pitch_deg.to_radians());
        let down = world_from_part * (pitch * -Vector3::z());
        let reach = ellipsoid.shape * down;
        let point = ellipsoid.centre + reach * (skin / reach.dot(&down).max(1e-12).sqrt());
        at(world_from_part.transpose() * (point - origin.coords))
    };
    PITCHES_DEG.iter().map(lowest).collect()
}

/// The right foot's share of the body's weight in the cycle of the right foot.
///
/// Rises during the first double support, 0–12 % of the cycle, is 1 to 50 %, and falls in the second, 50–62 %
/// (Perry & Burnfield 2010, ch. 2). The left foot has the rest.
pub(super) fn right_load(phase: f64) -> f64 {
    const DOUBLE_SUPPORT: f64 = 0.12;
    let phase = phase.rem_euclid(1.0);
    let rise = |p: f64| {
        let x = (p / DOUBLE_SUPPORT).clamp(0.0, 1.0);
        x * x * (3.0 - 2.0 * x)
    };
    if phase < 0.5 { rise(phase) } else { 1.0 - rise(phase - 0.5) }
}

#[cfg(test)]
mod tests {
    use std::path::Path;

    use super::*;
    use crate::io::model;

    #[test]
    fn the_feet_share_the_weight() {
        for percent in 0..100 {
            let phase = f64::from(percent) / 100.0;
            approx::assert_relative_eq!(
                right_load(phase) + right_load(phase + 0.5),
                1.0,
                epsilon = 1e-12
            );
        }
        approx::assert_relative_eq!(right_load(0.3), 1.0);
    }

    #[test]
    fn the_loaded_point_of_a_foot_at_rest_is_the_lowest_of_its_ellipsoids() {
        let model = model::load("human-ellipsoids", Path::new("")).unwrap();
        let shape = Shape(model.statistics.mean.clone());
        let rest = Motion::rest(&model);
        let body = Posed::new(&model, &shape, &rest);
        let foot = Foot::find(&model, &shape, "RBigToe").unwrap();
        let loaded = foot.loaded_point(&body, &foot.contact(&body));
        let on_foot = model.ellipsoids.iter().filter(|e| e.part == foot.part);
        let bottom = on_foot
            .map(|e| body.primitive(e))
            .map(|e| e.centre.z - e.shape[(2, 2)].sqrt())
            .fold(f64::INFINITY, f64::min);
        assert!((0.0..0.005).contains(&(loaded.z - bottom)), "{} {bottom}", loaded.z);
    }
}
