//! Where in a person's flesh the joints lie.
//!
//! Persons of the same flesh differ in that. At angles 0 let a part's own joint be at o and the next part's at e. If they lie δ and δ′ elsewhere in the flesh, the bone between them is no longer e − o but
//!
//! ```text
//! b = e + δ′ − o − δ
//! ```
//!
//! Angles are those of the bones, so a part's axes turn with its bone: by Q, the least rotation that takes e − o to b (1
//! for a part without a bone, as pelvis, head and foot). In the part's axes, flesh that was at x is then at Qᵀ(x − δ), and a joint
//! that the part carries at Qᵀ(x + δ′ − δ). Every part keeps its flesh as it is; its bone is longer or shorter and lies
//! elsewhere in it, by the same in every frame.

use nalgebra::{DVector, Rotation3, Vector3};
use rand::Rng;
use rand_distr::{Distribution, StandardNormal};

use crate::body::{BodyModel, Motion, NamedPoint, Part, PartId, Posed, Shape};

/// The person of this shape with the joints and exported points elsewhere in the flesh, each by a δ from a normal distribution;
/// a model for this shape alone.
///
/// `published` has parts and points of the same names, with the standard deviations of δ along the axes of their parts
/// ([`BodyModel::scatter_m`], [`NamedPoint::sd_m`](crate::body::NamedPoint::sd_m), metres); what it does not name stays. The δ
/// of the two sides are mirror images, others are independent.
pub fn draw_centres(
    model: &BodyModel,
    shape: &Shape,
    published: &BodyModel,
    rng: &mut impl Rng,
) -> BodyModel {
    let angles = DVector::zeros(model.joints.len());
    let straight = Motion {
        angles,
        ..Motion::rest(model)
    };
    let straight = Posed::new(model, shape, &straight);
    let moved = draw(&straight, published, rng);
    let flesh: Vec<Flesh> = turned(&straight, &moved);
    let in_world = |part: usize| straight.world_from_part(PartId(part));
    let mut person = model.clone();
    for (part, parent) in model.part_parents().into_iter().enumerate() {
        let Some(parent) = parent else { continue };
        let Some(&joint) = model.own_joints(part, Some(parent)).first() else {
            continue;
        };
        let translation = &mut person.joints[joint.0].translation;
        let centre = in_world(part) * flesh[part].centre;
        let carried = translation.at(shape) + in_world(parent).tr_mul(&centre);
        translation.put(flesh[parent].in_bone(carried), shape);
    }
    for ball in &mut person.metaballs {
        let flesh = &flesh[ball.part.0];
        let centre = flesh.in_bone(ball.centre.at(shape));
        ball.centre.put(centre, shape);
        ball.part_from_primitive = flesh.turn.inverse() * ball.part_from_primitive;
    }
    for (point, moved) in person.points.iter_mut().zip(&moved[model.parts.len()..]) {
        // own centres and their midpoints are where their parts are
        let places = point.places.iter_mut();
        for (part, at) in places.filter(|(_, at)| at.value != Vector3::zeros()) {
            let place = at.at(shape) + in_world(part.0).tr_mul(moved);
            at.put(flesh[part.0].in_bone(place), shape);
        }
    }
    person
}

/// δ of every part's joint, then of every exported point, in the world.
fn draw(straight: &Posed<'_>, published: &BodyModel, rng: &mut impl Rng) -> Vec<Vector3<f64>> {
    let model = straight.model;
    let of_part = |part: &Part| {
        let known = published.parts.iter().position(|p| p.name == part.name)?;
        Some(published.scatter_m(PartId(known)))
    };
    let of_point = |point: &NamedPoint| Some(published.points[published.point(&point.name)?].sd_m);
    let scatter = model.parts.iter().map(of_part);
    let scatter = scatter.chain(model.points.iter().map(of_point));
    let mut along = |sd: f64| {
        let z: f64 = StandardNormal.sample(rng);
        sd * z
    };
    let mut drawn: Vec<Vector3<f64>> = scatter
        .map(|sd| sd.unwrap_or_default().map(&mut along))
        .collect();
    let point = |index: usize| model.parts.len() + index;
    let points = model.point_pairs().into_iter();
    let points = points.map(|(right, left)| (point(right), point(left)));
    for (right, left) in model.part_pairs().into_iter().chain(points) {
        drawn[left] = drawn[right].component_mul(&Vector3::new(1.0, -1.0, 1.0));
    }
    let parts = (0..model.parts.len()).map(PartId);
    let parts = parts.chain(model.points.iter().map(|point| point.places[0].0));
    let in_world = |(part, moved)| straight.world_from_part(part) * moved;
    parts.zip(drawn).map(in_world).collect()
}

