//! A background that learns: an adaptive mixture of Gaussians in every pixel.
//!
//! The colours that a pixel shows over time are a mixture of K Gaussians of one variance in all channels. A new colour x
//! belongs to the mode k with the largest ω/σ among those with ‖x − μ_k‖²/3 < (2.5 σ_k)²; all weights follow
//! ω ← (1 − α) ω + α M with M = 1 for that mode and 0 for the others, and that mode learns
//! μ ← μ + ρ (x − μ), σ² ← σ² + ρ (‖x − μ‖²/3 − σ²). Where none matches, the mode of least weight is replaced by
//! (ω = α, μ = x, σ = σ₀). Background are the modes of largest ω/σ whose weights first exceed T together.
//!
//! Rows are independent and run in parallel; within a row each mode is five runs of `f32`, so that the compiler
//! vectorises every loop.
//!
//! # Source
//! Stauffer & Grimson, *Adaptive background mixture models for real-time tracking*, CVPR 1999, eq. 1–9.
//! **Differs**: ρ = α/ω instead of α·η(x | μ, σ), so that with α = 1/t a mode is the plain mean of what it has matched
//! (as Zivkovic 2004); the distance is the root mean square over the channels.

use rayon::prelude::*;

use super::{Mask, Picture, Plane};

/// Settings of a [`Mixture`].
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MixtureOptions {
    /// K, number of modes in a pixel (default 4; the paper: 3 to 5).
    pub modes: usize,
    /// A colour matches a mode within so many standard deviations (default 2.5, as published).
    pub match_sigmas: f32,
    /// σ₀ of a new mode, grey levels (default 6).
    pub first_sigma: f32,
    /// σ never falls below this, grey levels (default 2: a camera's noise and rounding).
    pub least_sigma: f32,
    /// T, share of the time that shows background at least (default 0.7).
    pub background_share: f32,
}

impl Default for MixtureOptions {
    fn default() -> Self {
        Self {
            modes: 4,
            match_sigmas: 2.5,
            first_sigma: 6.0,
            least_sigma: 2.0,
            background_share: 0.7,
        }
    }
}

/// One Gaussian of a pixel.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Mode {
    /// ω, share of the time.
    pub weight: f32,
    /// σ², grey levels squared, of each channel.
    pub variance: f32,
    /// μ, red, green, blue.
    pub mean: [f32; 3],
}

/// Numbers of a mode: ω, σ², and the mean's three.
const NUMBERS: usize = 5;

/// A mixture of Gaussians in every pixel of a picture.
#[derive(Clone, Debug)]
pub struct Mixture {
    width: usize,
    height: usize,
    options: MixtureOptions,
    /// For each row, for each mode, its [`NUMBERS`] one after another, each over the columns.
    rows: Vec<f32>,
}

impl Mixture {
    /// A mixture that has seen nothing.
    pub fn new(width: usize, height: usize, options: MixtureOptions) -> Self {
        let options = MixtureOptions {
            modes: options.modes.max(1),
            ..options
        };
        Self {
            width,
            height,
            options,
            rows: vec![0.0; width * height * options.modes * NUMBERS],
        }
    }

    /// K.
    pub fn modes(&self) -> usize {
        self.options.modes
    }

    /// Learns a picture at the rate α and says which pixels are not background; nothing for one of another size.
    ///
    /// α = 1/t for the t-th picture gives all of them the same weight; a constant α forgets with time constant 1/α.
    pub fn update(&mut self, picture: &Picture, rate: f32) -> Mask {
        let mut foreground = Plane::filled(self.width, self.height, 0_u8);
        let is_same_size = picture.width() == self.width && picture.height() == self.height;
        if is_same_size && self.width > 0 {
            let length = self.width * self.options.modes * NUMBERS;
            let rows = self.rows.par_chunks_mut(length);
            let marks = foreground.par_rows_mut();
            let pixels = picture.values().par_chunks(self.width);
            let options = self.options;
            rows.zip(marks).zip(pixels).for_each_init(
                || Scratch::new(length / options.modes / NUMBERS),
                |scratch, ((row, marks), pixels)| {
                    scratch.update(row, marks, pixels, rate, &options)
                },
            );
        }
        Mask::of_ones(foreground)
    }

    /// Mode `k` of pixel (x, y); one of no weight where there is none.
    pub fn mode(&self, k: usize, x: usize, y: usize) -> Mode {
        let start = ((y * self.options.modes + k) * NUMBERS) * self.width + x;
        let number = |i: usize| {
            self.rows
                .get(start + i * self.width)
                .copied()
                .unwrap_or(0.0)
        };
        Mode {
            weight: number(0),
            variance: number(1).max(self.options.least_sigma.powi(2)),
            mean: [number(2), number(3), number(4)],
        }
    }
}

