//! Kinematics: model, shape and motion make a posed body (PFD99 eq. 2–3).

use nalgebra::{Matrix3, Point3, Rotation3, Vector3};

use super::{BodyModel, FrameId, Motion, PartId, Primitive, ScaledVector, Shape};
use crate::math::quadric::Ellipsoid;

/// Radius of the skin of one metaball over its own: exp(−2d) = ½ at √d = √(½ ln 2).
const SKIN_OF_ONE: f64 = 0.588_705;

/// The frame of a joint or of the root in the world.
#[derive(Debug, Clone, Copy)]
pub(super) struct Frame {
    pub(super) world_from_frame: Matrix3<f64>,
    pub(super) origin_world: Vector3<f64>,
}

/// A body in one pose. Computed once per evaluation; every term reads it.
#[derive(Debug, Clone)]
pub struct Posed<'a> {
    /// The model.
    pub model: &'a BodyModel,
    pub(super) shape: &'a Shape,
    /// By [`FrameId`](super::FrameId).
    pub(super) frames: Vec<Frame>,
    /// For each frame, how it turns in the world when the angle of its joint grows by one; zero for the root's.
    pub(super) turns_world: Vec<Vector3<f64>>,
}

impl<'a> Posed<'a> {
    /// Poses a body: one loop over the frames, parents first.
    ///
    /// world_from_frame = world_from_parent · Trans(t(s)) · D_ini · Rot(axis, share · θ).
    pub fn new(model: &'a BodyModel, shape: &'a Shape, motion: &Motion) -> Self {
        debug_assert_eq!(shape.0.len(), model.coefficients.len(), "a shape of another model");
        let mut frames: Vec<Frame> = Vec::with_capacity(model.frames());
        let mut turns_world = vec![Vector3::zeros()];
        frames.push(Frame {
            world_from_frame: motion.world_from_root.into_inner(),
            origin_world: motion.position_world,
        });

        for turn in (1..model.frames()).filter_map(|i| model.turn(FrameId(i))) {
            let joint = &model.joints[turn.joint.0];
            let parent = frames[turn.parent.0];
            let translation = joint.translation.at(shape);
            let world_from_static = parent.world_from_frame * joint.parent_from_joint.matrix();
            let angle = turn.share * motion.angles[turn.joint.0];
            let turned = Rotation3::from_axis_angle(&joint.axis, angle);

            turns_world.push(world_from_static * (joint.axis.into_inner() * turn.share));
            frames.push(Frame {
                world_from_frame: world_from_static * turned.matrix(),
                origin_world: parent.origin_world + parent.world_from_frame * translation,
            });
        }

        Self { model, shape, frames, turns_world }
    }

    /// s of this body.
    pub fn shape(&self) -> &Shape {
        self.shape
    }

    pub(super) fn frame(&self, part: PartId) -> &Frame {
        &self.frames[FrameId::from_joint(self.model.parts[part.0].joint).0]
    }

    /// Where the root is in the world.
    pub fn root_world(&self) -> Vector3<f64> {
        self.frames[0].origin_world
    }

    /// Where the joint of a part is in the world.
    pub fn origin_of_part(&self, part: PartId) -> Point3<f64> {
        Point3::from(self.frame(part).origin_world)
    }

    /// Orientation of a part in the world: its axes as columns.
    pub fn world_from_part(&self, part: PartId) -> Matrix3<f64> {
        self.frame(part).world_from_frame
    }

    /// A point fixed to a part, in the world.
    pub fn point(&self, part: PartId, place: &ScaledVector) -> Point3<f64> {
        let frame = self.frame(part);
        Point3::from(frame.origin_world + frame.world_from_frame * place.at(self.shape))
    }

    /// A point of the world in the frame of a part.
    pub fn in_part(&self, part: PartId, point_world: &Point3<f64>) -> Vector3<f64> {
        let frame = self.frame(part);
        frame.world_from_frame.tr_mul(&(point_world.coords - frame.origin_world))
    }

    /// All exported points in the world, in the order of [`BodyModel::points`].
    pub fn points(&self) -> Vec<Point3<f64>> {
        self.model.points.iter().map(|point| self.named_point(point)).collect()
    }

    /// A primitive as an ellipsoid in the world.
    pub fn primitive(&self, primitive: &Primitive) -> Ellipsoid {
        let frame = &self.frames[primitive.frame.0];
        let (axes, radii) = (self.primitive_axes(primitive), self.primitive_radii(primitive));
        let squared = Matrix3::from_diagonal(&radii.component_mul(&radii));
        Ellipsoid {
            centre: frame.origin_world + frame.world_from_frame * primitive.centre.at(self.shape),
            shape: axes * squared * axes.transpose(),
        }
    }

    /// The box around the body's ellipsoids, or if it has none, around the skins that its metaballs would have alone.
    ///
    /// Least and greatest x, y, z in the world, metres; `None` for a body with neither.
    pub fn bounds(&self) -> Option<(Vector3<f64>, Vector3<f64>)> {
        let (primitives, size) = self.solids();
        let boxes = primitives.iter().map(|p| {
            let e = self.primitive(p);
            let half = e.shape.diagonal().map(f64::sqrt) * size;
            (e.centre - half, e.centre + half)
        });
        boxes.reduce(|a, b| (a.0.inf(&b.0), a.1.sup(&b.1)))
    }

    /// The ellipsoids, or where there are none, the metaballs, and by how much smaller their skins are.
    pub(super) fn solids(&self) -> (&[Primitive], f64) {
        match self.model.ellipsoids.as_slice() {
            [] => (&self.model.metaballs, SKIN_OF_ONE),
            ellipsoids => (ellipsoids, 1.0),
        }
    }

    /// Unit axes of a primitive in the world, as columns.
    pub fn primitive_axes(&self, primitive: &Primitive) -> Matrix3<f64> {
        self.frames[primitive.frame.0].world_from_frame * primitive.part_from_primitive.matrix()
    }

    /// Radii of a primitive along its axes, metres.
    pub fn primitive_radii(&self, primitive: &Primitive) -> Vector3<f64> {
        primitive.radii.at(self.shape)
    }

    /// The model's ellipsoids in the world.
    pub fn ellipsoids(&self) -> Vec<Ellipsoid> {
        self.model.ellipsoids.iter().map(|e| self.primitive(e)).collect()
    }
}
