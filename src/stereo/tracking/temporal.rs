//! Least-squares matching of a patch in the next image of the same camera.
//!
//! f(p) = a·g(c + A·p) + b + noise, with A a 2 × 2 matrix: six geometric unknowns, for it is not known how the surface moves.
//! Contrast a and brightness b are eliminated. The fit starts from the best correlation in a search box.
//!
//! # Source
//! PFD99 § 2.2 and Fig. 4; Gruen 1985, *Adaptive least squares correlation*.

use nalgebra::{Matrix2, Point2, SMatrix, SVector, Vector2};

use crate::image::Plane;
use crate::stereo::bicubic::sample;
use crate::stereo::matching::PatchPixel;

/// Steps after which a patch that still moves is given up.
const MOST_STEPS: usize = 12;
/// A patch that moves less is at rest, px.
const AT_REST_PX: f64 = 0.01;
/// How far a patch may move from the best correlation, px.
const FARTHEST_PX: f64 = 3.0;
/// Standard deviation of the elements of A from those of the identity.
const MAP_SD: f64 = 0.15;
/// Step of the first search, px: between the places that are tried, and between the pixels that are compared.
const COARSE: i64 = 2;

type Vector6 = SVector<f64, 6>;
type Matrix6 = SMatrix<f64, 6, 6>;

/// A patch found in the next image.
#[derive(Debug, Clone, Copy)]
pub(super) struct TemporalMatch {
    pub(super) pixel: Point2<f64>,
    /// Standard deviation of the place in its worst direction, px.
    pub(super) sigma_px: f64,
    pub(super) correlation: f64,
}

/// The whole pixel in the box of ±`reach` around `expected` with the best correlation.
pub(super) fn search(
    patch: &[PatchPixel],
    image: &Plane<f32>,
    expected: &Point2<f64>,
    reach: usize,
) -> Option<Point2<f64>> {
    let is_compared = |offset: f64| offset.round() as i64 % COARSE == 0;
    let thin = patch.iter().copied();
    let thin: Vec<PatchPixel> =
        thin.filter(|pixel| is_compared(pixel.dx) && is_compared(pixel.dy)).collect();

    let reach = i64::try_from(reach).ok()? / COARSE * COARSE;
    let middle = Point2::new(expected.x.round() as i64, expected.y.round() as i64);
    let coarse = best_place(&thin, image, middle, reach, COARSE)?;
    let fine = best_place(patch, image, coarse, COARSE - 1, 1)?;
    Some(fine.map(|x| x as f64))
}

/// The place with the best correlation in the box of ±`reach` around the middle, a step apart.
fn best_place(
    patch: &[PatchPixel],
    image: &Plane<f32>,
    middle: Point2<i64>,
    reach: i64,
    step: i64,
) -> Option<Point2<i64>> {
    let side = 2 * (reach / step) + 1;
    let first = middle.map(|x| x - reach);
    let places =
        (0..side * side).map(|i| Point2::new(first.x + i % side * step, first.y + i / side * step));
    let rated = places.filter_map(|place| Some((correlation(patch, image, place)?, place)));
    let best = rated.max_by(|a, b| a.0.total_cmp(&b.0));
    best.map(|(_, place)| place)
}

/// Correlation coefficient of the patch with the pixels around a place; `None` where the image ends or has no contrast.
fn correlation(patch: &[PatchPixel], image: &Plane<f32>, place: Point2<i64>) -> Option<f32> {
    let mut sums = [0.0f32; 6];
    for pixel in patch {
        let column = usize::try_from(place.x + pixel.dx as i64).ok()?;
        let row = usize::try_from(place.y + pixel.dy as i64).ok()?;
        let (f, g) = (pixel.value, image.get(column, row)?);
        for (sum, term) in sums.iter_mut().zip([1.0, f, g, f * f, g * g, f * g]) {
            *sum += term;
        }
    }

    let [n, f, g, ff, gg, fg] = sums;
    let (ff, gg, fg) = (ff - f * f / n, gg - g * g / n, fg - f * g / n);
    // less than a grey level of contrast is none; NaN neither
    (ff > n && gg > n).then(|| fg / (ff * gg).sqrt())
}

