//! The frame posteriors, ZS06 eq. 2 and 3, as least-squares problems, and their optimum.

use nalgebra::DVector;

use super::prior::{PosePrior, ShapePrior};
use super::step::StepPrior;
use crate::body::{BodyModel, Layout, Motion, Posed, Shape, State};
use crate::likelihood::Term;
use crate::solver::{NormalEquations, Problem};

/// −log p(mₖ, s | Zₖ) = −log p(Zₖ | mₖ, s) − log p(s) − log p(mₖ) (eq. 2).
pub struct KeyframePosterior<'a> {
    /// The body.
    pub model: &'a BodyModel,
    /// p(s).
    pub shape_prior: &'a ShapePrior,
    /// p(mₖ): limits and rest.
    pub pose_prior: &'a PosePrior,
    /// p(Zₖ | mₖ, s).
    pub terms: &'a [Box<dyn Term + 'a>],
}

/// −log p(mᵢ | mᵢ₋₁, s, Zᵢ) = −log p(Zᵢ | mᵢ, s) − log p(mᵢ | mᵢ₋₁) (eq. 3), shape given.
pub struct FramePosterior<'a> {
    /// The body.
    pub model: &'a BodyModel,
    /// s.
    pub shape: &'a Shape,
    /// p(mᵢ): limits and rest.
    pub pose_prior: &'a PosePrior,
    /// p(mᵢ | mᵢ₋₁) with the mean that mᵢ₋₁ predicts; uniform if `None`.
    pub step: Option<(&'a StepPrior, &'a Motion)>,
    /// p(Zᵢ | mᵢ, s).
    pub terms: &'a [Box<dyn Term + 'a>],
}

/// The most probable motion of one frame, and what it costs.
#[derive(Debug, Clone, PartialEq, serde::Serialize, serde::Deserialize)]
pub struct FrameFit {
    /// mᵢ.
    pub motion: Motion,
    /// −log p(Zᵢ | mᵢ, s).
    pub data: f64,
    /// −log p of limits and rest.
    pub pose: f64,
    /// −log p(mᵢ | its neighbour on the keyframe's side).
    pub step: f64,
    /// Independent observations behind `data`.
    pub observations: f64,
    /// The tracking was lost here, and the frame was searched anew.
    pub recovered: bool,
}

impl FrameFit {
    /// Its share of E.
    pub fn cost(&self) -> f64 {
        self.alone() + self.step
    }

    /// What it costs without its neighbour.
    pub(super) fn alone(&self) -> f64 {
        self.data + self.pose
    }

    /// The fit of a frame that shows nothing: the motion is taken to be the last that was seen.
    pub(super) fn held(pose_prior: &PosePrior, motion: Motion) -> Self {
        let pose = pose_prior.cost(&motion);
        Self { motion, data: 0.0, pose, step: 0.0, observations: 0.0, recovered: false }
    }

    /// The data's cost per observation.
    pub(super) fn level(&self) -> f64 {
        self.data / self.observations.max(1.0)
    }
}

/// −log p(Zᵢ | mᵢ, s).
pub(super) fn data_cost(terms: &[Box<dyn Term + '_>], body: &Posed<'_>) -> f64 {
    terms.iter().map(|t| t.cost(body)).sum()
}

/// The same, and its rows added to the equations.
pub(super) fn linearize_data(
    terms: &[Box<dyn Term + '_>],
    body: &Posed<'_>,
    equations: &mut NormalEquations,
) -> f64 {
    terms.iter().map(|t| t.linearize(body, equations)).sum()
}

/// Number of independent observations behind them.
pub(super) fn observations(terms: &[Box<dyn Term + '_>]) -> f64 {
    terms.iter().map(|t| t.observations()).sum()
}

impl Problem for KeyframePosterior<'_> {
    type State = State;
    type Model = NormalEquations;

    fn empty_model(&self) -> NormalEquations {
        NormalEquations::zeros(Layout::new(self.model).total())
    }

    fn cost(&self, x: &State) -> f64 {
        let body = Posed::new(self.model, &x.shape, &x.motion);
        data_cost(self.terms, &body)
            + self.shape_prior.cost(&x.shape)
            + self.pose_prior.cost(&x.motion)
    }

    fn linearize(&self, x: &State, equations: &mut NormalEquations) -> f64 {
        let body = Posed::new(self.model, &x.shape, &x.motion);
        let first = Layout::new(self.model).motion();
        linearize_data(self.terms, &body, equations)
            + self.shape_prior.linearize(&x.shape, first, equations)
            + self.pose_prior.linearize(&x.motion, equations)
    }

    fn retract(&self, x: &State, delta: &DVector<f64>) -> State {
        Layout::new(self.model).retract(x, delta)
    }
}

impl FramePosterior<'_> {
    fn step_cost(&self, motion: &Motion) -> f64 {
        let cost = |(step, mean): (&StepPrior, &Motion)| step.cost(mean, motion);
        self.step.map_or(0.0, cost)
    }

    /// The fit of a motion whose cost is known; the data's part of it is what the priors leave.
    pub(super) fn frame_fit(&self, motion: Motion, cost: f64) -> FrameFit {
        let (pose, step) = (self.pose_prior.cost(&motion), self.step_cost(&motion));
        FrameFit {
            motion,
            data: (cost - pose - step).max(0.0),
            pose,
            step,
            observations: observations(self.terms),
            recovered: false,
        }
    }
}

impl Problem for FramePosterior<'_> {
    type State = Motion;
    type Model = NormalEquations;

    fn empty_model(&self) -> NormalEquations {
        NormalEquations::zeros(Layout::new(self.model).motion())
    }

    fn cost(&self, x: &Motion) -> f64 {
        data_cost(self.terms, &Posed::new(self.model, self.shape, x))
            + self.pose_prior.cost(x)
            + self.step_cost(x)
    }

    fn linearize(&self, x: &Motion, equations: &mut NormalEquations) -> f64 {
        let body = Posed::new(self.model, self.shape, x);
        linearize_data(self.terms, &body, equations)
            + self.pose_prior.linearize(x, equations)
            + self.step.map_or(0.0, |(step, mean)| step.linearize(mean, x, equations))
    }

    fn retract(&self, x: &Motion, delta: &DVector<f64>) -> Motion {
        Layout::new(self.model).retract_motion(x, delta)
    }
}

impl std::fmt::Debug for KeyframePosterior<'_> {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "KeyframePosterior({}, {} terms)", self.model.name, self.terms.len())
    }
}

impl std::fmt::Debug for FramePosterior<'_> {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "FramePosterior({}, {} terms)", self.model.name, self.terms.len())
    }
}
