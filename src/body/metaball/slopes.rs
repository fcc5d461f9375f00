//! Derivatives of the field with respect to the state (PF02 eq. A.2, A.3, A.5).
//!
//! Whatever a residual is, its derivative is Σ wᵢ αᵢ ∂(ln fᵢ)/∂θ + b·∂(∇ ln F)/∂θ with numbers αᵢ and a vector b;
//! the same α for all is α ∂(ln F)/∂θ. With q = ∇f/F = −4 w u, M = ∇²f/F = w (16 uuᵀ − 4 A⁻¹), p = ∇ ln F
//! and β = αᵢ − b·p, what one metaball adds to it is, at a fixed point x,
//!
//! - turned by ω about o: ∂f = −∇f·v, ∂∇f = −∇²f v + ω × ∇f, v = ω × (x − o), so
//!   ω·(q × b − (x − o) × h) with **h = β q + M b**;
//! - moved by t: −t·h;
//! - radius a along the axis e, ȧ = ∂a/∂θ, v = e·u: 4 w a ȧ ((β − 4 b·u) v² + 2 v (b·e)/a²).
//!
//! So a part passes on two vectors, Σq and Σh, whatever hangs on it, and each joint takes one cross product.

use nalgebra::{Matrix3, Vector3};

use super::{Field, FieldSample};
use crate::body::jacobian::stretch_columns;
use crate::body::posed::scaled;
use crate::body::{BodyModel, JointId, Layout, PartId, Posed, Primitive};

/// All that the derivatives of a field need, computed once per pose.
#[derive(Debug, Clone)]
pub struct FieldSlopes {
    root: Option<Matrix3<f64>>,
    /// The root's frame, then one per joint.
    frames: Vec<FrameSlopes>,
    metaballs: Vec<BallSlopes>,
    limbs: Vec<Chain>,
}

/// How a frame is turned and moved by its own joint.
#[derive(Debug, Clone)]
struct FrameSlopes {
    origin_world: Vector3<f64>,
    /// Component and axis of the joint; the root has none.
    joint: Option<(usize, Vector3<f64>)>,
    stretch: Vec<(usize, Vector3<f64>)>,
}

/// How a metaball changes within its part.
#[derive(Debug, Clone)]
struct BallSlopes {
    frame: usize,
    precision: Matrix3<f64>,
    centre: Vec<(usize, Vector3<f64>)>,
    radii: Vec<RadiusSlope>,
}

#[derive(Debug, Clone, Copy)]
struct RadiusSlope {
    component: usize,
    axis_world: Vector3<f64>,
    /// a·∂a/∂s.
    slope: f64,
    /// 1/a².
    precision: f64,
}

/// The frames that move a limb and the components that change it.
#[derive(Debug, Clone)]
struct Chain {
    /// From the tip to the root, which is frame 0.
    frames: Vec<usize>,
    /// Ascending.
    components: Vec<usize>,
}

/// One row: the components of a limb and the memory to compute their values.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct FieldRow {
    /// One value for each of [`FieldSlopes::components`].
    pub values: Vec<f64>,
    dense: Vec<f64>,
    /// Σq and Σh of each frame.
    pulls: Vec<(Vector3<f64>, Vector3<f64>)>,
}

impl FieldSlopes {
    /// The slopes of `Field::of(body)`.
    pub fn new(body: &Posed<'_>, field: &Field) -> Self {
        let layout = Layout::of(body.model);
        let primitives = field.sources.iter().map(|&i| &body.model.metaballs[i]);
        let frames: Vec<_> = (0..body.frames.len())
            .map(|frame| frame_slopes(body, layout, frame))
            .collect();
        let metaballs: Vec<_> = primitives
            .zip(&field.metaballs)
            .map(|(p, m)| ball_slopes(body, layout, p, m.precision))
            .collect();
        let limbs = body.model.limbs();
        let limbs = limbs.iter().zip(&field.limbs).map(|(parts, balls)| {
            let balls = balls.iter().map(|&i| &metaballs[i]);
            chain(body.model, layout, parts, &frames, balls)
        });
        Self {
            root: (layout.root() == 6).then_some(body.frames[0].world_from_frame),
            limbs: limbs.collect(),
            frames,
            metaballs,
        }
    }

    /// The components of the state that can change a limb, ascending.
    pub fn components(&self, limb: usize) -> &[usize] {
        &self.limbs[limb].components
    }

    /// Number of limbs.
    pub fn limbs(&self) -> usize {
        self.limbs.len()
    }

    /// Σ wᵢ αᵢ ∂(ln fᵢ)/∂θ + b·∂(∇ ln F)/∂θ at a fixed point, for the components of the sample's limb.
    ///
    /// `alpha` gives αᵢ of the metaball i of the field. 1 for all and `b` = 0 is the derivative of ln F; 0 for all and
    /// `b` = eₖ that of (∇ ln F)ₖ. Those of F and ∇F follow: ∂F = F ∂ ln F, ∂∇F = F (∂∇ ln F + ∇ ln F ∂ ln F).
    ///
    /// # Source
    /// PF02 eq. A.2, A.3, A.5; the sums over parts are ours.
    pub fn row(
        &self,
        sample: &FieldSample,
        alpha: impl Fn(usize) -> f64,
        b: &Vector3<f64>,
        row: &mut FieldRow,
    ) {
        let chain = &self.limbs[sample.limb];
        row.clear(chain, self.frames.len());
        let level = b.dot(&sample.log_gradient);
        for share in &sample.shares {
            let ball = &self.metaballs[share.metaball];
            let (w, u) = (share.weight, &share.pull);
            let along = b.dot(u);
            let beta = alpha(share.metaball) - level;
            let q = u * (-4.0 * w);
            let h = u * (w * (16.0 * along - 4.0 * beta)) - (ball.precision * b) * (4.0 * w);
            let pulls = &mut row.pulls[ball.frame];
            *pulls = (pulls.0 + q, pulls.1 + h);
            for (component, moved) in &ball.centre {
                row.dense[*component] -= moved.dot(&h);
            }
            for radius in &ball.radii {
                let v = radius.axis_world.dot(u);
                let bend = 2.0 * b.dot(&radius.axis_world) * radius.precision;
                row.dense[radius.component] +=
                    4.0 * w * radius.slope * v * ((beta - 4.0 * along) * v + bend);
            }
        }
        self.pass_down(chain, &sample.point_world, b, row);
        row.values
            .extend(chain.components.iter().map(|&c| row.dense[c]));
    }

