//! The census transform: a signature of a pixel's neighbourhood that does not depend on contrast and brightness.

use crate::image::Plane;

/// The neighbours that are compared with the middle, (dx, dy): all of 5 × 5.
const NEIGHBOURS: [(isize, isize); 24] = neighbours();
/// Distance of the farthest neighbours, px.
const REACH: usize = 2;
/// Largest distance of two signatures.
pub(super) const BITS: u8 = NEIGHBOURS.len() as u8;

/// One bit for each neighbour of each pixel: whether it is brighter than the pixel.
///
/// The 24 bits lie in three planes of bytes and not in one of words: bytes are counted four times as fast.
#[derive(Debug)]
pub(super) struct Census {
    planes: [Plane<u8>; 3],
}

impl Census {
    /// The signatures of an image; its outermost pixels are repeated beyond its edge.
    ///
    /// # Source
    /// Zabih & Woodfill 1994, *Non-parametric local transforms for computing visual correspondence*.
    pub(super) fn new(image: &Plane<u8>) -> Self {
        let blank = Plane::filled(image.width(), image.height(), 0);
        let mut planes = [blank.clone(), blank.clone(), blank];
        for y in 0..image.height() {
            let rows = padded_rows(image, y);
            let centre = image.row(y);
            for (bit, (dx, dy)) in NEIGHBOURS.iter().enumerate() {
                let from = REACH.saturating_add_signed(*dx);
                let neighbours = &rows[REACH.saturating_add_signed(*dy)][from..];
                let signature = planes[bit / 8].row_mut(y);
                set_bits(signature, neighbours, centre, 1 << (bit % 8));
            }
        }
        Self { planes }
    }

    /// The three bytes of each pixel of row `y`.
    pub(super) fn row(&self, y: usize) -> [&[u8]; 3] {
        self.planes.each_ref().map(|plane| plane.row(y))
    }
}

fn set_bits(signature: &mut [u8], neighbours: &[u8], centre: &[u8], bit: u8) {
    for ((signature, neighbour), centre) in signature.iter_mut().zip(neighbours).zip(centre) {
        *signature |= if neighbour > centre { bit } else { 0 };
    }
}

/// The rows y − 2 … y + 2, each with two more pixels at both ends.
fn padded_rows(image: &Plane<u8>, y: usize) -> [Vec<u8>; 2 * REACH + 1] {
    std::array::from_fn(|i| {
        let row = image.row((y + i).saturating_sub(REACH).min(image.height() - 1));
        let end = |pixel: Option<&u8>| [pixel.copied().unwrap_or(0); REACH];
        [&end(row.first())[..], row, &end(row.last())[..]].concat()
    })
}

const fn neighbours() -> [(isize, isize); 24] {
    let mut all = [(0, 0); 24];
    let mut bit = 0;
    let mut cell = 0;
    while cell < 25 {
        if cell != 12 {
            all[bit] = (cell % 5 - 2, cell / 5 - 2);
            bit += 1;
        }
        cell += 1;
    }
    all
}

#[cfg(test)]
mod tests {
    use super::*;

    fn signature(image: &Plane<u8>, x: usize, y: usize) -> u32 {
        let [a, b, c] = Census::new(image).row(y).map(|row| u32::from(row[x]));
        a | b << 8 | c << 16
    }

    #[test]
    fn each_neighbour_has_its_bit() {
        for (bit, (dx, dy)) in NEIGHBOURS.iter().enumerate() {
            let mut image = Plane::filled(7, 7, 10u8);
            let (x, y) = (3usize.saturating_add_signed(*dx), 3usize.saturating_add_signed(*dy));
            image.row_mut(y)[x] = 11;
            assert_eq!(signature(&image, 3, 3), 1 << bit);
        }
    }

    #[test]
    fn contrast_and_brightness_change_nothing() {
        let value = |i: usize| (i * i * 7 % 60) as u8;
        let image = Plane::from_values(8, 8, (0..64).map(value).collect()).unwrap();
        let other = (0..64).map(|i| 3 * value(i) + 20).collect();
        let other = Plane::from_values(8, 8, other).unwrap();
        for (x, y) in [(0, 0), (3, 4), (7, 7)] {
            assert_eq!(signature(&image, x, y), signature(&other, x, y));
        }
    }
}
