//! L of H + λ·diag H = LLᵀ, in the places of H: a pass forwards; and the step −H⁻¹g, one forwards and one backwards.

use nalgebra::{DMatrix, DVector};

use super::BorderedChain;

/// L of H = LLᵀ, in the places of H.
pub(super) struct Factor {
    pub(super) links: Vec<FactorLink>,
    pub(super) corner: DMatrix<f64>,
}

pub(super) struct FactorLink {
    pub(super) diagonal: DMatrix<f64>,
    pub(super) couplings: Vec<DMatrix<f64>>,
    pub(super) border: DMatrix<f64>,
}

impl Factor {
    /// Cholesky factor of H + λ·(diag H + ε); `None` where that is not positive definite.
    pub(super) fn of(chain: &BorderedChain, lambda: f64) -> Option<Self> {
        let floor = 1e-9 * chain.largest_diagonal().max(f64::MIN_POSITIVE);
        let damped = |block: &DMatrix<f64>| {
            let mut block = block.clone();
            (0..block.nrows()).for_each(|k| block[(k, k)] += lambda * (block[(k, k)] + floor));
            block
        };
        let mut links: Vec<FactorLink> = Vec::with_capacity(chain.links.len());
        let mut corner = damped(&chain.corner);
        for (i, link) in chain.links.iter().enumerate() {
            let reach = link.couplings.len();
            // L(i, i−k), the farthest first: each needs those that are farther
            let mut couplings: Vec<DMatrix<f64>> = link.couplings.clone();
            for k in (1..=reach).rev() {
                for far in k + 1..=reach {
                    let Some(before) = links[i - k].couplings.get(far - k - 1) else {
                        continue;
                    };
                    let product = &couplings[far - 1] * before.transpose();
                    couplings[k - 1] -= product;
                }
                divide_right(&mut couplings[k - 1], &links[i - k].diagonal);
            }
            let mut diagonal = damped(&link.diagonal);
            let mut border = link.border.clone();
            for (k, coupling) in couplings.iter().enumerate() {
                let transposed = coupling.transpose();
                diagonal.gemm(-1.0, coupling, &transposed, 1.0);
                border.gemm(-1.0, &links[i - k - 1].border, &transposed, 1.0);
            }
            let diagonal = diagonal.cholesky()?.unpack();
            divide_right(&mut border, &diagonal);
            corner.gemm(-1.0, &border, &border.transpose(), 1.0);
            links.push(FactorLink {
                diagonal,
                couplings,
                border,
            });
        }
        let corner = if corner.is_empty() {
            corner
        } else {
            corner.cholesky()?.unpack()
        };
        Some(Factor { links, corner })
    }

    /// −H⁻¹g.
    pub(super) fn minimizer(&self, chain: &BorderedChain) -> DVector<f64> {
        let (n, p) = (self.links.len(), self.corner.nrows());
        let m = chain.links.first().map_or(0, |l| l.gradient.len());
        // forwards: Ly = −g
        let mut y: Vec<DVector<f64>> = Vec::with_capacity(n);
        let mut shared = -&chain.corner_gradient;
        for (i, (factor, link)) in self.links.iter().zip(&chain.links).enumerate() {
            let mut one = -&link.gradient;
            for (k, coupling) in factor.couplings.iter().enumerate() {
                one.gemv(-1.0, coupling, &y[i - k - 1], 1.0);
            }
            factor.diagonal.solve_lower_triangular_mut(&mut one);
            shared.gemv(-1.0, &factor.border, &one, 1.0);
            y.push(one);
        }
        if p > 0 {
            self.corner.solve_lower_triangular_mut(&mut shared);
            // backwards: Lᵀδ = y
            self.corner.tr_solve_lower_triangular_mut(&mut shared);
        }
        for i in (0..n).rev() {
            let factor = &self.links[i];
            let mut one = std::mem::replace(&mut y[i], DVector::zeros(0));
            one.gemv_tr(-1.0, &factor.border, &shared, 1.0);
            factor.diagonal.tr_solve_lower_triangular_mut(&mut one);
            for (k, coupling) in factor.couplings.iter().enumerate() {
                y[i - k - 1].gemv_tr(-1.0, coupling, &one, 1.0);
            }
            y[i] = one;
        }
        let mut delta = DVector::zeros(n * m + p);
        for (i, one) in y.iter().enumerate() {
            delta.rows_mut(i * m, m).copy_from(one);
        }
        delta.rows_mut(n * m, p).copy_from(&shared);
        delta
    }
}

/// block ← block · L⁻ᵀ.
fn divide_right(block: &mut DMatrix<f64>, lower: &DMatrix<f64>) {
    let mut transposed = block.transpose();
    lower.solve_lower_triangular_mut(&mut transposed);
    *block = transposed.transpose();
}
