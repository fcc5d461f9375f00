//! An adaptive background: a mixture of Gaussians in every pixel that learns.
//!
//! The colours that a pixel shows over time are a mixture of K Gaussians of one variance in all channels. A new colour x
//! belongs to the mode k with the largest ω/σ among those with ‖x − μ_k‖²/3 < (2.5 σ_k)²; all weights follow
//! ω ← (1 − α) ω + α M with M = 1 for that mode and 0 for the others, and that mode learns
//! μ ← μ + ρ (x − μ), σ² ← σ² + ρ (‖x − μ‖²/3 − σ²). Where none matches, the mode of least weight is replaced by
//! (ω = α, μ = x, σ = σ₀). The modes of largest ω/σ are background, as many as it takes for their weights to exceed T.
//!
//! Rows are independent and run in parallel. A row is cut into tiles of 64 pixels. Each number of a mode is one array over a
//! tile, so that the compiler vectorises every loop; modes that no pixel of a tile needs are skipped.
//!
//! # Source
//! Stauffer & Grimson, *Adaptive background mixture models for real-time tracking*, CVPR 1999, eq. 1–9.
//! **Differs**: ρ = α/ω instead of α·η(x | μ, σ), so that with α = 1/t a mode is the plain mean of the colours that matched
//! it (as Zivkovic 2004); the distance is the root mean square over the channels.

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
    /// T, least share of the time that a pixel shows background (default 0.7).
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
    /// μ: red, green, blue.
    pub mean: [f32; 3],
}

/// Pixels that are updated together: their modes stay in the first-level cache, and every loop has a known length.
const LANES: usize = 64;
/// A number for each pixel of a tile.
type Lane = [f32; LANES];

/// One mode of each pixel of a tile.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Modes {
    weight: Lane,
    variance: Lane,
    mean: [Lane; 3],
}

const EMPTY: Modes =
    Modes { weight: [0.0; LANES], variance: [0.0; LANES], mean: [[0.0; LANES]; 3] };

/// A mixture of Gaussians in every pixel of a picture.
#[derive(Clone, Debug)]
pub struct Mixture {
    width: usize,
    height: usize,
    options: MixtureOptions,
    /// For each row, for each tile of it, its K modes.
    tiles: Vec<Modes>,
    /// How many modes of each tile have any weight.
    used: Vec<u8>,
}

impl Mixture {
    /// A mixture that has seen nothing.
    pub fn new(width: usize, height: usize, options: MixtureOptions) -> Self {
        let options =
            MixtureOptions { modes: options.modes.clamp(1, usize::from(u8::MAX)), ..options };
        let tiles = width.div_ceil(LANES) * height;
        Self {
            width,
            height,
            options,
            tiles: vec![EMPTY; tiles * options.modes],
            used: vec![0; tiles],
        }
    }

    /// K.
    pub fn modes(&self) -> usize {
        self.options.modes
    }

    /// Learns a picture at the rate α and returns the pixels that are not background; a picture of another size is ignored.
    ///
    /// α = 1/t for the t-th picture gives all pictures the same weight. A constant α forgets with the time constant 1/α and
    /// drops a mode whose weight falls below α/2.
    pub fn update(&mut self, picture: &Picture, rate: f32) -> Mask {
        let mut foreground = Plane::filled(self.width, self.height, 0_u8);
        let is_same_size = picture.width() == self.width && picture.height() == self.height;
        if is_same_size && self.width > 0 {
            let tiles = self.width.div_ceil(LANES);
            let (options, modes) = (self.options, self.options.modes);
            let rows = self.tiles.par_chunks_exact_mut(tiles * modes);
            let used = self.used.par_chunks_exact_mut(tiles);
            let pixels = picture.values().par_chunks_exact(self.width);
            let marks = foreground.par_rows_mut();
            let rows = rows.zip(used).zip(pixels).zip(marks);
            rows.with_min_len(8).for_each(|(((row, used), pixels), marks)| {
                update_row(row, used, pixels, marks, rate, &options);
            });
        }
        Mask::from_ones(foreground)
    }

    /// Mode `k` of pixel (x, y); a mode without weight if there is none.
    pub fn mode(&self, k: usize, x: usize, y: usize) -> Mode {
        let tile = y * self.width.div_ceil(LANES) + x / LANES;
        let modes = self.tiles.get(tile * self.options.modes + k);
        let modes = modes.filter(|_| k < self.options.modes).unwrap_or(&EMPTY);
        let lane = x % LANES;
        Mode {
            weight: modes.weight[lane],
            variance: modes.variance[lane].max(self.options.least_sigma.powi(2)),
            mean: [0, 1, 2].map(|channel| modes.mean[channel][lane]),
        }
    }
}

/// The bits are the same for every instruction set; only the width of the loops differs.
#[multiversion::multiversion(targets("x86_64+avx2", "x86_64+avx512f+avx512vl"))]
fn update_row(
    row: &mut [Modes],
    used: &mut [u8],
    pixels: &[[u8; 3]],
    marks: &mut [u8],
    rate: f32,
    options: &MixtureOptions,
) {
    let tiles = row.chunks_exact_mut(options.modes).zip(used);
    let pixels = pixels.chunks(LANES).zip(marks.chunks_mut(LANES));
    for ((modes, used), (pixels, marks)) in tiles.zip(pixels) {
        let tile = Tile::new(pixels);
        tile.update(modes, used, marks, rate, options);
    }
}

/// The colours of a tile.
struct Tile {
    colour: [Lane; 3],
}

