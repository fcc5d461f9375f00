//! Pictures out of image files.

use std::path::Path;

use ::image::{DynamicImage, ImageDecoder};

use super::FootageError;
use crate::image::Picture;
use crate::io::input::{self, MOST_OF_AN_IMAGE};
use crate::io::recording::image_decoder::decoder;

/// Reads an image of any bit depth and colour type as RGB, turned as its metadata state; opacity is ignored.
pub(super) fn read(path: &Path) -> Result<Picture, FootageError> {
    let unreadable = |reason: String| FootageError::Image { path: path.into(), reason };
    let bytes = input::read(path, MOST_OF_AN_IMAGE).map_err(|e| unreadable(e.to_string()))?;
    let mut decoder = decoder(&bytes).map_err(|e| unreadable(e.to_string()))?;
    let turn = decoder.orientation();
    let mut picture = DynamicImage::from_decoder(decoder).map_err(|e| unreadable(e.to_string()))?;
    if let Ok(turn) = turn {
        picture.apply_orientation(turn);
    }
    let rgb = picture.into_rgb8();
    let (width, height) = (rgb.width() as usize, rgb.height() as usize);
    let raw = rgb.into_raw();
    let (pixels, _) = raw.as_chunks::<3>();
    // a decoder gives as many values as it promised pixels
    let picture = Picture::from_values(width, height, pixels.to_vec());
    Ok(picture.unwrap_or_else(|| Picture::filled(0, 0, [0; 3])))
}
