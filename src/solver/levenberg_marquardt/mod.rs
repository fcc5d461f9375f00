//! Gauss–Newton with Marquardt's damping.

mod parabola;

use nalgebra::DVector;

use super::{Problem, QuadraticModel};
use parabola::Parabola;

/// When to stop, and how careful to begin.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Options {
    /// Most linearisations after the first.
    pub max_iterations: usize,
    /// First λ; 0 would be Gauss–Newton.
    pub damping: f64,
    /// The last step is the one that promises to lower the cost by less than this fraction of it, or that does so.
    pub relative_decrease: f64,
}

impl Default for Options {
    fn default() -> Self {
        Self { max_iterations: 30, damping: 1e-3, relative_decrease: 1e-5 }
    }
}

/// How an optimisation ended; none of these is an error.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Termination {
    /// The cost no longer falls by more than the tolerance.
    Converged,
    /// The iterations were used up.
    OutOfIterations,
    /// No damping gave a lower cost: a minimum to rounding, or a wrong derivative.
    Stalled,
}

/// How an optimisation went.
#[derive(Debug, Clone, PartialEq)]
pub struct Report {
    /// Why it ended.
    pub termination: Termination,
    /// Linearisations after the first.
    pub iterations: usize,
    /// E at the start and after every accepted step: never rising.
    pub costs: Vec<f64>,
}

/// The state of least cost that was found, with its quadratic model.
#[derive(Debug, Clone)]
pub struct Solution<S, M> {
    /// x.
    pub state: S,
    /// E(x).
    pub cost: f64,
    /// g and H; H is the precision of the Laplace approximation.
    pub model: M,
    /// Where they are: x, or before the last step.
    pub linearized_at: S,
    /// How it went.
    pub report: Report,
}

/// λ beyond which no step lowers the cost.
const MAX_DAMPING: f64 = 1e8;
/// λ that a step feels: less hardly changes it, and what was no better would not be better again.
const FELT: f64 = 1e-2;
/// A step that promises less than this many times the tolerance is likely the last.
const LIKELY_LAST: f64 = 10.0;

/// Minimises a problem from `start`.
///
/// A candidate is linearised at once, as most are accepted, and a separate evaluation of the cost would be work done twice. One that is
/// likely the last is not: its cost is evaluated alone, and it is linearised only where it lowers the cost by more than the tolerance, and
/// more than that is left. Gauss–Newton converges linearly: if the step before lowered the cost by d′ and a whole one by d, what is left is
/// about
///
/// d ρ/(1 − ρ),  ρ = d/d′.
///
/// A step that promises less than the tolerance, or keeps less, changes neither g nor H by anything that counts, and is taken if its
/// cost is lower. A candidate of higher cost is dropped. The step is then shortened once: E along δ is taken for the parabola
/// through E(x), its slope there and the cost that was dropped,
///
/// t = −gᵀδ / 2(E(x ⊞ δ) − E(x) − gᵀδ),
///
/// which needs no linearisation where it fails. Where the parabola falls by less than the tolerance, that is the last step, too. A cost
/// with small jumps rises behind one of them at any λ that does not change the step. If x ⊞ tδ is no better either, λ
/// grows by Nielsen's rule, but at once to 10⁻², which the step feels.
///
/// # Source
/// Marquardt 1963 (scaling by diag H); Madsen, Nielsen, Tingleff 2004, algorithm 3.16; Dennis & Schnabel 1983, § 6.3.2 (the
/// parabola).
pub fn levenberg_marquardt<P: Problem>(
    problem: &P,
    start: P::State,
    options: &Options,
) -> Solution<P::State, P::Model> {
    let mut descent = Descent::new(problem, start, options);
    let termination = loop {
        if let Some(termination) = descent.advance() {
            break termination;
        }
    };

    let Descent { state, cost, model, linearized_at, iterations, costs, .. } = descent;
    let report = Report { termination, iterations, costs };
    Solution { state, cost, model, linearized_at, report }
}

/// Where a minimisation has come to.
struct Descent<'p, P: Problem> {
    problem: &'p P,
    options: &'p Options,
    state: P::State,
    cost: f64,
    model: P::Model,
    linearized_at: P::State,
    /// The model at a candidate.
    candidate_model: P::Model,
    lambda: f64,
    growth: f64,
    iterations: usize,
    costs: Vec<f64>,
}

/// How a candidate was tried.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Tried {
    /// [`Descent::candidate_model`] is its own.
    Linearized,
    /// Its cost alone, as the step is likely the last.
    LikelyLast,
    /// Its cost alone, behind a shortened step: what that lowers the cost by says nothing of how fast it falls.
    Shortened,
}