    /// Sums over what hangs on each frame, from the tip to the root.
    fn pass_down(&self, chain: &Chain, x: &Vector3<f64>, b: &Vector3<f64>, row: &mut FieldRow) {
        let (mut q, mut h) = (Vector3::zeros(), Vector3::zeros());
        for &index in &chain.frames {
            let frame = &self.frames[index];
            q += row.pulls[index].0;
            h += row.pulls[index].1;
            for (component, moved) in &frame.stretch {
                row.dense[*component] -= moved.dot(&h);
            }
            if let Some((component, axis)) = &frame.joint {
                let turn = q.cross(b) - (x - frame.origin_world).cross(&h);
                row.dense[*component] += axis.dot(&turn);
            }
        }
        if let Some(world_from_root) = &self.root {
            let turn = q.cross(b) - (x - self.frames[0].origin_world).cross(&h);
            let turn = world_from_root.tr_mul(&turn);
            for k in 0..3 {
                row.dense[k] -= h[k];
                row.dense[3 + k] += turn[k];
            }
        }
    }
}

impl FieldRow {
    fn clear(&mut self, chain: &Chain, frames: usize) {
        let last = chain.components.last().map_or(0, |c| c + 1);
        if self.dense.len() < last {
            self.dense.resize(last, 0.0);
        }
        self.pulls.resize(frames, Default::default());
        self.values.clear();
        chain.components.iter().for_each(|&c| self.dense[c] = 0.0);
        chain
            .frames
            .iter()
            .for_each(|&f| self.pulls[f] = Default::default());
    }
}

fn frame_slopes(body: &Posed<'_>, layout: Layout, frame: usize) -> FrameSlopes {
    let mut stretch = Vec::new();
    let joint = frame.checked_sub(1).map(|index| {
        let joint = &body.model.joints[index];
        let parent = body.frames[joint.parent.map_or(0, |p| p.0 + 1)].world_from_frame;
        let mut add = |component, moved| stretch.push((component, moved));
        stretch_columns(body, layout, &parent, &joint.translation, &mut add);
        (layout.angle(JointId(index)), body.axes_world[index])
    });
    FrameSlopes {
        origin_world: body.frames[frame].origin_world,
        joint,
        stretch,
    }
}

fn ball_slopes(
    body: &Posed<'_>,
    layout: Layout,
    primitive: &Primitive,
    precision: Matrix3<f64>,
) -> BallSlopes {
    let world_from_part = body.frame(primitive.part).world_from_frame;
    let mut centre = Vec::new();
    let mut add = |component, moved| centre.push((component, moved));
    stretch_columns(body, layout, &world_from_part, &primitive.centre, &mut add);
    let axes = world_from_part * primitive.part_from_primitive.matrix();
    let radii = scaled(&primitive.radii, body.shape());
    let slope = |k: usize| {
        let scale = primitive.radii.scale[k];
        let (value, shape) = (primitive.radii.value[k], &body.shape().0);
        Some(RadiusSlope {
            component: layout.coefficient(scale.coefficient()?),
            axis_world: axes.column(k).into_owned(),
            slope: radii[k] * scale.apply(value, shape).1,
            precision: 1.0 / (radii[k] * radii[k]),
        })
    };
    BallSlopes {
        frame: frame_of(body.model, primitive.part),
        precision,
        centre,
        radii: (0..3).filter_map(slope).collect(),
    }
}

fn frame_of(model: &BodyModel, part: PartId) -> usize {
    model.parts[part.0].joint.map_or(0, |j| j.0 + 1)
}

fn chain<'a>(
    model: &BodyModel,
    layout: Layout,
    parts: &[PartId],
    frames: &[FrameSlopes],
    balls: impl Iterator<Item = &'a BallSlopes>,
) -> Chain {
    let tip = parts.first().and_then(|p| model.parts[p.0].joint);
    let joints = model.chain(tip);
    let chain_frames: Vec<usize> = joints.iter().rev().map(|j| j.0 + 1).chain([0]).collect();
    let mut components: Vec<usize> = (0..layout.root()).collect();
    for &frame in &chain_frames {
        components.extend(frames[frame].joint.iter().map(|(c, _)| *c));
        components.extend(frames[frame].stretch.iter().map(|(c, _)| *c));
    }
    for ball in balls {
        components.extend(ball.centre.iter().map(|(c, _)| *c));
        components.extend(ball.radii.iter().map(|r| r.component));
    }
    components.sort_unstable();
    components.dedup();
    Chain {
        frames: chain_frames,
        components,
    }
}
