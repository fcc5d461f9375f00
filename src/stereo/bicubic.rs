//! An image between its pixels.

use crate::image::Plane;

/// Brightness at a place and its slopes.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Sample {
    pub(super) value: f32,
    /// ∂/∂x and ∂/∂y.
    pub(super) slope: [f32; 2],
}

/// The image at (x, y), by the cubic of Catmull and Rom; `None` nearer than a pixel to the image's edge.
///
/// Not bilinear: that smooths the more, the farther from the pixels it is, and so draws matches to pixel centres.
///
/// # Source
/// Keys 1981, *Cubic convolution interpolation for digital image processing*, a = −½.
// always: where only the value is asked for, the slopes are then not computed
#[inline(always)]
pub(super) fn sample(image: &Plane<f32>, x: f64, y: f64) -> Option<Sample> {
    let inside = x >= 1.0 && y >= 1.0;
    // NaN is not inside
    if !inside {
        return None;
    }
    let (column, row) = (x as usize, y as usize);
    let (wx, dx) = weights((x - column as f64) as f32);
    let (wy, dy) = weights((y - row as f64) as f32);

    let mut sample = Sample { value: 0.0, slope: [0.0; 2] };
    for i in 0..4 {
        let taps = image.row(row + i - 1).get(column - 1..)?.first_chunk::<4>()?;
        let along =
            |w: &[f32; 4]| w[0] * taps[0] + w[1] * taps[1] + w[2] * taps[2] + w[3] * taps[3];
        let value = along(&wx);
        sample.value += wy[i] * value;
        sample.slope[0] += wy[i] * along(&dx);
        sample.slope[1] += dy[i] * value;
    }
    Some(sample)
}

/// The weights of four pixels at `t` between the second and the third, and their derivatives.
#[inline]
fn weights(t: f32) -> ([f32; 4], [f32; 4]) {
    let (t2, t3) = (t * t, t * t * t);
    (
        [
            0.5 * (-t3 + 2.0 * t2 - t),
            0.5 * (3.0 * t3 - 5.0 * t2 + 2.0),
            0.5 * (-3.0 * t3 + 4.0 * t2 + t),
            0.5 * (t3 - t2),
        ],
        [
            0.5 * (-3.0 * t2 + 4.0 * t - 1.0),
            0.5 * (9.0 * t2 - 10.0 * t),
            0.5 * (-9.0 * t2 + 8.0 * t + 1.0),
            0.5 * (3.0 * t2 - 2.0 * t),
        ],
    )
}

#[cfg(test)]
mod tests {
    use super::*;

    fn image(f: impl Fn(f32, f32) -> f32) -> Plane<f32> {
        let values = (0..80).map(|i| f((i % 10) as f32, (i / 10) as f32));
        Plane::from_values(10, 8, values.collect()).unwrap()
    }

    #[test]
    fn a_parabola_and_its_slopes_are_exact() {
        let parabola = image(|x, y| 3.0 + x * x - 2.0 * x * y + 0.5 * y * y);
        let (x, y) = (4.3, 3.8);
        let found = sample(&parabola, x, y).unwrap();
        let expected = [3.0 + x * x - 2.0 * x * y + 0.5 * y * y, 2.0 * x - 2.0 * y, y - 2.0 * x];
        let found = [found.value, found.slope[0], found.slope[1]];
        for (found, expected) in found.into_iter().zip(expected) {
            assert!((f64::from(found) - expected).abs() < 1e-4);
        }
    }

    #[test]
    fn outside_there_is_nothing() {
        let image = image(|x, _| x);
        for (x, y) in
            [(0.9, 4.0), (8.0, 4.0), (4.0, 6.0), (f64::NAN, 4.0), (4.0, -1e300), (1e300, 1.0)]
        {
            assert_eq!(sample(&image, x, y), None);
        }
        assert!((sample(&image, 4.0, 4.0).unwrap().value - 4.0).abs() < 1e-5);
    }
}
