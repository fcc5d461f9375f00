use rand::{RngExt, SeedableRng};

use super::factor::Columns;
use super::*;

/// H, both triangles.
pub(crate) fn dense(chain: &BorderedChain) -> DMatrix<f64> {
    let (frames, m) = (chain.links.len(), chain.links[0].gradient.len());
    let p = chain.corner.nrows();
    let mut dense = DMatrix::zeros(frames * m + p, frames * m + p);
    let mut put = |row, column, block: &DMatrix<f64>| {
        dense.view_mut((row, column), block.shape()).copy_from(block);
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
    let mut rng = rand_chacha::ChaCha8Rng::seed_from_u64((frames * 100 + m * 10 + reach) as u64);
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

const SIZES: [(usize, usize, usize, usize); 5] =
    [(1, 3, 2, 1), (6, 3, 2, 1), (7, 4, 3, 2), (5, 2, 0, 2), (4, 3, 2, 0)];

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
fn what_it_solves_for_several_columns_is_what_the_dense_matrix_does() {
    for (frames, m, p, reach) in SIZES {
        let (chain, dense) = random(frames, m, p, reach);
        let y = DMatrix::from_fn(dense.nrows(), 3, |i, j| (i as f64 + 7.0 * j as f64).sin());
        let columns = Columns {
            frames: (0..frames).map(|i| y.rows(i * m, m).into_owned()).collect(),
            shared: y.rows(frames * m, p).into_owned(),
        };
        let expected = dense.cholesky().unwrap().solve(&y);
        let found = Factor::new(&chain, 0.0).unwrap().solve(columns);
        for (i, frame) in found.frames.iter().enumerate() {
            let expected = expected.rows(i * m, m).into_owned();
            approx::assert_relative_eq!(*frame, expected, epsilon = 1e-12);
        }
        let expected = expected.rows(frames * m, p).into_owned();
        approx::assert_relative_eq!(found.shared, expected, epsilon = 1e-12);
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
            assert_eq!(marginal.followers.len(), reach.min(frames - 1 - i));
            for (k, follower) in marginal.followers.iter().enumerate() {
                let expected = block((i + k + 1) * m, i * m, m, m);
                approx::assert_relative_eq!(*follower, expected, epsilon = 1e-12);
            }
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
fn the_frames_alone_vary_as_at_a_fixed_shared_part() {
    for (frames, m, p, reach) in SIZES {
        let (chain, dense) = random(frames, m, p, reach);
        let n = frames * m;
        let expected = dense.view((0, 0), (n, n)).into_owned().cholesky().unwrap().inverse();
        assert!(chain.of_frames().marginals(|i, marginal| {
            let of_frame = expected.view((i * m, i * m), (m, m)).into_owned();
            approx::assert_relative_eq!(*marginal.frame, of_frame, epsilon = 1e-12);
            assert_eq!(marginal.shared.nrows(), 0);
        }));
    }
}

/// Σᵢᵢ of a frame is what it is at a fixed shared part, and what the shared part carries: A⁻¹ + GΣGᵀ, G = −A⁻¹Bᵀ.
#[test]
fn given_what_is_shared_frames_follow_it_and_keep_their_own() {
    for (frames, m, p, reach) in SIZES {
        let (chain, dense) = random(frames, m, p, reach);
        let n = frames * m;
        let spread = DMatrix::from_fn(p, p, |i, j| if i == j { 2.0 } else { 0.3 });
        let own = dense.view((0, 0), (n, n)).into_owned().cholesky().unwrap().inverse();
        let follows = -&own * dense.view((n, 0), (p, n)).transpose();
        let expected = &own + &follows * &spread * follows.transpose();

        let precision = spread.clone().cholesky().unwrap().inverse();
        let given = chain.with_shared_precision(&precision).unwrap();
        assert!(given.marginals(|i, marginal| {
            let of_frame = expected.view((i * m, i * m), (m, m)).into_owned();
            approx::assert_relative_eq!(*marginal.frame, of_frame, epsilon = 1e-12);
            approx::assert_relative_eq!(*marginal.shared, spread, epsilon = 1e-12);
        }));
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
                let block =
                    if a == b { &mut link.diagonal } else { &mut link.couplings[b - a - 1] };
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