/// What one row needs while it is updated, one number a column.
struct Scratch {
    colour: [Vec<f32>; 3],
    /// Largest ω²/σ² among the modes that match, −1 if none does.
    best_score: Vec<f32>,
    best: Vec<f32>,
    least_weight: Vec<f32>,
    least: Vec<f32>,
    /// Weight of the modes that rank before the best.
    before: Vec<f32>,
}

impl Scratch {
    fn new(width: usize) -> Self {
        let zeros = || vec![0.0; width];
        Self {
            colour: [zeros(), zeros(), zeros()],
            best_score: zeros(),
            best: zeros(),
            least_weight: zeros(),
            least: zeros(),
            before: zeros(),
        }
    }

    fn update(
        &mut self,
        row: &mut [f32],
        marks: &mut [u8],
        pixels: &[[u8; 3]],
        rate: f32,
        options: &MixtureOptions,
    ) {
        let width = pixels.len();
        for (x, pixel) in pixels.iter().enumerate() {
            for (channel, value) in self.colour.iter_mut().zip(pixel) {
                channel[x] = f32::from(*value);
            }
        }
        self.best_score.fill(-1.0);
        self.best.fill(-1.0);
        self.least_weight.fill(f32::INFINITY);
        self.before.fill(0.0);
        for (k, mode) in row.chunks_exact(NUMBERS * width).enumerate() {
            self.match_mode(k as f32, mode, options);
        }
        for mode in row.chunks_exact(NUMBERS * width) {
            self.rank_mode(mode);
        }
        for (k, mode) in row.chunks_exact_mut(NUMBERS * width).enumerate() {
            self.learn(k as f32, mode, rate, options);
        }
        for (x, mark) in marks.iter_mut().enumerate() {
            let is_background =
                self.best_score[x] >= 0.0 && self.before[x] < options.background_share;
            *mark = u8::from(!is_background);
        }
    }

    /// Whether mode k matches, and whether it is the best, or the least, so far.
    fn match_mode(&mut self, k: f32, mode: &[f32], options: &MixtureOptions) {
        let width = self.best.len();
        let [w, v, r, g, b] = parts(mode, width);
        let [red, green, blue] = [0, 1, 2].map(|i| &self.colour[i][..width]);
        let (best_score, best) = (&mut self.best_score[..width], &mut self.best[..width]);
        let (least_weight, least) = (&mut self.least_weight[..width], &mut self.least[..width]);
        let gate = 3.0 * options.match_sigmas * options.match_sigmas;
        for x in 0..width {
            let (dr, dg, db) = (red[x] - r[x], green[x] - g[x], blue[x] - b[x]);
            let squared = dr * dr + dg * dg + db * db;
            let is_match = (squared < gate * v[x]) & (w[x] > 0.0);
            let score = if is_match {
                w[x] * w[x] / v[x].max(1e-6)
            } else {
                -1.0
            };
            let is_better = score > best_score[x];
            best[x] = if is_better { k } else { best[x] };
            best_score[x] = if is_better { score } else { best_score[x] };
            let is_less = w[x] < least_weight[x];
            least[x] = if is_less { k } else { least[x] };
            least_weight[x] = if is_less { w[x] } else { least_weight[x] };
        }
    }

    /// Adds the weight of a mode that ranks before the best.
    fn rank_mode(&mut self, mode: &[f32]) {
        let width = self.best.len();
        let [w, v, ..] = parts(mode, width);
        let (score, before) = (&self.best_score[..width], &mut self.before[..width]);
        for x in 0..width {
            let is_before = w[x] * w[x] > score[x] * v[x] * (1.0 + 1e-5);
            before[x] += if is_before { w[x] } else { 0.0 };
        }
    }

    fn learn(&self, k: f32, mode: &mut [f32], rate: f32, options: &MixtureOptions) {
        let width = self.best.len();
        let [w, v, r, g, b] = parts_mut(mode, width);
        let [red, green, blue] = [0, 1, 2].map(|i| &self.colour[i][..width]);
        let (best, least) = (&self.best[..width], &self.least[..width]);
        let first = options.first_sigma * options.first_sigma;
        let floor = options.least_sigma * options.least_sigma;
        for x in 0..width {
            let is_match = best[x] == k;
            let is_new = (best[x] < 0.0) & (least[x] == k);
            let gained = if is_match | is_new { rate } else { 0.0 };
            let kept = if is_new { 0.0 } else { w[x] * (1.0 - rate) };
            w[x] = kept + gained;
            let (dr, dg, db) = (red[x] - r[x], green[x] - g[x], blue[x] - b[x]);
            let rho = if is_match {
                (rate / w[x].max(1e-9)).min(1.0)
            } else {
                0.0
            };
            let rho = if is_new { 1.0 } else { rho };
            r[x] += rho * dr;
            g[x] += rho * dg;
            b[x] += rho * db;
            let spread = (dr * dr + dg * dg + db * db) / 3.0;
            let learned = (v[x] + rho * (spread - v[x])).max(floor);
            v[x] = if is_new { first } else { learned };
        }
    }
}

