//! Uncertain places of joints in the flesh: coefficients that say where the joints lie.
//!
//! Cameras see flesh, not joints. Where in the flesh a joint lies is known to within [`Part::sd_m`](super::Part::sd_m), and where
//! an exported point lies, to within [`NamedPoint::sd_m`](super::NamedPoint::sd_m). The coefficients c are these places, each in
//! units of its standard deviation. Let the joint of a part lie δ away from where the model has it, in the flesh on both of its
//! sides, and the joint at the other end of its bone δ′ away. At angles 0 the bone L = e − o between them becomes L + δ′ − δ: it is
//! turned against the flesh by
//!
//! ω = L × (δ′ − δ)/‖L‖²
//!
//! (never about itself; ω is 0 for a part without a bone, such as pelvis, head and foot). Joint angles are those of the bones, so a
//! part's axes turn with its bone. In these axes, to first order in c and at fixed angles,
//!
//! | what               | without c | with c             | turned by |
//! |--------------------|-----------|--------------------|-----------|
//! | the part's flesh   | x      | x − δ − ω × x         | −ω               |
//! | a joint it carries | x      | x − δ − ω × x + its δ | –                |
//! | an exported point  | x      | x − δ − ω × x + its δ | –                |
//!
//! The displacements are shifts by further coefficients ([`Shift`]). An ellipsoid or metaball is shifted so, but not turned: at
//! one standard deviation ω is about 1°, which moves the end of a primitive of 20 cm by 2 mm. A joint or point on the left is
//! displaced as the mirror image of the right one, by (δx, −δy, δz); all others are independent.

use nalgebra::{DMatrix, Matrix3, Matrix3xX, Vector3};

use super::{BodyModel, CoefficientId, Motion, PartId, Posed, ScaledVector, Shape, Shift};

impl BodyModel {
    /// The body whose coefficients are s and then the places c of its joints and points, measured on the mean body.
    pub(super) fn with_places(&self) -> Self {
        let mean = Shape(self.statistics.mean.clone());
        let straight = Motion::straight(self);
        let straight = Posed::new(self, &mean, &straight);
        let moved = Displacements::new(&straight);

        let mut placed = self.clone();
        let unit = DMatrix::identity(moved.names.len(), moved.names.len());
        placed.add_coefficients(&moved.names, &unit);
        placed.add_shifts(&straight, &moved);
        placed
    }

    /// Adds coefficients of mean 0 and this covariance, independent of the others.
    pub(super) fn add_coefficients(&mut self, names: &[String], covariance: &DMatrix<f64>) {
        let first = self.coefficients.len();
        let all = first + names.len();
        self.coefficients.extend_from_slice(names);
        let statistics = &mut self.statistics;
        statistics.mean = statistics.mean.clone().resize_vertically(all, 0.0);
        statistics.covariance = statistics.covariance.clone().resize(all, all, 0.0);
        let mut added = statistics.covariance.view_mut((first, first), covariance.shape());
        added.copy_from(covariance);
    }

    /// Lets c shift joints, flesh and points.
    fn add_shifts(&mut self, straight: &Posed<'_>, moved: &Displacements) {
        let model = straight.model;
        let first = model.coefficients.len();
        let shifts = |directions: &PlaceSlopes| -> Vec<Shift> {
            let with_effect = directions.column_iter().enumerate();
            let with_effect = with_effect.filter(|(_, d)| d.amax() > 0.0);
            let shift = |(k, direction): (usize, _)| Shift {
                coefficient: CoefficientId(first + k),
                direction: Vector3::from(direction),
            };
            with_effect.map(shift).collect()
        };

        for (part, parent) in model.part_parents().into_iter().enumerate() {
            let joint = model.own_joints(part, parent).first().copied();
            let (Some(parent), Some(joint)) = (parent, joint) else {
                continue;
            };
            let translation = &mut self.joints[joint.0].translation;
            let own = in_part(straight, parent, &moved.world[part]);
            let carried = own + moved.flesh(parent, &translation.at(straight.shape));
            translation.shifts.extend(shifts(&carried));
        }

        let primitives = self.ellipsoids.iter_mut();
        for primitive in primitives.chain(&mut self.metaballs) {
            let flesh = moved.flesh(primitive.part.0, &primitive.centre.at(straight.shape));
            primitive.centre.shifts.extend(shifts(&flesh));
        }

        for (index, point) in self.points.iter_mut().enumerate() {
            // joint centres and their midpoints lie where their parts' joints lie
            let places = point.places.iter_mut();
            for (part, at) in places.filter(|(_, at)| at.value != Vector3::zeros()) {
                let own = &moved.world[model.parts.len() + index];
                let own = in_part(straight, part.0, own);
                let place = own + moved.flesh(part.0, &at.at(straight.shape));
                at.shifts.extend(shifts(&place));
            }
        }
    }
}

/// The derivative of a place or turn with respect to c, a column for each: metres or radians per standard deviation.
type PlaceSlopes = Matrix3xX<f64>;

