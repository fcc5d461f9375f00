//! Gauss–Newton with Marquardt's damping.

use nalgebra::DVector;

use super::{Problem, QuadraticModel};

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
    /// g and H at x, or before the last step; H is the precision of the Laplace approximation.
    pub model: M,
    /// How it went.
    pub report: Report,
}

/// A step is not shortened to less than this part of it at once.
const SHORTEST: f64 = 0.1;
/// λ beyond which no step lowers the cost.
const MAX_DAMPING: f64 = 1e8;

/// Minimises a problem from `start`.
///
/// Every candidate is linearised at once: most are accepted, and a separate evaluation of the cost would be work done
/// twice. Only the last is not: the step that promises less than the tolerance changes neither g nor H by anything that counts, and is
/// taken if its cost is lower. A candidate of higher cost is dropped. The step is then shortened once: E along δ is taken for the parabola
/// through E(x), its slope there and the cost that was dropped,
///
/// t = −gᵀδ / 2(E(x ⊞ δ) − E(x) − gᵀδ),
///
/// which needs no linearisation where it fails. A cost with small jumps rises behind one of them at any λ that does not
/// change the step, and Nielsen's rule alone came to a λ that does after five or six linearisations. If x ⊞ tδ is no better either, λ
/// grows by that rule.
///
/// # Source
/// Marquardt 1963 (scaling by diag H); Madsen, Nielsen, Tingleff 2004, algorithm 3.16; Dennis & Schnabel 1983, § 6.3.2 (the
/// parabola).
pub fn levenberg_marquardt<P: Problem>(
    problem: &P,
    start: P::State,
    options: &Options,
) -> Solution<P::State, P::Model> {
    let mut state = start;
    let mut model = problem.empty_model();
    let mut candidate_model = model.clone();
    let mut cost = problem.linearize(&state, &mut model);
    let mut costs = vec![cost];
    let (mut lambda, mut growth, mut iterations) = (options.damping, 2.0, 0);

    let termination = loop {
        if lambda > MAX_DAMPING {
            break Termination::Stalled;
        }
        if iterations >= options.max_iterations {
            break Termination::OutOfIterations;
        }

        // more damping where H is not positive definite
        let step = model.minimizer(lambda);
        let Some(mut delta) = step.filter(|d| d.iter().all(|v| v.is_finite())) else {
            lambda = (lambda * 10.0).max(1e-6);
            continue;
        };

        // the last step
        let promised = model.predicted_decrease(&delta);
        if promised <= options.relative_decrease * cost.abs() {
            if let Some(lower) = lower(problem, &state, cost, &delta) {
                (state, cost) = lower;
                costs.push(cost);
            }
            break Termination::Converged;
        }

        // try the step
        iterations += 1;
        let mut candidate = problem.retract(&state, &delta);
        candidate_model.clear();
        let mut candidate_cost = problem.linearize(&candidate, &mut candidate_model);

        if candidate_cost.is_nan() || candidate_cost >= cost {
            // drop it, and try a shorter one
            if negligible(&delta) {
                break Termination::Stalled;
            }
            delta *= shortening(cost, candidate_cost, model.gradient().dot(&delta));
            let may_go_on = iterations < options.max_iterations;
            let shorter = may_go_on.then(|| lower(problem, &state, cost, &delta)).flatten();
            let Some((shorter, _)) = shorter else {
                lambda = (lambda * growth).max(1e-9);
                growth *= 2.0;
                continue;
            };
            candidate = shorter;
            iterations += 1;
            candidate_model.clear();
            candidate_cost = problem.linearize(&candidate, &mut candidate_model);
        }

        // take it, and trust the model as far as it was right
        let (decrease, promised) = (cost - candidate_cost, model.predicted_decrease(&delta));
        let gain = decrease / promised.max(f64::MIN_POSITIVE);
        lambda *= (1.0 - (2.0 * gain - 1.0).powi(3)).clamp(0.1, 1.0);
        growth = 2.0;
        state = candidate;
        std::mem::swap(&mut model, &mut candidate_model);
        cost = candidate_cost;
        costs.push(cost);
        if decrease <= options.relative_decrease * cost.abs() {
            break Termination::Converged;
        }
    };

    Solution { state, cost, model, report: Report { termination, iterations, costs } }
}

/// x ⊞ δ and its cost, if that is lower than the one of x.
fn lower<P: Problem>(
    problem: &P,
    state: &P::State,
    cost: f64,
    delta: &DVector<f64>,
) -> Option<(P::State, f64)> {
    let candidate = problem.retract(state, delta);
    let candidate_cost = problem.cost(&candidate);
    (candidate_cost < cost).then_some((candidate, candidate_cost))
}

/// t: by how much a step is shortened behind which the cost is higher; `slope` is gᵀδ.
fn shortening(cost: f64, dropped: f64, slope: f64) -> f64 {
    let t = -slope / (2.0 * (dropped - cost - slope));
    // a dropped cost that is not finite says only that the step was too long
    if t.is_finite() { t.clamp(SHORTEST, 0.5) } else { SHORTEST }
}

fn negligible(delta: &DVector<f64>) -> bool {
    delta.amax() < 1e-12
}

#[cfg(test)]
mod tests {
    use nalgebra::DVector;

    use super::*;
    use crate::solver::{NormalEquations, check_linearization};

    /// Rosenbrock's valley as residuals 10(y − x²), 1 − x; `slip` plants a wrong derivative.
    struct Rosenbrock {
        slip: f64,
    }

