//! Smoothing the costs along paths, and the best disparity of every pixel of a band of rows.
//!
//! For each path direction r, L_r(p, d) = C(p, d) + min(L_r(p−r, d), L_r(p−r, d±1) + P₁, min_k L_r(p−r, k) + P₂)
//! − min_k L_r(p−r, k). Three paths are summed: from the left, from the right and from above; so a row needs no more
//! than the row above it, and everything stays in the cache. All numbers fit a byte, and the loops over d have a
//! constant length, which compilers turn into vector instructions.
//!
//! # Source
//! Hirschmüller 2008, *Stereo processing by semiglobal matching and mutual information*, eq. 13; the cost C is the
//! Hamming distance of census signatures. **Differs**: three paths instead of eight, as in OpenCV's `MODE_SGBM_3WAY`.

use std::ops::Range;

use super::census::{BITS, Census};
use super::{CorrelationOptions, DisparityRange};

/// Rows above a band with which its path from above starts, so that bands can be computed at the same time.
pub(super) const RUN_UP: usize = 16;
/// Most disparities that are computed.
pub(super) const MOST_DISPARITIES: usize = 256;
/// The cost of a disparity that leads out of the other image.
const OUTSIDE: u8 = BITS / 2;
/// The sum of an impossible disparity.
const NEVER: u8 = u8::MAX;

/// The images and options that every band reads.
#[derive(Debug, Clone, Copy)]
pub(super) struct BandInput<'a> {
    pub(super) left: &'a Census,
    pub(super) right: &'a Census,
    pub(super) width_left: usize,
    pub(super) width_right: usize,
    pub(super) options: &'a CorrelationOptions,
}

/// Rows whose paths are followed side by side: a path alone would wait for its own last step.
const ABREAST: usize = 4;

/// Writes the disparities of `rows` into `found`, row by row; NaN where there is none.
///
/// `D` is the number of disparities that are computed: at least those of the range.
#[inline(always)]
pub(super) fn band<const D: usize>(input: &BandInput<'_>, rows: Range<usize>, found: &mut [f32]) {
    let mut work = BandWork::<D>::new(input);
    for y in rows.start.saturating_sub(RUN_UP)..rows.start {
        work.costs(input, y, 0);
        work.go_down(input.options, 0);
    }

    let width = input.width_left.max(1);
    for (y, found) in rows.step_by(ABREAST).zip(found.chunks_mut(ABREAST * width)) {
        // where fewer rows are left, the others are computed all the same, and must not overflow
        for row in work.rows.iter_mut().skip(found.len() / width) {
            row.sums.fill(Lane([0; D]));
        }
        for (i, _) in found.chunks(width).enumerate() {
            work.costs(input, y + i, i);
            work.go_down(input.options, i);
        }
        work.along_the_rows(input.options);
        for (i, found) in found.chunks_mut(width).enumerate() {
            work.choose(input, i, found);
        }
    }
}

/// A byte for each disparity of one pixel, aligned to what the widest vector instructions load at once.
#[derive(Clone, Copy)]
#[repr(align(64))]
struct Lane<const D: usize>([u8; D]);

/// Where some paths are: the costs L_r(p, d) of each at its last pixel, and their minimum.
///
/// In memory, with impossible disparities between one path and the next, so that d − 1 and d + 1 are the same bytes, read
/// one place farther: compilers would take a shift of a vector apart into single bytes.
struct Paths<const D: usize> {
    costs: Vec<u8>,
    least: Vec<u8>,
}

/// Impossible disparities before each path, and after the last.
const BETWEEN: usize = 64;

impl<const D: usize> Paths<D> {
    fn start(count: usize) -> Self {
        let mut costs = [[NEVER; BETWEEN].as_slice(), &[0; D]].concat().repeat(count);
        costs.extend([NEVER; BETWEEN]);
        Self { costs, least: vec![0; count] }
    }

    /// Takes one of the paths to its next pixel, which costs C(p, d) itself.
    #[inline(always)]
    fn step(&mut self, path: usize, costs: &Lane<D>, options: &CorrelationOptions) -> Lane<D> {
        let (p1, p2) = (options.step_penalty, options.jump_penalty);
        let place = path * (BETWEEN + D) + BETWEEN;
        let least_before = self.least[path];
        let from_any = least_before.saturating_add(p2);
        let before = &mut self.costs[place - 1..place + D + 1];
        let mut next = Lane([0; D]);
        for d in 0..D {
            let beside = before[d].min(before[d + 2]).saturating_add(p1);
            let before = before[d + 1].min(beside).min(from_any);
            next.0[d] = costs.0[d] + (before - least_before);
        }
        before[1..=D].copy_from_slice(&next.0);
        self.least[path] = least(&next.0);
        next
    }
}

