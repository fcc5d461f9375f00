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

/// Row and column of the first entry in which two Jacobians differ by more than its row's tolerance, or by NaN.
///
/// Searched column after column.
pub fn first_difference(
    analytic: &DMatrix<f64>,
    numeric: &DMatrix<f64>,
    tolerance: impl Fn(usize) -> f64,
) -> Option<(usize, usize)> {
    let rows = analytic.nrows();
    let mut entries = (0..analytic.ncols()).flat_map(|c| (0..rows).map(move |r| (r, c)));
    entries.find(|&at| {
        let off = (analytic[at] - numeric[at]).abs();
        off.is_nan() || off > tolerance(at.0)
    })
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
}
