//! Nonlinear least squares: what is optimised, how, and how it ended.
//!
//! A [`Problem`] is a negative log density E(x) known as a sum of squared residuals; it fills a
//! [`QuadraticModel`] (dense [`NormalEquations`], or a [`BorderedChain`] of frames) and never sees a
//! damping factor. [`levenberg_marquardt`] minimises it and never sees a camera. [`Loss`] makes
//! residuals robust, [`check_linearization`] is the law that every implementation is tested with.

mod bordered_chain;
mod check;
mod levenberg_marquardt;
mod normal_equations;
mod robust;

#[cfg(test)]
pub(crate) use bordered_chain::tests::dense;
pub use bordered_chain::{BorderedChain, Link, Marginal};
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
    /// The form of g and H.
    type Model: QuadraticModel;
    /// The zero model of this problem's dimension.
    fn empty_model(&self) -> Self::Model;
    /// E(x).
    fn cost(&self, x: &Self::State) -> f64;
    /// Adds JᵀWJ and JᵀWr at x to `model` and returns E(x).
    fn linearize(&self, x: &Self::State, model: &mut Self::Model) -> f64;
    /// x ⊞ δ.
    fn retract(&self, x: &Self::State, delta: &DVector<f64>) -> Self::State;
}

/// `E(x ⊞ δ) ≈ E(x) + gᵀδ + ½ δᵀHδ`, with E = ½ Σ w r², g = JᵀWr, H = JᵀWJ.
pub trait QuadraticModel: Clone {
    /// Sets everything back to zero, keeping the memory.
    fn clear(&mut self);
    /// g.
    fn gradient(&self) -> DVector<f64>;
    /// The δ that minimises the model with λ·(diag H + ε) added; `None` where H is not positive definite.
    fn minimizer(&self, lambda: f64) -> Option<DVector<f64>>;
    /// E(x) − model(δ) = −gᵀδ − ½ δᵀHδ.
    fn predicted_decrease(&self, delta: &DVector<f64>) -> f64;
}
