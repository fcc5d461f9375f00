//! The sequence posterior, ZS06 eq. 1, of all motions and the shape at once.
//!
//! E(s, m₁..ₙ) = −log p(s) + Σᵢ \[−w log p(Zᵢ | mᵢ, s) + E_d − log p(mᵢ)\] + Σᵢ \[−log p(mᵢ | mᵢ₋₁, …)\]
//!
//! A frame's terms touch its own motion and the shape, a motion's factor touches its neighbours: g and H are a
//! [`BorderedChain`] with the shape as border. w is how often the data count, see [`super::noise`], and E_d what the differences
//! between cameras side by side say beyond that: [`super::contrasts`].

use nalgebra::DVector;
use rayon::prelude::*;

use super::Terms;
use super::chain::ChainPrior;
use super::contrasts::Contrasts;
use super::frame::{FrameFit, data_cost, linearize_data, observations};
use super::prior::{PosePrior, ShapePrior};
use super::sequence_state::SequenceState;
use crate::body::{BodyModel, Layout, Motion, Posed, Shape};
use crate::solver::{BorderedChain, Link, NormalEquations, Problem};

/// −log p(s, m₁..ₙ | Z₁..ₙ) (eq. 1).
pub struct SequencePosterior<'a> {
    /// The body.
    pub model: &'a BodyModel,
    /// p(s).
    pub shape_prior: &'a ShapePrior,
    /// p(mᵢ): limits and rest.
    pub pose_prior: &'a PosePrior,
    /// p(m₁, …, mₙ), but for each frame's own part.
    pub chain_prior: &'a ChainPrior,
    /// Seconds from the frame before; the first is not read: p(m₁) counts whole.
    pub seconds: &'a [f64],
    /// p(Zᵢ | mᵢ, s), frame by frame.
    pub terms: &'a [Terms<'a>],
    /// How many times the data's cost counts: observations that err more, or more together, count less.
    pub data_weight: f64,
    /// E_d.
    pub contrasts: &'a Contrasts,
}

/// Frames that are summed one after the other, so that sums do not depend on the number of threads.
const CHUNK: usize = 8;

impl SequencePosterior<'_> {
    /// −log p(Zᵢ | mᵢ, s) − log p(mᵢ) of one frame, added to its equations.
    fn linearize_frame(&self, x: &SequenceState, i: usize, equations: &mut NormalEquations) -> f64 {
        let body = Posed::new(self.model, &x.shape, &x.motions[i]);
        let data = linearize_data(&self.terms[i], &body, equations);
        equations.hessian *= self.data_weight;
        equations.gradient *= self.data_weight;
        let lasts = self.lasts_s(i);
        self.data_weight * data
            + self.contrasts.linearize(i, &body, equations)
            + self.pose_prior.linearize_lasting(&x.motions[i], lasts, equations)
    }

    /// How long a frame lasts, seconds; the first frame's pose is drawn from all.
    fn lasts_s(&self, i: usize) -> f64 {
        if i == 0 { f64::INFINITY } else { self.seconds[i] }
    }

    /// Adds a run of frames to their links; returns their cost and what they add to the corner.
    fn linearize_chunk(
        &self,
        x: &SequenceState,
        first: usize,
        links: &mut [Link],
    ) -> (f64, NormalEquations) {
        let layout = Layout::new(self.model);
        let (m, p) = (layout.motion(), layout.total() - layout.motion());
        let mut equations = NormalEquations::zeros(m + p);
        let mut corner = NormalEquations::zeros(p);
        let mut cost = 0.0;

        for (k, link) in links.iter_mut().enumerate() {
            equations.hessian.fill(0.0);
            equations.gradient.fill(0.0);
            cost += self.linearize_frame(x, first + k, &mut equations);

            // blocks of the motion, of motion and shape, of the shape
            link.diagonal += equations.hessian.view((0, 0), (m, m));
            link.border += equations.hessian.view((m, 0), (p, m));
            link.gradient += equations.gradient.rows(0, m);
            corner.hessian += equations.hessian.view((m, m), (p, p));
            corner.gradient += equations.gradient.rows(m, p);
        }
        (cost, corner)
    }

    /// The fit of every frame; the data's cost has weight 1.
    pub(super) fn frame_fits(&self, x: &SequenceState) -> Vec<FrameFit> {
        let one = |(i, motion): (usize, &Motion)| {
            let body = Posed::new(self.model, &x.shape, motion);
            FrameFit {
                motion: motion.clone(),
                data: data_cost(&self.terms[i], &body),
                pose: self.pose_prior.cost_lasting(motion, self.lasts_s(i)),
                step: self.chain_prior.cost(&x.motions, self.seconds, i),
                observations: observations(&self.terms[i]),
                recovered: false,
            }
        };
        x.motions.par_iter().enumerate().map(one).collect()
    }
}

impl Problem for SequencePosterior<'_> {
    type State = SequenceState;
    type Model = BorderedChain;

    fn empty_model(&self) -> BorderedChain {
        let layout = Layout::new(self.model);
        let shared = layout.total() - layout.motion();
        BorderedChain::zeros(self.terms.len(), layout.motion(), shared, self.chain_prior.reach())
    }

    fn cost(&self, x: &SequenceState) -> f64 {
        let cost = |f: FrameFit| self.data_weight * f.data + f.pose + f.step;
        let each = self.frame_fits(x).into_iter().map(cost);
        let contrasts =
            |(i, motion)| self.contrasts.cost(i, &Posed::new(self.model, &x.shape, motion));
        let contrasts: Vec<f64> = x.motions.par_iter().enumerate().map(contrasts).collect();
        each.chain(contrasts).sum::<f64>() + self.shape_prior.cost(&x.shape)
    }

    fn linearize(&self, x: &SequenceState, model: &mut BorderedChain) -> f64 {
        // each frame by itself: data, limits and rest
        let chunks: Vec<(f64, NormalEquations)> = model
            .links
            .par_chunks_mut(CHUNK)
            .enumerate()
            .map(|(k, links)| self.linearize_chunk(x, k * CHUNK, links))
            .collect();
        // what they share: the shape
        let p = model.corner_gradient.len();
        let mut corner = NormalEquations::zeros(p);
        let mut cost = self.shape_prior.linearize(&x.shape, 0, &mut corner);
        for (chunk_cost, chunk) in chunks {
            cost += chunk_cost;
            corner.hessian += chunk.hessian;
            corner.gradient += chunk.gradient;
        }
        model.corner += corner.hessian;
        model.corner_gradient += corner.gradient;
        // how each follows the ones before
        let steps = (0..x.motions.len())
            .map(|i| self.chain_prior.linearize(&x.motions, self.seconds, i, &mut model.links));
        cost + steps.sum::<f64>()
    }

    fn retract(&self, x: &SequenceState, delta: &DVector<f64>) -> SequenceState {
        let layout = Layout::new(self.model);
        let m = layout.motion();
        let motion = |(i, motion): (usize, &Motion)| {
            layout.retract_motion(motion, &delta.rows(i * m, m).into_owned())
        };
        SequenceState {
            shape: Shape(&x.shape.0 + delta.rows(x.motions.len() * m, x.shape.0.len())),
            motions: x.motions.iter().enumerate().map(motion).collect(),
        }
    }
}

impl std::fmt::Debug for SequencePosterior<'_> {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "SequencePosterior({}, {} frames)", self.model.name, self.terms.len())
    }
}