/// The least value.
#[inline(always)]
fn least<const D: usize>(values: &[u8; D]) -> u8 {
    let mut lanes = [u8::MAX; 16];
    for chunk in values.chunks_exact(16) {
        for (lane, value) in lanes.iter_mut().zip(chunk) {
            *lane = (*lane).min(*value);
        }
    }
    least_of_sixteen(lanes)
}

/// The least of sixteen bytes by four instructions: of a loop the compiler makes sixteen single bytes.
#[cfg(target_arch = "x86_64")]
#[inline(always)]
fn least_of_sixteen(lanes: [u8; 16]) -> u8 {
    use safe_arch::{byte_shr_imm_u128_m128i, get_i32_from_m128i_s, m128i, min_u8_m128i};
    let lanes = m128i::from(lanes);
    let lanes = min_u8_m128i(lanes, byte_shr_imm_u128_m128i::<8>(lanes));
    let lanes = min_u8_m128i(lanes, byte_shr_imm_u128_m128i::<4>(lanes));
    let lanes = min_u8_m128i(lanes, byte_shr_imm_u128_m128i::<2>(lanes));
    let lanes = min_u8_m128i(lanes, byte_shr_imm_u128_m128i::<1>(lanes));
    get_i32_from_m128i_s(lanes) as u8
}

#[cfg(not(target_arch = "x86_64"))]
#[inline(always)]
fn least_of_sixteen(lanes: [u8; 16]) -> u8 {
    lanes.iter().fold(u8::MAX, |least, lane| least.min(*lane))
}

/// Costs, paths and choices of the rows that are worked on.
struct BandWork<const D: usize> {
    /// C(x, d) of each row, and then the sum of its paths.
    rows: [Row<D>; ABREAST],
    /// The paths from above, of each x.
    from_above: Paths<D>,
    /// Those from the left and from the right, of each row.
    from_sides: Paths<D>,
    /// Signatures of the other image from right to left, so that rising disparities lie side by side.
    mirrored: [Vec<u8>; 3],
    /// Place of the other image's rightmost pixel in `mirrored`.
    margin: usize,
    /// For each pixel of the other image, the best of those that chose it.
    chosen: Vec<Choice>,
    /// The choice of each pixel.
    best: Vec<Choice>,
}

/// A disparity and its sum of costs.
#[derive(Clone, Copy)]
struct Choice {
    sum: u8,
    disparity: u8,
}

impl Choice {
    const NONE: Self = Self { sum: NEVER, disparity: 0 };
}

#[derive(Clone)]
struct Row<const D: usize> {
    costs: Vec<Lane<D>>,
    sums: Vec<Lane<D>>,
}

impl<const D: usize> BandWork<D> {
    fn new(input: &BandInput<'_>) -> Self {
        let (left, right) = (input.width_left, input.width_right);
        let first = input.options.range.first;
        // place of (x, d) is margin + right − 1 − x + first + d; the least and the largest must exist
        let margin = (left as i64 - right as i64 - i64::from(first)).max(0) as usize;
        let length = margin + right + D + first.max(0).unsigned_abs() as usize;
        Self {
            rows: std::array::from_fn(|_| Row {
                costs: vec![Lane([0; D]); left],
                sums: vec![Lane([0; D]); left],
            }),
            from_above: Paths::start(left),
            from_sides: Paths::start(2 * ABREAST),
            mirrored: std::array::from_fn(|_| vec![0; length]),
            margin,
            chosen: vec![Choice::NONE; right],
            best: vec![Choice::NONE; left],
        }
    }

    /// C(x, d) of image row `y`, into the row `i` of those that are worked on: in how many of 24 bits the signatures differ.
    #[inline(always)]
    fn costs(&mut self, input: &BandInput<'_>, y: usize, i: usize) {
        for (mirrored, row) in self.mirrored.iter_mut().zip(input.right.row(y)) {
            let into = mirrored.iter_mut().skip(self.margin);
            into.zip(row.iter().rev()).for_each(|(to, from)| *to = *from);
        }

        let left = input.left.row(y);
        let rightmost = (self.margin + input.width_right) as i64 - 1;
        let first = i64::from(input.options.range.first);
        for (x, Lane(costs)) in self.rows[i].costs.iter_mut().enumerate() {
            let place = (rightmost - x as i64 + first).max(0) as usize;
            let (a, b, c) = (left[0][x], left[1][x], left[2][x]);
            let (Some(right_a), Some(right_b), Some(right_c)) = (
                self.mirrored[0][place..].first_chunk::<D>(),
                self.mirrored[1][place..].first_chunk::<D>(),
                self.mirrored[2][place..].first_chunk::<D>(),
            ) else {
                continue;
            };

            for d in 0..D {
                costs[d] = ((a ^ right_a[d]).count_ones()
                    + (b ^ right_b[d]).count_ones()
                    + (c ^ right_c[d]).count_ones()) as u8;
            }
            fill_outside(costs, &valid(input, x), OUTSIDE);
        }
    }

