//! Opening, closing and widening a mask with a disk.
//!
//! A pixel lies within r of a mask if in one of the rows y + j, |j| ≤ r, a pixel of the mask is at most √(r² − j²) columns aside. So
//! the distances along the rows are found once, and every row asks those about it.

use super::{Mask, Plane};

/// A mask with its gaps narrower than a disk of this radius filled.
pub fn closed(mask: &Mask, radius_px: u8) -> Mask {
    narrowed(&widened(mask, radius_px), radius_px)
}

/// A mask without its pieces narrower than a disk of this radius.
pub fn opened(mask: &Mask, radius_px: u8) -> Mask {
    widened(&narrowed(mask, radius_px), radius_px)
}

/// A mask, widened by this radius on all sides.
pub fn widened(mask: &Mask, radius_px: u8) -> Mask {
    let (width, height) = (mask.width(), mask.height());
    let mut aside = Plane::filled(width, height, u16::MAX);
    for y in 0..height {
        write_distances(mask.row(y), aside.row_mut(y));
    }

    let radius = usize::from(radius_px);
    let mut wider = Plane::filled(width, height, 0);
    for y in 0..height {
        let row = wider.row_mut(y);
        for other in y.saturating_sub(radius)..(y + radius + 1).min(height) {
            let half = (radius.pow(2) - y.abs_diff(other).pow(2)).isqrt() as u16;
            for (pixel, aside) in row.iter_mut().zip(aside.row(other)) {
                *pixel |= u8::from(*aside <= half);
            }
        }
    }
    Mask::from_ones(wider)
}

/// A mask without what lies within this radius of the background; beyond the image there is none.
fn narrowed(mask: &Mask, radius_px: u8) -> Mask {
    inverted(&widened(&inverted(mask), radius_px))
}

fn inverted(mask: &Mask) -> Mask {
    Mask::from_fn(mask.width(), mask.height(), |x, y| !mask.is_foreground(x, y))
}

/// How far each pixel of a row is from the nearest that is 1, px; [`u16::MAX`] without any.
fn write_distances(row: &[u8], distances: &mut [u16]) {
    let mut last = u16::MAX;
    for (distance, pixel) in distances.iter_mut().zip(row) {
        last = if *pixel == 1 { 0 } else { last.saturating_add(1) };
        *distance = last;
    }
    let mut next = u16::MAX;
    for distance in distances.iter_mut().rev() {
        next = next.saturating_add(1).min(*distance);
        *distance = next;
    }
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

    #[test]
    fn every_radius_is_the_disk_that_its_definition_says() {
        let spotted = |x: usize, y: usize| (x * 7 + y * 13).is_multiple_of(37) && x + y > 5;
        let mask = Mask::from_fn(23, 17, spotted);
        for radius in [1_u8, 2, 4, 30] {
            let is_near = |x: usize, y: usize| {
                let within = |(i, j): (usize, usize)| {
                    x.abs_diff(i).pow(2) + y.abs_diff(j).pow(2) <= usize::from(radius).pow(2)
                };
                let mut spots = (0..17).flat_map(|j| (0..23).map(move |i| (i, j)));
                spots.any(|(i, j)| spotted(i, j) && within((i, j)))
            };
            assert_eq!(widened(&mask, radius), Mask::from_fn(23, 17, is_near), "{radius}");
        }
        assert_eq!(area(&widened(&Mask::from_fn(23, 17, |_, _| false), 200)), 0);
    }
}
