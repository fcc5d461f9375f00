//! Normal equations in the numbers of the ellipses, chained to the body once.
//!
//! In a camera an ellipse has 5 numbers, in the world an ellipsoid has 9. Rows are summed over the
//! points in the 5, over the cameras in the 9, and only then multiplied with the body's Jacobian:
//! H = Σᵢⱼ Jᵢᵀ (Σ_cameras Pᵢᵀ (Σ_points) Pⱼ) Jⱼ. A row that touches two ellipses (smooth minimum)
//! adds a block to their pair.

use std::collections::BTreeMap;

use nalgebra::{SMatrix, SVector};

use crate::body::EllipsoidJacobians;
use crate::math::quadric::ProjectionJacobian;
use crate::solver::NormalEquations;

/// Gradient and Hessian blocks, `N` numbers per ellipse.
#[derive(Debug, Clone)]
pub(super) struct EllipseSums<const N: usize> {
    gradients: Vec<SVector<f64, N>>,
    /// Where the block of a pair (i ≥ j) is; `NONE` if no row touched it.
    places: Vec<u32>,
    blocks: Vec<(usize, usize, SMatrix<f64, N, N>)>,
    /// Of an offset's component and an ellipse.
    offsets: BTreeMap<(usize, usize), SVector<f64, N>>,
}

const NONE: u32 = u32::MAX;

impl<const N: usize> EllipseSums<N> {
    pub(super) fn new(ellipses: usize) -> Self {
        Self {
            gradients: vec![SVector::zeros(); ellipses],
            places: vec![NONE; ellipses * ellipses],
            blocks: Vec::with_capacity(4 * ellipses),
            offsets: BTreeMap::new(),
        }
    }

    pub(super) fn clear(&mut self) {
        self.gradients.fill(SVector::zeros());
        self.places.fill(NONE);
        self.blocks.clear();
        self.offsets.clear();
    }

    /// Adds one residual r of weight w whose derivative is `rows[k].1` in ellipse `rows[k].0`.
    #[inline]
    pub(super) fn add(&mut self, rows: &[(usize, SVector<f64, N>)], r: f64, w: f64) {
        for (k, (i, a)) in rows.iter().enumerate() {
            self.gradients[*i] += a * (w * r);
            for (j, b) in &rows[..=k] {
                let ((i, a), (j, b)) = if i >= j { ((i, a), (j, b)) } else { ((j, b), (i, a)) };
                self.block(*i, *j).ger(w, a, b, 1.0);
            }
        }
    }

    fn block(&mut self, i: usize, j: usize) -> &mut SMatrix<f64, N, N> {
        let place = &mut self.places[i * self.gradients.len() + j];
        if *place == NONE {
            *place = self.blocks.len() as u32;
            self.blocks.push((i, j, SMatrix::zeros()));
        }
        &mut self.blocks[*place as usize].2
    }
}

impl EllipseSums<5> {
    /// Adds what one residual r of weight w has to do with offsets, whose components have the derivatives `offset`: their own
    /// equations, and those with the ellipses of `rows`.
    pub(super) fn add_offset(
        &mut self,
        offset: impl Iterator<Item = (usize, f64)> + Clone,
        rows: &[(usize, SVector<f64, 5>)],
        r: f64,
        w: f64,
        equations: &mut NormalEquations,
    ) {
        for (component, slope) in offset.clone() {
            if component >= equations.gradient.len() {
                return;
            }
            equations.gradient[component] += w * slope * r;
            for (other, other_slope) in offset.clone().filter(|(other, _)| *other <= component) {
                equations.hessian[(component, other)] += w * slope * other_slope;
            }
            for (ellipse, row) in rows {
                let sum = self.offsets.entry((component, *ellipse)).or_default();
                *sum += row * (w * slope);
            }
        }
    }
}

impl EllipseSums<9> {
    /// Adds one camera's sums through its projection Jacobians.
    pub(super) fn add_camera(&mut self, sums: &EllipseSums<5>, projections: &[ProjectionJacobian]) {
        for (gradient, (g, p)) in
            self.gradients.iter_mut().zip(sums.gradients.iter().zip(projections))
        {
            *gradient += p.tr_mul(g);
        }
        for (i, j, block) in &sums.blocks {
            let chained = projections[*i].tr_mul(block) * projections[*j];
            *self.block(*i, *j) += chained;
        }
        for ((component, ellipse), sum) in &sums.offsets {
            let chained = projections[*ellipse].tr_mul(sum);
            *self.offsets.entry((*component, *ellipse)).or_default() += chained;
        }
    }

    /// Chains to the body: adds to the components that `equations` has.
    pub(super) fn add_to(&self, jacobians: &EllipsoidJacobians, equations: &mut NormalEquations) {
        let free: Vec<usize> = jacobians
            .components
            .iter()
            .map(|c| c.partition_point(|&component| component < equations.gradient.len()))
            .collect();
        for (i, gradient) in self.gradients.iter().enumerate() {
            for (column, &component) in jacobians.components[i][..free[i]].iter().enumerate() {
                equations.gradient[component] += jacobians.values[i].column(column).dot(gradient);
            }
        }
        for ((offset, ellipse), sum) in &self.offsets {
            let components = &jacobians.components[*ellipse][..free[*ellipse]];
            for (column, &component) in components.iter().enumerate() {
                let value = jacobians.values[*ellipse].column(column).dot(sum);
                let (row, column) = (component.max(*offset), component.min(*offset));
                equations.hessian[(row, column)] += value;
            }
        }
        for (i, j, block) in &self.blocks {
            let (rows, columns) =
                (&jacobians.components[*i][..free[*i]], &jacobians.components[*j][..free[*j]]);
            for (b, &column) in columns.iter().enumerate() {
                let pull = block * jacobians.values[*j].column(b);
                // a pair's block stands for its transpose too; on the diagonal half of it is enough
                let first = if i == j { b } else { 0 };
                for (a, &row) in rows.iter().enumerate().skip(first) {
                    let value = jacobians.values[*i].column(a).dot(&pull);
                    let twice = if i != j && row == column { 2.0 } else { 1.0 };
                    equations.hessian[(row.max(column), row.min(column))] += twice * value;
                }
            }
        }
    }
}
