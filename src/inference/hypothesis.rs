//! A shape hypothesis, what became of it, and which one won.

use super::frame::FrameFit;
use crate::body::{BodyModel, Motion, Shape};

/// Where a shape hypothesis comes from.
#[derive(Debug, Clone, Copy, PartialEq, Eq, serde::Serialize, serde::Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Origin {
    /// The mean of p(s).
    Prior,
    /// argmax p(mₖ, s | Zₖ): the reading of that number, 0 the best.
    Keyframe(usize),
    /// The winner of the others, turned to face the other way.
    Turned,
}

/// A shape s*ₖ with the motion of its keyframe.
#[derive(Debug, Clone, PartialEq, serde::Serialize, serde::Deserialize)]
pub struct Hypothesis {
    /// Where it comes from.
    pub origin: Origin,
    /// Position of the keyframe among the frames.
    pub keyframe: usize,
    /// s.
    pub shape: Shape,
    /// mₖ.
    pub motion: Motion,
    /// −log p(mₖ, s | Zₖ) at the keyframe.
    pub keyframe_cost: f64,
}

impl Hypothesis {
    /// Whether it is one of this body.
    pub(super) fn fits(&self, model: &BodyModel) -> bool {
        self.shape.0.len() == model.coefficients.len() && is_of(&self.motion, model)
    }
}

/// What became of a hypothesis.
#[derive(Debug, Clone, PartialEq, serde::Serialize, serde::Deserialize)]
pub struct Trial {
    /// The hypothesis.
    pub hypothesis: Hypothesis,
    /// −log p(s).
    pub shape_cost: f64,
    /// The frames that were fitted; all of them unless it was pruned.
    pub frames: Vec<Option<FrameFit>>,
}

impl Trial {
    /// E of what was fitted: the sequence posterior's −log (eq. 1), or a lower bound if it was pruned.
    pub fn energy(&self) -> f64 {
        self.shape_cost + self.frames.iter().flatten().map(FrameFit::cost).sum::<f64>()
    }

    /// Whether it is one of this body in so many frames.
    pub(super) fn fits(&self, model: &BodyModel, frames: usize) -> bool {
        let mut fitted = self.frames.iter().flatten();
        self.frames.len() == frames
            && self.hypothesis.fits(model)
            && fitted.all(|fit| is_of(&fit.motion, model))
    }

    /// Every frame was fitted.
    pub fn finished(&self) -> bool {
        self.frames.iter().all(Option::is_some)
    }
}

fn is_of(motion: &Motion, model: &BodyModel) -> bool {
    motion.angles.len() == model.joints.len()
}

/// The finished trial of least energy.
pub(super) fn most_probable(trials: &[Trial]) -> Option<usize> {
    let finished = (0..trials.len()).filter(|&i| trials[i].finished());
    finished.min_by(|&a, &b| trials[a].energy().total_cmp(&trials[b].energy()))
}

/// What Algorithm 1 found.
#[derive(Debug, Clone, PartialEq)]
pub struct Search {
    /// All hypotheses in the order of their keyframes, the prior's first.
    pub trials: Vec<Trial>,
    /// Which of them is the most probable.
    pub winner: usize,
}

/// −log p of an observation that is of nobody, beside one that lies on the surface: it is anywhere in a room of five metres, and not
/// within a standard deviation of one centimetre; log(5 / (0.01 √2π)).
const OF_NOBODY: f64 = 5.3;

impl Search {
    /// By how much the winner makes the observations more probable than nobody would, log p(Z, s, m) − log p(Z | nobody).
    pub fn evidence(&self) -> f64 {
        let winner = &self.trials[self.winner];
        let frames = winner.frames.iter().flatten();
        OF_NOBODY * frames.map(|fit| fit.observations).sum::<f64>() - winner.energy()
    }
}
