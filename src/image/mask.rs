//! Foreground or not, for each pixel.

use super::Plane;

/// Which pixels of an image show the person.
#[derive(Clone, Debug, PartialEq)]
pub struct Mask {
    /// 1 is foreground, 0 background; there are no other values.
    pixels: Plane<u8>,
}

impl Mask {
    /// The pixels of `luma` that are brighter than `threshold`.
    pub fn brighter_than<T: Copy + PartialOrd>(luma: &Plane<T>, threshold: T) -> Self {
        let mut pixels = Plane::filled(luma.width(), luma.height(), 0);
        for y in 0..luma.height() {
            for (pixel, value) in pixels.row_mut(y).iter_mut().zip(luma.row(y)) {
                *pixel = u8::from(*value > threshold);
            }
        }
        Self { pixels }
    }

    /// The pixels (x, y) for which `is_foreground` holds.
    pub fn from_fn(
        width: usize,
        height: usize,
        is_foreground: impl Fn(usize, usize) -> bool,
    ) -> Self {
        let mut pixels = Plane::filled(width, height, 0);
        for y in 0..height {
            for (x, pixel) in pixels.row_mut(y).iter_mut().enumerate() {
                *pixel = u8::from(is_foreground(x, y));
            }
        }
        Self { pixels }
    }

    /// The pixels that hold 1; all others must hold 0.
    pub(super) fn from_ones(pixels: Plane<u8>) -> Self {
        Self { pixels }
    }

    /// Columns.
    pub fn width(&self) -> usize {
        self.pixels.width()
    }

    /// Rows.
    pub fn height(&self) -> usize {
        self.pixels.height()
    }

    /// Whether pixel (x, y) is foreground; false outside the image.
    pub fn is_foreground(&self, x: usize, y: usize) -> bool {
        self.pixels.get(x, y) == Some(1)
    }

    /// Row `y` as ones and zeros; empty if there is no such row.
    pub fn row(&self, y: usize) -> &[u8] {
        self.pixels.row(y)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_threshold_itself_is_background() {
        let luma = Plane::from_values(3, 1, vec![126u8, 127, 128]).unwrap();
        let mask = Mask::brighter_than(&luma, 127);
        assert_eq!(mask.row(0), &[0, 0, 1]);
        assert!(mask.is_foreground(2, 0) && !mask.is_foreground(3, 0));
    }
}
