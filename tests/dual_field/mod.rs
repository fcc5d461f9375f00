//! The metaball field written anew in hyper-dual numbers: kinematics, ellipsoids and ln F, nothing shared.

use maquette::body::{BodyModel, FrameId, Layout, PartId, Root, Scale, ScaledVector, Shift, State};
use nalgebra::{Matrix3, Point3};
use num_dual::{DualNum, HyperDual64};

type Vector = [HyperDual64; 3];
type Matrix = [Vector; 3];

/// ln F of one limb at one point, to be differentiated.
pub(crate) struct DualField<'a> {
    model: &'a BodyModel,
    state: &'a State,
    point: [f64; 3],
    parts: Vec<PartId>,
}

impl<'a> DualField<'a> {
    pub(crate) fn new(
        model: &'a BodyModel,
        state: &'a State,
        point: &Point3<f64>,
        limb: usize,
    ) -> Self {
        Self { model, state, point: point.coords.into(), parts: model.limbs()[limb].clone() }
    }

    /// ln F with eps1 = ∂x_k and eps2 = ∂x_l.
    pub(crate) fn space_space(&self, k: usize, l: usize) -> HyperDual64 {
        let mut x = self.point.map(HyperDual64::from_re);
        x[k].eps1 = 1.0;
        x[l].eps2 = 1.0;
        self.log_value(x, usize::MAX)
    }

    /// ln F with eps1 = ∂x_k and eps2 = ∂δ_component.
    pub(crate) fn space_state(&self, k: usize, component: usize) -> HyperDual64 {
        let mut x = self.point.map(HyperDual64::from_re);
        x[k].eps1 = 1.0;
        self.log_value(x, component)
    }

    fn log_value(&self, x: Vector, component: usize) -> HyperDual64 {
        let (frames, shape) = self.kinematics(component);
        let mut distances = Vec::new();
        for ball in &self.model.metaballs {
            if !self.parts.contains(&ball.part) {
                continue;
            }
            let (turn, origin) = &frames[ball.frame.0];
            let centre = add(*origin, times(turn, scaled(&ball.centre, &shape)));
            let axes = product(turn, &constant(ball.part_from_primitive.matrix()));
            let radii = scaled(&ball.radii, &shape);
            let offset = sub(x, centre);
            let along = (0..3).map(|i| {
                let y = (0..3).map(|r| axes[r][i] * offset[r]).sum::<HyperDual64>() / radii[i];
                y * y
            });
            distances.push(along.sum::<HyperDual64>());
        }
        let least = distances.iter().map(|d| d.re).fold(f64::INFINITY, f64::min);
        let sum: HyperDual64 = distances.iter().map(|d| ((*d - least) * -2.0).exp()).sum();
        sum.ln() - 2.0 * least
    }

    /// Every frame's rotation and origin, and the shape, with eps2 in one component of the state.
    fn kinematics(&self, component: usize) -> (Vec<(Matrix, Vector)>, Vec<HyperDual64>) {
        let layout = Layout::new(self.model);
        let dual = |value: f64, index: usize| {
            let eps2 = f64::from(u8::from(index == component));
            HyperDual64::new(value, 0.0, eps2, 0.0)
        };
        let motion = &self.state.motion;
        let shape = self.state.shape.0.iter().enumerate();
        let shape: Vec<_> = shape.map(|(i, s)| dual(*s, layout.motion() + i)).collect();
        let mut turn = constant(motion.world_from_root.matrix());
        let mut origin = [0, 1, 2].map(|k| HyperDual64::from_re(motion.position_world[k]));
        if self.model.root != Root::Fixed {
            origin = [0, 1, 2].map(|k| dual(motion.position_world[k], k));
            // exp(δ) = I + [δ] to first order, and δ = 0
            let [a, b, c] = [3, 4, 5].map(|k| dual(0.0, k));
            let one = HyperDual64::from_re(1.0);
            turn = product(&turn, &[[one, -c, b], [c, one, -a], [-b, a, one]]);
        }
        let mut frames = vec![(turn, origin)];
        for turn in (1..self.model.frames()).filter_map(|i| self.model.turn(FrameId(i))) {
            let joint = &self.model.joints[turn.joint.0];
            let (parent, start) = frames[turn.parent.0];
            let angle = dual(motion.angles[turn.joint.0], layout.angle(turn.joint)) * turn.share;
            let axis = [0, 1, 2].map(|k| joint.axis[k]);
            let fixed = product(&parent, &constant(joint.parent_from_joint.matrix()));
            frames.push((
                product(&fixed, &about(axis, angle)),
                add(start, times(&parent, scaled(&joint.translation, &shape))),
            ));
        }
        (frames, shape)
    }
}

fn scaled(vector: &ScaledVector, shape: &[HyperDual64]) -> Vector {
    let shift = |k: usize| -> HyperDual64 {
        let of = |s: &Shift| shape[s.coefficient.0] * s.direction[k];
        vector.shifts.iter().map(of).sum()
    };
    [0, 1, 2].map(|k| {
        let value = HyperDual64::from_re(vector.value[k]);
        let logistic = |s: HyperDual64| ((-s).exp() + 1.0).recip() * 2.0;
        let scaled = match vector.scale[k] {
            Scale::Fixed => value,
            Scale::Log(c) => value * shape[c.0].exp(),
            Scale::Share(c) => value * logistic(shape[c.0]),
            Scale::Rest(c) => value * logistic(-shape[c.0]),
        };
        scaled + shift(k)
    })
}

/// Rodrigues: cos θ I + sin θ [a] + (1 − cos θ) aaᵀ.
fn about(axis: [f64; 3], angle: HyperDual64) -> Matrix {
    let (sin, cos) = angle.sin_cos();
    let cross = [[0.0, -axis[2], axis[1]], [axis[2], 0.0, -axis[0]], [-axis[1], axis[0], 0.0]];
    [0, 1, 2].map(|r| {
        [0, 1, 2].map(|c| {
            let identity = f64::from(u8::from(r == c));
            cos * identity + sin * cross[r][c] + (-cos + 1.0) * (axis[r] * axis[c])
        })
    })
}

fn constant(matrix: &Matrix3<f64>) -> Matrix {
    [0, 1, 2].map(|r| [0, 1, 2].map(|c| HyperDual64::from_re(matrix[(r, c)])))
}

fn product(a: &Matrix, b: &Matrix) -> Matrix {
    [0, 1, 2].map(|r| [0, 1, 2].map(|c| (0..3).map(|k| a[r][k] * b[k][c]).sum()))
}

fn times(a: &Matrix, v: Vector) -> Vector {
    [0, 1, 2].map(|r| (0..3).map(|k| a[r][k] * v[k]).sum())
}

fn add(a: Vector, b: Vector) -> Vector {
    [0, 1, 2].map(|k| a[k] + b[k])
}

fn sub(a: Vector, b: Vector) -> Vector {
    [0, 1, 2].map(|k| a[k] - b[k])
}
