//! The law of every problem: what `linearize` says is what `cost` does.

use nalgebra::{DMatrix, DVector};

use super::{Problem, QuadraticModel};
use crate::math::{DerivativeFault, central_differences, compare_derivatives};

/// How a linearisation contradicts its cost.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum LinearizationFault {
    /// The two evaluations differ.
    #[error("linearize returns {linearized}, cost returns {cost}")]
    Cost {
        /// What `linearize` returned.
        linearized: f64,
        /// What `cost` returned.
        cost: f64,
    },
    /// One component of the gradient is wrong.
    #[error(transparent)]
    Gradient(#[from] DerivativeFault),
}

/// Compares `linearize` with `cost` and with central differences of it at `x`.
///
/// The gradient must agree within `tolerance` of its largest component, with differences of step `h`.
///
/// # Errors
/// The first disagreement that was found.
pub fn check_linearization<P: Problem>(
    problem: &P,
    x: &P::State,
    h: f64,
    tolerance: f64,
) -> Result<(), LinearizationFault> {
    let mut model = problem.empty_model();
    let linearized = problem.linearize(x, &mut model);
    let gradient = model.gradient();
    let cost = problem.cost(x);

    if (linearized - cost).abs() > 1e-12 * cost.abs().max(1.0) {
        return Err(LinearizationFault::Cost { linearized, cost });
    }

    let numeric = central_differences(gradient.len(), h, |delta| {
        DVector::from_element(1, problem.cost(&problem.retract(x, delta)))
    });
    let scale = numeric.amax().max(1e-3);
    let analytic = DMatrix::from_row_slice(1, gradient.len(), gradient.as_slice());
    let names = |_, component| ["E".into(), format!("δ[{component}]")];
    Ok(compare_derivatives(&analytic, &numeric, |_| tolerance * scale, names)?)
}
