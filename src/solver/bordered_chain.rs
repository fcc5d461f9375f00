//! The quadratic model of a chain: one block per frame, coupled to the frames before it, and a border shared by all.
//!
//! With the frames' components first and the shared ones last,
//!
//! ```text
//!     ⎡ A₀            B₀ᵀ ⎤         A  m × m, one a frame
//!     ⎢ U₁ A₁         B₁ᵀ ⎥         U  m × m, coupling to each of the `reach` frames before
//! H = ⎢    U₂ A₂      B₂ᵀ ⎥         B  p × m, the border
//!     ⎢       ⋱  ⋱    ⋮   ⎥         C  p × p, the corner
//!     ⎣ B₀ B₁ B₂  ⋯   C   ⎦
//! ```
//!
//! H = LLᵀ with L of the same form, so a step is one pass forwards and one backwards, O(n) in time and memory.
//! The blocks of H⁻¹ that lie where L has blocks follow in one more pass backwards, without the others
//! (Takahashi's recursion): with R the rows of L below frame i, Σ_Ri = −Σ_RR·L_Ri·Lᵢᵢ⁻¹ and
//! Σᵢᵢ = Lᵢᵢ⁻ᵀLᵢᵢ⁻¹ − Σᵢ_R·L_Ri·Lᵢᵢ⁻¹.
//!
//! # Source
//! Takahashi, Fagan, Chen 1973; Rue & Held 2005, *Gaussian Markov Random Fields*, § 2.3.

use nalgebra::{DMatrix, DVector};

use super::QuadraticModel;

/// One frame's part of the model.
#[derive(Debug, Clone)]
pub struct Link {
    /// Aᵢ, m × m, lower triangle.
    pub diagonal: DMatrix<f64>,
    /// Blocks (i, i − 1), (i, i − 2), …: m × m each, as many as the chain reaches back.
    pub couplings: Vec<DMatrix<f64>>,
    /// Bᵢ, p × m.
    pub border: DMatrix<f64>,
    /// gᵢ, m.
    pub gradient: DVector<f64>,
}

/// `E(x ⊞ δ) ≈ E(x) + gᵀδ + ½ δᵀHδ` of a chain with a border.
#[derive(Debug, Clone)]
pub struct BorderedChain {
    /// The frames, in order.
    pub links: Vec<Link>,
    /// C, p × p, lower triangle.
    pub corner: DMatrix<f64>,
    /// Gradient of the shared components, p.
    pub corner_gradient: DVector<f64>,
}

/// The covariances of one frame and of what all frames share: blocks of H⁻¹.
#[derive(Debug)]
pub struct Marginal<'a> {
    /// Σᵢᵢ, m × m.
    pub frame: &'a DMatrix<f64>,
    /// Σ of the shared components with the frame's, p × m.
    pub cross: &'a DMatrix<f64>,
    /// Σ of the shared components, p × p.
    pub shared: &'a DMatrix<f64>,
}

/// L of H = LLᵀ, in the places of H.
struct Factor {
    links: Vec<FactorLink>,
    corner: DMatrix<f64>,
}

struct FactorLink {
    diagonal: DMatrix<f64>,
    couplings: Vec<DMatrix<f64>>,
    border: DMatrix<f64>,
}

impl BorderedChain {
    /// The zero model of `frames` blocks of m components, each coupled to `reach` before it, and p shared components.
    pub fn zeros(frames: usize, m: usize, p: usize, reach: usize) -> Self {
        let link = |i: usize| Link {
            diagonal: DMatrix::zeros(m, m),
            couplings: vec![DMatrix::zeros(m, m); reach.min(i)],
            border: DMatrix::zeros(p, m),
            gradient: DVector::zeros(m),
        };
        Self {
            links: (0..frames).map(link).collect(),
            corner: DMatrix::zeros(p, p),
            corner_gradient: DVector::zeros(p),
        }
    }

