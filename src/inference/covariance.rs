//! How sure the joint optimum is: covariances of motions and shape, carried on to angles, points and lengths.
//!
//! Σ is the covariance of all unknowns (`repeated_error.rs`): the motions, s, where the joints lie in the flesh, how far the
//! surface lies outside. A number q(θ) of the body has the variance J Σ Jᵀ, J = ∂q/∂θ.

use std::ops::Range;

use nalgebra::{DMatrix, DVector, Matrix3, SVector, Vector3};
use rayon::prelude::*;

use super::camera_offset::COMPONENTS;
use super::camera_prior::CameraPrior;
use super::repeated_error::RepeatedError;
use super::sequence_state::SequenceState;
use crate::body::{BodyModel, Layout, Motion, PartId, Posed, Shape};

/// How far the joint optimum may be from the truth, as far as a bias that returns in every frame can be known.
#[derive(Debug, Clone, PartialEq)]
pub struct Uncertainty {
    /// The shape.
    pub shape: ShapeUncertainty,
    /// Frame by frame.
    pub frames: Vec<FrameUncertainty>,
    /// Covariance of the components of all cameras' offsets, camera after camera; empty where cameras are trusted.
    pub cameras: DMatrix<f64>,
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
    /// Covariance of each exported point, square metres.
    pub points: Vec<Matrix3<f64>>,
    /// Covariance of the way from the left to the right point of each of [`BodyModel::point_pairs`], square metres.
    pub apart: Vec<Matrix3<f64>>,
}

/// Frames of which covariances wait until they are carried on together.
const BATCH: usize = 32;

impl Uncertainty {
    /// Standard deviations of the components of a camera's offset; `None` where cameras are trusted.
    pub fn camera_sd(&self, camera: usize) -> Option<SVector<f64, COMPONENTS>> {
        let first = COMPONENTS * camera;
        let is_unknown = first < self.cameras.nrows();
        let sd = |k: usize| self.cameras[(first + k, first + k)].max(0.0).sqrt();
        is_unknown.then(|| SVector::from_fn(|k, _| sd(k)))
    }

    /// Covariance of the components of some of the cameras.
    pub(super) fn of_cameras(&self, cameras: Range<usize>) -> DMatrix<f64> {
        let end = (COMPONENTS * cameras.end).min(self.cameras.nrows());
        let first = (COMPONENTS * cameras.start).min(end);
        self.cameras.view((first, first), (end - first, end - first)).into_owned()
    }

    /// From the covariances of an optimum's error; `None` where a matrix is singular.
    pub(super) fn new(
        model: &BodyModel,
        state: &SequenceState,
        camera_prior: &CameraPrior,
        error: &RepeatedError,
    ) -> Option<Self> {
        let RepeatedError { passes, stays } = error;
        let carried = |(i, covariance): (usize, DMatrix<f64>)| {
            let body = Posed::new(model, &state.shape, &state.motions[i]);
            frame_uncertainty(model, &body, &covariance)
        };
        // frame by frame, in the order of the chain's marginals: backwards
        let (mut frames, mut shared) = (Vec::new(), DMatrix::zeros(0, 0));
        let mut waiting: Vec<(usize, DMatrix<f64>)> = Vec::with_capacity(BATCH);
        let complete = passes.marginals(|i, marginal| {
            if shared.is_empty() {
                shared = marginal.shared.clone();
            }
            let mut covariance = marginal.covariance();
            let mut of_motion = covariance.view_mut((0, 0), stays.shape());
            of_motion += stays;
            waiting.push((i, covariance));
            if waiting.len() == BATCH {
                frames.par_extend(waiting.par_drain(..).map(carried));
            }
        });
        frames.par_extend(waiting.into_par_iter().map(carried));
        frames.reverse();
        if !complete || frames.len() != state.motions.len() {
            return None;
        }

        let p = state.shape.0.len();
        let covariance = shared.view((0, 0), (p, p)).into_owned();
        let lengths_sd_m = lengths_sd_m(&lengths_slopes(model, &state.shape), &covariance);
        let rows = (0..state.cameras.len()).flat_map(|camera| camera_prior.rows(camera).all());
        let rows: Vec<usize> = rows.map(|row| p + row).collect();
        let cameras = DMatrix::from_fn(rows.len(), rows.len(), |i, j| shared[(rows[i], rows[j])]);
        Some(Self { shape: ShapeUncertainty { covariance, lengths_sd_m }, frames, cameras })
    }
}

fn frame_uncertainty(model: &BodyModel, body: &Posed<'_>, all: &DMatrix<f64>) -> FrameUncertainty {
    let layout = Layout::new(model);
    let (root, joints) = (layout.root(), layout.motion() - layout.root());

    // components of the motion
    let sd = |variance: f64| variance.max(0.0).sqrt();
    let deviations = all.diagonal().map(sd);
    let position_sd_m = match root {
        6 => Vector3::from(deviations.fixed_rows::<3>(0)),
        _ => Vector3::zeros(),
    };

    // whatever else moves with them: J Σ Jᵀ, of the components that move it
    let carried = |jacobian: &DMatrix<f64>| {
        let moves = |column: &usize| jacobian.column(*column).amax() > 0.0;
        let columns: Vec<usize> = (0..jacobian.ncols()).filter(moves).collect();
        let jacobian = jacobian.select_columns(&columns);
        let sigma =
            DMatrix::from_fn(columns.len(), columns.len(), |i, j| all[(columns[i], columns[j])]);
        let covariance = &jacobian * sigma * jacobian.transpose();
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
        points: (0..model.points.len()).map(|index| carried(&body.point_jacobian(index))).collect(),
        apart: model.point_pairs().into_iter().map(apart).collect(),
    }
}

fn lengths_sd_m(slopes: &DMatrix<f64>, covariance: &DMatrix<f64>) -> Vec<f64> {
    let variances = (slopes * covariance).component_mul(slopes).column_sum();
    variances.iter().map(|variance| variance.max(0.0).sqrt()).collect()
}

/// How the lengths of a model at rest move with the coefficients of its shape, lengths × coefficients, m.
///
/// ∂‖b − a‖ = uᵀ(∂b − ∂a), u = (b − a)/‖b − a‖; 0 of a length whose ends are one point.
pub fn lengths_slopes(model: &BodyModel, shape: &Shape) -> DMatrix<f64> {
    let rest = Motion::rest(model);
    let body = Posed::new(model, shape, &rest);
    let points = body.points();
    let first = Layout::new(model).motion();
    let mut slopes = DMatrix::zeros(model.lengths.len(), shape.0.len());
    for (i, (_, from, to)) in model.lengths.iter().enumerate() {
        if let Some(along) = (points[*to] - points[*from]).try_normalize(1e-12) {
            let moved = body.point_jacobian(*to) - body.point_jacobian(*from);
            let gradient: DVector<f64> = moved.columns_range(first..).tr_mul(&along);
            slopes.set_row(i, &gradient.transpose());
        }
    }
    slopes
}
