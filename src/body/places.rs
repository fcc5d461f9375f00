//! Where else in the flesh the joints may lie: a body in which their places are coefficients.
//!
//! What is seen is flesh. Where in it a joint lies is known to [`Part::sd_m`](super::Part::sd_m), where an exported point lies to
//! [`NamedPoint::sd_m`](super::NamedPoint::sd_m); c are these places, each in its standard deviations. Let the joint of part p lie
//! δ from where the model has it, in the flesh of both its sides, and that of the part at the bone's end δ′. At angles 0 the bone
//! L = e − o between them is then L + δ′ − δ: against the flesh it is turned by
//!
//! ω = L × (δ′ − δ)/‖L‖²
//!
//! (not about itself; 0 of a part without a bone, as pelvis, head and foot). Angles are those of the bones, so a part's axes turn
//! with its bone. In them, to first order in c, at fixed angles,
//!
//! | what               | was at | is at                 | and is turned by |
//! |--------------------|--------|-----------------------|------------------|
//! | the part's flesh   | x      | x − δ − ω × x         | −ω               |
//! | a joint it carries | x      | x − δ − ω × x + its δ | –                |
//! | an exported point  | x      | x − δ − ω × x + its δ | –                |
//!
//! Displacements are shifts by further coefficients ([`Shift`]). Turns of the flesh are those of further joints x, y and z about the
//! part's origin that carry its flesh only; how c turns them, −∂ω/∂c, is the same in every pose. A joint or point on the left lies
//! as the mirror image of the right one: (δx, −δy, δz); others are independent.

use nalgebra::{DMatrix, Matrix3, Matrix3xX, Rotation3, Vector3};

use super::{
    BodyModel, CoefficientId, FrameId, Joint, JointId, Layout, Motion, PartId, Posed, ScaledVector,
    Shape, Shift, Turn,
};

/// A body with the places c of joints and points as coefficients after those of s, and joints that turn flesh after its own.
#[derive(Debug, Clone)]
pub struct PlacedBody {
    /// The body.
    pub model: BodyModel,
    /// What c does to the angles of the joints that turn flesh: −∂ω/∂c, rad per standard deviation.
    pub turns: DMatrix<f64>,
}

impl PlacedBody {
    /// The places about which a body of this shape is linear.
    pub fn new(model: &BodyModel, shape: &Shape) -> Self {
        let straight = Motion::straight(model);
        let straight = Posed::new(model, shape, &straight);
        let moved = Displacements::new(&straight);
        let mut placed = Self {
            model: model.clone(),
            turns: DMatrix::zeros(0, moved.count),
        };
        placed.add_coefficients(moved.count);
        placed.shift(&straight, &moved);
        placed.turn(&moved);
        placed
    }

    /// Number of places.
    pub fn count(&self) -> usize {
        self.turns.ncols()
    }

    /// s, and every place where the model has it.
    pub fn shape(&self, shape: &Shape) -> Shape {
        let mut all = shape
            .0
            .clone()
            .resize_vertically(self.model.coefficients.len(), 0.0);
        all.rows_mut(shape.0.len(), self.count()).fill(0.0);
        Shape(all)
    }

    /// A motion, and flesh that is not turned.
    pub fn motion(&self, motion: &Motion) -> Motion {
        let angles = motion.angles.clone();
        Motion {
            angles: angles.resize_vertically(self.model.joints.len(), 0.0),
            ..motion.clone()
        }
    }

    fn add_coefficients(&mut self, count: usize) {
        let (first, model) = (self.model.coefficients.len(), &mut self.model);
        model
            .coefficients
            .extend((0..count).map(|k| format!("place {k}")));
        let statistics = &mut model.statistics;
        let all = first + count;
        statistics.mean = statistics.mean.clone().resize_vertically(all, 0.0);
        statistics.covariance = statistics.covariance.clone().resize(all, all, 0.0);
        (first..all).for_each(|k| statistics.covariance[(k, k)] = 1.0);
    }

    /// Shifts joints, flesh and points.
    fn shift(&mut self, straight: &Posed<'_>, moved: &Displacements) {
        let model = straight.model;
        let first = model.coefficients.len();
        let shifts = |directions: &Place| -> Vec<Shift> {
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
            let own = moved.in_part(straight, parent, &moved.world[part]);
            let carried = own + moved.flesh(parent, &translation.at(straight.shape));
            translation.shifts.extend(shifts(&carried));
        }
        let primitives = self.model.ellipsoids.iter_mut();
        for primitive in primitives.chain(&mut self.model.metaballs) {
            // −ω × x is the turn's, about the part's origin
            let flesh = -&moved.centres[primitive.part.0];
            primitive.centre.shifts.extend(shifts(&flesh));
        }
        for (index, point) in self.model.points.iter_mut().enumerate() {
            // own centres and their midpoints are where their parts are
            let places = point.places.iter_mut();
            for (part, at) in places.filter(|(_, at)| at.value != Vector3::zeros()) {
                let own = &moved.world[model.parts.len() + index];
                let own = moved.in_part(straight, part.0, own);
                let place = own + moved.flesh(part.0, &at.at(straight.shape));
                at.shifts.extend(shifts(&place));
            }
        }
    }

