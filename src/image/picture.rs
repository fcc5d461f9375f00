//! Colour pictures.

use super::Plane;

/// Red, green and blue of each pixel, full range.
pub type Picture = Plane<[u8; 3]>;

/// Brightness Y = 0.299 R + 0.587 G + 0.114 B of each pixel, rounded (ITU-R BT.601).
pub fn luma(picture: &Picture) -> Plane<u8> {
    picture.map(|[r, g, b]| {
        let sum = 19_595 * u32::from(r) + 38_470 * u32::from(g) + 7_471 * u32::from(b);
        // the weights add up to 2^16: at most 255
        ((sum + (1 << 15)) >> 16) as u8
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn grey_stays_as_it_is_and_green_is_brightest() {
        let picture = |rgb| Picture::filled(1, 1, rgb);
        for value in [0, 1, 127, 255] {
            assert_eq!(luma(&picture([value; 3])).values(), [value]);
        }
        assert_eq!(luma(&picture([255, 0, 0])).values(), [76]);
        assert_eq!(luma(&picture([0, 255, 0])).values(), [150]);
        assert_eq!(luma(&picture([0, 0, 255])).values(), [29]);
    }
}
