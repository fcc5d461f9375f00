//! What people's sizes share: known factors by regression, the rest by principal axes.
//!
//! ℓ = μ + a·h + b·g + c·s + Λq + e: ℓ logarithms, h stature within a sex, g log mass at given stature, s = ±1 the sex, all of variance 1.

use nalgebra::{DMatrix, DVector, SymmetricEigen};
use rand::{Rng, RngExt};

use super::quantities::{THIGH, TRUNK, buttock_knee, quantities};
use super::survey::Person;

/// Known factors: stature, girth, sex.
pub(crate) const KNOWN: [&str; 3] = ["stature", "girth", "sex"];
/// Factors of what is left, each with the quantity that it is known by.
pub(crate) const SHARED: [(&str, &str); 4] = [
    ("proportion", "shank"),
    ("frame", "foot breadth"),
    ("legs", "lower thigh girth"),
    ("arms", "forearm girth"),
];

/// Columns before the quantities: log stature, log mass, log buttock–knee length.
const BEFORE: usize = 3;
const STATURE: usize = 0;
const MASS: usize = 1;
const BUTTOCK_KNEE: usize = 2;

/// Logarithms, one row a person, of men and women.
pub(crate) struct Sample([DMatrix<f64>; 2]);

/// Loadings of every quantity; log units.
#[derive(Debug, Clone)]
pub(crate) struct Estimate {
    /// Geometric mean of men and of women, each counted half; m.
    pub(crate) mean: DVector<f64>,
    /// Quantities × (known, shared).
    pub(crate) loadings: DMatrix<f64>,
    /// SD of what is a quantity's own.
    pub(crate) own: DVector<f64>,
    /// Correlations that the factors leave, 0 on the diagonal.
    pub(crate) left: DMatrix<f64>,
    /// Correlations after the known factors.
    pub(crate) correlations: DMatrix<f64>,
    /// SD of log stature within a sex.
    pub(crate) stature_sd: f64,
    /// SD of log mass at given stature within a sex.
    pub(crate) girth_sd: f64,
    /// SD of the hip's height as the crotch finds it, m.
    pub(crate) crotch_sd_m: f64,
    /// Distance of the sexes' means in SDs within a sex.
    pub(crate) sex_distance: f64,
}

impl Sample {
    pub(crate) fn new(men: &[Person], women: &[Person]) -> Self {
        let quantities = quantities();
        let logs = |people: &[Person]| {
            DMatrix::from_fn(people.len(), BEFORE + quantities.len(), |row, column| {
                let person = &people[row];
                let value = match column {
                    STATURE => person.metres("stature"),
                    MASS => person.mass_kg(),
                    BUTTOCK_KNEE => buttock_knee(person),
                    _ => (quantities[column - BEFORE].of)(person),
                };
                value.ln()
            })
        };
        Self([logs(men), logs(women)])
    }

    /// As many men and women, drawn with replacement.
    pub(crate) fn resampled(&self, rng: &mut impl Rng) -> Self {
        let mut draw = |logs: &DMatrix<f64>| {
            let rows: Vec<usize> =
                (0..logs.nrows()).map(|_| rng.random_range(0..logs.nrows())).collect();
            logs.select_rows(&rows)
        };
        Self([draw(&self.0[0]), draw(&self.0[1])])
    }

    /// Means of each sex, and the covariance within a sex; both sexes count half.
    fn moments(&self) -> ([DVector<f64>; 2], DMatrix<f64>) {
        let mut within = DMatrix::zeros(self.0[0].ncols(), self.0[0].ncols());
        let means = [0, 1].map(|sex| {
            let logs = &self.0[sex];
            let mean = logs.row_mean();
            let mut centred = logs.clone();
            centred.row_iter_mut().for_each(|mut row| row -= &mean);
            within += 0.5 * centred.tr_mul(&centred) / (logs.nrows() - 1) as f64;
            mean.transpose()
        });
        (means, within)
    }
}