/// How c moves joints and points, and turns bones against flesh, at angles 0.
pub(crate) struct Displacements {
    /// What each c is called, such as `shank place forward`.
    pub(crate) names: Vec<String>,
    /// ∂δ/∂c of every part's joint, then of every exported point, in the world.
    pub(crate) world: Vec<PlaceSlopes>,
    /// ∂δ/∂c of every part's joint, in the part's axes.
    centres: Vec<PlaceSlopes>,
    /// ∂ω/∂c of every part, in its axes.
    turns: Vec<PlaceSlopes>,
}

impl Displacements {
    pub(crate) fn new(straight: &Posed<'_>) -> Self {
        let model = straight.model;
        let (names, world) = displacements_world(straight);
        let count = names.len();

        // ω = L × (δ′ − δ)/‖L‖²
        let bones = model.bones();
        let turn = |part: usize| {
            let Some(end) = bones[part] else {
                return PlaceSlopes::zeros(count);
            };
            let along = straight.origin_of_part(end) - straight.origin_of_part(PartId(part));
            let scale = along.norm_squared().max(1e-12);
            let apart = &world[end.0] - &world[part];
            in_part(straight, part, &(along.cross_matrix() * apart / scale))
        };

        let parts = 0..model.parts.len();
        Self {
            names,
            turns: parts.clone().map(turn).collect(),
            centres: parts.map(|part| in_part(straight, part, &world[part])).collect(),
            world,
        }
    }

    /// −δ − ω × x of a part's flesh at x, in its axes.
    fn flesh(&self, part: usize, x: &Vector3<f64>) -> PlaceSlopes {
        x.cross_matrix() * &self.turns[part] - &self.centres[part]
    }
}

/// A displacement in the world, along the axes of a part.
fn in_part(straight: &Posed<'_>, part: usize, world: &PlaceSlopes) -> PlaceSlopes {
    straight.world_from_part(PartId(part)).transpose() * world
}

/// The names of the places, and ∂δ/∂c of every part's joint and then of every exported point, in the world.
fn displacements_world(straight: &Posed<'_>) -> (Vec<String>, Vec<PlaceSlopes>) {
    let all = joints_and_points(straight.model);
    let pairs = mirror_pairs(straight.model);
    let left_of = |right: usize| pairs.iter().find(|p| p.0 == right).map(|p| p.1);
    let is_left = |index: usize| pairs.iter().any(|p| p.1 == index);

    // one place for each uncertain axis; left ones follow the right ones
    let mut places = Vec::new();
    for (index, (_, sd_m)) in all.iter().enumerate().filter(|(i, _)| !is_left(*i)) {
        let axes = (0..3).filter(|&k| sd_m[k] > 0.0);
        places.extend(axes.map(|k| (index, Vector3::ith(k, sd_m[k]))));
    }

    let mut world = vec![PlaceSlopes::zeros(places.len()); all.len()];
    let mirror = Matrix3::from_diagonal(&Vector3::new(1.0, -1.0, 1.0));
    let axes = |index: usize| straight.world_from_part(all[index].0);
    for (column, (index, along)) in places.iter().enumerate() {
        world[*index].set_column(column, &(axes(*index) * along));
        if let Some(left) = left_of(*index) {
            world[left].set_column(column, &(axes(left) * mirror * along));
        }
    }
    let names = places.iter().map(|(index, along)| place_name(straight.model, *index, along));
    (names.collect(), world)
}

/// Such as `shank place forward`, without the side.
fn place_name(model: &BodyModel, index: usize, along: &Vector3<f64>) -> String {
    let name = match index.checked_sub(model.parts.len()) {
        None => model.parts[index].name.trim_end_matches("_r"),
        Some(point) => model.points[point].name.trim_start_matches('R'),
    };
    format!("{name} place {}", ["forward", "left", "up"][along.iamax()])
}

/// The part of every part's joint and then of every exported point, and the standard deviations of its place.
fn joints_and_points(model: &BodyModel) -> Vec<(PartId, Vector3<f64>)> {
    let joints = model.parts.iter().enumerate();
    let joints = joints.map(|(i, part)| (PartId(i), part.sd_m));

    // a joint's centre has its part's place, all other points have places of their own
    let points = model.points.iter().map(|point| {
        let (part, _) = point.places[0];
        let is_centre = |(_, at): &(PartId, ScaledVector)| at.value == Vector3::zeros();
        match point.places.iter().all(is_centre) {
            true => (part, Vector3::zeros()),
            false => (part, point.sd_m),
        }
    });
    joints.chain(points).collect()
}

/// (right, left) among the joints of all parts and then the exported points.
fn mirror_pairs(model: &BodyModel) -> Vec<(usize, usize)> {
    let after_parts = |(right, left)| (model.parts.len() + right, model.parts.len() + left);
    let points = model.point_pairs().into_iter().map(after_parts);
    model.part_pairs().into_iter().chain(points).collect()
}
