//! The quadratic model of a cost around a state.

use nalgebra::{DMatrix, DVector};

use super::QuadraticModel;

/// `E(x ⊞ δ) ≈ E(x) + gᵀδ + ½ δᵀHδ`, with E = ½ Σ w r², g = JᵀWr, H = JᵀWJ.
///
/// Only the lower triangle of `hessian` is filled and read.
#[derive(Debug, Clone)]
pub struct NormalEquations {
    /// H, dimension × dimension, lower triangle.
    pub hessian: DMatrix<f64>,
    /// g, dimension × 1.
    pub gradient: DVector<f64>,
}

impl NormalEquations {
    /// The zero model of a given dimension.
    pub fn zeros(dimension: usize) -> Self {
        Self { hessian: DMatrix::zeros(dimension, dimension), gradient: DVector::zeros(dimension) }
    }

    /// Adds one scalar residual `r` with weight `w` and a Jacobian that is zero but in component `i`.
    pub fn add_single(&mut self, i: usize, slope: f64, r: f64, w: f64) {
        self.gradient[i] += w * slope * r;
        self.hessian[(i, i)] += w * slope * slope;
    }
}

impl QuadraticModel for NormalEquations {
    fn clear(&mut self) {
        self.hessian.fill(0.0);
        self.gradient.fill(0.0);
    }

    fn gradient(&self) -> DVector<f64> {
        self.gradient.clone()
    }

    fn minimizer(&self, lambda: f64) -> Option<DVector<f64>> {
        let mut damped = self.hessian.clone();
        let floor = 1e-9 * damped.diagonal().amax().max(f64::MIN_POSITIVE);
        for i in 0..damped.nrows() {
            damped[(i, i)] += lambda * (damped[(i, i)] + floor);
        }
        Some(damped.cholesky()?.solve(&-&self.gradient))
    }

    fn predicted_decrease(&self, delta: &DVector<f64>) -> f64 {
        let mut product = DVector::zeros(delta.len());
        product.sygemv(1.0, &self.hessian, delta, 0.0);
        -self.gradient.dot(delta) - 0.5 * delta.dot(&product)
    }
}