impl Estimate {
    /// The factors of a sample, `count` of them beside the known ones.
    pub(crate) fn new(sample: &Sample, count: usize) -> Self {
        let ([men, women], within) = sample.moments();
        let half_difference = 0.5 * (&men - &women);
        let mean = (0.5 * (&men + &women)).map(f64::exp);

        // regression on log stature, then on what mass has beside it
        let stature_sd = within[(STATURE, STATURE)].sqrt();
        let stature = within.column(STATURE) / stature_sd;
        let rest = &within - &stature * stature.transpose();
        let girth_sd = rest[(MASS, MASS)].sqrt();
        let mut girth = rest.column(MASS) / girth_sd;
        let mut rest = &rest - &girth * girth.transpose();
        let crotch_sd_m = take_out_crotch(&mut rest, &mut girth, &mean);

        // principal axes of what is left
        let n = mean.len() - BEFORE;
        let rest = rest.view((BEFORE, BEFORE), (n, n)).into_owned();
        let sd = rest.diagonal().map(f64::sqrt);
        let correlations = DMatrix::from_fn(n, n, |i, j| rest[(i, j)] / (sd[i] * sd[j]));
        let shared = named(varimax(&principal_axes(&correlations, count)));
        let mut left = &correlations - &shared * shared.transpose();
        left.fill_diagonal(0.0);

        let own = DVector::from_fn(n, |i, _| sd[i] * (1.0 - shared.row(i).norm_squared()).sqrt());
        let loadings = DMatrix::from_fn(n, KNOWN.len() + count, |i, factor| match factor {
            0 => stature[BEFORE + i],
            1 => girth[BEFORE + i],
            2 => half_difference[BEFORE + i],
            k => sd[i] * shared[(i, k - KNOWN.len())],
        });
        let mean = mean.rows(BEFORE, n).into_owned();
        let sex_distance = distance(&within, &half_difference);
        Self {
            mean,
            loadings,
            own,
            left,
            correlations,
            stature_sd,
            girth_sd,
            crotch_sd_m,
            sex_distance,
        }
    }
}

/// Takes the crotch's errors out of thigh and trunk; returns the random one, m.
///
/// The crotch finds the hip's height with an error v that makes thighs longer and trunks shorter. Buttock–knee length holds the
/// same thigh without that error: v² = var(thigh) − cov(thigh, buttock–knee length), in metres. The crotch also lies lower in
/// heavier people, whose thigh bones are no shorter: girth leaves the thigh alone, and the trunk gives back what it took.
fn take_out_crotch(rest: &mut DMatrix<f64>, girth: &mut DVector<f64>, mean: &DVector<f64>) -> f64 {
    let names: Vec<&str> = quantities().iter().map(|q| q.name).collect();
    let column = |name| BEFORE + names.iter().position(|n| *n == name).unwrap_or_default();
    let (thigh, trunk) = (column(THIGH), column(TRUNK));
    girth[trunk] += girth[thigh] * mean[thigh] / mean[trunk];
    girth[thigh] = 0.0;

    let thigh_m2 = rest[(thigh, thigh)] * mean[thigh].powi(2);
    let shared_m2 = rest[(thigh, BUTTOCK_KNEE)] * mean[thigh] * mean[BUTTOCK_KNEE];
    let variance_m2 = (thigh_m2 - shared_m2).max(0.0);
    let mut slope = DVector::zeros(mean.len());
    slope[thigh] = 1.0 / mean[thigh];
    slope[trunk] = -1.0 / mean[trunk];
    *rest -= variance_m2 * &slope * slope.transpose();
    variance_m2.sqrt()
}

/// How far the sexes' means lie apart in SDs within a sex: of stature, mass and all quantities.
fn distance(within: &DMatrix<f64>, half_difference: &DVector<f64>) -> f64 {
    let difference = 2.0 * half_difference;
    let solved = within.clone().cholesky().map(|c| c.solve(&difference));
    solved.map_or(f64::NAN, |s| s.dot(&difference).sqrt())
}

