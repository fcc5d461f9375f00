//! How sure the joint optimum is: covariances of motions and shape, carried on to angles, points and lengths.
//!
//! From H⁻¹, with the shape's part widened τ times ([`Noise`](super::noise::Noise)): cov(s) = τ Σ_ss, and as m depends on s
//! through G = Σ_ms Σ_ss⁻¹, cov(m) = Σ_mm + (τ − 1)·G Σ_ss Gᵀ. To this is added what the unknown places of the joints in the
//! flesh contribute, (S; 1)(S; 1)ᵀ for θ and c together ([`Considered`]).

use nalgebra::{Cholesky, DMatrix, DVector, Dyn, Matrix3, Vector3};

use super::considered::Considered;
use super::sequence_posterior::SequenceState;
use crate::body::{BodyModel, Layout, Motion, PartId, Posed, Shape};
use crate::solver::{BorderedChain, Marginal};

/// How far the joint optimum may be from the truth, as far as a bias that returns in every frame can be known.
#[derive(Debug, Clone, PartialEq)]
pub struct Uncertainty {
    /// The shape.
    pub shape: ShapeUncertainty,
    /// Frame by frame.
    pub frames: Vec<FrameUncertainty>,
}

/// Covariances of the shape.
#[derive(Debug, Clone, PartialEq)]
pub struct ShapeUncertainty {
    /// Covariance of the coefficients.
    pub covariance: DMatrix<f64>,
    /// Standard deviation of each length of the model, metres.
    pub lengths_sd_m: Vec<f64>,
}

/// Standard deviations of one frame.
#[derive(Debug, Clone, PartialEq)]
pub struct FrameUncertainty {
    /// Of the root's origin, world axes; 0 if it is fixed.
    pub position_sd_m: Vector3<f64>,
    /// Of each part's orientation in the world, about its own axes; 0 of a part that nothing turns.
    pub parts_sd: Vec<Vector3<f64>>,
    /// Of the angles between the bones.
    pub angles_sd: DVector<f64>,
    /// Of the same angles, if the joints' places in the flesh were known.
    pub seen_angles_sd: DVector<f64>,
    /// Covariance of each exported point, square metres.
    pub points: Vec<Matrix3<f64>>,
    /// Covariance of the way from the left to the right point of each of [`BodyModel::point_pairs`], square metres.
    pub apart: Vec<Matrix3<f64>>,
}

impl Uncertainty {
    /// From H of the chain, τ, and what other places of the joints would change; `None` where H is singular.
    pub(super) fn new(
        model: &BodyModel,
        state: &SequenceState,
        chain: &BorderedChain,
        tau: f64,
        considered: &Considered,
    ) -> Option<Self> {
        let placed_shape = considered.placed.shape(&state.shape);

        // frame by frame, in the order of the chain's marginals: backwards
        let (mut frames, mut shape) = (Vec::new(), DMatrix::zeros(0, 0));
        let mut factor = None;
        let complete = chain.marginals(|i, marginal| {
            // the same in every frame
            let factor = factor.get_or_insert_with(|| {
                shape = marginal.shared * tau;
                marginal.shared.clone().cholesky()
            });
            let sensitivity = &considered.sensitivity.frames[i];
            let motion = considered.placed.motion(&state.motions[i]);
            let body = Posed::new(&considered.placed.model, &placed_shape, &motion);
            let estimate = estimate_covariance(model, marginal, factor.as_ref(), tau);
            frames.extend(
                estimate.map(|e| frame_uncertainty(model, &body, e, considered, sensitivity)),
            );
        });
        frames.reverse();
        if !complete || frames.len() != state.motions.len() {
            return None;
        }

        // the shape: as of a frame whose motion is known
        let layout = Layout::new(model);
        let (m, p) = (layout.motion(), layout.total() - layout.motion());
        let mut all = DMatrix::zeros(m + p, m + p);
        all.view_mut((m, m), (p, p)).copy_from(&shape);
        let still = DMatrix::zeros(m, considered.placed.count());
        let all = with_places(model, &all, considered, &still);
        let first = all.nrows() - p - considered.placed.count();
        let shape = ShapeUncertainty {
            covariance: all.view((first, first), (p, p)).into_owned(),
            lengths_sd_m: lengths_sd_m(considered, &placed_shape, &all),
        };
        Some(Self { shape, frames })
    }
}