/// Moves, turns and stretches the patch until it looks like the image, by Gauss–Newton; `None` if it does not come to rest.
pub(super) fn fit(
    patch: &[PatchPixel],
    image: &Plane<f32>,
    start: &Point2<f64>,
) -> Option<TemporalMatch> {
    let (mut place, mut map) = (*start, Matrix2::identity());
    for _ in 0..MOST_STEPS {
        let equations = Sums::over(patch, image, &place, &map)?.equations(&map)?;
        let factor = equations.normal.cholesky()?;
        let step = factor.solve(&equations.right);
        place += Vector2::new(step[0], step[1]);
        map += Matrix2::new(step[2], step[3], step[4], step[5]);

        // NaN is not near
        let near = (place - start).norm() <= FARTHEST_PX;
        if !near {
            return None;
        }
        if step[0].hypot(step[1]) < AT_REST_PX {
            let inverse = factor.inverse();
            let spread = inverse.fixed_view::<2, 2>(0, 0).into_owned() * equations.variance;
            return Some(TemporalMatch {
                pixel: place,
                sigma_px: spread.symmetric_eigenvalues().max().sqrt(),
                correlation: equations.correlation,
            });
        }
    }
    None
}

/// Sums over a patch of f, of g, of J = ∂g/∂(c, A), and of their products.
struct Sums {
    count: f64,
    f: f64,
    ff: f64,
    g: f64,
    gg: f64,
    fg: f64,
    j: Vector6,
    fj: Vector6,
    gj: Vector6,
    jj: Matrix6,
}

/// Normal equations with the prior of the map, without contrast and brightness.
struct Equations {
    normal: Matrix6,
    right: Vector6,
    /// Of the brightness.
    variance: f64,
    correlation: f64,
}

impl Sums {
    /// `None` where the image ends.
    fn over(
        patch: &[PatchPixel],
        image: &Plane<f32>,
        place: &Point2<f64>,
        map: &Matrix2<f64>,
    ) -> Option<Self> {
        let mut sums = Self {
            count: patch.len() as f64,
            f: 0.0,
            ff: 0.0,
            g: 0.0,
            gg: 0.0,
            fg: 0.0,
            j: Vector6::zeros(),
            fj: Vector6::zeros(),
            gj: Vector6::zeros(),
            jj: Matrix6::zeros(),
        };

        for PatchPixel { dx, dy, value } in patch {
            let at = place + map * Vector2::new(*dx, *dy);
            let found = sample(image, at.x, at.y)?;
            let [gx, gy] = found.slope.map(f64::from);
            let (f, g) = (f64::from(*value), f64::from(found.value));
            let row = Vector6::from([gx, gy, gx * dx, gx * dy, gy * dx, gy * dy]);
            sums.f += f;
            sums.ff += f * f;
            sums.g += g;
            sums.gg += g * g;
            sums.fg += f * g;
            sums.j += row;
            sums.fj += row * f;
            sums.gj += row * g;
            sums.jj += row * row.transpose();
        }
        Some(sums)
    }

    /// Eliminates contrast and brightness, and adds the prior of the map; `None` without contrast.
    fn equations(&self, map: &Matrix2<f64>) -> Option<Equations> {
        let (n, j) = (self.count, &self.j);
        let (ff, gg) = (self.ff - self.f * self.f / n, self.gg - self.g * self.g / n);
        let fg = self.fg - self.f * self.g / n;
        // NaN is no texture
        let is_textured = ff > n && gg > n;
        if !is_textured {
            return None;
        }

        let contrast = fg / gg;
        let (fj, gj) = (self.fj - j * (self.f / n), self.gj - j * (self.g / n));
        let jj = self.jj - j * j.transpose() / n;
        let mut normal = (jj - gj * gj.transpose() / gg) * contrast.powi(2);
        let mut right = (fj - gj * contrast) * contrast;
        let variance = ((ff - fg * contrast) / (n - 8.0).max(1.0)).max(1.0 / 12.0);

        let off = map - Matrix2::identity();
        for (i, off) in [off.m11, off.m12, off.m21, off.m22].into_iter().enumerate() {
            normal[(i + 2, i + 2)] += variance / MAP_SD.powi(2);
            right[i + 2] -= variance / MAP_SD.powi(2) * off;
        }
        Some(Equations { normal, right, variance, correlation: fg / (ff * gg).sqrt() })
    }
}
