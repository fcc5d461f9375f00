//! Uncertain places of joints in the flesh: a body whose coefficients also say where its joints lie.
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
//! The displacements are shifts by further coefficients ([`Shift`]). The flesh is turned by three further joints about the axes x, y
//! and z through the part's origin, which carry nothing else; how c turns them, −∂ω/∂c, is the same in every pose. A joint or point
//! on the left is displaced as the mirror image of the right one, by (δx, −δy, δz); all others are independent.

use nalgebra::{DMatrix, Matrix3, Matrix3xX, Rotation3, Vector3};

use super::{
    BodyModel, CoefficientId, FrameId, Joint, JointId, Layout, Motion, PartId, Posed, ScaledVector,
    Shape, Shift, Turn,
};

/// A body whose coefficients are s and then the places c of joints and points, and whose last joints turn flesh against bones.
#[derive(Debug, Clone)]
pub struct PlacedBody {
    /// The body.
    pub model: BodyModel,
    /// What c does to the angles of the joints that turn flesh: −∂ω/∂c, rad per standard deviation.
    pub turns: DMatrix<f64>,
}

impl PlacedBody {
    /// Adds places to a body, linearised at a shape.
    pub fn new(model: &BodyModel, shape: &Shape) -> Self {
        let straight = Motion::straight(model);
        let straight = Posed::new(model, shape, &straight);
        let moved = Displacements::new(&straight);
        let mut placed = Self { model: model.clone(), turns: DMatrix::zeros(0, moved.count) };
        placed.add_coefficients(moved.count);
        placed.add_shifts(&straight, &moved);
        placed.add_turns(&moved);
        placed
    }

    /// Number of places.
    pub fn count(&self) -> usize {
        self.turns.ncols()
    }

    /// s with every place where the model has it: c = 0.
    pub fn shape(&self, shape: &Shape) -> Shape {
        let mut all = shape.0.clone().resize_vertically(self.model.coefficients.len(), 0.0);
        all.rows_mut(shape.0.len(), self.count()).fill(0.0);
        Shape(all)
    }

    /// A motion in which no flesh is turned against its bones.
    pub fn motion(&self, motion: &Motion) -> Motion {
        let angles = motion.angles.clone();
        Motion { angles: angles.resize_vertically(self.model.joints.len(), 0.0), ..motion.clone() }
    }

    fn add_coefficients(&mut self, count: usize) {
        let (first, model) = (self.model.coefficients.len(), &mut self.model);
        model.coefficients.extend((0..count).map(|k| format!("place {k}")));
        let statistics = &mut model.statistics;
        let all = first + count;
        statistics.mean = statistics.mean.clone().resize_vertically(all, 0.0);
        statistics.covariance = statistics.covariance.clone().resize(all, all, 0.0);
        // c is in standard deviations
        (first..all).for_each(|k| statistics.covariance[(k, k)] = 1.0);
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
            let translation = &mut self.model.joints[joint.0].translation;
            let own = in_part(straight, parent, &moved.world[part]);
            let carried = own + moved.flesh(parent, &translation.at(straight.shape));
            translation.shifts.extend(shifts(&carried));
        }

        let primitives = self.model.ellipsoids.iter_mut();
        for primitive in primitives.chain(&mut self.model.metaballs) {
            // −ω × x is left to the joints that turn the flesh about the part's origin
            let flesh = -&moved.centres[primitive.part.0];
            primitive.centre.shifts.extend(shifts(&flesh));
        }

