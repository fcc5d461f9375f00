//! The camera matrix K.

use nalgebra::{Matrix3, Point2, Vector2};
use serde::{Deserialize, Serialize};

/// Focal lengths, principal point and skew of a pinhole camera, all in pixels.
///
/// Maps normalised coordinates (x, y) = (X/Z, Y/Z) to undistorted pixels:
/// u = f_x·x + s·y + c_x, v = f_y·y + c_y.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Intrinsics {
    /// Focal length along image rows, f_x > 0.
    pub fx_px: f64,
    /// Focal length along image columns, f_y > 0.
    pub fy_px: f64,
    /// Principal point, horizontal; 0 is the centre of the leftmost pixel.
    pub cx_px: f64,
    /// Principal point, vertical; 0 is the centre of the topmost pixel.
    pub cy_px: f64,
    /// Skew s; 0 for nearly every real sensor.
    pub skew_px: f64,
}

impl Intrinsics {
    /// K = \[f_x s c_x; 0 f_y c_y; 0 0 1\].
    pub fn matrix(&self) -> Matrix3<f64> {
        Matrix3::new(
            self.fx_px,
            self.skew_px,
            self.cx_px,
            0.0,
            self.fy_px,
            self.cy_px,
            0.0,
            0.0,
            1.0,
        )
    }

    /// K⁻¹.
    pub fn inverse_matrix(&self) -> Matrix3<f64> {
        let Self { fx_px, fy_px, cx_px, cy_px, skew_px } = *self;
        let skew = -skew_px / (fx_px * fy_px);
        Matrix3::new(
            1.0 / fx_px,
            skew,
            -cx_px / fx_px - skew * cy_px,
            0.0,
            1.0 / fy_px,
            -cy_px / fy_px,
            0.0,
            0.0,
            1.0,
        )
    }

    /// f = (f_x + f_y)/2: at depth z a metre across the line of sight is f/z pixels.
    pub fn focal_px(&self) -> f64 {
        0.5 * (self.fx_px + self.fy_px)
    }

    /// With focal lengths that are so many times as long, about the same principal point.
    #[must_use]
    pub fn zoomed(&self, factor: f64) -> Self {
        let Self { fx_px, fy_px, skew_px, .. } = self;
        Self { fx_px: fx_px * factor, fy_px: fy_px * factor, skew_px: skew_px * factor, ..*self }
    }

    /// The pixel of normalised coordinates.
    pub fn pixel(&self, normalized: &Vector2<f64>) -> Point2<f64> {
        Point2::new(
            self.fx_px * normalized.x + self.skew_px * normalized.y + self.cx_px,
            self.fy_px * normalized.y + self.cy_px,
        )
    }

    /// Normalised coordinates of a pixel: the inverse of [`Intrinsics::pixel`].
    pub fn normalized(&self, pixel: &Point2<f64>) -> Vector2<f64> {
        let y = (pixel.y - self.cy_px) / self.fy_px;
        let x = (pixel.x - self.cx_px - self.skew_px * y) / self.fx_px;
        Vector2::new(x, y)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use nalgebra::Vector3;

    const SKEWED: Intrinsics =
        Intrinsics { fx_px: 800.0, fy_px: 810.0, cx_px: 321.0, cy_px: 239.5, skew_px: 3.0 };

    #[test]
    fn the_pixel_is_that_of_the_matrix() {
        let by_matrix = SKEWED.matrix() * Vector3::new(0.3, -0.2, 1.0);
        let pixel = SKEWED.pixel(&Vector2::new(0.3, -0.2));
        approx::assert_relative_eq!(pixel.coords, by_matrix.xy(), epsilon = 1e-12);
    }

    #[test]
    fn normalised_coordinates_undo_the_pixel() {
        let normalized = Vector2::new(-0.41, 0.27);
        let back = SKEWED.normalized(&SKEWED.pixel(&normalized));
        approx::assert_relative_eq!(back, normalized, epsilon = 1e-14);
    }
}
