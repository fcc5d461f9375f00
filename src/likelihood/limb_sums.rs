//! Normal equations limb by limb.
//!
//! A row of a field term touches only the components that move its limb, 10 to 40 of them. So rows are summed
//! in a small dense matrix for each limb, and each of these is added to the whole once. Where the shape is given, its
//! components, more than half of a limb's, are not summed at all.

use std::collections::BTreeMap;

use super::offset_row::OffsetRow;
use crate::body::metaball::FieldSlopes;
use crate::solver::NormalEquations;

/// JᵀWJ and JᵀWr of the rows of each limb.
#[derive(Debug, Clone)]
pub(super) struct LimbSums {
    limbs: Vec<Sums>,
}

#[derive(Debug, Clone)]
struct Sums {
    /// By the component of an offset: what it has to do with the limb's components.
    offsets: BTreeMap<usize, Vec<f64>>,
    gradient: Vec<f64>,
    /// Column after column; the lower triangle is filled.
    hessian: Vec<f64>,
}

impl LimbSums {
    /// Zeros, for the components below `dimension`.
    pub(super) fn new(slopes: &FieldSlopes, dimension: usize) -> Self {
        let sums = |limb| {
            let n = slopes.components(limb).partition_point(|&c| c < dimension);
            Sums { offsets: BTreeMap::new(), gradient: vec![0.0; n], hessian: vec![0.0; n * n] }
        };
        Self { limbs: (0..slopes.limbs()).map(sums).collect() }
    }

    /// Adds a residual r of weight w with the derivatives `row`, one for each component of the limb.
    #[inline]
    pub(super) fn add(&mut self, limb: usize, row: &[f64], r: f64, w: f64) {
        let Sums { gradient, hessian, .. } = &mut self.limbs[limb];
        let n = gradient.len();
        let row = &row[..n];
        for (j, column) in hessian.chunks_exact_mut(n.max(1)).enumerate() {
            let scaled = w * row[j];
            gradient[j] += scaled * r;
            for (sum, value) in column[j..].iter_mut().zip(&row[j..]) {
                *sum += scaled * value;
            }
        }
    }

    /// Adds what the offsets of a residual of weight w have to do with the limb's components, whose derivatives are `row`.
    pub(super) fn add_offset(&mut self, limb: usize, row: &[f64], offset: &OffsetRow, w: f64) {
        let Sums { gradient, offsets, .. } = &mut self.limbs[limb];
        let n = gradient.len();
        for (component, slope) in offset.slopes {
            let sums = offsets.entry(component).or_insert_with(|| vec![0.0; n]);
            for (sum, value) in sums.iter_mut().zip(row) {
                *sum += w * slope * value;
            }
        }
    }

    /// Adds all sums to the equations; their dimension is that of [`LimbSums::new`].
    pub(super) fn add_to(&self, slopes: &FieldSlopes, equations: &mut NormalEquations) {
        for (limb, sums) in self.limbs.iter().enumerate() {
            let n = sums.gradient.len();
            let components = &slopes.components(limb)[..n];
            for (offset, sums) in &sums.offsets {
                for (&component, sum) in components.iter().zip(sums) {
                    let (row, column) = (component.max(*offset), component.min(*offset));
                    equations.hessian[(row, column)] += sum;
                }
            }
            for (j, &column) in components.iter().enumerate() {
                equations.gradient[column] += sums.gradient[j];
                for (i, &row) in components.iter().enumerate().skip(j) {
                    equations.hessian[(row, column)] += sums.hessian[j * n + i];
                }
            }
        }
    }
}
