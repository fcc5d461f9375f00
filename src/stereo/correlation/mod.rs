//! Dense disparity of a rectified pair by correlation of small neighbourhoods.
//!
//! [`correlate`] compares the census signature (5 × 5 pixels) of every pixel of the left image with those of the same row
//! of the right image, smooths the costs along three paths, takes the best disparity, and refines it between the pixels. A
//! disparity is kept only if the right image chooses the same, no other is as good, and it is not a speck.
//!
//! | file             | holds                                                       |
//! |------------------|-------------------------------------------------------------|
//! | `census.rs`      | the signatures                                              |
//! | `semi_global.rs` | costs, paths, choice: a band of rows, all in the cache      |
//! | `specks.rs`      | removing small regions                                      |

mod census;
mod semi_global;
mod specks;

use multiversion::multiversion;
use rayon::prelude::*;

use super::DepthError;
use crate::image::Plane;
use census::Census;
use semi_global::{BandInput, MOST_DISPARITIES, band};
pub(super) use specks::remove as remove_specks;

/// Rows that are computed at once.
const BAND: usize = 64;
/// Largest penalty with which the sum of three paths fits a byte, beside the mark of an impossible disparity.
const MOST_PENALTY: u8 = 60;

/// The disparities that are looked for.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct DisparityRange {
    /// The least, px; may be negative.
    pub first: i32,
    /// How many, in steps of one pixel; at most 256.
    pub count: usize,
}

/// How dense disparity is computed.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct CorrelationOptions {
    /// The disparities that are looked for; the two at the ends are never results. 0 to 63.
    pub range: DisparityRange,
    /// P₁: what a step of one pixel between neighbours costs, bits of 24. 4.
    pub step_penalty: u8,
    /// P₂: what any larger step costs, bits of 24; at most 60. 24.
    pub jump_penalty: u8,
    /// By what share of the best sum the next best must exceed it. 0.05.
    pub uniqueness: f32,
    /// By how much the right image's choice may differ, px. 1.
    pub tolerance: usize,
    /// Regions of fewer pixels are removed. 100.
    pub least_region: usize,
}

impl Default for CorrelationOptions {
    fn default() -> Self {
        Self {
            range: DisparityRange { first: 0, count: 64 },
            step_penalty: 4,
            jump_penalty: 24,
            uniqueness: 0.05,
            tolerance: 1,
            least_region: 100,
        }
    }
}

/// The disparities of the left image, x_left − x_right in pixels; NaN where none is sure.
///
/// Images are grey and rectified: a point is in the same row of both. The result is the same for any number of threads.
///
/// # Errors
/// [`DepthError`] for images with different numbers of rows and options outside their range.
pub fn correlate(
    left: &Plane<u8>,
    right: &Plane<u8>,
    options: &CorrelationOptions,
) -> Result<Plane<f32>, DepthError> {
    check(left, right, options)?;

    // 1. signatures
    let (census_left, census_right) = rayon::join(|| Census::new(left), || Census::new(right));
    let input = BandInput {
        left: &census_left,
        right: &census_right,
        width_left: left.width(),
        width_right: right.width(),
        options,
    };

    // 2. costs, paths and choice, band by band
    let mut values = vec![f32::NAN; left.width() * left.height()];
    let bands = values.par_chunks_mut((BAND * left.width()).max(1));
    bands.enumerate().for_each(|(i, found)| {
        let rows = i * BAND..((i + 1) * BAND).min(left.height());
        fill_band(&input, rows, found);
    });

    // 3. small regions removed
    let nothing = || Plane::filled(left.width(), left.height(), f32::NAN);
    let found = Plane::from_values(left.width(), left.height(), values);
    let mut disparities = found.unwrap_or_else(nothing);
    remove_specks(&mut disparities, options.least_region);
    Ok(disparities)
}

#[multiversion(targets(
    "x86_64+avx512f+avx512bw+avx512vl+avx512bitalg+avx512vbmi+popcnt+bmi2",
    "x86_64+avx2+popcnt+bmi2",
))]
fn fill_band(input: &BandInput<'_>, rows: std::ops::Range<usize>, found: &mut [f32]) {
    match input.options.range.count {
        0..=32 => band::<32>(input, rows, found),
        33..=64 => band::<64>(input, rows, found),
        65..=128 => band::<128>(input, rows, found),
        _ => band::<MOST_DISPARITIES>(input, rows, found),
    }
}