/// Covariance of a frame's motion and of s if the joints' places were known.
fn estimate_covariance(
    model: &BodyModel,
    marginal: &Marginal<'_>,
    shared: Option<&Cholesky<f64, Dyn>>,
    tau: f64,
) -> Option<DMatrix<f64>> {
    let layout = Layout::new(model);
    let (m, p) = (layout.motion(), layout.total() - layout.motion());

    // cov(m)
    let mut motion = marginal.frame.clone();
    if p > 0 {
        let depends = shared?.solve(marginal.cross);
        motion += marginal.cross.tr_mul(&depends) * (tau - 1.0);
    }

    // with τ Σ_sm and τ Σ_ss
    let mut all = DMatrix::zeros(m + p, m + p);
    all.view_mut((0, 0), (m, m)).copy_from(&motion);
    let mut cross = all.view_mut((m, 0), (p, m));
    cross.copy_from(&(marginal.cross * tau));
    let mut shape = all.view_mut((m, m), (p, p));
    shape.copy_from(&(marginal.shared * tau));
    all.fill_upper_triangle_with_lower_triangle();
    Some(all)
}

/// Covariance of all components of the body with places: `estimate` is that of a motion and of s, `motion` is S of that motion.
fn with_places(
    model: &BodyModel,
    estimate: &DMatrix<f64>,
    considered: &Considered,
    motion: &DMatrix<f64>,
) -> DMatrix<f64> {
    let (placed, shape) = (&considered.placed, &considered.sensitivity.shared);
    let total = Layout::new(&placed.model).total();
    let first_place = total - placed.count();
    let first_shape = first_place - shape.nrows();

    // (S; 1)(S; 1)ᵀ
    let mut errors = DMatrix::zeros(total, placed.count());
    errors.rows_mut(0, motion.nrows()).copy_from(motion);
    errors.rows_mut(first_shape, shape.nrows()).copy_from(shape);
    errors.rows_mut(first_place, placed.count()).fill_with_identity();
    let mut all = &errors * errors.transpose();

    // the estimate's, where its components are among all
    let among: Vec<usize> = Layout::new(model).components_in(placed).collect();
    for (i, &row) in among.iter().enumerate() {
        for (j, &column) in among.iter().enumerate() {
            all[(row, column)] += estimate[(i, j)];
        }
    }
    all
}

fn frame_uncertainty(
    model: &BodyModel,
    body: &Posed<'_>,
    estimate: DMatrix<f64>,
    considered: &Considered,
    sensitivity: &DMatrix<f64>,
) -> FrameUncertainty {
    let layout = Layout::new(model);
    let (root, joints) = (layout.root(), layout.motion() - layout.root());
    let all = with_places(model, &estimate, considered, sensitivity);

    // components of the motion
    let sd = |variance: f64| variance.max(0.0).sqrt();
    let deviations = all.diagonal().map(sd);
    let position_sd_m = match root {
        6 => Vector3::from(deviations.fixed_rows::<3>(0)),
        _ => Vector3::zeros(),
    };

    // whatever else moves with them: J Σ Jᵀ
    let carried = |jacobian: &DMatrix<f64>| {
        let covariance = jacobian * &all * jacobian.transpose();
        Matrix3::from(covariance.fixed_view::<3, 3>(0, 0))
    };
    let apart = |(right, left): (usize, usize)| {
        carried(&(body.point_jacobian(right) - body.point_jacobian(left)))
    };
    let turned = |part: usize| carried(&body.rotation_jacobian(PartId(part))).diagonal();

    FrameUncertainty {
        position_sd_m,
        parts_sd: (0..model.parts.len()).map(|part| turned(part).map(sd)).collect(),
        angles_sd: deviations.rows(root, joints).into_owned(),
        seen_angles_sd: estimate.diagonal().rows(root, joints).map(sd),
        points: (0..model.points.len()).map(|index| carried(&body.point_jacobian(index))).collect(),
        apart: model.point_pairs().into_iter().map(apart).collect(),
    }
}

/// ∂‖b − a‖ = uᵀ(∂b − ∂a), u = (b − a)/‖b − a‖.
fn lengths_sd_m(considered: &Considered, shape: &Shape, all: &DMatrix<f64>) -> Vec<f64> {
    let model = &considered.placed.model;
    let rest = Motion::rest(model);
    let body = Posed::new(model, shape, &rest);
    let points = body.points();
    let first = Layout::new(model).motion();
    let covariance = all.view_range(first.., first..);
    let sd_m = |(_, from, to): &(String, usize, usize)| {
        let along = (points[*to] - points[*from]).try_normalize(1e-12)?;
        let moved = body.point_jacobian(*to) - body.point_jacobian(*from);
        let gradient: DVector<f64> = moved.columns_range(first..).tr_mul(&along);
        Some(gradient.dot(&(covariance * &gradient)).max(0.0).sqrt())
    };
    model.lengths.iter().map(|l| sd_m(l).unwrap_or(0.0)).collect()
}
