//! The implicit step: (I + τA) x = b in O(n), factored once.
//!
//! A = (α/h²) D₁ᵀD₁ + (β/h⁴) D₂ᵀD₂ of n points at distance h, D₁ and D₂ first and second differences along the curve. It has
//! five diagonals. Those of a closed curve go around, so its last two points are taken as a border:
//! \[B C; Cᵀ E\]\[u; v\] = \[r; s\], with S = E − CᵀB⁻¹C: v = S⁻¹(s − CᵀB⁻¹r), u = B⁻¹r − (B⁻¹C) v; B = LDLᵀ.

use nalgebra::{Matrix2, Vector2};

use super::Ends;

/// Points of a closed curve in the border.
const BORDER: usize = 2;

/// I + τA, factored.
#[derive(Clone, Debug)]
pub(super) struct Banded {
    /// D⁻¹, and L on the first and second diagonal below.
    inverse: Vec<f64>,
    first: Vec<f64>,
    second: Vec<f64>,
    border: Option<Border>,
}

/// The border of a closed curve.
#[derive(Clone, Debug)]
struct Border {
    /// The rows of C.
    corner: Vec<Vector2<f64>>,
    /// The rows of B⁻¹C.
    solved: Vec<Vector2<f64>>,
    /// S⁻¹.
    schur_inverse: Matrix2<f64>,
}

/// The diagonals of a symmetric matrix: `offset[k][i]` couples i with i + k, around the end of a closed curve.
struct Diagonals {
    offset: [Vec<f64>; 3],
}

impl Diagonals {
    /// I + `bend[0]` D₁ᵀD₁ + `bend[1]` D₂ᵀD₂.
    fn new(n: usize, ends: Ends, bend: [f64; 2]) -> Self {
        let mut diagonals = Self { offset: [vec![1.0; n], vec![0.0; n], vec![0.0; n]] };

        let stencils: [&[f64]; 2] = [&[-1.0, 1.0], &[1.0, -2.0, 1.0]];
        for (stencil, weight) in stencils.into_iter().zip(bend) {
            let count = match ends {
                Ends::Closed => n,
                Ends::Open => n + 1 - stencil.len(),
            };

            // DᵀD, row by row of D
            for start in 0..count {
                for (a, left) in stencil.iter().enumerate() {
                    for (b, right) in stencil.iter().enumerate().skip(a) {
                        diagonals.offset[b - a][(start + a) % n] += weight * left * right;
                    }
                }
            }
        }
        diagonals
    }
}

impl Banded {
    /// I + τA for n ≥ 5 points; `bend` is τα/h² and τβ/h⁴, neither negative. `None` for fewer points, or if it is singular.
    pub(super) fn new(n: usize, ends: Ends, bend: [f64; 2]) -> Option<Self> {
        if n < 5 || !bend.iter().all(|b| b.is_finite() && *b >= 0.0) {
            return None;
        }

        let Diagonals { offset } = Diagonals::new(n, ends, bend);
        match ends {
            Ends::Open => Some(Self::factored(&offset, n)),
            Ends::Closed => {
                let mut banded = Self::factored(&offset, n - BORDER);
                banded.border = Some(banded.bordered(&offset, n)?);
                Some(banded)
            }
        }
    }

    /// LDLᵀ of the first `inner` rows and columns.
    fn factored(offset: &[Vec<f64>; 3], inner: usize) -> Self {
        let [mut inverse, mut first, mut second] = [const { Vec::new() }; 3];
        for i in 0..inner {
            let mut pivot = offset[0][i];

            let mut l_second = 0.0;
            if i > 1 {
                l_second = offset[2][i - 2] * inverse[i - 2];
                pivot -= l_second * offset[2][i - 2];
            }

            let mut l_first = 0.0;
            if i > 0 {
                let before = if i > 1 { l_second * first[i - 1] / inverse[i - 2] } else { 0.0 };
                let coupling = offset[1][i - 1] - before;
                l_first = coupling * inverse[i - 1];
                pivot -= l_first * coupling;
            }

            inverse.push(pivot.recip());
            first.push(l_first);
            second.push(l_second);
        }
        Self { inverse, first, second, border: None }
    }

