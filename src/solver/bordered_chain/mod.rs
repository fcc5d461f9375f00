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
//! H = LLᵀ with L of the same form, so a step is one pass forwards and one backwards, O(n) in time and memory (`factor`).
//! The covariances are one more pass backwards (`marginals`).

mod factor;
mod marginals;

use nalgebra::{DMatrix, DVector};

pub use marginals::Marginal;

use super::QuadraticModel;
use factor::{Factor, explained_by_all};

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

impl BorderedChain {
    /// The zero model of `frames` blocks of m components, each coupled to the `reach` blocks before it, and p shared components.
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

    /// The same chain given what is shared, with this precision Λ; `None` where the chain is not positive definite.
    ///
    /// C = Λ + Σᵢ BᵢAᵢ⁻¹Bᵢᵀ: then H⁻¹ has Λ⁻¹ in its corner.
    pub fn with_shared_precision(mut self, shared: &DMatrix<f64>) -> Option<Self> {
        let factor = Factor::new(&self, 0.0)?;
        self.corner = shared + explained_by_all(&factor.links);
        Some(self)
    }

    /// The chain of the frames alone, where what they share is fixed.
    #[must_use]
    pub fn of_frames(&self) -> Self {
        let m = self.links.first().map_or(0, |link| link.gradient.len());
        let without_border = |link: &Link| Link { border: DMatrix::zeros(0, m), ..link.clone() };
        Self {
            links: self.links.iter().map(without_border).collect(),
            corner: DMatrix::zeros(0, 0),
            corner_gradient: DVector::zeros(0),
        }
    }

    /// Multiplies it by a factor.
    pub fn scale(&mut self, factor: f64) {
        for link in &mut self.links {
            link.diagonal *= factor;
            link.couplings.iter_mut().for_each(|coupling| *coupling *= factor);
            link.border *= factor;
            link.gradient *= factor;
        }
        self.corner *= factor;
        self.corner_gradient *= factor;
    }

    /// Adds a model of the same form, times a factor.
    pub fn add_scaled(&mut self, other: &Self, factor: f64) {
        for (link, other) in self.links.iter_mut().zip(&other.links) {
            link.diagonal += &other.diagonal * factor;
            for (coupling, other) in link.couplings.iter_mut().zip(&other.couplings) {
                *coupling += other * factor;
            }
            link.border += &other.border * factor;
            link.gradient.axpy(factor, &other.gradient, 1.0);
        }
        self.corner += &other.corner * factor;
        self.corner_gradient.axpy(factor, &other.corner_gradient, 1.0);
    }

    fn largest_diagonal(&self) -> f64 {
        let blocks = self.links.iter().map(|l| &l.diagonal).chain([&self.corner]);
        blocks.flat_map(|b| (0..b.nrows()).map(move |k| b[(k, k)])).fold(0.0, f64::max)
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
        let parts = self.links.iter().map(|l| &l.gradient).chain([&self.corner_gradient]);
        let all: Vec<f64> = parts.flat_map(|g| g.iter().copied()).collect();
        DVector::from_vec(all)
    }

    fn minimizer(&self, lambda: f64) -> Option<DVector<f64>> {
        Some(Factor::new(self, lambda)?.minimizer(self))
    }

    fn predicted_decrease(&self, delta: &DVector<f64>) -> f64 {
        let m = self.links.first().map_or(0, |l| l.gradient.len());
        let shared = delta.rows(self.links.len() * m, self.corner.nrows()).into_owned();
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
pub(crate) mod tests;
