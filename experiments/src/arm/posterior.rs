//! p(a | Z₁ … Zₙ) on a grid, every φ at its optimum (ZS06, Fig. 4).

use maquette::body::{Motion, Shape};
use maquette::inference::frame::FramePosterior;
use maquette::inference::step::StepPrior;
use maquette::inference::{Detail, Evidence, Sequence};
use maquette::solver::{Options, levenberg_marquardt};
use nalgebra::DVector;
use rayon::prelude::*;

/// a = 1/(1 + e⁻ˢ) of a shape of the model `arm-2d`.
pub fn share_of(shape: &Shape) -> f64 {
    1.0 / (1.0 + (-shape.0[0]).exp())
}

/// s = ln(a/(1 − a)).
pub fn coefficient_of(a: f64) -> Shape {
    Shape(DVector::from_element(1, (a / (1.0 - a)).ln()))
}

/// The data's say on a: p(Z₁ … Zₙ, φ* | a), as densities over 0 < a < 1 (a uniform prior of a).
#[derive(Debug, Clone)]
pub struct Posterior {
    grid: Vec<f64>,
    /// For each a, what each frame adds to −log p.
    costs: Vec<Vec<f64>>,
}

/// Turns of φ about its prediction from which each frame is fitted, radians: a wrong a has several optima.
const STARTS: [f64; 3] = [0.0, -0.2, 0.2];

impl Posterior {
    /// Fits every frame's φ at `cells` equally spaced values of a.
    pub fn new(evidence: &Evidence<'_>, sequence: Sequence<'_>, cells: usize) -> Self {
        let grid: Vec<f64> = (0..cells).map(|i| (i as f64 + 0.5) / cells as f64).collect();
        let costs = grid.par_iter().map(|&a| frame_costs(evidence, sequence, &coefficient_of(a)));
        Self { costs: costs.collect(), grid }
    }

    /// (a, density) given the first `frames` frames.
    pub fn after(&self, frames: usize) -> Vec<(f64, f64)> {
        let energy: Vec<f64> = self.costs.iter().map(|c| c[..frames].iter().sum()).collect();
        let least = energy.iter().copied().fold(f64::INFINITY, f64::min);
        let weights: Vec<f64> = energy.iter().map(|e| (least - e).exp()).collect();
        let sum = weights.iter().sum::<f64>() / self.grid.len() as f64;
        self.grid.iter().zip(weights).map(|(a, w)| (*a, w / sum)).collect()
    }

    /// exp(−∫ p ln p da): the width of the uniform density that says as little; 1 if nothing is known.
    pub fn width(&self, frames: usize) -> f64 {
        let terms =
            self.after(frames).into_iter().filter(|(_, p)| *p > 0.0).map(|(_, p)| -p * p.ln());
        (terms.sum::<f64>() / self.grid.len() as f64).exp()
    }

    /// The most probable a.
    pub fn mode(&self, frames: usize) -> f64 {
        let best = self.after(frames).into_iter().max_by(|x, y| x.1.total_cmp(&y.1));
        best.map_or(f64::NAN, |(a, _)| a)
    }
}

/// −log p(φᵢ* | φᵢ₋₁*, s, Zᵢ) frame by frame, without p(s).
fn frame_costs(evidence: &Evidence<'_>, sequence: Sequence<'_>, shape: &Shape) -> Vec<f64> {
    let step = StepPrior::new(evidence.model, 1.0 / sequence.fps);
    let mut last: Option<Motion> = None;
    let mut costs = Vec::with_capacity(sequence.frames.len());
    for frame in sequence.frames {
        let terms = evidence.terms(frame, Detail::Fine);
        let posterior = FramePosterior {
            model: evidence.model,
            shape,
            pose_prior: &evidence.pose_prior,
            step: last.as_ref().map(|mean| (&step, mean)),
            terms: &terms,
        };
        let predicted = last.clone().unwrap_or_else(|| Motion::rest(evidence.model));
        let fitted = STARTS.map(|turn| {
            let mut start = predicted.clone();
            start.angles.add_scalar_mut(turn);
            levenberg_marquardt(&posterior, start, &Options::default())
        });
        if let Some(best) = fitted.into_iter().min_by(|a, b| a.cost.total_cmp(&b.cost)) {
            costs.push(best.cost);
            last = Some(best.state);
        }
    }
    costs
}
