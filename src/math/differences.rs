//! Central differences with Richardson extrapolation: the oracle behind every derivative checker.

use nalgebra::{DMatrix, DVector};

/// Jacobian of `f` at 0, by central differences of step `h` and `h/2`, extrapolated.
///
/// J·eᵢ = (4·D(h/2) − D(h))/3, D(h) = (f(h·eᵢ) − f(−h·eᵢ))/(2h). The error is O(h⁴) plus rounding of O(ε/h).
/// `f` maps a displacement (`dimension` × 1) to a vector of any fixed length.
pub fn central_differences(
    dimension: usize,
    h: f64,
    f: impl Fn(&DVector<f64>) -> DVector<f64>,
) -> DMatrix<f64> {
    let slope = |i: usize, h: f64| {
        let mut delta = DVector::zeros(dimension);
        delta[i] = h;
        (f(&delta) - f(&-delta)) / (2.0 * h)
    };
    let columns: Vec<_> =
        (0..dimension).map(|i| (slope(i, 0.5 * h) * 4.0 - slope(i, h)) / 3.0).collect();
    DMatrix::from_columns(&columns)
}

/// A derivative that is not the slope of its function.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[error("∂{function}/∂{variable} is {analytic} and {numeric} by differences")]
pub struct DerivativeFault {
    /// Which number is differentiated.
    pub function: String,
    /// With respect to what, and where.
    pub variable: String,
    /// What the code says.
    pub analytic: f64,
    /// What differences say.
    pub numeric: f64,
}

/// Compares a Jacobian with the same by differences, column after column; `names` are those of a row's function and a
/// column's variable.
///
/// # Errors
/// The first entry that differs by more than its row's tolerance, or by NaN.
pub fn compare_derivatives(
    analytic: &DMatrix<f64>,
    numeric: &DMatrix<f64>,
    tolerance: impl Fn(usize) -> f64,
    names: impl Fn(usize, usize) -> [String; 2],
) -> Result<(), DerivativeFault> {
    let rows = analytic.nrows();
    let mut entries = (0..analytic.ncols()).flat_map(|c| (0..rows).map(move |r| (r, c)));
    let is_off = |at: &(usize, usize)| {
        let off = (analytic[*at] - numeric[*at]).abs();
        off.is_nan() || off > tolerance(at.0)
    };

    match entries.find(is_off) {
        None => Ok(()),
        Some((row, column)) => {
            let [function, variable] = names(row, column);
            let [analytic, numeric] = [analytic, numeric].map(|all| all[(row, column)]);
            Err(DerivativeFault { function, variable, analytic, numeric })
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_cubic_is_differentiated_to_rounding() {
        let jacobian = central_differences(2, 1e-2, |d| {
            DVector::from_vec(vec![(1.0 + d[0]).powi(3) * (2.0 + d[1])])
        });
        approx::assert_relative_eq!(jacobian[(0, 0)], 6.0, epsilon = 1e-10);
        approx::assert_relative_eq!(jacobian[(0, 1)], 1.0, epsilon = 1e-10);
    }

    #[test]
    fn a_sign_error_in_one_entry_is_found_and_named() {
        let numeric = DMatrix::from_row_slice(2, 2, &[1.0, 2.0, 3.0, 4.0]);
        let compare = |analytic: &DMatrix<f64>| {
            let names = |row, column| [format!("f[{row}]"), format!("δ[{column}]")];
            compare_derivatives(analytic, &numeric, |_| 1e-9, names)
        };
        let mut analytic = numeric.clone();
        assert_eq!(compare(&analytic), Ok(()));
        analytic[(1, 0)] = -3.0;
        let fault = compare(&analytic).unwrap_err();
        assert_eq!(fault.to_string(), "∂f[1]/∂δ[0] is -3 and 3 by differences");
        analytic[(0, 0)] = f64::NAN;
        assert_eq!(compare(&analytic).unwrap_err().function, "f[0]");
    }
}