    /// C, B⁻¹C and S⁻¹; `None` if S is singular.
    fn bordered(&self, offset: &[Vec<f64>; 3], n: usize) -> Option<Border> {
        // C, and of E what lies off the diagonal of the whole matrix
        let mut corner = vec![Vector2::zeros(); n - BORDER];
        let mut own = Matrix2::from_diagonal(&Vector2::new(offset[0][n - 2], offset[0][n - 1]));
        own[(0, 1)] = offset[1][n - 2];
        own[(1, 0)] = offset[1][n - 2];
        for (k, diagonal) in offset.iter().enumerate().skip(1) {
            for (i, value) in diagonal.iter().enumerate() {
                let (low, high) = (i.min((i + k) % n), i.max((i + k) % n));
                if low < n - BORDER && high >= n - BORDER {
                    corner[low][high - (n - BORDER)] += value;
                }
            }
        }

        // S = E − Cᵀ (B⁻¹C)
        let mut solved = corner.clone();
        self.solve_inner(&mut solved);
        let products = corner.iter().zip(&solved).map(|(c, s)| c * s.transpose());
        let schur: Matrix2<f64> = own - products.sum::<Matrix2<f64>>();
        let schur_inverse = schur.cholesky()?.inverse();
        Some(Border { corner, solved, schur_inverse })
    }

    /// Replaces b by x, both components at once; `values` has as many points as the curve.
    pub(super) fn solve(&self, values: &mut [Vector2<f64>]) {
        let Some(border) = &self.border else {
            self.solve_inner(values);
            return;
        };
        let (inner, last) = values.split_at_mut(self.inverse.len());
        self.solve_inner(inner);

        // v: rows of the border, columns x and y
        let mut rest = Matrix2::from_rows(&[last[0].transpose(), last[1].transpose()]);
        for (corner, value) in border.corner.iter().zip(inner.iter()) {
            rest -= corner * value.transpose();
        }
        let found = border.schur_inverse * rest;

        // u
        for (solved, value) in border.solved.iter().zip(inner.iter_mut()) {
            *value -= found.tr_mul(solved);
        }
        for (row, value) in last.iter_mut().enumerate() {
            *value = found.row(row).transpose();
        }
    }

    /// B⁻¹ x: forwards by L, backwards by D and Lᵀ.
    fn solve_inner(&self, x: &mut [Vector2<f64>]) {
        let n = self.inverse.len();
        for i in 1..n {
            let mut value = x[i] - x[i - 1] * self.first[i];
            if i > 1 {
                value -= x[i - 2] * self.second[i];
            }
            x[i] = value;
        }

        for i in (0..n).rev() {
            let mut value = x[i] * self.inverse[i];
            if i + 1 < n {
                value -= x[i + 1] * self.first[i + 1];
            }
            if i + 2 < n {
                value -= x[i + 2] * self.second[i + 2];
            }
            x[i] = value;
        }
    }
}

#[cfg(test)]
mod tests {
    use nalgebra::DMatrix;

    use super::*;

    /// The same matrix, dense, from its definition.
    fn dense(n: usize, ends: Ends, [tension, stiffness]: [f64; 2]) -> DMatrix<f64> {
        let rows = |stencil: &[f64]| {
            let count = match ends {
                Ends::Closed => n,
                Ends::Open => n + 1 - stencil.len(),
            };
            let mut d = DMatrix::zeros(count, n);
            for row in 0..count {
                for (k, value) in stencil.iter().enumerate() {
                    d[(row, (row + k) % n)] += value;
                }
            }
            d
        };
        let (d1, d2) = (rows(&[-1.0, 1.0]), rows(&[1.0, -2.0, 1.0]));
        DMatrix::identity(n, n) + d1.tr_mul(&d1) * tension + d2.tr_mul(&d2) * stiffness
    }

    #[test]
    fn the_solution_is_that_of_the_dense_matrix() {
        use Ends::{Closed, Open};
        for (n, ends) in [(5, Open), (6, Closed), (7, Open), (40, Closed), (41, Open)] {
            for bend in [[0.0, 0.0], [3.0, 0.0], [0.5, 40.0], [1e4, 1e6]] {
                let b: Vec<_> =
                    (0..n).map(|i| Vector2::new((i as f64).sin(), (i * i % 7) as f64)).collect();
                let mut x = b.clone();
                Banded::new(n, ends, bend).unwrap().solve(&mut x);
                let back = dense(n, ends, bend) * DMatrix::from_fn(n, 2, |i, k| x[i][k]);
                let expected = DMatrix::from_fn(n, 2, |i, k| b[i][k]);
                approx::assert_relative_eq!(back, expected, epsilon = 1e-6);
            }
        }
    }

    #[test]
    fn too_few_points_and_nonsense_are_no_matrix() {
        assert!(Banded::new(4, Ends::Closed, [1.0, 1.0]).is_none());
        assert!(Banded::new(9, Ends::Closed, [-1.0, 1.0]).is_none());
        assert!(Banded::new(9, Ends::Open, [f64::NAN, 1.0]).is_none());
    }
}
