//! How two cameras with known lenses stand to each other, from five points that both see.
//!
//! A point X is seen at the normalised image points a of one camera and b of the other, (x, y, 1)ᵀ each. With X_b = R X_a + t,
//!
//! bᵀ E a = 0,  E = \[t\]R.
//!
//! Five points leave E = x E₁ + y E₂ + z E₃ + E₄ in the null space of their equations, and E is essential if
//!
//! det E = 0,  2 E Eᵀ E − tr(E Eᵀ) E = 0:
//!
//! ten cubics in x, y, z. Gauss–Jordan elimination expresses the ten monomials of third degree by the ten others, v = (x², …, z, 1). Then x v = A v,
//! and each real eigenvector of A is a solution. There are ten at most. Of E = U diag(1, 1, 0) Vᵀ four poses follow, R = U W Vᵀ or U Wᵀ Vᵀ and
//! t = ± u₃; points must lie before both cameras.
//!
//! Five points suffice where they lie in a plane, as eight do not; lengths remain unknown, and ‖t‖ = 1.
//!
//! # Source
//! Nistér 2004, *An efficient solution to the five-point relative pose problem*; Stewénius, Engels, Nistér 2006, *Recent developments on direct
//! relative orientation* (the action matrix); Hartley & Zisserman 2004, § 9.6 (the four poses).

use nalgebra::{
    DMatrix, Matrix3, Point2, Rotation3, SMatrix, SVector, Schur, SymmetricEigen, Translation3,
    UnitQuaternion, Vector3,
};

use crate::math::Rigid3;

/// Powers of x, y, z in the twenty monomials up to third degree; the ten of third degree first.
const POWERS: [[usize; 3]; 20] = [
    [3, 0, 0],
    [2, 1, 0],
    [1, 2, 0],
    [0, 3, 0],
    [2, 0, 1],
    [1, 1, 1],
    [0, 2, 1],
    [1, 0, 2],
    [0, 1, 2],
    [0, 0, 3],
    [2, 0, 0],
    [1, 1, 0],
    [0, 2, 0],
    [1, 0, 1],
    [0, 1, 1],
    [0, 0, 2],
    [1, 0, 0],
    [0, 1, 0],
    [0, 0, 1],
    [0, 0, 0],
];
/// x times each of the ten lower monomials: one of third degree, or the position among the lower ones.
const TIMES_X: [Result<usize, usize>; 10] =
    [Ok(0), Ok(1), Ok(2), Ok(4), Ok(5), Ok(7), Err(0), Err(1), Err(3), Err(6)];
/// An eigenvalue whose imaginary part is smaller is real.
const REAL: f64 = 1e-10;
/// Most iterations of an eigenvalue.
const MOST_ITERATIONS: usize = 1000;

/// A polynomial in x, y, z of third degree at most.
#[derive(Clone, Copy)]
struct Polynomial(SVector<f64, 20>);

impl Polynomial {
    /// c₀x + c₁y + c₂z + c₃.
    fn linear(c: [f64; 4]) -> Self {
        let mut all = SVector::<f64, 20>::zeros();
        all.fixed_rows_mut::<4>(16).copy_from_slice(&c);
        Self(all)
    }

    fn times(&self, other: &Self) -> Self {
        let mut product = SVector::<f64, 20>::zeros();
        let nonzero = |i: &usize| self.0[*i].abs() > 0.0;
        for i in (0..20).filter(nonzero) {
            for j in (0..20).filter(|j| other.0[*j].abs() > 0.0) {
                let powers = [0, 1, 2].map(|k| POWERS[i][k] + POWERS[j][k]);
                if let Some(at) = POWERS.iter().position(|known| *known == powers) {
                    product[at] += self.0[i] * other.0[j];
                }
            }
        }
        Self(product)
    }

    fn sum(terms: impl IntoIterator<Item = Self>) -> Self {
        Self(terms.into_iter().map(|term| term.0).sum())
    }

    fn scaled(&self, by: f64) -> Self {
        Self(self.0 * by)
    }
}

