//! Covariances of a chain: only the blocks of H⁻¹ that lie where L has blocks, in one pass backwards.
//!
//! Takahashi's recursion: with R the rows of L below frame i, Σ_Ri = −Σ_RR·L_Ri·Lᵢᵢ⁻¹ and
//! Σᵢᵢ = Lᵢᵢ⁻ᵀLᵢᵢ⁻¹ − Σᵢ_R·L_Ri·Lᵢᵢ⁻¹.
//!
//! # Source
//! Takahashi, Fagan, Chen 1973; Rue & Held 2005, *Gaussian Markov Random Fields*, § 2.3.

use std::cmp::Ordering;

use nalgebra::DMatrix;

use super::BorderedChain;
use super::factor::Factor;

/// The covariances of one frame and of what all frames share: blocks of H⁻¹.
#[derive(Debug)]
pub struct Marginal<'a> {
    /// Σᵢᵢ, m × m.
    pub frame: &'a DMatrix<f64>,
    /// Σ of the shared components with the frame's, p × m.
    pub cross: &'a DMatrix<f64>,
    /// Σ of the shared components, p × p.
    pub shared: &'a DMatrix<f64>,
    /// Σ of each of the frames coupled to it that follow, nearest first, with the frame's, m × m each.
    pub followers: &'a [DMatrix<f64>],
}

impl Marginal<'_> {
    /// Σ of the frame's components and then of the shared ones, (m + p) × (m + p).
    pub fn covariance(&self) -> DMatrix<f64> {
        let (m, p) = (self.frame.nrows(), self.shared.nrows());
        let mut all = DMatrix::zeros(m + p, m + p);
        all.view_mut((0, 0), (m, m)).copy_from(self.frame);
        all.view_mut((m, 0), (p, m)).copy_from(self.cross);
        all.view_mut((m, m), (p, p)).copy_from(self.shared);
        all.fill_upper_triangle_with_lower_triangle();
        all
    }
}

impl BorderedChain {
    /// Calls `visit(i, Σ)` for every frame, the last one first; `false` if H is not positive definite.
    pub fn marginals(&self, mut visit: impl FnMut(usize, &Marginal<'_>)) -> bool {
        let Some(factor) = Factor::new(self, 0.0) else {
            return false;
        };
        let shared = inverse_of_square(&factor.corner);
        // nearest first
        let mut behind: Vec<Behind> = Vec::new();

        for (i, link) in factor.links.iter().enumerate().rev() {
            let reach = behind.len();
            let below = |k: usize| &factor.links[i + k + 1].couplings[k];

            // W = L_Ri · Lᵢᵢ⁻¹ for every row block R below
            let w: Vec<DMatrix<f64>> =
                (0..reach).map(|k| divided_by(below(k), &link.diagonal)).collect();
            let w_border = divided_by(&link.border, &link.diagonal);

            // Σ_Ri = −Σ_RR W
            let mut cross = -(&shared * &w_border);
            for (b, w) in behind.iter().zip(&w) {
                cross.gemm(-1.0, &b.cross, w, 1.0);
            }
            let to_behind: Vec<DMatrix<f64>> = (0..reach)
                .map(|k| {
                    let mut block = -(behind[k].cross.transpose() * &w_border);
                    for (l, w) in w.iter().enumerate() {
                        block -= between(&behind, k, l) * w;
                    }
                    block
                })
                .collect();

            // Σᵢᵢ = Lᵢᵢ⁻ᵀLᵢᵢ⁻¹ − Σᵢ_R W
            let mut frame = inverse_of_square(&link.diagonal) - cross.transpose() * &w_border;
            for (block, w) in to_behind.iter().zip(&w) {
                frame -= block.transpose() * w;
            }
            // rounding that breaks the symmetry grows from frame to frame
            frame = (&frame + frame.transpose()) * 0.5;

            let followers = &to_behind;
            visit(i, &Marginal { frame: &frame, cross: &cross, shared: &shared, followers });

            // the frames before are coupled to so many behind
            behind.insert(0, Behind { frame, cross, to_behind });
            behind.truncate(self.reach());
        }
        true
    }

    /// Σ of the shared components, p × p; `None` if H is not positive definite.
    pub fn shared_covariance(&self) -> Option<DMatrix<f64>> {
        Some(inverse_of_square(&Factor::new(self, 0.0)?.corner))
    }

    fn reach(&self) -> usize {
        self.links.last().map_or(0, |l| l.couplings.len())
    }
}

/// Covariances of a frame that was visited: its own, with the shared components, with the frames behind it.
struct Behind {
    frame: DMatrix<f64>,
    cross: DMatrix<f64>,
    /// Σ(frame behind by k + 1, this frame).
    to_behind: Vec<DMatrix<f64>>,
}

/// Σ(k, l) of two frames behind.
fn between(behind: &[Behind], k: usize, l: usize) -> DMatrix<f64> {
    match k.cmp(&l) {
        Ordering::Equal => behind[k].frame.clone(),
        Ordering::Greater => behind[l].to_behind[k - l - 1].clone(),
        Ordering::Less => behind[k].to_behind[l - k - 1].transpose(),
    }
}

/// block · L⁻¹.
fn divided_by(block: &DMatrix<f64>, lower: &DMatrix<f64>) -> DMatrix<f64> {
    let mut transposed = block.transpose();
    lower.tr_solve_lower_triangular_mut(&mut transposed);
    transposed.transpose()
}

/// (LLᵀ)⁻¹.
fn inverse_of_square(lower: &DMatrix<f64>) -> DMatrix<f64> {
    let mut inverse = DMatrix::identity(lower.nrows(), lower.nrows());
    lower.solve_lower_triangular_mut(&mut inverse);
    inverse.tr_mul(&inverse)
}