/// How a part's flesh lies about its bone, in the part's axes.
struct Flesh {
    /// Q.
    turn: Rotation3<f64>,
    /// δ of its own joint.
    centre: Vector3<f64>,
}

impl Flesh {
    /// Qᵀ(x − δ).
    fn in_bone(&self, x: Vector3<f64>) -> Vector3<f64> {
        self.turn.inverse_transform_vector(&(x - self.centre))
    }
}

/// By part.
fn turned(straight: &Posed<'_>, moved: &[Vector3<f64>]) -> Vec<Flesh> {
    let model = straight.model;
    let bones = model.bones();
    let of_part = |part: usize| {
        let axes = straight.world_from_part(PartId(part));
        let along = bones[part].and_then(|end| {
            let old = straight.origin_of_part(end) - straight.origin_of_part(PartId(part));
            let new = old + moved[end.0] - moved[part];
            Rotation3::rotation_between(&axes.tr_mul(&old), &axes.tr_mul(&new))
        });
        Flesh {
            turn: along.unwrap_or_default(),
            centre: axes.tr_mul(&moved[part]),
        }
    };
    (0..model.parts.len()).map(of_part).collect()
}

#[cfg(test)]
mod tests {
    use std::path::Path;

    use rand::SeedableRng;
    use rand_chacha::ChaCha8Rng;

    use super::*;
    use crate::io::model;
    use crate::synth::draw_shape;

    /// (Q, δ) of a part from each of its balls.
    fn seen(old: &BodyModel, new: &BodyModel, part: usize, shape: &Shape) -> Vec<Flesh> {
        let balls = old.metaballs.iter().zip(&new.metaballs);
        let of_part = balls.filter(|(old, _)| old.part.0 == part);
        let flesh = of_part.map(|(old, new)| {
            let turn = old.part_from_primitive * new.part_from_primitive.inverse();
            Flesh {
                turn,
                centre: old.centre.at(shape) - turn * new.centre.at(shape),
            }
        });
        flesh.collect()
    }

    #[test]
    fn flesh_stays_rigid_bones_keep_their_axes_and_centres_scatter_as_published() {
        let load = |name| model::load(name, Path::new("")).unwrap();
        let (walker, published) = (load("walker-metaballs"), load("human-metaballs"));
        let mut rng = ChaCha8Rng::seed_from_u64(5);
        let part = |name: &str| walker.parts.iter().position(|p| p.name == name).unwrap();
        let (thigh, shank) = (part("thigh_r"), part("shank_r"));
        let knee = walker.joint("knee_flexion_r").unwrap().0;
        let sd = published
            .parts
            .iter()
            .position(|p| p.name == "thigh_r")
            .unwrap();
        let sd = published.scatter_m(PartId(sd));
        let (draws, mut squares) = (1000, Vector3::zeros());
        for _ in 0..draws {
            let shape = draw_shape(&walker, &mut rng);
            let person = draw_centres(&walker, &shape, &published, &mut rng);
            let [of_thigh, of_shank] = [thigh, shank].map(|p| seen(&walker, &person, p, &shape));
            for flesh in &of_thigh {
                assert!((flesh.centre - of_thigh[0].centre).norm() < 1e-12);
                assert!((flesh.turn.matrix() - of_thigh[0].turn.matrix()).norm() < 1e-12);
            }
            let [old, new] = [&walker, &person].map(|m| m.joints[knee].translation.at(&shape));
            assert!(old.cross(&new).norm() < 1e-12, "{old} {new}");
            let knee_in_flesh = of_thigh[0].turn * new + of_thigh[0].centre;
            assert!((knee_in_flesh - old - of_shank[0].centre).norm() < 1e-12);
            squares += of_thigh[0].centre.component_mul(&of_thigh[0].centre);
        }
        for k in 0..3 {
            // 5 standard errors of a variance
            let variance = squares[k] / f64::from(draws);
            let error = (variance / sd[k].powi(2) - 1.0).abs();
            assert!(
                error < 5.0 * (2.0 / f64::from(draws)).sqrt(),
                "{k}: {error}"
            );
        }
    }

    #[test]
    fn a_body_of_which_nothing_is_published_stays_as_it_is() {
        let walker = model::load("walker-metaballs", Path::new("")).unwrap();
        let mut rng = ChaCha8Rng::seed_from_u64(5);
        let shape = draw_shape(&walker, &mut rng);
        let same = draw_centres(&walker, &shape, &walker, &mut rng);
        let balls = walker.metaballs.iter().zip(&same.metaballs);
        for (old, new) in balls {
            assert!((old.centre.at(&shape) - new.centre.at(&shape)).norm() < 1e-12);
        }
    }
}
