//! Coarser and finer pictures, and means over boxes.

use super::{Picture, Plane};

/// The mean colours of blocks of `factor` × `factor` pixels; a remainder at the right and the bottom is dropped.
pub fn shrink(picture: &Picture, factor: usize) -> Picture {
    let factor = factor.max(1);
    if factor == 1 {
        return picture.clone();
    }

    let (width, height) = (picture.width() / factor, picture.height() / factor);
    let half = (factor * factor / 2) as u32;
    let mut small = Picture::filled(width, height, [0; 3]);
    for y in 0..height {
        let mut sums = vec![[0_u32; 3]; width];
        for row in (0..factor).map(|dy| picture.row(y * factor + dy)) {
            for (sum, block) in sums.iter_mut().zip(row.chunks_exact(factor)) {
                for pixel in block {
                    for (s, value) in sum.iter_mut().zip(pixel) {
                        *s += u32::from(*value);
                    }
                }
            }
        }

        for (pixel, sum) in small.row_mut(y).iter_mut().zip(&sums) {
            // a mean of bytes is a byte
            *pixel = sum.map(|s| ((s + half) / (factor * factor) as u32) as u8);
        }
    }
    small
}

/// A plane that was shrunk by `factor`, interpolated at each of `width` × `height` pixels: bilinear, constant beyond the edge.
pub fn enlarge(small: &Plane<f32>, factor: usize, width: usize, height: usize) -> Plane<f32> {
    let factor = factor.max(1) as f32;
    // two neighbours, and how far between them
    let place = |i: usize, n: usize| {
        let at = ((i as f32 + 0.5) / factor - 0.5).clamp(0.0, n.saturating_sub(1) as f32);
        let low = (at as usize).min(n.saturating_sub(2));
        (low, (low + 1).min(n.saturating_sub(1)), at - low as f32)
    };

    let mut large = Plane::filled(width, height, 0.0);
    if small.values().is_empty() {
        return large;
    }

    let columns: Vec<_> = (0..width).map(|x| place(x, small.width())).collect();
    for y in 0..height {
        let (top, bottom, t) = place(y, small.height());
        let (top, bottom) = (small.row(top), small.row(bottom));
        for (value, (left, right, s)) in large.row_mut(y).iter_mut().zip(&columns) {
            let upper = top[*left] + s * (top[*right] - top[*left]);
            let lower = bottom[*left] + s * (bottom[*right] - bottom[*left]);
            *value = upper + t * (lower - upper);
        }
    }
    large
}

/// The mean of (2·reach + 1)² pixels around each pixel, of those that lie in the picture.
pub fn box_mean(plane: &Plane<f32>, reach: usize) -> Plane<f32> {
    let (width, height) = (plane.width(), plane.height());
    let mut across = Plane::filled(width, height, 0.0);
    for y in 0..height {
        running_mean(plane.row(y), reach, across.row_mut(y));
    }

    // the sums of the rows around, kept up to date from row to row
    let mut mean = Plane::filled(width, height, 0.0);
    let mut sums = vec![0.0_f64; width];
    let add = |y: usize, sign: f64, sums: &mut Vec<f64>| {
        for (sum, value) in sums.iter_mut().zip(across.row(y)) {
            *sum += sign * f64::from(*value);
        }
    };

    for y in 0..reach.min(height) {
        add(y, 1.0, &mut sums);
    }
    for y in 0..height {
        if y + reach < height {
            add(y + reach, 1.0, &mut sums);
        }
        if y > reach {
            add(y - reach - 1, -1.0, &mut sums);
        }

        let count = (y + reach + 1).min(height) - y.saturating_sub(reach);
        for (value, sum) in mean.row_mut(y).iter_mut().zip(&sums) {
            *value = (sum / count as f64) as f32;
        }
    }
    mean
}

fn running_mean(values: &[f32], reach: usize, means: &mut [f32]) {
    let mut sum: f64 = values.iter().take(reach).map(|v| f64::from(*v)).sum();
    for x in 0..values.len() {
        if let Some(value) = values.get(x + reach) {
            sum += f64::from(*value);
        }
        if x > reach {
            sum -= f64::from(values[x - reach - 1]);
        }
        let count = (x + reach + 1).min(values.len()) - x.saturating_sub(reach);
        means[x] = (sum / count as f64) as f32;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn blocks_become_their_means() {
        let values = (0..24_u8).map(|i| [i, 2 * i, 100]).collect();
        let picture = Picture::from_values(6, 4, values).unwrap();
        let small = shrink(&picture, 2);
        assert_eq!((small.width(), small.height()), (3, 2));
        // 0, 1, 6, 7
        assert_eq!(small.get(0, 0), Some([4, 7, 100]));
        assert_eq!(shrink(&picture, 1), picture);
    }

    #[test]
    fn a_slope_stays_a_slope_when_it_is_enlarged() {
        let small = Plane::from_values(4, 3, (0..12).map(|i| (i % 4) as f32).collect()).unwrap();
        let large = enlarge(&small, 2, 9, 6);
        assert_eq!(large.get(1, 2), Some(0.25));
        assert_eq!(large.get(4, 5), Some(1.75));
        assert_eq!(large.get(8, 0), Some(3.0), "beyond the last pixel");
        assert_eq!(enlarge(&Plane::filled(0, 0, 1.0), 2, 3, 3).get(1, 1), Some(0.0));
    }

    #[test]
    fn a_box_mean_is_the_mean_of_the_box_within_the_picture() {
        let plane =
            Plane::from_values(7, 5, (0..35).map(|i| ((i * i) % 11) as f32).collect()).unwrap();
        for reach in [0, 1, 2, 9] {
            let means = box_mean(&plane, reach);
            for (x, y) in [(0_usize, 0_usize), (3, 2), (6, 4), (1, 3)] {
                let (mut sum, mut count) = (0.0, 0.0);
                for v in y.saturating_sub(reach)..=y + reach {
                    for u in x.saturating_sub(reach)..=x + reach {
                        if let Some(value) = plane.get(u, v) {
                            sum += value;
                            count += 1.0;
                        }
                    }
                }
                approx::assert_relative_eq!(means.get(x, y).unwrap(), sum / count, epsilon = 1e-5);
            }
        }
    }
}
