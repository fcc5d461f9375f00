//! How many rows the pictures of two cameras side by side lie apart that should show a point in the same row.
//!
//! In a rectified pair a point is in row v of both pictures. If one camera was turned by δ about its horizontal axis after the calibration, it
//! is in row v + d, d ≈ f δ, of the other, and correlation finds fewer depths the larger d is. So the second picture is moved by d rows, and d is
//! where most pixels have a depth.

use rayon::prelude::*;

use super::correlation::{CorrelationOptions, correlate};
use super::rectify::{bytes, rectify};
use super::{DepthError, StereoView};
use crate::image::Plane;

/// Pictures are moved by at most so many rows.
pub const MOST_ROWS: i32 = 12;

/// How many pixels of a pair have a depth where the second picture is moved by d rows, d = −[`MOST_ROWS`] … [`MOST_ROWS`].
///
/// # Errors
/// [`DepthError`] for cameras that do not stand side by side.
pub fn known_by_rows(first: &StereoView, second: &StereoView) -> Result<Vec<usize>, DepthError> {
    let pair = rectify(first, second)?;
    let options = CorrelationOptions { range: pair.range(None), ..CorrelationOptions::default() };
    let (left, right) = (bytes(&pair.left.image), bytes(&pair.right.image));

    let known = (-MOST_ROWS..=MOST_ROWS).into_par_iter().map(|rows| {
        let disparities = correlate(&left, &moved(&right, rows), &options)?;
        Ok(disparities.values().iter().filter(|d| d.is_finite()).count())
    });
    known.collect()
}

/// A picture of which row v is row v + `rows` of another; black where that has none.
fn moved(picture: &Plane<u8>, rows: i32) -> Plane<u8> {
    let mut moved = Plane::filled(picture.width(), picture.height(), 0);
    for y in 0..picture.height() {
        let from = y as i64 + i64::from(rows);
        if (0..picture.height() as i64).contains(&from) {
            moved.row_mut(y).copy_from_slice(picture.row(from as usize));
        }
    }
    moved
}

#[cfg(test)]
mod tests {
    use rand::{RngExt, SeedableRng};
    use rand_chacha::ChaCha8Rng;

    use super::*;
    use crate::camera::{Camera, Distortion, Intrinsics};
    use crate::math::Rigid3;

    /// Two pictures of a wall of blobs, the second so many rows lower.
    fn pair(lower: usize) -> [StereoView; 2] {
        let (width, height, disparity) = (120, 80, 9);
        let mut rng = ChaCha8Rng::seed_from_u64(3);
        let mut blobs = Plane::filled(width + disparity, height + lower, 0.0_f32);
        for y in 0..blobs.height() {
            blobs.row_mut(y).fill_with(|| rng.random_range(0.0..255.0));
        }
        let view = |name: &str, x_m: f64, corner: [usize; 2]| {
            let pixel = |i: usize| blobs.get(i % width + corner[0], i / width + corner[1]);
            let values = (0..width * height).filter_map(pixel).collect();
            let intrinsics =
                Intrinsics { fx_px: 100.0, fy_px: 100.0, cx_px: 59.5, cy_px: 39.5, skew_px: 0.0 };
            StereoView {
                camera: Camera {
                    name: name.into(),
                    width_px: width as u32,
                    height_px: height as u32,
                    intrinsics,
                    distortion: Distortion::None,
                    camera_from_world: Rigid3::translation(-x_m, 0.0, 0.0),
                },
                image: Plane::from_values(width, height, values).unwrap(),
            }
        };
        [view("left", 0.0, [0, lower]), view("right", 0.2, [disparity, 0])]
    }

    #[test]
    fn the_second_picture_lies_as_many_rows_lower_as_it_was_moved() {
        for lower in [0, 1, 4] {
            let [first, second] = pair(lower);
            let known = known_by_rows(&first, &second).unwrap();
            let rows = (-MOST_ROWS..=MOST_ROWS).zip(&known).max_by_key(|(_, n)| **n).unwrap().0;
            assert_eq!(rows, lower as i32, "{known:?}");
        }
    }
}