/// The essential matrices, up to scale, under which five pairs of normalised image points (a, b) lie on each other's epipolar lines.
///
/// Ten at most; none of points that coincide.
pub fn essential_matrices(pairs: &[[Point2<f64>; 2]; 5]) -> Vec<Matrix3<f64>> {
    let Some(basis) = null_space(pairs) else {
        return Vec::new();
    };
    let Some(action) = action_matrix(&constraints(&basis)) else {
        return Vec::new();
    };
    let of_eigenvalue = |value: f64| {
        let shifted = action - SMatrix::<f64, 10, 10>::identity() * value;
        let v = shifted.svd(false, true).v_t?.row(9).transpose();
        let [x, y, z] = [6, 7, 8].map(|k| v[k] / v[9]);
        let e = basis[0] * x + basis[1] * y + basis[2] * z + basis[3];
        e.iter().all(|value| value.is_finite()).then_some(e)
    };
    let dynamic = DMatrix::from_column_slice(10, 10, action.as_slice());
    let schur = Schur::try_new(dynamic, f64::EPSILON, MOST_ITERATIONS);
    let values = schur.map(|schur| schur.complex_eigenvalues());
    let real = values.iter().flatten().filter(|value| value.im.abs() < REAL);
    real.filter_map(|value| of_eigenvalue(value.re)).collect()
}

/// E₁ … E₄: what the equations bᵀEa = 0 leave free.
fn null_space(pairs: &[[Point2<f64>; 2]; 5]) -> Option<[Matrix3<f64>; 4]> {
    let mut equations = SMatrix::<f64, 5, 9>::zeros();
    for (i, [a, b]) in pairs.iter().enumerate() {
        let product = b.to_homogeneous() * a.to_homogeneous().transpose();
        equations.set_row(i, &SMatrix::<f64, 1, 9>::from_column_slice(product.as_slice()));
    }
    if !equations.iter().all(|value| value.is_finite()) {
        return None;
    }
    let eigen = SymmetricEigen::new(equations.transpose() * equations);
    let mut order: Vec<usize> = (0..9).collect();
    order.sort_by(|a, b| eigen.eigenvalues[*a].total_cmp(&eigen.eigenvalues[*b]));
    Some([0, 1, 2, 3].map(|k| {
        let column = eigen.eigenvectors.column(order[k]);
        Matrix3::from_column_slice(column.as_slice())
    }))
}

/// The ten cubics, a row each.
fn constraints(basis: &[Matrix3<f64>; 4]) -> SMatrix<f64, 10, 20> {
    let e = |i: usize, j: usize| Polynomial::linear([0, 1, 2, 3].map(|k| basis[k][(i, j)]));
    let square = |i: usize, j: usize| Polynomial::sum((0..3).map(|k| e(i, k).times(&e(j, k))));
    let squares = [0, 1, 2].map(|i| [0, 1, 2].map(|j| square(i, j)));
    let half_trace = Polynomial::sum((0..3).map(|i| squares[i][i])).scaled(-0.5);

    let mut rows = SMatrix::<f64, 10, 20>::zeros();
    for (i, j) in (0..9).map(|k| (k / 3, k % 3)) {
        let cube = (0..3).map(|k| squares[i][k].times(&e(k, j)));
        let row = Polynomial::sum(cube.chain([half_trace.times(&e(i, j))]));
        rows.set_row(3 * i + j, &row.0.transpose());
    }
    let minor = |a: usize, b: usize| {
        let crossed = e(1, b).times(&e(2, a)).scaled(-1.0);
        Polynomial::sum([e(1, a).times(&e(2, b)), crossed])
    };
    let determinant =
        [(0, minor(1, 2)), (1, minor(2, 0)), (2, minor(0, 1))].map(|(j, m)| e(0, j).times(&m));
    rows.set_row(9, &Polynomial::sum(determinant).0.transpose());
    rows
}

/// A with x v = A v.
fn action_matrix(rows: &SMatrix<f64, 10, 20>) -> Option<SMatrix<f64, 10, 10>> {
    let highest = rows.fixed_columns::<10>(0).into_owned();
    let lower = highest.lu().solve(&rows.fixed_columns::<10>(10).into_owned())?;
    let mut action = SMatrix::<f64, 10, 10>::zeros();
    for (i, product) in TIMES_X.iter().enumerate() {
        match product {
            Ok(third_degree) => action.set_row(i, &-lower.row(*third_degree)),
            Err(position) => action[(i, *position)] = 1.0,
        }
    }
    action.iter().all(|value| value.is_finite()).then_some(action)
}

