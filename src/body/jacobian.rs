//! Derivatives of points and ellipsoids with respect to motion and shape.
//!
//! A component of the state turns a part about an axis ω through o, moves it, or stretches it:
//! - rotation: ∂c = ω × (c − o), ∂A = \[ω\]A + (\[ω\]A)ᵀ. Joint j: ω its axis, o its origin; the root's
//!   rotation R·exp(δ): ω the root's own axes, o its origin (PF02 eq. A.3, the cross-product form);
//! - coefficient: ∂c = Σ over the translations t up the chain of R·∂t/∂s, and R·∂(centre)/∂s;
//!   ∂A = R·diag(2·aᵢ·∂aᵢ/∂s)·Rᵀ.

use nalgebra::{Const, DMatrix, Dyn, Matrix3, OMatrix, Vector3};

use super::{
    BodyModel, FrameId, Layout, NamedPoint, PartId, PointSlopes, Posed, Primitive, ScaledVector,
};
use crate::math::quadric::Ellipsoid;

/// 9 × any number of columns.
pub(crate) type Matrix9xX = OMatrix<f64, Const<9>, Dyn>;

/// ∂(9 numbers of each ellipsoid)/∂(state), for the components that move it.
#[derive(Debug, Clone)]
pub struct EllipsoidJacobians {
    /// For each ellipsoid, which components of the state move it, ascending.
    pub components: Vec<Vec<usize>>,
    /// For each ellipsoid, 9 × number of its components.
    pub values: Vec<Matrix9xX>,
}

impl EllipsoidJacobians {
    /// Memory for a model's ellipsoids, to be filled by [`EllipsoidJacobians::update`].
    pub fn new(model: &BodyModel) -> Self {
        let layout = Layout::new(model);
        let components: Vec<_> =
            model.ellipsoids.iter().map(|e| components(model, layout, e)).collect();
        let values = components.iter().map(|c| Matrix9xX::zeros(c.len())).collect();
        Self { components, values }
    }

    /// Fills the values at a pose.
    pub fn update(&mut self, body: &Posed<'_>, ellipsoids: &[Ellipsoid]) {
        let layout = Layout::new(body.model);
        let all = body
            .model
            .ellipsoids
            .iter()
            .zip(ellipsoids)
            .zip(&self.components)
            .zip(&mut self.values);
        for (((primitive, ellipsoid), components), values) in all {
            values.fill(0.0);
            fill(body, layout, primitive, ellipsoid, components, values);
        }
    }
}

/// The components of the state that move a primitive, ascending.
fn components(model: &BodyModel, layout: Layout, primitive: &Primitive) -> Vec<usize> {
    let joints: Vec<_> = model.path(primitive.frame).map(|(_, t)| t.joint).collect();
    let translations = joints.iter().map(|j| &model.joints[j.0].translation);
    let mut list: Vec<usize> =
        (0..layout.root()).chain(joints.iter().map(|&j| layout.angle(j))).collect();

    let lengths = translations.chain([&primitive.centre, &primitive.radii]);
    let coefficients = lengths.flat_map(|v| v.coefficients());
    list.extend(coefficients.map(|c| layout.coefficient(c)));

    list.sort_unstable();
    list.dedup();
    list
}

/// Adds the derivatives of one ellipsoid to `values`, 9 × `components`.
fn fill(
    body: &Posed<'_>,
    layout: Layout,
    primitive: &Primitive,
    ellipsoid: &Ellipsoid,
    components: &[usize],
    values: &mut Matrix9xX,
) {
    let column = |component: usize| components.binary_search(&component).unwrap_or(usize::MAX);

    point_columns(body, layout, primitive.frame, &primitive.centre, |component, d| {
        let c = column(component);
        (0..3).for_each(|k| values[(k, c)] += d[k]);
    });

    // how the shape matrix turns
    let mut turn = |component: usize, axis: Vector3<f64>| {
        let half = axis.cross_matrix() * ellipsoid.shape;
        add_shape(values, column(component), &(half + half.transpose()));
    };
    if layout.root() == 6 {
        let root = body.frames[0].world_from_frame;
        (0..3).for_each(|k| turn(3 + k, root.column(k).into_owned()));
    }
    for (frame, by) in body.model.path(primitive.frame) {
        turn(layout.angle(by.joint), body.turns_world[frame.0]);
    }

    // how it stretches
    let (axes, radii) = (body.primitive_axes(primitive), body.primitive_radii(primitive));
    for (coefficient, slope) in primitive.radii.slopes(body.shape()) {
        let stretch = Matrix3::from_diagonal(&(2.0 * radii.component_mul(&slope)));
        let d = axes * stretch * axes.transpose();
        add_shape(values, column(layout.coefficient(coefficient)), &d);
    }
}