    impl Problem for Rosenbrock {
        type State = [f64; 2];
        type Model = NormalEquations;
        fn empty_model(&self) -> NormalEquations {
            NormalEquations::zeros(2)
        }
        fn cost(&self, x: &[f64; 2]) -> f64 {
            0.5 * ((10.0 * (x[1] - x[0] * x[0])).powi(2) + (1.0 - x[0]).powi(2))
        }
        fn linearize(&self, x: &[f64; 2], equations: &mut NormalEquations) -> f64 {
            let rows = [
                (10.0 * (x[1] - x[0] * x[0]), [-20.0 * x[0] + self.slip, 10.0]),
                (1.0 - x[0], [-1.0, 0.0]),
            ];
            for (r, j) in rows {
                for a in 0..2 {
                    equations.gradient[a] += j[a] * r;
                    (0..=a).for_each(|b| equations.hessian[(a, b)] += j[a] * j[b]);
                }
            }
            self.cost(x)
        }
        fn retract(&self, x: &[f64; 2], delta: &DVector<f64>) -> [f64; 2] {
            [x[0] + delta[0], x[1] + delta[1]]
        }
    }

    #[test]
    fn rosenbrock_is_solved_and_the_cost_never_rises() {
        let solution = levenberg_marquardt(
            &Rosenbrock { slip: 0.0 },
            [-1.2, 1.0],
            &Options { max_iterations: 100, relative_decrease: 1e-12, ..Options::default() },
        );
        approx::assert_relative_eq!(solution.state[0], 1.0, epsilon = 1e-6);
        approx::assert_relative_eq!(solution.state[1], 1.0, epsilon = 1e-6);
        assert!(
            solution.report.costs.windows(2).all(|w| w[1] <= w[0]),
            "{:?}",
            solution.report.costs
        );
    }

    /// |x| made of halves that meet in a kink, where every step of the right half's model is too long.
    struct Kink;

    impl Problem for Kink {
        type State = f64;
        type Model = NormalEquations;
        fn empty_model(&self) -> NormalEquations {
            NormalEquations::zeros(1)
        }
        fn cost(&self, x: &f64) -> f64 {
            1.0 + 1e-6 * x.max(-1e6 * x)
        }
        fn linearize(&self, x: &f64, equations: &mut NormalEquations) -> f64 {
            equations.gradient[0] += 1e-6;
            equations.hessian[(0, 0)] += 1e-6;
            self.cost(x)
        }
        fn retract(&self, x: &f64, delta: &DVector<f64>) -> f64 {
            x + delta[0]
        }
    }

    #[test]
    fn a_dropped_step_that_promised_less_than_the_tolerance_ends_it() {
        let solution = levenberg_marquardt(&Kink, 0.0, &Options::default());
        assert_eq!(solution.report.termination, Termination::Converged);
        assert_eq!((solution.state, solution.report.iterations), (0.0, 0));
    }

    /// ½x² and its least value, which jumps up below 1.
    struct Parabola {
        least: f64,
        jump: f64,
    }

    impl Problem for Parabola {
        type State = f64;
        type Model = NormalEquations;
        fn empty_model(&self) -> NormalEquations {
            NormalEquations::zeros(1)
        }
        fn cost(&self, x: &f64) -> f64 {
            self.least + 0.5 * x * x + if *x < 1.0 { self.jump } else { 0.0 }
        }
        fn linearize(&self, x: &f64, equations: &mut NormalEquations) -> f64 {
            equations.gradient[0] += x;
            equations.hessian[(0, 0)] += 1.0;
            self.cost(x)
        }
        fn retract(&self, x: &f64, delta: &DVector<f64>) -> f64 {
            x + delta[0]
        }
    }

    #[test]
    fn the_last_step_is_taken_and_not_linearised() {
        let options = Options { damping: 0.1, relative_decrease: 1e-2, ..Options::default() };
        let solution = levenberg_marquardt(&Parabola { least: 10.0, jump: 0.0 }, 3.0, &options);
        let Report { termination, iterations, costs } = &solution.report;
        assert_eq!((*termination, *iterations), (Termination::Converged, 1));
        // from 3 to 0.27, and on; g is that of 0.27
        assert_eq!(costs.len(), 3);
        assert!(costs.is_sorted_by(|before, after| after < before), "{costs:?}");
        assert!(solution.state < 0.01, "{}", solution.state);
        approx::assert_relative_eq!(solution.model.gradient[0], 3.0 * 0.1 / 1.1, epsilon = 1e-6);
    }

    #[test]
    fn a_step_behind_a_jump_is_shortened_and_needs_no_other_damping() {
        let options = Options { max_iterations: 2, ..Options::default() };
        let solution = levenberg_marquardt(&Parabola { least: 0.0, jump: 10.0 }, 3.0, &options);
        // from 3 towards 0, where the cost is 10: t = 9 / 2(10 − 4.5 + 9)
        approx::assert_relative_eq!(solution.state, 3.0 * (1.0 - 9.0 / 29.0), max_relative = 1e-2);
        assert_eq!((solution.report.iterations, solution.report.costs.len()), (2, 2));
    }

    #[test]
    fn the_checker_passes_a_right_derivative_and_names_the_wrong_one() {
        check_linearization(&Rosenbrock { slip: 0.0 }, &[-1.2, 1.0], 1e-4, 1e-7).unwrap();
        let fault =
            check_linearization(&Rosenbrock { slip: 0.5 }, &[-1.2, 1.0], 1e-4, 1e-7).unwrap_err();
        assert!(fault.to_string().contains("∂E/∂δ[0]"), "{fault}");
    }
}
