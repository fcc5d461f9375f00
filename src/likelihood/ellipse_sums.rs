//! Normal equations in the numbers of the ellipses, chained to the body once.
//!
//! In a camera an ellipse has 5 numbers, in the world an ellipsoid has 9. Rows are summed over the
//! points in the 5, over the cameras in the 9, and only then multiplied with the body's Jacobian:
//! H = Σᵢⱼ Jᵢᵀ (Σ_cameras Pᵢᵀ (Σ_points) Pⱼ) Jⱼ. A row that touches two ellipses (smooth minimum)
//! adds a block to their pair.

use nalgebra::{SMatrix, SVector};

use super::offset_row::OffsetRow;
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
    /// Of an ellipse and the component of an offset, in the order in which they came.
    offsets: Vec<(usize, usize, SVector<f64, N>)>,
    /// Where each is, by ellipse and component.
    offset_places: Vec<Vec<u32>>,
}

const NONE: u32 = u32::MAX;

impl<const N: usize> EllipseSums<N> {
    pub(super) fn new(ellipses: usize) -> Self {
        Self {
            gradients: vec![SVector::zeros(); ellipses],
            places: vec![NONE; ellipses * ellipses],
            blocks: Vec::with_capacity(4 * ellipses),
            offsets: Vec::new(),
            offset_places: vec![Vec::new(); ellipses],
        }
    }

    pub(super) fn clear(&mut self) {
        self.gradients.fill(SVector::zeros());
        self.places.fill(NONE);
        self.blocks.clear();
        for (ellipse, component, _) in self.offsets.drain(..) {
            self.offset_places[ellipse][component] = NONE;
        }
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

    fn offset(&mut self, ellipse: usize, component: usize) -> &mut SVector<f64, N> {
        let places = &mut self.offset_places[ellipse];
        if places.len() <= component {
            places.resize(component + 1, NONE);
        }
        let place = &mut places[component];
        if *place == NONE {
            *place = self.offsets.len() as u32;
            self.offsets.push((ellipse, component, SVector::zeros()));
        }
        &mut self.offsets[*place as usize].2
    }
}

impl EllipseSums<5> {
    /// Adds what the offsets of a residual of weight w have to do with the ellipses of its `rows`.
    pub(super) fn add_offset(
        &mut self,
        offset: &OffsetRow,
        rows: &[(usize, SVector<f64, 5>)],
        w: f64,
    ) {
        for (ellipse, row) in rows {
            for (component, slope) in offset.slopes {
                *self.offset(*ellipse, component) += row * (w * slope);
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
        for (ellipse, component, sum) in &sums.offsets {
            *self.offset(*ellipse, *component) += projections[*ellipse].tr_mul(sum);
        }
    }

    /// Chains to the body: adds to the components that `equations` has.
    ///
    /// With Jᵢ the body's Jacobian of ellipsoid i and Bᵢⱼ the blocks, H = A + Aᵀ with A = Σᵢ JᵢᵀRᵢ,
    /// Rᵢ = ½BᵢᵢJᵢ + Σ BᵢⱼJⱼ over j < i, and what offsets have to do with i in their own columns of Rᵢ.
    pub(super) fn add_to(&self, jacobians: &EllipsoidJacobians, equations: &mut NormalEquations) {
        let dimension = equations.gradient.len();
        let free = |i: usize| {
            let components = &jacobians.components[i];
            let free = components.partition_point(|&component| component < dimension);
            components[..free].iter().copied().zip(jacobians.values[i].column_iter())
        };

        let hessian = &mut equations.hessian;
        let mut row = SparseRow::new(dimension);
        for (i, gradient) in self.gradients.iter().enumerate() {
            for (component, slope) in free(i) {
                equations.gradient[component] += slope.dot(gradient);
            }

            // Rᵢ
            for (j, block) in self.blocks_of(i) {
                let block = if i == j { block * 0.5 } else { *block };
                free(j).for_each(|(component, slope)| row.add(component, &(block * slope)));
            }
            self.offsets_of(i).for_each(|(component, sum)| row.add(component, sum));

            // A and Aᵀ, of which only the lower triangle counts
            row.drain(|column, pull| {
                for (component, slope) in free(i) {
                    let value = slope.dot(pull);
                    let place = (component.max(column), component.min(column));
                    hessian[place] += if component == column { 2.0 * value } else { value };
                }
            });
        }
    }

    /// The blocks (i, j), j ≤ i, that a row touched.
    fn blocks_of(&self, i: usize) -> impl Iterator<Item = (usize, &SMatrix<f64, 9, 9>)> {
        let count = self.gradients.len();
        let places = self.places[i * count..][..=i].iter().enumerate();
        places.filter(|(_, place)| **place != NONE).map(|(j, p)| (j, &self.blocks[*p as usize].2))
    }

    /// The offsets that a row of ellipse i touched.
    fn offsets_of(&self, i: usize) -> impl Iterator<Item = (usize, &SVector<f64, 9>)> {
        let places = self.offset_places[i].iter().enumerate();
        places.filter(|(_, place)| **place != NONE).map(|(c, p)| (c, &self.offsets[*p as usize].2))
    }
}

/// A row of many columns of 9 numbers, of which few are not 0.
struct SparseRow {
    columns: Vec<SVector<f64, 9>>,
    is_touched: Vec<bool>,
    touched: Vec<usize>,
}

impl SparseRow {
    fn new(columns: usize) -> Self {
        Self {
            columns: vec![SVector::zeros(); columns],
            is_touched: vec![false; columns],
            touched: Vec::with_capacity(columns),
        }
    }

    #[inline]
    fn add(&mut self, column: usize, value: &SVector<f64, 9>) {
        if !std::mem::replace(&mut self.is_touched[column], true) {
            self.touched.push(column);
        }
        self.columns[column] += value;
    }

    /// Calls `visit` for every column that is not 0, and clears it.
    fn drain(&mut self, mut visit: impl FnMut(usize, &SVector<f64, 9>)) {
        for column in self.touched.drain(..) {
            visit(column, &self.columns[column]);
            self.columns[column] = SVector::zeros();
            self.is_touched[column] = false;
        }
    }
}