/// The four poses of the second camera, from the first one's frame, that have this essential matrix; ‖t‖ = 1.
pub fn poses_of_essential(essential: &Matrix3<f64>) -> Vec<Rigid3> {
    let svd = essential.svd(true, true);
    let (Some(u), Some(v_t)) = (svd.u, svd.v_t) else {
        return Vec::new();
    };
    let w = Matrix3::new(0.0, -1.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 1.0);
    let last = svd.singular_values.imin();
    // the direction that E loses comes last
    let order = [(last + 1) % 3, (last + 2) % 3, last];
    let u = Matrix3::from_columns(&order.map(|k| u.column(k).into_owned()));
    let v_t = Matrix3::from_rows(&order.map(|k| v_t.row(k).into_owned()));
    let pose = |w: Matrix3<f64>, sign: f64| {
        let rotation = u * w * v_t;
        let rotation = rotation * rotation.determinant().signum();
        let rotation = Rotation3::from_matrix_unchecked(rotation);
        let translation: Vector3<f64> = u.column(2) * sign;
        Rigid3::from_parts(
            Translation3::from(translation),
            UnitQuaternion::from_rotation_matrix(&rotation),
        )
    };
    [(w, 1.0), (w, -1.0), (w.transpose(), 1.0), (w.transpose(), -1.0)]
        .map(|(w, sign)| pose(w, sign))
        .into()
}

#[cfg(test)]
mod tests {
    use nalgebra::Point3;
    use rand::{RngExt, SeedableRng};
    use rand_chacha::ChaCha8Rng;

    use super::*;

    fn seen(pose: &Rigid3, points: &[Point3<f64>; 5]) -> [[Point2<f64>; 2]; 5] {
        let at = |point: Point3<f64>| Point2::from(point.coords.xy() / point.z);
        points.map(|point| [at(point), at(pose * point)])
    }

    /// The angle and the distance between the pose nearest to another, and that one.
    fn nearest(pose: &Rigid3, points: &[Point3<f64>; 5]) -> f64 {
        let matrices = essential_matrices(&seen(pose, points));
        assert!(!matrices.is_empty() && matrices.len() <= 10);
        let direction = pose.translation.vector / pose.translation.vector.norm();
        let off = |found: Rigid3| {
            let turned = found.rotation.angle_to(&pose.rotation);
            turned + (found.translation.vector - direction).norm()
        };
        let found = matrices.iter().flat_map(poses_of_essential).map(off);
        found.fold(f64::INFINITY, f64::min)
    }

    fn random(rng: &mut ChaCha8Rng, flat: f64) -> (Rigid3, [Point3<f64>; 5]) {
        let mut draw = || rng.random_range(-1.0..1.0);
        let turn = Vector3::new(draw(), draw(), draw());
        let way = Vector3::new(draw(), draw(), 0.3 * draw());
        let points: [Point3<f64>; 5] =
            std::array::from_fn(|_| Point3::new(draw(), draw(), 4.0 + flat * draw()));
        // about a point that both see
        let about = Translation3::new(0.0, 0.0, 4.0);
        let turn = Rigid3::rotation(turn);
        (Translation3::from(way) * about * turn * about.inverse(), points)
    }

    #[test]
    fn five_points_tell_how_two_cameras_stand_to_each_other_also_in_a_plane() {
        let mut rng = ChaCha8Rng::seed_from_u64(5);
        for flat in [1.0, 1.0, 1.0, 1.0, 0.0, 0.0] {
            let (pose, points) = random(&mut rng, flat);
            let off = nearest(&pose, &points);
            assert!(off < 1e-5, "{off}");
        }
    }

    #[test]
    fn five_times_the_same_point_tells_nothing_that_is_wrong_without_panic() {
        let points = [[Point2::new(0.1, 0.2), Point2::new(-0.1, 0.0)]; 5];
        for essential in essential_matrices(&points) {
            assert!(essential.iter().all(|value| value.is_finite()));
        }
        let points = [[Point2::new(f64::NAN, 0.2), Point2::new(-0.1, 0.0)]; 5];
        assert!(essential_matrices(&points).is_empty());
    }

    #[test]
    fn of_four_poses_one_has_the_points_before_both_cameras() {
        let (pose, points) = random(&mut ChaCha8Rng::seed_from_u64(2), 1.0);
        let essential = pose.translation.vector.cross_matrix()
            * pose.rotation.to_rotation_matrix().into_inner();
        let found = poses_of_essential(&essential);
        assert_eq!(found.len(), 4);
        for [a, b] in seen(&pose, &points) {
            let product = b.to_homogeneous().dot(&(essential * a.to_homogeneous()));
            assert!(product.abs() < 1e-12, "{product}");
        }
        let right = found.iter().filter(|found| {
            let way = pose.translation.vector / pose.translation.vector.norm();
            found.rotation.angle_to(&pose.rotation) < 1e-6
                && (found.translation.vector - way).norm() < 1e-6
        });
        assert_eq!(right.count(), 1);
    }
}
