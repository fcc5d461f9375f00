//! The Cholesky factor of a chain, one pass forwards; and the step −H⁻¹g, one pass forwards and one backwards.

use nalgebra::{DMatrix, DVector};
use rayon::prelude::*;

use super::BorderedChain;

/// L of H = LLᵀ; its blocks lie where those of H lie.
pub(super) struct Factor {
    pub(super) links: Vec<FactorLink>,
    pub(super) corner: DMatrix<f64>,
}

/// Right-hand sides or solutions of a chain's equations, as columns.
pub(super) struct Columns {
    /// The components of each frame, m × columns.
    pub(super) frames: Vec<DMatrix<f64>>,
    /// The shared ones, p × columns.
    pub(super) shared: DMatrix<f64>,
}

/// The blocks of L in one frame's row.
pub(super) struct FactorLink {
    pub(super) diagonal: DMatrix<f64>,
    pub(super) couplings: Vec<DMatrix<f64>>,
    pub(super) border: DMatrix<f64>,
}

/// Frames that are summed one after the other, so that sums do not depend on the number of threads.
const CHUNK: usize = 8;

impl Factor {
    /// Cholesky factor of H + λ·(diag H + ε); `None` where that is not positive definite.
    pub(super) fn new(chain: &BorderedChain, lambda: f64) -> Option<Self> {
        let floor = 1e-9 * chain.largest_diagonal().max(f64::MIN_POSITIVE);
        let damped = |block: &DMatrix<f64>| {
            let mut block = block.clone();
            (0..block.nrows()).for_each(|k| block[(k, k)] += lambda * (block[(k, k)] + floor));
            block
        };

        let mut links: Vec<FactorLink> = Vec::with_capacity(chain.links.len());
        for (i, link) in chain.links.iter().enumerate() {
            // L(i, i−k), the farthest first: each needs those that are farther
            let reach = link.couplings.len();
            let mut couplings: Vec<DMatrix<f64>> = link.couplings.clone();
            for k in (1..=reach).rev() {
                for far in k + 1..=reach {
                    let Some(before) = links[i - k].couplings.get(far - k - 1) else {
                        continue;
                    };
                    let product = &couplings[far - 1] * before.transpose();
                    couplings[k - 1] -= product;
                }
                divide_by_transpose(&mut couplings[k - 1], &links[i - k].diagonal);
            }

            // A and B without what the frames before explain
            let mut diagonal = damped(&link.diagonal);
            let mut border = link.border.clone();
            for (k, coupling) in couplings.iter().enumerate() {
                let transposed = coupling.transpose();
                diagonal.gemm(-1.0, coupling, &transposed, 1.0);
                border.gemm(-1.0, &links[i - k - 1].border, &transposed, 1.0);
            }

            let diagonal = diagonal.cholesky()?.unpack();
            divide_by_transpose(&mut border, &diagonal);
            links.push(FactorLink { diagonal, couplings, border });
        }

        // the corner without what all frames explain
        let corner = damped(&chain.corner) - explained_by_all(&links);

        // a chain that shares nothing has no corner
        let corner = if corner.is_empty() { corner } else { corner.cholesky()?.unpack() };
        Some(Factor { links, corner })
    }

    /// −H⁻¹g.
    pub(super) fn minimizer(&self, chain: &BorderedChain) -> DVector<f64> {
        let column = |g: &DVector<f64>| DMatrix::from_column_slice(g.len(), 1, g.as_slice());
        let frames = chain.links.iter().map(|link| -column(&link.gradient));
        let shared = -column(&chain.corner_gradient);
        let solved = self.solve(Columns { frames: frames.collect(), shared });
        let all = solved.frames.iter().chain([&solved.shared]);
        let all: Vec<f64> = all.flat_map(|x| x.iter().copied()).collect();
        DVector::from_vec(all)
    }

    /// H⁻¹Y.
    pub(super) fn solve(&self, columns: Columns) -> Columns {
        let Columns { mut frames, mut shared } = columns;

        // forwards: LX = Y
        for (i, factor) in self.links.iter().enumerate() {
            let (before, from) = frames.split_at_mut(i);
            let one = &mut from[0];
            for (k, coupling) in factor.couplings.iter().enumerate() {
                one.gemm(-1.0, coupling, &before[i - k - 1], 1.0);
            }
            factor.diagonal.solve_lower_triangular_mut(one);
            shared.gemm(-1.0, &factor.border, one, 1.0);
        }

        // the corner, and backwards: LᵀX = X
        if !shared.is_empty() {
            self.corner.solve_lower_triangular_mut(&mut shared);
            self.corner.tr_solve_lower_triangular_mut(&mut shared);
        }
        for (i, factor) in self.links.iter().enumerate().rev() {
            let (before, from) = frames.split_at_mut(i);
            let one = &mut from[0];
            one.gemm_tr(-1.0, &factor.border, &shared, 1.0);
            factor.diagonal.tr_solve_lower_triangular_mut(one);
            for (k, coupling) in factor.couplings.iter().enumerate() {
                before[i - k - 1].gemm_tr(-1.0, coupling, one, 1.0);
            }
        }
        Columns { frames, shared }
    }
}

/// Σ BBᵀ of the borders of all frames.
pub(super) fn explained_by_all(links: &[FactorLink]) -> DMatrix<f64> {
    let shared = links.first().map_or(0, |link| link.border.nrows());
    let parts: Vec<DMatrix<f64>> = links.par_chunks(CHUNK).map(explained).collect();
    parts.iter().fold(DMatrix::zeros(shared, shared), |sum, part| sum + part)
}

/// Σ BBᵀ of the borders of some frames.
fn explained(links: &[FactorLink]) -> DMatrix<f64> {
    let shared = links[0].border.nrows();
    let mut sum = DMatrix::zeros(shared, shared);
    for link in links {
        sum.gemm(1.0, &link.border, &link.border.transpose(), 1.0);
    }
    sum
}

/// block ← block · L⁻ᵀ.
fn divide_by_transpose(block: &mut DMatrix<f64>, lower: &DMatrix<f64>) {
    let mut transposed = block.transpose();
    lower.solve_lower_triangular_mut(&mut transposed);
    *block = transposed.transpose();
}