    /// Cholesky factor of H + λ·(diag H + ε); `None` where that is not positive definite.
    fn factor(&self, lambda: f64) -> Option<Factor> {
        let floor = 1e-9 * self.largest_diagonal().max(f64::MIN_POSITIVE);
        let damped = |block: &DMatrix<f64>| {
            let mut block = block.clone();
            (0..block.nrows()).for_each(|k| block[(k, k)] += lambda * (block[(k, k)] + floor));
            block
        };
        let mut links: Vec<FactorLink> = Vec::with_capacity(self.links.len());
        let mut corner = damped(&self.corner);
        for (i, link) in self.links.iter().enumerate() {
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

    fn largest_diagonal(&self) -> f64 {
        let blocks = self.links.iter().map(|l| &l.diagonal).chain([&self.corner]);
        blocks
            .flat_map(|b| (0..b.nrows()).map(move |k| b[(k, k)]))
            .fold(0.0, f64::max)
    }

    /// Calls `visit(i, Σ)` for every frame, the last one first; `false` if H is not positive definite.
    pub fn marginals(&self, mut visit: impl FnMut(usize, &Marginal<'_>)) -> bool {
        let Some(factor) = self.factor(0.0) else {
            return false;
        };
        let shared = inverse_of_square(&factor.corner);
        // Σ of the frames behind, nearest first: (frame, cross with shared, with the frames behind it)
        let mut behind: Vec<Behind> = Vec::new();
        for (i, link) in factor.links.iter().enumerate().rev() {
            let reach = behind.len();
            let below = |k: usize| &factor.links[i + k + 1].couplings[k];
            // W = L_Ri · Lᵢᵢ⁻¹ for every row block R below
            let w: Vec<DMatrix<f64>> = (0..reach)
                .map(|k| divided_right_t(below(k), &link.diagonal))
                .collect();
            let w_border = divided_right_t(&link.border, &link.diagonal);
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
            visit(
                i,
                &Marginal {
                    frame: &frame,
                    cross: &cross,
                    shared: &shared,
                },
            );
            behind.insert(
                0,
                Behind {
                    frame,
                    cross,
                    to_behind,
                },
            );
            behind.truncate(self.reach());
        }
        true
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
        std::cmp::Ordering::Equal => behind[k].frame.clone(),
        std::cmp::Ordering::Greater => behind[l].to_behind[k - l - 1].clone(),
        std::cmp::Ordering::Less => behind[k].to_behind[l - k - 1].transpose(),
    }
}

/// block ← block · L⁻ᵀ.
fn divide_right(block: &mut DMatrix<f64>, lower: &DMatrix<f64>) {
    let mut transposed = block.transpose();
    lower.solve_lower_triangular_mut(&mut transposed);
    *block = transposed.transpose();
}

/// block · L⁻¹.
fn divided_right_t(block: &DMatrix<f64>, lower: &DMatrix<f64>) -> DMatrix<f64> {
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

impl Factor {
    /// −H⁻¹g.
    fn minimizer(&self, chain: &BorderedChain) -> DVector<f64> {
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

impl QuadraticModel for BorderedChain {
    fn clear(&mut self) {
        for link in &mut self.links {
            link.diagonal.fill(0.0);
            link.couplings.iter_mut().for_each(|c| c.fill(0.0));
            link.border.fill(0.0);
            link.gradient.fill(0.0);
        }
        self.corner.fill(0.0);
        self.corner_gradient.fill(0.0);
    }

    fn gradient(&self) -> DVector<f64> {
        let parts = self
            .links
            .iter()
            .map(|l| &l.gradient)
            .chain([&self.corner_gradient]);
        let all: Vec<f64> = parts.flat_map(|g| g.iter().copied()).collect();
        DVector::from_vec(all)
    }

    fn minimizer(&self, lambda: f64) -> Option<DVector<f64>> {
        Some(self.factor(lambda)?.minimizer(self))
    }

    fn predicted_decrease(&self, delta: &DVector<f64>) -> f64 {
        let m = self.links.first().map_or(0, |l| l.gradient.len());
        let shared = delta
            .rows(self.links.len() * m, self.corner.nrows())
            .into_owned();
        let step = |i: usize| delta.rows(i * m, m).into_owned();
        let mut curvature = quadratic(&self.corner, &shared);
        let mut slope = self.corner_gradient.dot(&shared);
        for (i, link) in self.links.iter().enumerate() {
            let own = step(i);
            slope += link.gradient.dot(&own);
            curvature += quadratic(&link.diagonal, &own) + 2.0 * shared.dot(&(&link.border * &own));
            for (k, coupling) in link.couplings.iter().enumerate() {
                curvature += 2.0 * own.dot(&(coupling * step(i - k - 1)));
            }
        }
        -slope - 0.5 * curvature
    }
}

/// xᵀMx from the lower triangle of M.
fn quadratic(lower: &DMatrix<f64>, x: &DVector<f64>) -> f64 {
    let mut product = DVector::zeros(x.len());
    product.sygemv(1.0, lower, x, 0.0);
    x.dot(&product)
}

#[cfg(test)]
mod tests {
    use rand::{RngExt, SeedableRng};

    use super::*;

    fn dense(chain: &BorderedChain) -> DMatrix<f64> {
        let (frames, m) = (chain.links.len(), chain.links[0].gradient.len());
        let p = chain.corner.nrows();
        let mut dense = DMatrix::zeros(frames * m + p, frames * m + p);
        let mut put = |row, column, block: &DMatrix<f64>| {
            dense
                .view_mut((row, column), block.shape())
                .copy_from(block);
        };
        for (i, link) in chain.links.iter().enumerate() {
            put(i * m, i * m, &link.diagonal);
            put(frames * m, i * m, &link.border);
            for (k, coupling) in link.couplings.iter().enumerate() {
                put(i * m, (i - k - 1) * m, coupling);
            }
        }
        put(frames * m, frames * m, &chain.corner);
        dense.fill_upper_triangle_with_lower_triangle();
        dense
    }

    /// A random positive definite chain and the dense matrix that it stands for.
    fn random(frames: usize, m: usize, p: usize, reach: usize) -> (BorderedChain, DMatrix<f64>) {
        let mut rng =
            rand_chacha::ChaCha8Rng::seed_from_u64((frames * 100 + m * 10 + reach) as u64);
        let mut draw =
            |rows, columns| DMatrix::from_fn(rows, columns, |_, _| rng.random_range(-1.0..1.0));
        let mut chain = BorderedChain::zeros(frames, m, p, reach);
        for link in &mut chain.links {
            link.couplings.iter_mut().for_each(|c| *c = draw(m, m));
            link.border = draw(p, m);
            link.gradient = draw(m, 1).column(0).into_owned();
            let a = draw(m, m);
            link.diagonal = &a * a.transpose() + DMatrix::identity(m, m) * (8.0 * (m + p) as f64);
        }
        let c = draw(p, p);
        chain.corner = &c * c.transpose() + DMatrix::identity(p, p) * (4.0 * (m * frames) as f64);
        chain.corner_gradient = draw(p, 1).column(0).into_owned();
        let dense = dense(&chain);
        (chain, dense)
    }

    const SIZES: [(usize, usize, usize, usize); 5] = [
        (1, 3, 2, 1),
        (6, 3, 2, 1),
        (7, 4, 3, 2),
        (5, 2, 0, 2),
        (4, 3, 2, 0),
    ];

    #[test]
    fn its_step_is_that_of_the_dense_matrix() {
        for (frames, m, p, reach) in SIZES {
            let (chain, dense) = random(frames, m, p, reach);
            for lambda in [0.0, 0.3] {
                let floor = 1e-9 * dense.diagonal().amax();
                let mut damped = dense.clone();
                (0..dense.nrows()).for_each(|k| damped[(k, k)] += lambda * (dense[(k, k)] + floor));
                let expected = damped.cholesky().unwrap().solve(&-chain.gradient());
                let step = chain.minimizer(lambda).unwrap();
                approx::assert_relative_eq!(step, expected, epsilon = 1e-12);
            }
        }
    }

    #[test]
    fn its_predicted_decrease_is_that_of_the_dense_matrix() {
        for (frames, m, p, reach) in SIZES {
            let (chain, dense) = random(frames, m, p, reach);
            let step = DVector::from_fn(dense.nrows(), |i, _| (i as f64).sin());
            let expected = -chain.gradient().dot(&step) - 0.5 * step.dot(&(&dense * &step));
            approx::assert_relative_eq!(
                chain.predicted_decrease(&step),
                expected,
                max_relative = 1e-12
            );
        }
    }

    #[test]
    fn its_marginals_are_blocks_of_the_dense_inverse() {
        for (frames, m, p, reach) in SIZES {
            let (chain, dense) = random(frames, m, p, reach);
            let inverse = dense.cholesky().unwrap().inverse();
            let mut visited = 0;
            assert!(chain.marginals(|i, marginal| {
                visited += 1;
                let block = |rows: usize, columns: usize, r, c| {
                    inverse.view((rows, columns), (r, c)).into_owned()
                };
                approx::assert_relative_eq!(
                    *marginal.frame,
                    block(i * m, i * m, m, m),
                    epsilon = 1e-12
                );
                approx::assert_relative_eq!(
                    *marginal.cross,
                    block(frames * m, i * m, p, m),
                    epsilon = 1e-12
                );
                approx::assert_relative_eq!(
                    *marginal.shared,
                    block(frames * m, frames * m, p, p),
                    epsilon = 1e-12
                );
            }));
            assert_eq!(visited, frames);
        }
    }

    #[test]
    fn marginals_of_a_long_stiff_chain_stay_those_of_the_dense_inverse() {
        let (n, m) = (150, 2);
        let mut chain = BorderedChain::zeros(n, m, 1, 2);
        let (stiff, held) = (1e6, 1.0);
        for i in 0..n {
            for (a, slope) in [1.0, -2.0, 1.0].into_iter().enumerate().filter(|_| i > 1) {
                for (b, other) in [1.0, -2.0, 1.0].into_iter().enumerate().skip(a) {
                    let link = &mut chain.links[i - a];
                    let block = if a == b {
                        &mut link.diagonal
                    } else {
                        &mut link.couplings[b - a - 1]
                    };
                    (0..m).for_each(|k| block[(k, k)] += stiff * slope * other);
                }
            }
            let row = DMatrix::from_row_slice(1, 3, &[1.0, 0.3, 1.0 + (i as f64).sin()]);
            let outer = row.tr_mul(&row) * held;
            chain.links[i].diagonal += outer.view((0, 0), (m, m)) + DMatrix::identity(m, m) * 0.01;
            chain.links[i].border += outer.view((m, 0), (1, m));
            chain.corner += outer.view((m, m), (1, 1));
        }
        let inverse = dense(&chain).cholesky().unwrap().inverse();
        assert!(chain.marginals(|i, marginal| {
            let block = inverse.view((i * m, i * m), (m, m)).into_owned();
            approx::assert_relative_eq!(*marginal.frame, block, max_relative = 1e-6);
        }));
    }

    #[test]
    fn a_frame_that_nothing_holds_has_no_step_without_damping() {
        let (mut chain, _) = random(3, 2, 1, 1);
        chain.links[1].diagonal.fill(0.0);
        assert!(chain.minimizer(0.0).is_none());
        assert!(!chain.marginals(|_, _| ()));
    }
}
