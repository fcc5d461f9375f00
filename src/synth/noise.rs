//! What a segmentation does to a true mask.

use nalgebra::Point2;
use rand::{Rng, RngExt};
use rand_distr::{Distribution, Poisson, StandardNormal};

use crate::image::{EvenSteps, Mask, NearestPoints, Plane};

/// Errors of a segmentation, with the units of the image.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SegmentationErrors {
    /// Standard deviation of the border's displacement.
    pub border_sd_px: f64,
    /// Length along which the border errs together.
    pub correlation_px: f64,
    /// Mean number of bites out of the border in a mask.
    pub bites: f64,
    /// Mean number of holes in a mask.
    pub holes: f64,
    /// Mean number of specks outside the person in a mask.
    pub specks: f64,
    /// Radii of bites, holes and specks: least and greatest.
    pub blot_radius_px: (f64, f64),
}

impl SegmentationErrors {
    /// A good background subtraction: 0.7 px of raggedness, a bite in every second mask, few specks.
    pub const MILD: Self = Self {
        border_sd_px: 0.7,
        correlation_px: 6.0,
        bites: 0.5,
        holes: 0.3,
        specks: 0.7,
        blot_radius_px: (1.0, 3.5),
    };

    /// The mask that a segmentation with these errors would give.
    pub fn apply(&self, mask: &Mask, rng: &mut impl Rng) -> Mask {
        let mut pixels = Plane::filled(mask.width(), mask.height(), 0u8);
        for y in 0..mask.height() {
            pixels.row_mut(y).copy_from_slice(mask.row(y));
        }
        if let Some(window) = Window::around(mask, 4.0 * self.border_sd_px.max(0.0) + 2.0) {
            self.roughen(mask, &window, &mut pixels, rng);
            self.bite(mask, &window, &mut pixels, rng);
        }
        for _ in 0..count(self.specks, rng) {
            let x = rng.random_range(0..mask.width().max(1));
            let y = rng.random_range(0..mask.height().max(1));
            self.blot(&mut pixels, x, y, 1, rng);
        }
        Mask::brighter_than(&pixels, 0)
    }

    /// Moves the border by a smooth random field: inside is where distance + noise < 0.
    fn roughen(&self, mask: &Mask, window: &Window, pixels: &mut Plane<u8>, rng: &mut impl Rng) {
        let noise = SmoothNoise::new(window, self.correlation_px, rng);
        if self.border_sd_px.is_nan() || self.border_sd_px <= 0.0 {
            return;
        }
        let distance = SignedDistance::new(mask, window);
        for y in 0..window.height {
            let row = pixels.row_mut(window.top + y);
            for x in 0..window.width {
                let moved = distance.at(x, y) + self.border_sd_px * noise.at(x, y);
                row[window.left + x] = u8::from(moved < 0.0);
            }
        }
    }

    /// Takes discs out at the border and in the middle.
    fn bite(&self, mask: &Mask, window: &Window, pixels: &mut Plane<u8>, rng: &mut impl Rng) {
        let inside = |x: usize, y: usize| mask.is_foreground(x, y);
        let all = window.pixels().filter(|&(x, y)| inside(x, y));
        let (border, middle): (Vec<_>, Vec<_>) = all.partition(|&(x, y)| is_border(inside, x, y));
        for (places, mean) in [(border, self.bites), (middle, self.holes)] {
            for _ in 0..count(mean, rng) {
                if !places.is_empty() {
                    let (x, y) = places[rng.random_range(0..places.len())];
                    self.blot(pixels, x, y, 0, rng);
                }
            }
        }
    }

    /// Paints a disc.
    fn blot(&self, pixels: &mut Plane<u8>, x: usize, y: usize, value: u8, rng: &mut impl Rng) {
        let (low, high) = self.blot_radius_px;
        let radius = low + (high - low) * rng.random_range(0.0..1.0);
        let reach = radius.clamp(0.0, 1e4).ceil() as usize;

        for row in y.saturating_sub(reach)..=y + reach {
            let dy = row as f64 - y as f64;
            let target = pixels.row_mut(row);
            let columns = x.saturating_sub(reach)..(x + reach + 1).min(target.len());
            for column in columns {
                let dx = column as f64 - x as f64;
                if dx * dx + dy * dy <= radius * radius {
                    target[column] = value;
                }
            }
        }
    }
}

/// A Poisson number; 0 where the mean is 0 or impossible.
fn count(mean: f64, rng: &mut impl Rng) -> usize {
    Poisson::new(mean).map_or(0, |p| p.sample(rng) as usize)
}

