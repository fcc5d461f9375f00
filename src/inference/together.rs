//! One shape from several frames at once: argmax p(s) Πₖ p(Zₖ | mₖ, s) p(mₖ).
//!
//! A single keyframe cannot tell where in the flesh a joint lies; the frames together can, since the flesh
//! turns about it. With one motion per frame and one shape for all, H has the shape of an arrow: blocks
//! Hₖ = \[Aₖ Bₖᵀ; Bₖ Cₖ\]. Eliminating every mₖ leaves
//! (Σ Cₖ − Bₖ Aₖ⁻¹ Bₖᵀ) δs = −Σ (gₛₖ − Bₖ Aₖ⁻¹ gₘₖ), then δmₖ = −Aₖ⁻¹ (gₘₖ + Bₖᵀ δs).
//!
//! The body's mismatch with the model repeats in every frame, so K frames are not K times the evidence
//! about s: each frame's cost is weighed by 1/√K, which makes them √K times.

use nalgebra::{Cholesky, DMatrix, DVector, Dyn};
use rayon::prelude::*;

use super::Evidence;
use crate::body::{Layout, Motion, Posed, Shape};
use crate::likelihood::Term;
use crate::solver::NormalEquations;

/// A frame of the joint problem: its terms and its motion so far.
pub(super) struct Member<'a> {
    pub(super) terms: Vec<Box<dyn Term + 'a>>,
    pub(super) motion: Motion,
}

/// K frames weigh as much as K^(1 − TEMPER) independent ones.
const TEMPER: f64 = 0.5;

/// Iterations of the arrow-shaped problem.
const ITERATIONS: usize = 15;

/// The shape that the members agree on, from a first one; improves their motions with it.
pub(super) fn refine(evidence: &Evidence<'_>, shape: Shape, members: &mut [Member<'_>]) -> Shape {
    let weight = (members.len() as f64).powf(-TEMPER);
    let (mut shape, mut lambda) = (shape, 1e-3);
    let mut arrow = Arrow::at(evidence, &shape, members, weight);
    for _ in 0..ITERATIONS {
        let Some((step_s, steps_m)) = arrow.solve(lambda) else {
            lambda *= 10.0;
            continue;
        };
        let layout = Layout::of(evidence.model);
        let moved = Shape(&shape.0 + &step_s);
        let before: Vec<Motion> = members.iter().map(|m| m.motion.clone()).collect();
        for (member, step) in members.iter_mut().zip(&steps_m) {
            member.motion = layout.retract_motion(&member.motion, step);
        }
        let candidate = Arrow::at(evidence, &moved, members, weight);
        if candidate.cost < arrow.cost {
            let decrease = arrow.cost - candidate.cost;
            lambda *= 0.2;
            shape = moved;
            arrow = candidate;
            if decrease < 1e-5 * arrow.cost {
                break;
            }
        } else {
            members
                .iter_mut()
                .zip(before)
                .for_each(|(member, motion)| member.motion = motion);
            lambda *= 8.0;
        }
    }
    shape
}

/// The linearised problem.
struct Arrow {
    cost: f64,
    /// Per frame: A, B, g of the motion.
    frames: Vec<(DMatrix<f64>, DMatrix<f64>, DVector<f64>)>,
    shape: NormalEquations,
}

impl Arrow {
    fn at(evidence: &Evidence<'_>, shape: &Shape, members: &[Member<'_>], weight: f64) -> Self {
        let layout = Layout::of(evidence.model);
        let (m, n) = (layout.motion(), layout.total());
        let linearized: Vec<(f64, NormalEquations)> = members
            .par_iter()
            .map(|member| {
                let mut equations = NormalEquations::zeros(n);
                let body = Posed::new(evidence.model, shape, &member.motion);
                let data: f64 = member
                    .terms
                    .iter()
                    .map(|t| t.linearize(&body, &mut equations))
                    .sum();
                let pose = evidence
                    .pose_prior
                    .linearize(&member.motion, &mut equations);
                equations.symmetrize();
                (data + pose, equations)
            })
            .collect();
        let mut reduced = NormalEquations::zeros(n - m);
        let prior = evidence.shape_prior.linearize(shape, 0, &mut reduced);
        let mut cost = prior;
        let mut frames = Vec::with_capacity(members.len());
        for (frame_cost, equations) in linearized {
            cost += weight * frame_cost;
            reduced.hessian += equations.hessian.view((m, m), (n - m, n - m)) * weight;
            reduced.gradient += equations.gradient.rows(m, n - m) * weight;
            frames.push((
                equations.hessian.view((0, 0), (m, m)) * weight,
                equations.hessian.view((m, 0), (n - m, m)) * weight,
                equations.gradient.rows(0, m) * weight,
            ));
        }
        Self {
            cost,
            frames,
            shape: reduced,
        }
    }

    /// (δs, δmₖ) with λ·diag added; `None` where a block is not positive definite.
    fn solve(&self, lambda: f64) -> Option<(DVector<f64>, Vec<DVector<f64>>)> {
        let damped = |matrix: &DMatrix<f64>| {
            let mut matrix = matrix.clone();
            (0..matrix.nrows()).for_each(|i| matrix[(i, i)] *= 1.0 + lambda);
            matrix
        };
        let factors: Option<Vec<Cholesky<f64, Dyn>>> = self
            .frames
            .iter()
            .map(|(a, _, _)| damped(a).cholesky())
            .collect();
        let factors = factors?;
        let mut schur = damped(&self.shape.hessian);
        let mut gradient = self.shape.gradient.clone();
        for ((_, b, g), factor) in self.frames.iter().zip(&factors) {
            let solved = factor.solve(&b.transpose());
            schur -= b * &solved;
            gradient -= solved.tr_mul(g);
        }
        let step_s = schur.cholesky()?.solve(&-gradient);
        let steps = self
            .frames
            .iter()
            .zip(&factors)
            .map(|((_, b, g), factor)| -factor.solve(&(g + b.tr_mul(&step_s))))
            .collect();
        Some((step_s, steps))
    }
}
