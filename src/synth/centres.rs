//! Where in a person's flesh the joints lie.
//!
//! Persons of the same flesh differ in that. At angles 0 let a part's own joint be at o and the next part's at e. If they
//! lie δ and δ′ elsewhere in the flesh, the bone between them is no longer e − o but
//!
//! ```text
//! b = e + δ′ − o − δ
//! ```
//!
//! Angles are those of the bones, so a part's axes turn with its bone: by Q, the least rotation that takes e − o to b (1
//! for a part without a bone, like pelvis, head and foot). In the part's axes, flesh that was at x is then at Qᵀ(x − δ), and
//! a joint that the part carries at Qᵀ(x + δ′ − δ). The flesh of every part stays the same. The bone in it is longer or shorter
//! and lies elsewhere, equally in every frame.

use nalgebra::{DVector, Rotation3, Vector3};
use rand::Rng;
use rand_distr::{Distribution, StandardNormal};

use crate::body::{BodyModel, Displacements, Motion, PartId, Posed, Shape};

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
    let mut model = model.clone();
    for part in &mut model.parts {
        let known = published.parts.iter().position(|p| p.name == part.name);
        part.sd_m = known.map_or(Vector3::zeros(), |known| published.scatter_m(PartId(known)));
    }
    for point in &mut model.points {
        let known = published.point(&point.name);
        point.sd_m = known.map_or(Vector3::zeros(), |known| published.points[known].sd_m);
    }
    let straight = Motion::straight(&model);
    let places = Displacements::new(&Posed::new(&model, shape, &straight)).names.len();
    let c = DVector::from_fn(places, |_, _| StandardNormal.sample(rng));
    move_centres(&model, shape, &c)
}

/// The person of this shape with the joints and exported points at the places c (standard normal, mirror images alike); a model for this shape alone.
pub fn move_centres(model: &BodyModel, shape: &Shape, c: &DVector<f64>) -> BodyModel {
    let straight = Motion::straight(model);
    let straight = Posed::new(model, shape, &straight);
    let places = Displacements::new(&straight).world;
    let moved: Vec<Vector3<f64>> = places.iter().map(|place| place * c).collect();
    let flesh = displaced_flesh(&straight, &moved);
    let in_world = |part: usize| straight.world_from_part(PartId(part));
    let mut person = model.clone();

    // joints, where their parent's flesh carries them
    for (part, parent) in model.part_parents().into_iter().enumerate() {
        let Some(parent) = parent else { continue };
        let Some(&joint) = model.own_joints(part, Some(parent)).first() else {
            continue;
        };
        let translation = &mut person.joints[joint.0].translation;
        let centre = in_world(part) * flesh[part].centre;
        let carried = translation.at(shape) + in_world(parent).tr_mul(&centre);
        translation.set_at(flesh[parent].in_bone(carried), shape);
    }

    // flesh, as its bone sees it
    for primitive in person.ellipsoids.iter_mut().chain(&mut person.metaballs) {
        let flesh = &flesh[primitive.part.0];
        let centre = flesh.in_bone(primitive.centre.at(shape));
        primitive.centre.set_at(centre, shape);
        primitive.part_from_primitive = flesh.turn.inverse() * primitive.part_from_primitive;
    }

    for (point, moved) in person.points.iter_mut().zip(&moved[model.parts.len()..]) {
        // own centres and their midpoints are where their parts are
        let places = point.places.iter_mut();
        for (part, at) in places.filter(|(_, at)| at.value != Vector3::zeros()) {
            let place = at.at(shape) + in_world(part.0).tr_mul(moved);
            at.set_at(flesh[part.0].in_bone(place), shape);
        }
    }
    person
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

/// The flesh of every part.
fn displaced_flesh(straight: &Posed<'_>, moved: &[Vector3<f64>]) -> Vec<Flesh> {
    let model = straight.model;
    let bones = model.bones();
    let flesh = |part: usize| {
        let axes = straight.world_from_part(PartId(part));
        let along = bones[part].and_then(|end| {
            let old = straight.origin_of_part(end) - straight.origin_of_part(PartId(part));
            let new = old + moved[end.0] - moved[part];
            Rotation3::rotation_between(&axes.tr_mul(&old), &axes.tr_mul(&new))
        });
        Flesh { turn: along.unwrap_or_default(), centre: axes.tr_mul(&moved[part]) }
    };
    (0..model.parts.len()).map(flesh).collect()
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
            Flesh { turn, centre: old.centre.at(shape) - turn * new.centre.at(shape) }
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
        let sd = published.parts.iter().position(|p| p.name == "thigh_r").unwrap();
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
            assert!(error < 5.0 * (2.0 / f64::from(draws)).sqrt(), "{k}: {error}");
        }
    }

    #[test]
    fn centres_that_move_a_little_are_the_shifts_of_the_detailed_body() {
        let model = model::load("human-metaballs", Path::new("")).unwrap();
        let detailed = model.detailed();
        let shape = Shape(model.statistics.mean.clone());
        let places = |name: &&String| name.contains(" place ");
        let count = detailed.coefficients.iter().filter(places).count();
        let c = DVector::from_fn(count, |k, _| 1e-4 * (3.0 * k as f64).sin());
        let mut motion = Motion::rest(&model);
        (motion.angles.iter_mut().enumerate()).for_each(|(k, a)| *a = 0.4 * (k as f64).cos());

        // exactly, and to first order
        let moved = move_centres(&model, &shape, &c);
        let exact = Posed::new(&moved, &shape, &motion);
        let mut all = Shape(detailed.statistics.mean.clone());
        all.0.rows_mut(shape.0.len(), count).copy_from(&c);
        let linear = Posed::new(&detailed, &all, &motion);
        let before = Posed::new(&model, &shape, &motion);

        let mut farthest: f64 = 0.0;
        for (point, (old, new)) in
            before.points().iter().zip(exact.points().iter().zip(linear.points()))
        {
            farthest = farthest.max((old - point).norm());
            assert!((old - new).norm() < 1e-8, "{point}");
        }
        let balls = model.metaballs.iter().zip(&moved.metaballs).zip(&detailed.metaballs);
        for ((ball, exactly), linearly) in balls {
            let [old, new] = [exact.primitive(exactly), linear.primitive(linearly)];
            let name = &model.parts[ball.part.0].name;
            assert!((old.centre - new.centre).norm() < 1e-8, "{name}");
        }
        assert!(farthest > 3e-7, "{farthest}: it moves at all");
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