/// The part of an image in which a mask's border can move.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
struct Window {
    left: usize,
    top: usize,
    width: usize,
    height: usize,
}

impl Window {
    /// The foreground's bounding box, larger by `margin_px`; `None` if there is no foreground.
    fn around(mask: &Mask, margin_px: f64) -> Option<Self> {
        let margin = margin_px.clamp(0.0, 1e4).ceil() as usize;
        let columns = |y: usize| {
            let row = mask.row(y);
            Some((row.iter().position(|&v| v == 1)?, row.iter().rposition(|&v| v == 1)?))
        };

        let (mut left, mut right, mut top, mut bottom) = (usize::MAX, 0, usize::MAX, 0);
        for y in 0..mask.height() {
            if let Some((first, last)) = columns(y) {
                (left, right) = (left.min(first), right.max(last));
                (top, bottom) = (top.min(y), y);
            }
        }

        (top != usize::MAX).then(|| {
            let (left, top) = (left.saturating_sub(margin), top.saturating_sub(margin));
            Self {
                left,
                top,
                width: (right + margin + 1).min(mask.width()) - left,
                height: (bottom + margin + 1).min(mask.height()) - top,
            }
        })
    }

    fn pixels(self) -> impl Iterator<Item = (usize, usize)> {
        (0..self.height)
            .flat_map(move |y| (0..self.width).map(move |x| (self.left + x, self.top + y)))
    }
}

/// Distance to the border in pixels, negative inside.
struct SignedDistance {
    to_inside: Plane<f64>,
    to_outside: Plane<f64>,
}

impl SignedDistance {
    fn new(mask: &Mask, window: &Window) -> Self {
        let to = |wanted: bool| {
            let is_wanted =
                |x: usize, y: usize| mask.is_foreground(window.left + x, window.top + y) == wanted;
            distances(window.width, window.height, is_wanted)
        };
        Self { to_inside: to(true), to_outside: to(false) }
    }

    /// At a pixel of the window; the border lies half a pixel from the pixels beside it.
    fn at(&self, x: usize, y: usize) -> f64 {
        let to = |distances: &Plane<f64>| distances.get(x, y).unwrap_or(f64::INFINITY);
        let (outward, inward) = (to(&self.to_inside), to(&self.to_outside));
        if outward > 0.0 { outward - 0.5 } else { 0.5 - inward }
    }
}

/// The distance of every pixel from the nearest that is wanted, px; infinite without any.
fn distances(width: usize, height: usize, is_wanted: impl Fn(usize, usize) -> bool) -> Plane<f64> {
    // the nearest to a pixel that is not wanted has one that is not wanted beside it
    let pixels = (0..height).flat_map(|y| (0..width).map(move |x| (x, y)));
    let border: Vec<Point2<f64>> = pixels
        .filter(|&(x, y)| is_wanted(x, y) && is_border(&is_wanted, x, y))
        .map(|(x, y)| Point2::new(x as f64, y as f64))
        .collect();

    let mut nearest = NearestPoints::new(border.iter().copied());
    let columns = EvenSteps { first: 0.0, step: 1.0, count: width };
    let mut distances = Plane::filled(width, height, f64::INFINITY);
    for y in 0..height {
        let row = distances.row_mut(y);
        nearest.along_row(y as f64, columns, |x, k| {
            row[x] = (Point2::new(x as f64, y as f64) - border[k]).norm();
        });
        for (_, distance) in row.iter_mut().enumerate().filter(|(x, _)| is_wanted(*x, y)) {
            *distance = 0.0;
        }
    }
    distances
}

/// Whether one of the four pixels beside a pixel is not inside, or beyond the first row or column.
fn is_border(inside: impl Fn(usize, usize) -> bool, x: usize, y: usize) -> bool {
    !(inside(x + 1, y)
        && inside(x, y + 1)
        && x > 0
        && inside(x - 1, y)
        && y > 0
        && inside(x, y - 1))
}

/// A Gaussian random field of variance 1 everywhere, smooth over a correlation length.
///
/// White noise on a lattice, interpolated by cubic B-splines and divided by the root of the sum of their squares.
struct SmoothNoise {
    lattice: Plane<f64>,
    spacing_px: f64,
}

