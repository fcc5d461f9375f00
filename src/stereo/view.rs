//! The image of a camera without its lens.

use nalgebra::Point2;
use rayon::prelude::*;

use super::bicubic::sample;
use crate::camera::{Camera, Distortion};
use crate::image::Plane;

/// An image of an ideal camera: x̃ = K·\[R|t\]·X̃ holds in it.
#[derive(Debug, Clone, PartialEq)]
pub struct StereoView {
    /// The camera, without distortion.
    pub camera: Camera,
    /// Brightness; NaN where the recorded image shows nothing.
    pub image: Plane<f32>,
}

/// An image whose size is not that of its camera.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[error(
    "camera {camera}: expected an image of {}x{} px, found {}x{}",
    expected[0], expected[1], found[0], found[1]
)]
pub struct StereoViewError {
    camera: String,
    expected: [usize; 2],
    found: [usize; 2],
}

impl StereoView {
    /// The recorded image as the camera without its lens would show it, pixel for pixel.
    ///
    /// # Errors
    /// [`StereoViewError`] for an image of another size than the camera's.
    pub fn undistorted(camera: &Camera, recorded: &Plane<u8>) -> Result<Self, StereoViewError> {
        let expected = [camera.width_px as usize, camera.height_px as usize];
        let found = [recorded.width(), recorded.height()];
        if expected != found {
            return Err(StereoViewError { camera: camera.name.clone(), expected, found });
        }

        let recorded = recorded.map(f32::from);
        let ideal = Camera { distortion: Distortion::None, ..camera.clone() };
        let (width, height) = (recorded.width(), recorded.height());
        let image = match camera.distortion {
            Distortion::None => recorded,
            _ => resampled(&recorded, width, height, |pixel| Some(camera.distort(&pixel))),
        };
        Ok(Self { camera: ideal, image })
    }
}

/// An image whose pixel p shows the place `source_from_pixel(p)` of `source`; NaN where there is none.
pub(super) fn resampled(
    source: &Plane<f32>,
    width: usize,
    height: usize,
    source_from_pixel: impl Fn(Point2<f64>) -> Option<Point2<f64>> + Sync,
) -> Plane<f32> {
    let mut values = vec![f32::NAN; width * height];
    let rows = values.par_chunks_mut(width.max(1)).enumerate();
    rows.for_each(|(y, row)| {
        for (x, value) in row.iter_mut().enumerate() {
            let from = source_from_pixel(Point2::new(x as f64, y as f64));
            if let Some(found) = from.and_then(|p| sample(source, p.x, p.y)) {
                *value = found.value.clamp(0.0, 255.0);
            }
        }
    });
    Plane::from_values(width, height, values).unwrap_or_else(|| Plane::filled(0, 0, 0.0))
}