    /// The paths from above, into the row `i` of those that are worked on.
    #[inline(always)]
    fn go_down(&mut self, options: &CorrelationOptions, i: usize) {
        let Row { costs, sums } = &mut self.rows[i];
        for (x, (costs, sums)) in costs.iter().zip(sums).enumerate() {
            *sums = self.from_above.step(x, costs, options);
        }
    }

    /// The paths from the left and from the right.
    #[inline(always)]
    fn along_the_rows(&mut self, options: &CorrelationOptions) {
        let width = self.best.len();
        self.from_sides = Paths::start(2 * ABREAST);
        for x in 0..width {
            for (i, Row { costs, sums }) in self.rows.iter_mut().enumerate() {
                for (path, x) in [(2 * i, x), (2 * i + 1, width - 1 - x)] {
                    add(&mut sums[x], &self.from_sides.step(path, &costs[x], options));
                }
            }
        }
    }

    /// The disparity of each pixel, if it is unique and no other pixel leads to the same place with a lower sum.
    #[inline(always)]
    fn choose(&mut self, input: &BandInput<'_>, i: usize, found: &mut [f32]) {
        let DisparityRange { first, count } = input.options.range;
        // column of the other image, or one that does not exist
        let other = |x: usize, disparity: u8| {
            let column = x as i64 - i64::from(first) - i64::from(disparity);
            usize::try_from(column).unwrap_or(usize::MAX)
        };

        // the best of each pixel, and of each pixel of the other image
        self.chosen.fill(Choice::NONE);
        for (x, Lane(sums)) in self.rows[i].sums.iter_mut().enumerate() {
            fill_outside(sums, &valid(input, x), NEVER);
            let sum = least(sums);
            let disparity = first_of(sums, sum);
            self.best[x] = Choice { sum, disparity };
            let chosen = self.chosen.get_mut(other(x, disparity));
            if let Some(chosen) = chosen.filter(|c| sum < c.sum) {
                *chosen = self.best[x];
            }
        }

        // kept where both agree and no other disparity is as good
        for (x, Lane(sums)) in self.rows[i].sums.iter().enumerate() {
            let Choice { sum, disparity } = self.best[x];
            let chosen = self.chosen.get(other(x, disparity));
            let chosen = chosen.map_or(u8::MAX, |chosen| chosen.disparity);
            let agrees = usize::from(disparity.abs_diff(chosen)) <= input.options.tolerance;
            let d = usize::from(disparity);
            let inside = d > 0 && d + 1 < count && sum < NEVER;
            found[x] = if agrees && inside && is_unique(sums, disparity, input.options) {
                first as f32 + refined(sums, d)
            } else {
                f32::NAN
            };
        }
    }
}

/// The disparities of the range that lead from pixel x into the other image.
#[inline(always)]
fn valid(input: &BandInput<'_>, x: usize) -> Range<usize> {
    let DisparityRange { first, count } = input.options.range;
    let farthest = x as i64 - i64::from(first);
    let from = (farthest - input.width_right as i64 + 1).clamp(0, count as i64);
    let to = (farthest + 1).clamp(from, count as i64);
    from as usize..to as usize
}

#[inline(always)]
fn fill_outside<const D: usize>(values: &mut [u8; D], valid: &Range<usize>, value: u8) {
    if *valid != (0..D) {
        values[..valid.start].fill(value);
        values[valid.end..].fill(value);
    }
}

#[inline(always)]
fn add<const D: usize>(sums: &mut Lane<D>, step: &Lane<D>) {
    for (sum, step) in sums.0.iter_mut().zip(&step.0) {
        *sum += step;
    }
}

/// The place of the first of the values that is `lowest`.
#[inline(always)]
fn first_of<const D: usize>(values: &[u8; D], lowest: u8) -> u8 {
    let mut places = [u8::MAX; D];
    for d in 0..D {
        places[d] = if values[d] == lowest { d as u8 } else { u8::MAX };
    }
    least(&places)
}

/// Whether every disparity that is no neighbour of the best has a sum larger by the share `uniqueness` at least.
#[inline(always)]
fn is_unique<const D: usize>(sums: &[u8; D], best: u8, options: &CorrelationOptions) -> bool {
    let mut others = [NEVER; D];
    for d in 0..D {
        let near = (d as u8).wrapping_sub(best.wrapping_sub(1)) <= 2;
        others[d] = if near { NEVER } else { sums[d] };
    }
    f32::from(least(&others)) >= f32::from(sums[usize::from(best)]) * (1.0 + options.uniqueness)
}

/// The minimum between the pixels: where two lines of opposite slope through the three sums meet.
#[inline(always)]
fn refined<const D: usize>(sums: &[u8; D], best: usize) -> f32 {
    let at = |d: usize| f32::from(sums[d]);
    let (below, lowest, above) = (at(best - 1), at(best), at(best + 1));
    let rise = below.max(above) - lowest;
    let known = below.max(above) < f32::from(NEVER) && rise > 0.0;
    best as f32 + if known { 0.5 * (below - above) / rise } else { 0.0 }
}