impl SmoothNoise {
    fn new(window: &Window, correlation_px: f64, rng: &mut impl Rng) -> Self {
        let spacing_px = if correlation_px > 1.0 { correlation_px } else { 1.0 };
        let nodes = |side: usize| (side as f64 / spacing_px) as usize + 4;
        let (columns, rows) = (nodes(window.width), nodes(window.height));
        let mut lattice = Plane::filled(columns, rows, 0.0);
        for y in 0..rows {
            for node in lattice.row_mut(y) {
                *node = StandardNormal.sample(rng);
            }
        }
        Self { lattice, spacing_px }
    }

    fn at(&self, x: usize, y: usize) -> f64 {
        let (column, across) = weights(x as f64 / self.spacing_px);
        let (row, down) = weights(y as f64 / self.spacing_px);
        let (mut value, mut variance) = (0.0, 0.0);
        for (j, v) in down.iter().enumerate() {
            for (i, u) in across.iter().enumerate() {
                let node = self.lattice.get(column + i, row + j).unwrap_or(0.0);
                value += u * v * node;
                variance += (u * v).powi(2);
            }
        }
        value / variance.sqrt()
    }
}

/// The first of four nodes around a place on the lattice, and their cubic B-spline weights.
fn weights(place: f64) -> (usize, [f64; 4]) {
    let t = place.fract();
    let (t2, t3) = (t * t, t * t * t);
    let each =
        [(1.0 - t).powi(3), 3.0 * t3 - 6.0 * t2 + 4.0, -3.0 * t3 + 3.0 * t2 + 3.0 * t + 1.0, t3];
    (place as usize, each.map(|w| w / 6.0))
}

#[cfg(test)]
mod tests {
    use rand::SeedableRng;
    use rand_chacha::ChaCha8Rng;

    use super::*;

    const NONE: SegmentationErrors = SegmentationErrors {
        border_sd_px: 0.0,
        correlation_px: 8.0,
        bites: 0.0,
        holes: 0.0,
        specks: 0.0,
        blot_radius_px: (2.0, 4.0),
    };

    /// Left half foreground.
    fn half_plane() -> Mask {
        Mask::from_fn(200, 400, |x, _| x < 100)
    }

    fn rng(seed: u64) -> ChaCha8Rng {
        ChaCha8Rng::seed_from_u64(seed)
    }

    fn area(mask: &Mask) -> usize {
        let count = |y| mask.row(y).iter().filter(|&&v| v == 1).count();
        (0..mask.height()).map(count).sum()
    }

    #[test]
    fn no_errors_leave_a_mask_as_it_is() {
        assert_eq!(NONE.apply(&half_plane(), &mut rng(1)), half_plane());
    }

    /// A straight border of 400 px holds about 50 independent errors: their spread is known to ±20 % (2 σ).
    #[test]
    fn the_border_moves_by_the_stated_amplitude_and_errs_together_along_the_stated_length() {
        let errors = SegmentationErrors { border_sd_px: 3.0, ..NONE };
        let (mut variance, mut next, mut far, mut count) = (0.0, 0.0, 0.0, 0.0);
        for seed in 0..8 {
            let mask = errors.apply(&half_plane(), &mut rng(seed));
            let width = |y: usize| mask.row(y).iter().filter(|&&v| v == 1).count() as f64 - 100.0;
            for y in 0..350 {
                variance += width(y).powi(2);
                next += width(y) * width(y + 1);
                far += width(y) * width(y + 40);
                count += 1.0;
            }
        }
        let sd = f64::sqrt(variance / count);
        assert!((2.6..3.4).contains(&sd), "{sd}");
        assert!(next / variance > 0.9 && (far / variance).abs() < 0.15);
    }

    #[test]
    fn bites_and_holes_take_away_and_specks_add() {
        let truth = half_plane();
        let only = |bites, holes, specks| SegmentationErrors { bites, holes, specks, ..NONE };
        assert!(area(&only(5.0, 0.0, 0.0).apply(&truth, &mut rng(1))) < area(&truth));
        assert!(area(&only(0.0, 5.0, 0.0).apply(&truth, &mut rng(1))) < area(&truth));
        assert!(area(&only(0.0, 0.0, 9.0).apply(&truth, &mut rng(1))) > area(&truth));
    }

    #[test]
    fn an_empty_mask_gets_only_specks() {
        let empty = Mask::from_fn(50, 40, |_, _| false);
        let specks = SegmentationErrors { specks: 4.0, ..SegmentationErrors::MILD };
        assert!(area(&specks.apply(&empty, &mut rng(1))) > 0);
        assert_eq!(area(&NONE.apply(&Mask::from_fn(0, 0, |_, _| true), &mut rng(1))), 0);
    }
}
