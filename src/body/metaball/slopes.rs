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
//! A residual may depend on more of a metaball than fᵢ: on something else that is fixed to it, whose gradient in space is γ.
//! That adds w γ to h, and w (ȧ/a) times its slope with respect to ln a to a radius.
//!
//! So a frame passes on two vectors, Σq and Σh, whatever hangs on it, and each joint costs one cross product.

use nalgebra::{Matrix3, Vector3};

use super::{Field, FieldSample, Share};
use crate::body::jacobian::stretch_columns;
use crate::body::{BodyModel, CoefficientId, FrameId, Layout, Posed, Primitive};

/// All that the derivatives of a field need, computed once per pose.
#[derive(Debug, Clone)]
pub struct FieldSlopes {
    root: Option<Matrix3<f64>>,
    /// By [`FrameId`].
    frames: Vec<FrameSlopes>,
    metaballs: Vec<BallSlopes>,
    limbs: Vec<Branch>,
}

/// How a frame's own joint turns and moves it.
#[derive(Debug, Clone)]
struct FrameSlopes {
    origin_world: Vector3<f64>,
    /// `None` for the root's frame.
    turn: Option<TurnSlope>,
    /// Components that move its origin, and how.
    stretch: Vec<(usize, Vector3<f64>)>,
}

/// How a joint's angle turns a frame.
#[derive(Debug, Clone, Copy)]
struct TurnSlope {
    /// The frame that carries it.
    parent: FrameId,
    /// The angle's component.
    component: usize,
    /// The axis, times the share of the angle.
    axis_world: Vector3<f64>,
}

/// How a metaball changes within its frame.
#[derive(Debug, Clone)]
struct BallSlopes {
    frame: FrameId,
    precision: Matrix3<f64>,
    /// Components that move its centre, and how.
    centre: Vec<(usize, Vector3<f64>)>,
    radii: Vec<RadiusSlope>,
}

/// How a coefficient changes one radius of a metaball.
#[derive(Debug, Clone, Copy)]
struct RadiusSlope {
    component: usize,
    /// Which of the metaball's axes.
    axis: usize,
    axis_world: Vector3<f64>,
    /// a·∂a/∂s.
    slope: f64,
    /// 1/a².
    precision: f64,
}

/// The frames that move a limb and the components that change it.
#[derive(Debug, Clone)]
struct Branch {
    /// Each before the one that carries it; the last is the root's.
    frames: Vec<FrameId>,
    /// Ascending.
    components: Vec<usize>,
}

/// How a residual depends on one metaball, divided by the metaball's weight.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct BallChange {
    /// αᵢ: on ln fᵢ.
    pub alpha: f64,
    /// γ: on the place in the metaball's frame, apart from fᵢ; world, 1/m.
    pub place: Vector3<f64>,
    /// On ln a of each radius, apart from fᵢ.
    pub radii: Vector3<f64>,
}

/// One row of a Jacobian, for the components of a limb, and the memory to compute it.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct FieldRow {
    /// One value for each of [`FieldSlopes::components`].
    pub values: Vec<f64>,
    dense: Vec<f64>,
    /// By [`FrameId`].
    pulls: Vec<Pull>,
}

/// Σq and Σh over all that hangs on a frame.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
struct Pull {
    q: Vector3<f64>,
    h: Vector3<f64>,
}

impl Pull {
    fn add(&mut self, other: Self) {
        self.q += other.q;
        self.h += other.h;
    }
}