fn parts(mode: &[f32], width: usize) -> [&[f32]; NUMBERS] {
    [0, 1, 2, 3, 4].map(|i| &mode[i * width..(i + 1) * width])
}

fn parts_mut(mode: &mut [f32], width: usize) -> [&mut [f32]; NUMBERS] {
    let (w, rest) = mode.split_at_mut(width);
    let (v, rest) = rest.split_at_mut(width);
    let (r, rest) = rest.split_at_mut(width);
    let (g, b) = rest.split_at_mut(width);
    [w, v, r, g, b]
}

#[cfg(test)]
mod tests {
    use super::*;

    const GREY: [u8; 3] = [100; 3];
    const RED: [u8; 3] = [200, 20, 20];

    fn trained(pictures: &[[u8; 3]]) -> Mixture {
        let mut mixture = Mixture::new(5, 3, MixtureOptions::default());
        for (t, colour) in pictures.iter().enumerate() {
            mixture.update(&Picture::filled(5, 3, *colour), 1.0 / (t as f32 + 1.0));
        }
        mixture
    }

    #[test]
    fn what_stays_is_background_and_what_is_new_is_not() {
        let mut mixture = trained(&[GREY; 20]);
        let mut picture = Picture::filled(5, 3, [102, 99, 101]);
        picture.row_mut(1)[4] = RED;
        let seen = mixture.update(&picture, 0.01);
        assert_eq!(
            (seen.row(0), seen.row(1)),
            (&[0; 5][..], &[0, 0, 0, 0, 1][..])
        );
    }

    #[test]
    fn with_equal_weights_a_mode_is_the_mean_of_what_it_matched() {
        let mixture = trained(&[[100; 3], [104; 3], RED, [102; 3]]);
        let modes: Vec<Mode> = (0..4).map(|k| mixture.mode(k, 2, 1)).collect();
        approx::assert_relative_eq!(modes[0].weight, 0.75, epsilon = 1e-6);
        approx::assert_relative_eq!(modes[0].mean[0], 102.0, epsilon = 1e-4);
        let red = modes.iter().find(|mode| mode.mean[0] == 200.0).unwrap();
        approx::assert_relative_eq!(red.weight, 0.25, epsilon = 1e-6);
    }

    #[test]
    fn the_weights_add_up_to_one_until_modes_are_replaced() {
        let mixture = trained(&[GREY, RED, GREY, [0; 3], GREY]);
        let sum: f32 = (0..4).map(|k| mixture.mode(k, 0, 0).weight).sum();
        approx::assert_relative_eq!(sum, 1.0, epsilon = 1e-6);
    }

    #[test]
    fn what_comes_often_enough_becomes_background() {
        let mut mixture = trained(&[GREY; 10]);
        let red = Picture::filled(5, 3, RED);
        let first = (0..60).position(|_| mixture.update(&red, 0.05).row(0)[0] == 0);
        // ω of the grey falls to 0.95^t; red is background when what ranks before it is below 0.7
        assert!((5..20).contains(&first.unwrap()), "{first:?}");
    }

    #[test]
    fn a_picture_of_another_size_teaches_nothing() {
        let mut mixture = trained(&[GREY; 3]);
        mixture.update(&Picture::filled(4, 3, RED), 0.5);
        assert_eq!(mixture.mode(0, 0, 0).mean, [100.0; 3]);
    }

    #[test]
    fn the_modes_do_not_depend_on_the_number_of_threads() {
        let mut pictures = Vec::new();
        for k in 0..6_u32 {
            let values = (0..15_u32).map(|i| [(i * 37 + k * 11) as u8, (i * k) as u8, 90]);
            pictures.push(Picture::from_values(5, 3, values.collect()).unwrap());
        }
        let run = |threads| {
            let pool = rayon::ThreadPoolBuilder::new()
                .num_threads(threads)
                .build()
                .unwrap();
            pool.install(|| {
                let mut mixture = Mixture::new(5, 3, MixtureOptions::default());
                for picture in &pictures {
                    mixture.update(picture, 0.1);
                }
                mixture.rows
            })
        };
        assert_eq!(run(1), run(3));
    }
}
