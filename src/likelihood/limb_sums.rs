//! Normal equations limb by limb.
//!
//! A row of a field term touches only the components that move its limb, 10 to 40 of them. So rows are summed
//! in a small dense matrix for each limb, and these are put into the whole one once.

use crate::body::metaball::FieldSlopes;
use crate::solver::NormalEquations;

/// JᵀWJ and JᵀWr of the rows of each limb.
#[derive(Debug, Clone)]
pub(super) struct LimbSums {
    limbs: Vec<Sums>,
}

#[derive(Debug, Clone)]
struct Sums {
    gradient: Vec<f64>,
    /// Column after column; the lower triangle is filled.
    hessian: Vec<f64>,
}

impl LimbSums {
    pub(super) fn new(slopes: &FieldSlopes) -> Self {
        let sums = |limb| {
            let n = slopes.components(limb).len();
            Sums {
                gradient: vec![0.0; n],
                hessian: vec![0.0; n * n],
            }
        };
        Self {
            limbs: (0..slopes.limbs()).map(sums).collect(),
        }
    }

    /// Adds a residual r of weight w with the derivatives `row`, one for each component of the limb.
    #[inline]
    pub(super) fn add(&mut self, limb: usize, row: &[f64], r: f64, w: f64) {
        let Sums { gradient, hessian } = &mut self.limbs[limb];
        let n = row.len();
        for (j, column) in hessian.chunks_exact_mut(n).enumerate() {
            let scaled = w * row[j];
            gradient[j] += scaled * r;
            for (sum, value) in column[j..].iter_mut().zip(&row[j..]) {
                *sum += scaled * value;
            }
        }
    }

    /// Adds all to the components that `equations` has.
    pub(super) fn add_to(&self, slopes: &FieldSlopes, equations: &mut NormalEquations) {
        for (limb, sums) in self.limbs.iter().enumerate() {
            let components = slopes.components(limb);
            let n = components.len();
            let free = components.partition_point(|&c| c < equations.gradient.len());
            for (j, &column) in components[..free].iter().enumerate() {
                equations.gradient[column] += sums.gradient[j];
                for (i, &row) in components[..free].iter().enumerate().skip(j) {
                    equations.hessian[(row, column)] += sums.hessian[j * n + i];
                }
            }
        }
    }
}
