//! A picture to draw smooth lines in.

use nalgebra::Point2;

use crate::image::{Mask, Plane};

/// Red, green, blue.
pub type Rgb = [u8; 3];

/// What a line is drawn with.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Pen {
    /// Its colour.
    pub color: Rgb,
    /// 0 invisible, 1 covering.
    pub opacity: f32,
    /// Width of the line, px.
    pub width_px: f64,
}

/// A picture. Pixel (0, 0) is the centre of its top-left pixel.
#[derive(Debug, Clone, PartialEq)]
pub struct Canvas {
    pixels: Plane<Rgb>,
}

impl Canvas {
    /// A mask in two colours.
    pub fn from_mask(mask: &Mask, background: Rgb, foreground: Rgb) -> Self {
        let mut pixels = Plane::filled(mask.width(), mask.height(), background);
        for y in 0..mask.height() {
            for (pixel, value) in pixels.row_mut(y).iter_mut().zip(mask.row(y)) {
                if *value > 0 {
                    *pixel = foreground;
                }
            }
        }
        Self { pixels }
    }

    /// A picture as it is.
    pub fn from_pixels(pixels: Plane<Rgb>) -> Self {
        Self { pixels }
    }

    /// The picture.
    pub fn pixels(&self) -> &Plane<Rgb> {
        &self.pixels
    }

    /// Draws segments in one stroke: where they touch or cross, the pen covers no more than once.
    ///
    /// A pixel is covered by ½ + width/2 − its distance from the nearest segment, between 0 and 1. A segment from a
    /// point to itself is a dot.
    pub fn draw(&mut self, segments: &[[Point2<f64>; 2]], pen: Pen) {
        let (width, height) = (self.pixels.width(), self.pixels.height());
        let mut covered = Plane::filled(width, height, 0.0f32);
        for segment in segments {
            cover(&mut covered, segment, 0.5 * pen.width_px);
        }

        for y in 0..height {
            for (pixel, covered) in self.pixels.row_mut(y).iter_mut().zip(covered.row(y)) {
                if *covered > 0.0 {
                    *pixel = mixed(*pixel, pen.color, pen.opacity * covered);
                }
            }
        }
    }
}

/// Raises the coverage of the pixels near a segment; those outside the picture and segments that are not finite are left out.
fn cover(covered: &mut Plane<f32>, segment: &[Point2<f64>; 2], half_width: f64) {
    let [a, b] = segment;
    let reach = half_width + 0.5;
    let (low, high) = (a.inf(b), a.sup(b));
    if !(low.coords + high.coords).iter().all(|v| v.is_finite()) {
        return;
    }

    let range = |low: f64, high: f64, size: usize| {
        let first = (low - reach).ceil().max(0.0);
        let end = ((high + reach).floor() + 1.0).clamp(0.0, size as f64);
        first as usize..end as usize
    };
    let columns = range(low.x, high.x, covered.width());

    let along = b - a;
    let squared_length = along.norm_squared().max(f64::MIN_POSITIVE);
    for y in range(low.y, high.y, covered.height()) {
        let row = covered.row_mut(y);
        for x in columns.clone() {
            let to = Point2::new(x as f64, y as f64) - a;
            let fraction = (to.dot(&along) / squared_length).clamp(0.0, 1.0);
            let distance = (to - along * fraction).norm();
            let coverage = (reach - distance).clamp(0.0, 1.0) as f32;
            row[x] = row[x].max(coverage);
        }
    }
}

fn mixed(under: Rgb, over: Rgb, share: f32) -> Rgb {
    std::array::from_fn(|i| {
        let (under, over) = (f32::from(under[i]), f32::from(over[i]));
        (under + share.clamp(0.0, 1.0) * (over - under)).round() as u8
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    const PEN: Pen = Pen { color: [255, 255, 255], opacity: 1.0, width_px: 2.0 };

    fn black() -> Canvas {
        Canvas::from_mask(&Mask::from_fn(12, 9, |_, _| false), [0; 3], [9; 3])
    }

    fn value(canvas: &Canvas, x: usize, y: usize) -> u8 {
        canvas.pixels().get(x, y).unwrap()[0]
    }

    #[test]
    fn a_line_covers_its_width_and_fades_over_one_pixel() {
        let mut canvas = black();
        canvas.draw(&[[Point2::new(2.0, 4.0), Point2::new(9.0, 4.0)]], PEN);
        let column: Vec<u8> = (2..7).map(|y| value(&canvas, 5, y)).collect();
        assert_eq!(column, [0, 128, 255, 128, 0]);
        assert_eq!((value(&canvas, 0, 4), value(&canvas, 11, 4)), (0, 0));
    }

    #[test]
    fn crossing_segments_of_one_stroke_cover_once() {
        let half = Pen { opacity: 0.5, ..PEN };
        let (a, b) = (Point2::new(2.0, 4.0), Point2::new(9.0, 4.0));
        let (mut once, mut twice) = (black(), black());
        once.draw(&[[a, b]], half);
        twice.draw(&[[a, b], [a, b]], half);
        assert_eq!(once, twice);
        twice.draw(&[[a, b]], half);
        assert_ne!(once, twice);
    }

    #[test]
    fn what_lies_outside_or_nowhere_changes_nothing() {
        let mut canvas = black();
        let nowhere = Point2::new(f64::NAN, 3.0);
        let far = Point2::new(-1e9, -1e9);
        canvas.draw(&[[nowhere, far], [far, far]], PEN);
        canvas.draw(&[[Point2::new(1e12, 4.0), Point2::new(1e12 + 1.0, 4.0)]], PEN);
        assert_eq!(canvas, black());
    }
}