impl<'p, P: Problem> Descent<'p, P> {
    fn new(problem: &'p P, state: P::State, options: &'p Options) -> Self {
        let mut model = problem.empty_model();
        let candidate_model = model.clone();
        let cost = problem.linearize(&state, &mut model);
        Self {
            problem,
            options,
            linearized_at: state.clone(),
            state,
            cost,
            model,
            candidate_model,
            lambda: options.damping,
            growth: 2.0,
            iterations: 0,
            costs: vec![cost],
        }
    }

    /// Tries one step; why it was the last.
    fn advance(&mut self) -> Option<Termination> {
        if self.lambda > MAX_DAMPING {
            return Some(Termination::Stalled);
        }
        if self.iterations >= self.options.max_iterations {
            return Some(Termination::OutOfIterations);
        }

        // more damping where H is not positive definite
        let step = self.model.minimizer(self.lambda);
        let Some(delta) = step.filter(|d| d.iter().all(|v| v.is_finite())) else {
            self.lambda = (self.lambda * 10.0).max(1e-6);
            return None;
        };

        // the last step
        let promised = self.model.predicted_decrease(&delta);
        if promised <= self.tolerance() {
            self.take_if_lower(&delta);
            return Some(Termination::Converged);
        }

        // try the step
        self.iterations += 1;
        let candidate = self.problem.retract(&self.state, &delta);
        let (cost, tried) = match promised <= LIKELY_LAST * self.tolerance() {
            true => (self.problem.cost(&candidate), Tried::LikelyLast),
            false => (self.linearize(&candidate), Tried::Linearized),
        };
        match cost < self.cost {
            true => self.take(candidate, cost, tried, &delta),
            false => self.shorten(delta, cost),
        }
    }

    /// The decrease below which a step is the last.
    fn tolerance(&self) -> f64 {
        self.options.relative_decrease * self.cost.abs()
    }

    /// The cost of a candidate, and its model.
    fn linearize(&mut self, candidate: &P::State) -> f64 {
        self.candidate_model.clear();
        self.problem.linearize(candidate, &mut self.candidate_model)
    }

    /// Takes a step that lowers the cost, and trusts the model as far as it was right.
    fn take(
        &mut self,
        candidate: P::State,
        cost: f64,
        tried: Tried,
        delta: &DVector<f64>,
    ) -> Option<Termination> {
        let decrease = self.cost - cost;
        let tolerance = self.options.relative_decrease * cost.abs();
        let is_last = decrease <= tolerance
            || tried == Tried::LikelyLast && self.left_after(decrease) <= tolerance;
        if tried != Tried::Linearized && !is_last {
            self.linearize(&candidate);
        }

        let gain = decrease / self.model.predicted_decrease(delta).max(f64::MIN_POSITIVE);
        self.lambda *= (1.0 - (2.0 * gain - 1.0).powi(3)).clamp(0.1, 1.0);
        self.growth = 2.0;
        self.go_to(candidate, cost);
        if tried == Tried::Linearized || !is_last {
            std::mem::swap(&mut self.model, &mut self.candidate_model);
            self.linearized_at = self.state.clone();
        }
        is_last.then_some(Termination::Converged)
    }

    /// By how much the cost is likely still to fall after a decrease; infinite if it falls no slower than before.
    fn left_after(&self, decrease: f64) -> f64 {
        let [.., before, now] = self.costs[..] else { return f64::INFINITY };
        let rate = decrease / (before - now);
        if rate < 1.0 { decrease * rate / (1.0 - rate) } else { f64::INFINITY }
    }

    /// Tries a shorter step where the cost behind δ is not lower.
    fn shorten(&mut self, mut delta: DVector<f64>, dropped: f64) -> Option<Termination> {
        if negligible(&delta) {
            return Some(Termination::Stalled);
        }
        let parabola = Parabola::new(self.cost, dropped, self.model.gradient().dot(&delta));
        delta *= parabola.step();
        if parabola.is_known() && parabola.promised <= self.tolerance() {
            self.take_if_lower(&delta);
            return Some(Termination::Converged);
        }

        if self.iterations < self.options.max_iterations {
            let shorter = self.problem.retract(&self.state, &delta);
            let cost = self.problem.cost(&shorter);
            if cost < self.cost {
                self.iterations += 1;
                return self.take(shorter, cost, Tried::Shortened, &delta);
            }
        }
        self.lambda = (self.lambda * self.growth).max(FELT);
        self.growth *= 2.0;
        None
    }

    fn take_if_lower(&mut self, delta: &DVector<f64>) {
        let candidate = self.problem.retract(&self.state, delta);
        let cost = self.problem.cost(&candidate);
        if cost < self.cost {
            self.go_to(candidate, cost);
        }
    }

    fn go_to(&mut self, state: P::State, cost: f64) {
        self.state = state;
        self.cost = cost;
        self.costs.push(cost);
    }
}

fn negligible(delta: &DVector<f64>) -> bool {
    delta.amax() < 1e-12
}

#[cfg(test)]
mod tests;
