//! Opening, closing and widening a mask with a disk.

use ::image::GrayImage;
use imageproc::distance_transform::Norm;
use imageproc::morphology::{close, dilate, open};

use super::{Mask, Plane};

/// A mask with its gaps narrower than a disk of this radius filled.
pub fn closed(mask: &Mask, radius_px: u8) -> Mask {
    through(mask, |grey| close(grey, Norm::L2, radius_px))
}

/// A mask without its pieces narrower than a disk of this radius.
pub fn opened(mask: &Mask, radius_px: u8) -> Mask {
    through(mask, |grey| open(grey, Norm::L2, radius_px))
}

/// A mask, widened by this radius on all sides.
pub fn widened(mask: &Mask, radius_px: u8) -> Mask {
    through(mask, |grey| dilate(grey, Norm::L2, radius_px))
}

fn through(mask: &Mask, operation: impl Fn(&GrayImage) -> GrayImage) -> Mask {
    let (width, height) = (mask.width(), mask.height());
    let values = (0..height).flat_map(|y| mask.row(y)).map(|v| 255 * v);
    let changed = GrayImage::from_raw(width as u32, height as u32, values.collect())
        .map(|grey| operation(&grey).into_raw())
        .and_then(|values| Plane::from_values(width, height, values));
    // a mask has as many values as pixels
    changed.map_or_else(|| mask.clone(), |plane| Mask::brighter_than(&plane, 127))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn area(mask: &Mask) -> usize {
        (0..mask.height()).flat_map(|y| mask.row(y)).filter(|v| **v == 1).count()
    }

    #[test]
    fn closing_fills_gaps_and_opening_removes_specks() {
        let striped = Mask::from_fn(30, 30, |x, y| {
            x % 3 != 0 && (8..22).contains(&y) && (8..22).contains(&x)
        });
        assert!(closed(&striped, 2).is_foreground(15, 15));
        let speck = Mask::from_fn(30, 30, |x, y| (x == 3 && y == 3) || (x > 10 && y > 10));
        let clean = opened(&speck, 2);
        assert!(!clean.is_foreground(3, 3) && clean.is_foreground(20, 20));
    }

    #[test]
    fn a_widened_pixel_is_a_disk() {
        let pixel = Mask::from_fn(30, 30, |x, y| x == 15 && y == 15);
        assert_eq!(area(&widened(&pixel, 3)), 29);
        assert_eq!(area(&widened(&pixel, 0)), 1);
    }
}