impl FieldSlopes {
    /// The slopes of the field of `body`, which is [`Field::from_body`].
    pub fn new(body: &Posed<'_>, field: &Field) -> Self {
        let layout = Layout::new(body.model);
        let primitives = field.sources.iter().map(|&i| &body.model.metaballs[i]);
        let frames: Vec<_> =
            (0..body.frames.len()).map(|frame| frame_slopes(body, layout, frame)).collect();
        let metaballs: Vec<_> = primitives
            .zip(&field.metaballs)
            .map(|(p, m)| ball_slopes(body, layout, p, m.precision))
            .collect();

        let limbs = field.limbs.iter().map(|balls| {
            let balls: Vec<_> = balls.iter().map(|&i| &metaballs[i]).collect();
            branch(body.model, layout, &frames, &balls)
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
        let change =
            |share: &Share| BallChange { alpha: alpha(share.metaball), ..BallChange::default() };
        let changes: Vec<_> = sample.shares.iter().map(change).collect();
        self.row_from_changes(sample, &changes, b, row);
    }

    /// [`row`](Self::row) of a residual that depends on more of each metaball: one change for each of [`FieldSample::shares`].
    pub fn row_from_changes(
        &self,
        sample: &FieldSample,
        changes: &[BallChange],
        b: &Vector3<f64>,
        row: &mut FieldRow,
    ) {
        let branch = &self.limbs[sample.limb];
        row.clear(branch, self.frames.len());
        let level = b.dot(&sample.log_gradient);

        for (share, change) in sample.shares.iter().zip(changes) {
            let ball = &self.metaballs[share.metaball];
            let (w, u) = (share.weight, &share.pull);
            let along = b.dot(u);
            let beta = change.alpha - level;

            // what the frame passes on, h = β q + M b + w γ
            let q = u * (-4.0 * w);
            let h = u * (w * (16.0 * along - 4.0 * beta)) - (ball.precision * b) * (4.0 * w)
                + change.place * w;
            row.pulls[ball.frame.0].add(Pull { q, h });

            // what moves and stretches it within its frame
            for (component, moved) in &ball.centre {
                row.dense[*component] -= moved.dot(&h);
            }
            for radius in &ball.radii {
                let v = radius.axis_world.dot(u);
                let bend = 2.0 * b.dot(&radius.axis_world) * radius.precision;
                row.dense[radius.component] +=
                    4.0 * w * radius.slope * v * ((beta - 4.0 * along) * v + bend)
                        + w * change.radii[radius.axis] * radius.slope * radius.precision;
            }
        }

        self.pass_down(branch, &sample.point_world, b, row);
        row.values.extend(branch.components.iter().map(|&c| row.dense[c]));
    }

    /// Passes what hangs on each frame on to the frame that carries it, from the tip to the root.
    fn pass_down(&self, branch: &Branch, x: &Vector3<f64>, b: &Vector3<f64>, row: &mut FieldRow) {
        for index in &branch.frames {
            let frame = &self.frames[index.0];
            let pull = row.pulls[index.0];
            let Pull { q, h } = pull;

            for (component, moved) in &frame.stretch {
                row.dense[*component] -= moved.dot(&h);
            }
            if let Some(joint) = &frame.turn {
                let turn = q.cross(b) - (x - frame.origin_world).cross(&h);
                row.dense[joint.component] += joint.axis_world.dot(&turn);
                row.pulls[joint.parent.0].add(pull);
            }
        }

        let Pull { q, h } = row.pulls[0];
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
    fn clear(&mut self, branch: &Branch, frames: usize) {
        let last = branch.components.last().map_or(0, |c| c + 1);
        if self.dense.len() < last {
            self.dense.resize(last, 0.0);
        }
        self.pulls.resize(frames, Pull::default());
        self.values.clear();
        branch.components.iter().for_each(|&c| self.dense[c] = 0.0);
        branch.frames.iter().for_each(|f| self.pulls[f.0] = Pull::default());
    }
}

fn frame_slopes(body: &Posed<'_>, layout: Layout, frame: usize) -> FrameSlopes {
    let mut stretch = Vec::new();
    let turn = body.model.turn(FrameId(frame)).map(|turn| {
        let translation = &body.model.joints[turn.joint.0].translation;
        let parent = body.frames[turn.parent.0].world_from_frame;
        let mut add = |component, moved| stretch.push((component, moved));
        stretch_columns(body, layout, &parent, translation, &mut add);
        TurnSlope {
            parent: turn.parent,
            component: layout.angle(turn.joint),
            axis_world: body.turns_world[frame],
        }
    });
    FrameSlopes { origin_world: body.frames[frame].origin_world, turn, stretch }
}

fn ball_slopes(
    body: &Posed<'_>,
    layout: Layout,
    primitive: &Primitive,
    precision: Matrix3<f64>,
) -> BallSlopes {
    let world_from_frame = body.frames[primitive.frame.0].world_from_frame;
    let mut centre = Vec::new();
    let mut add = |component, moved| centre.push((component, moved));
    stretch_columns(body, layout, &world_from_frame, &primitive.centre, &mut add);

    let (axes, radii) = (body.primitive_axes(primitive), body.primitive_radii(primitive));
    let slope = |(coefficient, slope): (CoefficientId, Vector3<f64>)| {
        let axes_that_grow = (0..3).filter(move |&k| slope[k] != 0.0);
        axes_that_grow.map(move |k| RadiusSlope {
            component: layout.coefficient(coefficient),
            axis: k,
            axis_world: axes.column(k).into_owned(),
            slope: radii[k] * slope[k],
            precision: 1.0 / (radii[k] * radii[k]),
        })
    };

    BallSlopes {
        frame: primitive.frame,
        precision,
        centre,
        radii: primitive.radii.slopes(body.shape()).flat_map(slope).collect(),
    }
}

/// The frames and components of a limb of these metaballs.
fn branch(
    model: &BodyModel,
    layout: Layout,
    frames: &[FrameSlopes],
    balls: &[&BallSlopes],
) -> Branch {
    let paths = balls.iter().flat_map(|ball| model.path(ball.frame));
    let mut on_root: Vec<FrameId> = paths.map(|(frame, _)| frame).chain([FrameId(0)]).collect();
    // a frame's number is above that of the one that carries it
    on_root.sort_unstable_by(|a, b| b.cmp(a));
    on_root.dedup();

    let mut components: Vec<usize> = (0..layout.root()).collect();
    for frame in &on_root {
        let frame = &frames[frame.0];
        components.extend(frame.turn.iter().map(|turn| turn.component));
        components.extend(frame.stretch.iter().map(|(c, _)| *c));
    }
    for ball in balls {
        components.extend(ball.centre.iter().map(|(c, _)| *c));
        components.extend(ball.radii.iter().map(|r| r.component));
    }
    components.sort_unstable();
    components.dedup();

    Branch { frames: on_root, components }
}