/// The modes that a tile's colours match.
struct Matches {
    /// Largest ω²/σ² among the modes that match, −1 if none does.
    score: Lane,
    /// Index of that mode, −1 if none matches.
    mode: [i32; LANES],
    /// Least weight of a mode.
    least_weight: Lane,
    /// Index of that mode.
    least: [i32; LANES],
}

impl Tile {
    #[inline(always)]
    fn new(pixels: &[[u8; 3]]) -> Self {
        let mut colour = [[0.0; LANES]; 3];
        for (i, pixel) in pixels.iter().enumerate().take(LANES) {
            colour[0][i] = f32::from(pixel[0]);
            colour[1][i] = f32::from(pixel[1]);
            colour[2][i] = f32::from(pixel[2]);
        }
        Self { colour }
    }

    #[inline(always)]
    fn update(
        &self,
        modes: &mut [Modes],
        used: &mut u8,
        marks: &mut [u8],
        rate: f32,
        options: &MixtureOptions,
    ) {
        let mut matches = Matches {
            score: [-1.0; LANES],
            mode: [-1; LANES],
            least_weight: [f32::INFINITY; LANES],
            least: [0; LANES],
        };
        let mut count = usize::from(*used);
        for (k, mode) in modes.iter().enumerate().take(count) {
            matches.compare(k as i32, mode, &self.colour, options);
        }

        // a colour that no mode matches takes the next one, if there is one
        let is_any_new = matches.score[..marks.len()].iter().any(|score| *score < 0.0);
        if is_any_new && count < modes.len() {
            matches.compare(count as i32, &modes[count], &self.colour, options);
            count += 1;
        }

        // the weight of the modes that rank before the matched one, which then learns
        let mut before = [0.0; LANES];
        if count > 1 {
            for mode in &modes[..count] {
                add_if_before(&mut before, mode, &matches.score);
            }
        }
        for (k, mode) in modes.iter_mut().enumerate().take(count) {
            matches.teach(k as i32, mode, &self.colour, rate, options);
        }

        let is_unused = |mode: &Modes| mode.weight.iter().all(|weight| *weight <= 0.0);
        while count > 1 && is_unused(&modes[count - 1]) {
            count -= 1;
        }
        *used = count as u8;

        for (i, mark) in marks.iter_mut().enumerate() {
            let is_background = matches.score[i] >= 0.0 && before[i] < options.background_share;
            *mark = u8::from(!is_background);
        }
    }
}

/// Adds the weight of a mode where it ranks before the matched one.
#[inline(always)]
fn add_if_before(before: &mut Lane, mode: &Modes, score: &Lane) {
    for i in 0..LANES {
        let weight = mode.weight[i];
        let is_before = weight * weight > score[i] * mode.variance[i] * (1.0 + 1e-5);
        before[i] += if is_before { weight } else { 0.0 };
    }
}

impl Matches {
    /// Compares colours with mode k, which may match best or weigh least so far.
    #[inline(always)]
    fn compare(&mut self, k: i32, mode: &Modes, colour: &[Lane; 3], options: &MixtureOptions) {
        let gate = 3.0 * options.match_sigmas * options.match_sigmas;
        for i in 0..LANES {
            let squared = squared(colour, &mode.mean, i);
            let (weight, variance) = (mode.weight[i], mode.variance[i]);
            let is_match = (squared < gate * variance) & (weight > 0.0);
            let score = if is_match { weight * weight / variance } else { -1.0 };

            let is_better = score > self.score[i];
            self.mode[i] = if is_better { k } else { self.mode[i] };
            self.score[i] = if is_better { score } else { self.score[i] };

            let is_less = weight < self.least_weight[i];
            self.least[i] = if is_less { k } else { self.least[i] };
            self.least_weight[i] = if is_less { weight } else { self.least_weight[i] };
        }
    }

    /// Updates mode k, which the colours match, replace, or leave alone.
    #[inline(always)]
    fn teach(
        &self,
        k: i32,
        mode: &mut Modes,
        colour: &[Lane; 3],
        rate: f32,
        options: &MixtureOptions,
    ) {
        let first = options.first_sigma * options.first_sigma;
        let floor = options.least_sigma * options.least_sigma;

        for i in 0..LANES {
            let is_match = self.mode[i] == k;
            let is_new = (self.mode[i] < 0) & (self.least[i] == k);

            // ω ← (1 − α) ω + α M; ρ = α/ω
            let kept = if is_new { 0.0 } else { mode.weight[i] * (1.0 - rate) };
            let weight = kept + if is_match | is_new { rate } else { 0.0 };
            let share = if is_match { rate / weight } else { 0.0 };
            let rho = if is_new { 1.0 } else { share };

            let spread = squared(colour, &mode.mean, i) / 3.0;
            for (mean, colour) in mode.mean.iter_mut().zip(colour) {
                mean[i] += rho * (colour[i] - mean[i]);
            }
            let learned = (mode.variance[i] + rho * (spread - mode.variance[i])).max(floor);
            mode.variance[i] = if is_new { first } else { learned };
            mode.weight[i] = if weight < 0.5 * rate { 0.0 } else { weight };
        }
    }
}

/// Squared distance of the colour of pixel i from the mean of its mode.
#[inline(always)]
fn squared(colour: &[Lane; 3], mean: &[Lane; 3], i: usize) -> f32 {
    let [r, g, b] = [0, 1, 2].map(|channel| colour[channel][i] - mean[channel][i]);
    r * r + g * g + b * b
}

#[cfg(test)]
mod tests;
