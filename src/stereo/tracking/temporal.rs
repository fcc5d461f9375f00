//! Least-squares matching of a patch in the next image of the same camera.
//!
//! f(p) = a·g(c + A·p) + b + noise, with A a 2 × 2 matrix: six geometric unknowns, for how the surface moves is not known;
//! contrast a and brightness b are eliminated. Where to begin comes from the best correlation in a search box.
//!
//! # Source
//! PFD99 § 2.2 and Fig. 4; Gruen 1985, *Adaptive least squares correlation*.

use nalgebra::{Matrix2, Point2, SMatrix, SVector, Vector2};

use crate::image::Plane;
use crate::stereo::bicubic::sample;

/// Steps after which a patch that still moves is given up.
const MOST_STEPS: usize = 12;
/// A patch that moves less is at rest, px.
const AT_REST_PX: f64 = 0.01;
/// How far a patch may move from the best correlation, px.
const FARTHEST_PX: f64 = 3.0;
/// Standard deviation of the map's elements from those of no change.
const MAP_SD: f64 = 0.15;
/// Every so many pixels are compared in the first search, and tried.
const COARSE: i64 = 2;

type Vector6 = SVector<f64, 6>;
type Matrix6 = SMatrix<f64, 6, 6>;

/// A patch in the next image.
#[derive(Debug, Clone, Copy)]
pub(super) struct Moved {
    pub(super) pixel: Point2<f64>,
    /// Standard deviation of the place in its worst direction, px.
    pub(super) sigma_px: f64,
    pub(super) correlation: f64,
}

/// The whole pixel in the box of ±`reach` around `expected` with the best correlation.
pub(super) fn search(
    patch: &[(f64, f64, f32)],
    image: &Plane<f32>,
    expected: &Point2<f64>,
    reach: usize,
) -> Option<Point2<f64>> {
    let thin: Vec<_> = patch
        .iter()
        .filter(|(dx, dy, _)| dx.round() as i64 % COARSE == 0 && dy.round() as i64 % COARSE == 0)
        .copied()
        .collect();
    let reach = i64::try_from(reach).ok()? / COARSE * COARSE;
    let middle = (expected.x.round() as i64, expected.y.round() as i64);
    let coarse = best(&thin, image, middle, reach, COARSE)?;
    let fine = best(patch, image, coarse, COARSE - 1, 1)?;
    Some(Point2::new(fine.0 as f64, fine.1 as f64))
}

fn best(
    patch: &[(f64, f64, f32)],
    image: &Plane<f32>,
    (x, y): (i64, i64),
    reach: i64,
    step: i64,
) -> Option<(i64, i64)> {
    let side = 2 * (reach / step) + 1;
    let places =
        (0..side * side).map(|i| (x - reach + i % side * step, y - reach + i / side * step));
    let rated = places.filter_map(|place| Some((correlation(patch, image, place)?, place)));
    rated
        .max_by(|a, b| a.0.total_cmp(&b.0))
        .map(|(_, place)| place)
}

fn correlation(patch: &[(f64, f64, f32)], image: &Plane<f32>, (x, y): (i64, i64)) -> Option<f32> {
    let mut sums = [0.0f32; 6];
    for (dx, dy, f) in patch {
        let (column, row) = (x + *dx as i64, y + *dy as i64);
        let g = image.get(usize::try_from(column).ok()?, usize::try_from(row).ok()?)?;
        for (sum, term) in sums.iter_mut().zip([1.0, *f, g, f * f, g * g, f * g]) {
            *sum += term;
        }
    }
    let [n, f, g, ff, gg, fg] = sums;
    let (ff, gg, fg) = (ff - f * f / n, gg - g * g / n, fg - f * g / n);
    // less than a grey level of contrast is none; NaN neither
    (ff > n && gg > n).then(|| fg / (ff * gg).sqrt())
}

/// Moves, turns and stretches the patch until it looks like the image; `None` if it does not come to rest.
pub(super) fn fit(
    patch: &[(f64, f64, f32)],
    image: &Plane<f32>,
    start: &Point2<f64>,
) -> Option<Moved> {
    let (mut place, mut map) = (*start, Matrix2::identity());
    for _ in 0..MOST_STEPS {
        let (normal, right, variance, correlation) = equations(patch, image, &place, &map)?;
        let factor = normal.cholesky()?;
        let step = factor.solve(&right);
        place += Vector2::new(step[0], step[1]);
        map += Matrix2::new(step[2], step[3], step[4], step[5]);
        // NaN is not near
        let near = (place - start).norm() <= FARTHEST_PX;
        if !near {
            return None;
        }
        if step[0].hypot(step[1]) < AT_REST_PX {
            let spread = factor.inverse().fixed_view::<2, 2>(0, 0).into_owned() * variance;
            let sigma_px = spread.symmetric_eigenvalues().max().sqrt();
            return Some(Moved {
                pixel: place,
                sigma_px,
                correlation,
            });
        }
    }
    None
}

/// Normal equations with the prior of the map, the variance of the brightness, and the correlation coefficient.
fn equations(
    patch: &[(f64, f64, f32)],
    image: &Plane<f32>,
    place: &Point2<f64>,
    map: &Matrix2<f64>,
) -> Option<(Matrix6, Vector6, f64, f64)> {
    let (mut f, mut ff, mut g, mut gg, mut fg) = (0.0, 0.0, 0.0, 0.0, 0.0);
    let (mut j, mut fj, mut gj, mut jj) = (
        Vector6::zeros(),
        Vector6::zeros(),
        Vector6::zeros(),
        Matrix6::zeros(),
    );
    for (dx, dy, value) in patch {
        let at = place + map * Vector2::new(*dx, *dy);
        let found = sample(image, at.x, at.y)?;
        let [gx, gy] = found.slope.map(f64::from);
        let (a, b) = (f64::from(*value), f64::from(found.value));
        let row = Vector6::from([gx, gy, gx * dx, gx * dy, gy * dx, gy * dy]);
        f += a;
        ff += a * a;
        g += b;
        gg += b * b;
        fg += a * b;
        j += row;
        fj += row * a;
        gj += row * b;
        jj += row * row.transpose();
    }
    let n = patch.len() as f64;
    let (ff, gg, fg) = (ff - f * f / n, gg - g * g / n, fg - f * g / n);
    let textured = ff > n && gg > n;
    if !textured {
        return None;
    }
    let contrast = fg / gg;
    let (fj, gj) = (fj - j * (f / n), gj - j * (g / n));
    let mut normal = (jj - j * j.transpose() / n - gj * gj.transpose() / gg) * contrast.powi(2);
    let mut right = (fj - gj * contrast) * contrast;
    let variance = ((ff - fg * contrast) / (n - 8.0).max(1.0)).max(1.0 / 12.0);
    let off = map - Matrix2::identity();
    for (i, off) in [off.m11, off.m12, off.m21, off.m22].into_iter().enumerate() {
        normal[(i + 2, i + 2)] += variance / MAP_SD.powi(2);
        right[i + 2] -= variance / MAP_SD.powi(2) * off;
    }
    Some((normal, right, variance, fg / (ff * gg).sqrt()))
}
