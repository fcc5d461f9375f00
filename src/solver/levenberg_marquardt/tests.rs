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
    assert!(solution.report.costs.windows(2).all(|w| w[1] <= w[0]), "{:?}", solution.report.costs);
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

/// ½x² and its least value, which jumps up below an edge.
struct Ledge {
    least: f64,
    jump: f64,
    edge: f64,
    /// H as it is stated; 1 is right.
    curvature: f64,
}

impl Ledge {
    fn new(least: f64, jump: f64) -> Self {
        Self { least, jump, edge: 1.0, curvature: 1.0 }
    }
}

impl Problem for Ledge {
    type State = f64;
    type Model = NormalEquations;
    fn empty_model(&self) -> NormalEquations {
        NormalEquations::zeros(1)
    }
    fn cost(&self, x: &f64) -> f64 {
        self.least + 0.5 * x * x + if *x < self.edge { self.jump } else { 0.0 }
    }
    fn linearize(&self, x: &f64, equations: &mut NormalEquations) -> f64 {
        equations.gradient[0] += x;
        equations.hessian[(0, 0)] += self.curvature;
        self.cost(x)
    }
    fn retract(&self, x: &f64, delta: &DVector<f64>) -> f64 {
        x + delta[0]
    }
}

#[test]
fn the_last_step_is_taken_and_not_linearised() {
    let options = Options { damping: 0.1, relative_decrease: 1e-2, ..Options::default() };
    let solution = levenberg_marquardt(&Ledge::new(10.0, 0.0), 3.0, &options);
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
    let solution = levenberg_marquardt(&Ledge::new(0.0, 10.0), 3.0, &options);
    // from 3 towards 0, where the cost is 10: t = 9 / 2(10 − 4.5 + 9)
    approx::assert_relative_eq!(solution.state, 3.0 * (1.0 - 9.0 / 29.0), max_relative = 1e-2);
    assert_eq!((solution.report.iterations, solution.report.costs.len()), (2, 2));
}

#[test]
fn it_ends_where_less_than_the_tolerance_is_left_after_two_steps() {
    // steps that go half of the way, so that d ρ/(1 − ρ) is what is left
    let halving = Ledge { curvature: 2.0, ..Ledge::new(10.0, 0.0) };
    let options = Options { damping: 1e-9, relative_decrease: 2e-2, ..Options::default() };
    let solution = levenberg_marquardt(&halving, 4.0, &options);
    assert_eq!(solution.report.termination, Termination::Converged);
    // 4, 2, 1, ½; ⅛ is left at ½, whose g is not needed
    approx::assert_relative_eq!(solution.state, 0.5, max_relative = 1e-6);
    approx::assert_relative_eq!(solution.model.gradient[0], 1.0, max_relative = 1e-6);
}

#[test]
fn what_a_shortened_step_keeps_does_not_tell_what_is_left() {
    let ledge = Ledge { curvature: 2.0, edge: 1.5, ..Ledge::new(10.0, 5.0) };
    let options = Options { damping: 1e-9, relative_decrease: 1e-2, ..Options::default() };
    let solution = levenberg_marquardt(&ledge, 4.0, &options);
    // from 2, after a decrease by 6, the first shortened step ends at 1.82 and lowers the cost by a third
    assert!((1.5..1.6).contains(&solution.state), "{}", solution.state);
}

#[test]
fn the_checker_passes_a_right_derivative_and_names_the_wrong_one() {
    check_linearization(&Rosenbrock { slip: 0.0 }, &[-1.2, 1.0], 1e-4, 1e-7).unwrap();
    let fault =
        check_linearization(&Rosenbrock { slip: 0.5 }, &[-1.2, 1.0], 1e-4, 1e-7).unwrap_err();
    assert!(fault.to_string().contains("∂E/∂δ[0]"), "{fault}");
}