/// Loadings L of `count` factors: K ≈ LLᵀ off the diagonal, least squares, by iterated communalities.
fn principal_axes(correlations: &DMatrix<f64>, count: usize) -> DMatrix<f64> {
    let n = correlations.nrows();
    let mut reduced = correlations.clone();
    let inverse = correlations.clone().cholesky().map(|c| c.inverse());
    let mut communality =
        DVector::from_fn(n, |i, _| inverse.as_ref().map_or(0.5, |m| 1.0 - 1.0 / m[(i, i)]));
    let mut loadings = DMatrix::zeros(n, count);
    for _ in 0..MOST_ROUNDS {
        reduced.set_diagonal(&communality);
        let eigen = SymmetricEigen::new(reduced.clone());
        let mut order: Vec<usize> = (0..n).collect();
        order.sort_by(|&a, &b| eigen.eigenvalues[b].total_cmp(&eigen.eigenvalues[a]));
        for (k, &j) in order.iter().take(count).enumerate() {
            let scale = eigen.eigenvalues[j].max(0.0).sqrt();
            loadings.set_column(k, &(scale * eigen.eigenvectors.column(j)));
        }
        let next = DVector::from_fn(n, |i, _| loadings.row(i).norm_squared().min(MOST_COMMON));
        let change = (&next - &communality).amax();
        communality = next;
        if change < 1e-7 {
            break;
        }
    }
    loadings
}

const MOST_ROUNDS: usize = 1000;
/// Largest share of a quantity's variance that factors may explain.
const MOST_COMMON: f64 = 0.98;

/// L turned so that each quantity loads on few factors (Kaiser 1958, rows normalised).
fn varimax(loadings: &DMatrix<f64>) -> DMatrix<f64> {
    let (n, count) = loadings.shape();
    let mut rows = loadings.clone();
    rows.row_iter_mut().for_each(|mut row| {
        let norm = row.norm().max(f64::MIN_POSITIVE);
        row /= norm;
    });
    let mut turn = DMatrix::identity(count, count);
    let mut before = 0.0;
    for _ in 0..MOST_ROUNDS {
        let turned = &rows * &turn;
        let squares = turned.map(|x| x * x).row_sum();
        let slope = DMatrix::from_fn(n, count, |i, k| {
            turned[(i, k)].powi(3) - turned[(i, k)] * squares[k] / n as f64
        });
        let svd = rows.tr_mul(&slope).svd(true, true);
        let (Some(u), Some(v_t)) = (&svd.u, &svd.v_t) else { break };
        turn = u * v_t;
        let sum = svd.singular_values.sum();
        if sum < before * (1.0 + 1e-10) {
            break;
        }
        before = sum;
    }
    loadings * turn
}

/// Factors in the order of [`SHARED`], each positive at the quantity that it is known by; further ones after them.
fn named(loadings: DMatrix<f64>) -> DMatrix<f64> {
    let names: Vec<&str> = quantities().iter().map(|q| q.name).collect();
    let mut free: Vec<usize> = (0..loadings.ncols()).collect();
    let mut columns = Vec::new();
    for (_, marker) in SHARED {
        let row = names.iter().position(|n| *n == marker).unwrap_or_default();
        let size = |k: usize| loadings[(row, k)].abs();
        let Some(at) = (0..free.len()).max_by(|&a, &b| size(free[a]).total_cmp(&size(free[b])))
        else {
            break;
        };
        let k = free.remove(at);
        columns.push(loadings.column(k) * loadings[(row, k)].signum());
    }
    columns.extend(free.into_iter().map(|k| loadings.column(k).into_owned()));
    DMatrix::from_columns(&columns)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn principal_axes_turned_back_are_the_factors_that_correlations_were_made_of() {
        let made = DMatrix::from_row_slice(
            6,
            2,
            &[0.8, 0.0, 0.7, 0.0, 0.6, 0.0, 0.0, 0.5, 0.0, 0.7, 0.0, 0.6],
        );
        let mut correlations = &made * made.transpose();
        correlations.fill_diagonal(1.0);
        let found = varimax(&principal_axes(&correlations, 2)).abs();
        let (same, other) = ((&found - &made).amax(), (found.column(1) - made.column(0)).amax());
        assert!(same.min(other) < 1e-4, "{found}");
    }
}