fn add_shape(values: &mut Matrix9xX, column: usize, d: &Matrix3<f64>) {
    for (i, (r, s)) in Ellipsoid::INDEX.into_iter().enumerate() {
        values[(3 + i, column)] += d[(r, s)];
    }
}

/// Calls `add(component, ∂point)` for every component of the state that moves a point of a frame.
pub(super) fn point_columns(
    body: &Posed<'_>,
    layout: Layout,
    frame: FrameId,
    place: &ScaledVector,
    mut add: impl FnMut(usize, Vector3<f64>),
) {
    let own = body.frames[frame.0];
    let point = own.origin_world + own.world_from_frame * place.at(body.shape());

    if layout.root() == 6 {
        let root = &body.frames[0];
        (0..3).for_each(|k| add(k, Vector3::ith(k, 1.0)));
        for k in 0..3 {
            add(3 + k, root.world_from_frame.column(k).cross(&(point - root.origin_world)));
        }
    }

    // each joint turns the point about its origin and carries it along a translation
    for (frame, by) in body.model.path(frame) {
        let arm = point - body.frames[frame.0].origin_world;
        add(layout.angle(by.joint), body.turns_world[frame.0].cross(&arm));
        let parent = body.frames[by.parent.0].world_from_frame;
        let translation = &body.model.joints[by.joint.0].translation;
        stretch_columns(body, layout, &parent, translation, &mut add);
    }

    stretch_columns(body, layout, &own.world_from_frame, place, &mut add);
}

/// Calls `add(component, ∂vector)` for every coefficient that stretches a vector of a frame.
pub(super) fn stretch_columns(
    body: &Posed<'_>,
    layout: Layout,
    world_from_frame: &Matrix3<f64>,
    vector: &ScaledVector,
    add: &mut impl FnMut(usize, Vector3<f64>),
) {
    for (coefficient, slope) in vector.slopes(body.shape()) {
        add(layout.coefficient(coefficient), world_from_frame * slope);
    }
}

impl Posed<'_> {
    /// ∂(rotation of a part)/∂(state) about the part's own axes, 3 × all components.
    pub fn rotation_jacobian(&self, part: PartId) -> DMatrix<f64> {
        let layout = Layout::new(self.model);
        let mut jacobian = DMatrix::zeros(3, layout.total());
        let part_from_world = self.world_from_part(part).transpose();
        let mut turn = |component: usize, axis_world: Vector3<f64>| {
            jacobian.set_column(component, &(part_from_world * axis_world));
        };

        if layout.root() == 6 {
            let root = self.frames[0].world_from_frame;
            (0..3).for_each(|k| turn(3 + k, root.column(k).into_owned()));
        }

        let frame = FrameId::from_joint(self.model.parts[part.0].joint);
        for (frame, by) in self.model.path(frame) {
            turn(layout.angle(by.joint), self.turns_world[frame.0]);
        }

        jacobian
    }

    /// ∂(exported point)/∂(state), 3 × all components.
    pub fn point_jacobian(&self, index: usize) -> DMatrix<f64> {
        self.named_point_jacobian(&self.model.points[index])
    }

    /// The same of a named point: its slopes, and 0 for all other components.
    pub(super) fn named_point_jacobian(&self, point: &NamedPoint) -> DMatrix<f64> {
        let mut slopes = PointSlopes::new();
        self.named_point_slopes(point, &mut slopes);
        let mut jacobian = DMatrix::zeros(3, Layout::new(self.model).total());
        slopes.iter().for_each(|(component, slope)| jacobian.set_column(*component, slope));
        jacobian
    }
}