    /// Puts three joints between the bones of each part that c turns and its flesh.
    fn turn(&mut self, moved: &Displacements) {
        let turned = |part: &usize| moved.turns[*part].amax() > 0.0;
        let turned: Vec<usize> = (0..moved.turns.len()).filter(turned).collect();
        let (old, added) = (self.model.joints.len(), 3 * turned.len());
        self.turns = DMatrix::zeros(added, moved.count);
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

    /// Joints x, y, z about a part's origin; its flesh, where it does not follow by a share, is theirs.
    fn add_joints(&mut self, part: PartId) {
        let model = &mut self.model;
        let before = FrameId::from_joint(model.parts[part.0].joint);
        let mut parent = model.parts[part.0].joint;
        for axis in [Vector3::x_axis(), Vector3::y_axis(), Vector3::z_axis()] {
            let name = format!(
                "flesh {} of {}",
                model.joints.len(),
                model.parts[part.0].name
            );
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

    /// Flesh of the same part that follows its joints by a share is turned as the rest of it.
    fn carry_followers(&mut self, joints: &[JointId]) {
        let model = &mut self.model;
        let Some(part) = model
            .parts
            .iter()
            .position(|p| p.joint == model.joints[joints[0].0].parent)
        else {
            return;
        };
        let own = FrameId::from_joint(joints.last().copied());
        let primitives = model.ellipsoids.iter().chain(&model.metaballs);
        let follow = primitives.filter(|p| p.part.0 == part && p.frame != own);
        let mut frames: Vec<FrameId> = follow.map(|p| p.frame).collect();
        frames.sort_unstable_by_key(|f| f.0);
        frames.dedup();
        for frame in frames {
            let mut parent = frame;
            for &joint in joints {
                let turn = Turn {
                    parent,
                    joint,
                    share: 1.0,
                };
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

/// What c does to a place, a column for each: metres per standard deviation.
type Place = Matrix3xX<f64>;

/// By what c moves joints and points, and turns bones, at angles 0.
pub(crate) struct Displacements {
    /// Number of places.
    count: usize,
    /// ∂δ/∂c of every part's joint, then of every exported point, in the world.
    pub(crate) world: Vec<Place>,
    /// ∂δ/∂c of every part's joint, in the part's axes.
    centres: Vec<Place>,
    /// ∂ω/∂c of every part, in its axes.
    turns: Vec<Place>,
}

impl Displacements {
    pub(crate) fn new(straight: &Posed<'_>) -> Self {
        let model = straight.model;
        let (count, world) = displaced(straight);
        let bones = model.bones();
        let in_axes =
            |part: usize, place: &Place| straight.world_from_part(PartId(part)).transpose() * place;
        let parts = 0..model.parts.len();
        let turn = |part: usize| {
            let Some(end) = bones[part] else {
                return Place::zeros(count);
            };
            let along = straight.origin_of_part(end) - straight.origin_of_part(PartId(part));
            let scale = along.norm_squared().max(1e-12);
            let apart = &world[end.0] - &world[part];
            in_axes(part, &(along.cross_matrix() * apart / scale))
        };
        Self {
            count,
            turns: parts.clone().map(turn).collect(),
            centres: parts.map(|part| in_axes(part, &world[part])).collect(),
            world,
        }
    }

    /// −δ − ω × x of a part's flesh at x, in its axes.
    fn flesh(&self, part: usize, x: &Vector3<f64>) -> Place {
        x.cross_matrix() * &self.turns[part] - &self.centres[part]
    }

    /// A displacement in the world along the axes of a part.
    fn in_part(&self, straight: &Posed<'_>, part: usize, world: &Place) -> Place {
        straight.world_from_part(PartId(part)).transpose() * world
    }
}

/// Number of places, and ∂δ/∂c of every part's joint and every exported point in the world.
fn displaced(straight: &Posed<'_>) -> (usize, Vec<Place>) {
    let model = straight.model;
    let parts = model
        .parts
        .iter()
        .enumerate()
        .map(|(i, p)| (PartId(i), p.sd_m));
    // own centres have their parts', all else lies by itself
    let points = model.points.iter().map(|point| {
        let by_itself = point
            .places
            .iter()
            .any(|(_, at)| at.value != Vector3::zeros());
        let sd_m = if by_itself {
            point.sd_m
        } else {
            Vector3::zeros()
        };
        (point.places[0].0, sd_m)
    });
    let all: Vec<(PartId, Vector3<f64>)> = parts.chain(points).collect();
    let pairs = model.point_pairs().into_iter();
    let pairs = pairs.map(|(right, left)| (model.parts.len() + right, model.parts.len() + left));
    let pairs: Vec<(usize, usize)> = model.part_pairs().into_iter().chain(pairs).collect();
    let twin = |right: usize| pairs.iter().find(|p| p.0 == right).map(|p| p.1);
    let is_left = |index: usize| pairs.iter().any(|p| p.1 == index);
    let mut places = Vec::new();
    for (right, (_, sd_m)) in all.iter().enumerate().filter(|(i, _)| !is_left(*i)) {
        let axes = (0..3).filter(|&k| sd_m[k] > 0.0);
        places.extend(axes.map(|k| (right, k, sd_m[k])));
    }
    let mut world = vec![Place::zeros(places.len()); all.len()];
    let mirror = Matrix3::from_diagonal(&Vector3::new(1.0, -1.0, 1.0));
    for (column, (right, k, sd)) in places.iter().enumerate() {
        let along = Vector3::ith(*k, *sd);
        let axes = |index: usize| straight.world_from_part(all[index].0);
        world[*right].set_column(column, &(axes(*right) * along));
        if let Some(left) = twin(*right) {
            world[left].set_column(column, &(axes(left) * mirror * along));
        }
    }
    (places.len(), world)
}

impl Layout {
    /// Where the components of a body stand among those of the same body with places: those of its motion, then of s.
    pub fn components_in(self, placed: &PlacedBody) -> impl Iterator<Item = usize> + use<> {
        let shape = Layout::new(&placed.model).motion();
        let coefficients = self.total() - self.motion();
        (0..self.motion()).chain(shape..shape + coefficients)
    }
}
