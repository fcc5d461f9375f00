//! Nonlinear least squares: what is optimised, how, and how it ended.
//!
//! A [`Problem`] is a negative log density E(x) known as a sum of squared residuals; it fills
//! [`NormalEquations`] and never sees a damping factor. [`levenberg_marquardt`] minimises it and
//! never sees a camera. [`Loss`] makes residuals robust, [`check_linearization`] is the law that
//! every implementation is tested with.

mod check;
mod levenberg_marquardt;
mod normal_equations;
mod robust;

pub use check::{LinearizationFault, check_linearization};
pub use levenberg_marquardt::{Options, Report, Solution, Termination, levenberg_marquardt};
pub use normal_equations::NormalEquations;
pub use robust::Loss;

use nalgebra::DVector;

/// A negative log density, known as a sum of squared residuals.
///
/// Law, checked by [`check_linearization`] in the tests of every implementation:
/// `linearize` returns what `cost` returns, and the gradient that it adds is that of `cost`.
pub trait Problem {
    /// The unknowns x.
    type State: Clone;
    /// Number of components of a displacement δ.
    fn dimension(&self) -> usize;
    /// E(x).
    fn cost(&self, x: &Self::State) -> f64;
    /// Adds JᵀWJ and JᵀWr at x to `equations` and returns E(x).
    fn linearize(&self, x: &Self::State, equations: &mut NormalEquations) -> f64;
    /// x ⊞ δ.
    fn retract(&self, x: &Self::State, delta: &DVector<f64>) -> Self::State;
}