        for (index, point) in self.model.points.iter_mut().enumerate() {
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

    /// Puts three joints between bone and flesh of each part that c turns.
    fn add_turns(&mut self, moved: &Displacements) {
        let turned = |part: &usize| moved.turns[*part].amax() > 0.0;
        let turned: Vec<usize> = (0..moved.turns.len()).filter(turned).collect();
        let (old, added) = (self.model.joints.len(), 3 * turned.len());
        self.turns = DMatrix::zeros(added, moved.count);

        // the frames of followers come after those of all joints
        let renumbered = |frame: FrameId| match frame.0 > old {
            true => FrameId(frame.0 + added),
            false => frame,
        };
        for turn in &mut self.model.followers {
            turn.parent = renumbered(turn.parent);
        }
        let model = &mut self.model;
        let primitives = model.ellipsoids.iter_mut().chain(&mut model.metaballs);
        for primitive in primitives {
            primitive.frame = renumbered(primitive.frame);
        }

        for (i, part) in turned.into_iter().enumerate() {
            let mut rows = self.turns.rows_mut(3 * i, 3);
            rows.copy_from(&-&moved.turns[part]);
            self.add_joints(PartId(part));
        }

        let added: Vec<JointId> = (old..old + added).map(JointId).collect();
        for joints in added.chunks(3) {
            self.carry_followers(joints);
        }
    }

    /// Adds joints about x, y and z through a part's origin, which carry its flesh unless that follows a joint by a share.
    fn add_joints(&mut self, part: PartId) {
        let model = &mut self.model;
        let before = FrameId::from_joint(model.parts[part.0].joint);
        let mut parent = model.parts[part.0].joint;

        for axis in [Vector3::x_axis(), Vector3::y_axis(), Vector3::z_axis()] {
            let name = format!("flesh {} of {}", model.joints.len(), model.parts[part.0].name);
            model.joints.push(Joint {
                name,
                parent,
                parent_from_joint: Rotation3::identity(),
                translation: ScaledVector::fixed(Vector3::zeros()),
                axis,
                limits: (-1.0, 1.0),
                rest: 0.0,
                spread: 1.0,
                speed: 1.0,
            });
            parent = Some(JointId(model.joints.len() - 1));
        }

        let primitives = model.ellipsoids.iter_mut().chain(&mut model.metaballs);
        for primitive in primitives.filter(|p| p.part == part && p.frame == before) {
            primitive.frame = FrameId::from_joint(parent);
        }
    }

    /// Lets the joints that turn a part's flesh also turn its flesh that follows a joint by a share.
    fn carry_followers(&mut self, joints: &[JointId]) {
        let model = &mut self.model;
        let Some(part) =
            model.parts.iter().position(|p| p.joint == model.joints[joints[0].0].parent)
        else {
            return;
        };

        // the frames of such flesh
        let own = FrameId::from_joint(joints.last().copied());
        let primitives = model.ellipsoids.iter().chain(&model.metaballs);
        let follow = primitives.filter(|p| p.part.0 == part && p.frame != own);
        let mut frames: Vec<FrameId> = follow.map(|p| p.frame).collect();
        frames.sort_unstable_by_key(|f| f.0);
        frames.dedup();

        for frame in frames {
            let mut parent = frame;
            for &joint in joints {
                let turn = Turn { parent, joint, share: 1.0 };
                parent = FrameId(model.frames());
                model.followers.push(turn);
            }

            let primitives = model.ellipsoids.iter_mut().chain(&mut model.metaballs);
            for primitive in primitives.filter(|p| p.part.0 == part && p.frame == frame) {
                primitive.frame = parent;
            }
        }
    }
}

/// The derivative of a place or turn with respect to c, a column for each: metres or radians per standard deviation.
type PlaceSlopes = Matrix3xX<f64>;

/// How c moves joints and points, and turns bones against flesh, at angles 0.
pub(crate) struct Displacements {
    /// Number of places.
    count: usize,
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
        let (count, world) = displacements_world(straight);

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
            count,
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

/// Number of places, and ∂δ/∂c of every part's joint and then of every exported point, in the world.
fn displacements_world(straight: &Posed<'_>) -> (usize, Vec<PlaceSlopes>) {
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
    (places.len(), world)
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

impl Layout {
    /// Which components of the body with places are those of this body: of its motion, then of s.
    pub fn components_in(self, placed: &PlacedBody) -> impl Iterator<Item = usize> + use<> {
        let shape = Layout::new(&placed.model).motion();
        let coefficients = self.total() - self.motion();
        (0..self.motion()).chain(shape..shape + coefficients)
    }
}