fn check(
    left: &Plane<u8>,
    right: &Plane<u8>,
    options: &CorrelationOptions,
) -> Result<(), DepthError> {
    if left.height() != right.height() {
        return Err(DepthError::Rows { left: left.height(), right: right.height() });
    }

    let DisparityRange { first, count } = options.range;
    let last = i64::from(first) + count as i64 - 1;
    let leads_inside = i64::from(first) < left.width() as i64 && last > -(right.width() as i64);
    if !(3..=MOST_DISPARITIES).contains(&count) || !leads_inside {
        return Err(DepthError::Range {
            first: first.into(),
            last,
            left: left.width(),
            right: right.width(),
        });
    }

    let (step, jump) = (options.step_penalty, options.jump_penalty);
    if step > jump || jump > MOST_PENALTY {
        return Err(DepthError::Penalties { step, jump });
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use rand::{RngExt, SeedableRng};
    use rand_chacha::ChaCha8Rng;

    use super::*;

    /// Blobs of random brightness, and the same moved to the left by `shift(x, y)` of the left image.
    fn pair(width: usize, height: usize, shift: impl Fn(usize, usize) -> usize) -> [Plane<u8>; 2] {
        let mut rng = ChaCha8Rng::seed_from_u64(1);
        let values = (0..width * height).map(|_| rng.random_range(0..=255));
        let left = Plane::from_values(width, height, values.collect()).unwrap();
        let mut right = Plane::filled(width, height, 0);
        for y in 0..height {
            for x in 0..width {
                if let Some(to) = x.checked_sub(shift(x, y)) {
                    right.row_mut(y)[to] = left.row(y)[x];
                }
            }
        }
        [left, right]
    }

    fn share(found: &Plane<f32>, is: impl Fn(f32) -> bool) -> f64 {
        let count = found.values().iter().filter(|d| is(**d)).count();
        count as f64 / found.values().len() as f64
    }

    #[test]
    fn a_moved_image_has_the_disparity_of_its_movement_in_every_size_of_range() {
        for (first, count, shift) in [(0, 20, 7), (0, 64, 31), (5, 100, 60), (-3, 200, 40)] {
            let [left, right] = pair(150, 70, |_, _| shift);
            let range = DisparityRange { first, count };
            let options = CorrelationOptions { range, ..Default::default() };
            let found = correlate(&left, &right, &options).unwrap();
            let right_ones = share(&found, |d| (d - shift as f32).abs() < 0.5);
            assert!(right_ones > 0.9 * (150.0 - shift as f64) / 150.0, "{count}: {right_ones}");
        }
    }

    #[test]
    fn a_swapped_pair_has_negative_disparities() {
        let [left, right] = pair(100, 40, |_, _| 6);
        let range = DisparityRange { first: -20, count: 32 };
        let options = CorrelationOptions { range, ..Default::default() };
        let found = correlate(&right, &left, &options).unwrap();
        assert!(share(&found, |d| (d + 6.0).abs() < 0.5) > 0.85);
    }

    #[test]
    fn the_result_does_not_depend_on_the_number_of_threads() {
        let [left, right] = pair(120, 200, |x, y| 5 + (x / 40 + y / 50) % 3);
        let by = |threads| {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
            let found = pool.install(|| correlate(&left, &right, &Default::default()));
            found.unwrap().values().iter().map(|d| d.to_bits()).collect::<Vec<_>>()
        };
        assert_eq!(by(1), by(3));
    }

    #[test]
    fn without_texture_nothing_is_matched() {
        let flat = Plane::filled(90, 60, 128);
        let found = correlate(&flat, &flat, &Default::default()).unwrap();
        assert!(found.values().iter().all(|d| d.is_nan()));
    }

    #[test]
    fn images_of_other_widths_are_matched_and_of_other_heights_are_refused() {
        let [left, right] = pair(120, 40, |_, _| 9);
        let narrow = (0..40).flat_map(|y| right.row(y)[..80].to_vec()).collect();
        let narrow = Plane::from_values(80, 40, narrow).unwrap();
        let found = correlate(&left, &narrow, &Default::default()).unwrap();
        assert!(share(&found, |d| (d - 9.0).abs() < 0.5) > 0.55);
        let low = Plane::filled(120, 39, 0);
        let refused = correlate(&left, &low, &Default::default()).unwrap_err();
        assert!(refused.to_string().contains("40 and 39 rows"));
    }

    #[test]
    fn ranges_and_penalties_that_make_no_sense_are_refused_in_one_line() {
        let [left, right] = pair(60, 20, |_, _| 3);
        let with = |first, count| CorrelationOptions {
            range: DisparityRange { first, count },
            ..Default::default()
        };
        let penalties = CorrelationOptions { jump_penalty: 61, ..Default::default() };
        let refused =
            [with(0, 2), with(0, 257), with(60, 64), with(-300, 64), with(i32::MAX, 64), penalties];
        for options in refused {
            let fault = correlate(&left, &right, &options).unwrap_err().to_string();
            assert!(fault.contains("expected") && !fault.contains('\n'));
        }
    }

    #[test]
    fn uniqueness_and_the_least_region_can_be_noticed() {
        let [left, mut right] = pair(100, 60, |_, _| 9);
        for y in 20..60 {
            right.row_mut(y).fill(90);
        }
        let found = |uniqueness, least_region| {
            let options = CorrelationOptions { uniqueness, least_region, ..Default::default() };
            share(&correlate(&left, &right, &options).unwrap(), f32::is_finite)
        };
        assert!(found(0.0, 0) > found(0.2, 0));
        assert!(found(0.0, 0) > found(0.0, 300));
    }
}
