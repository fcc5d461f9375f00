//! Pictures as JPEG.

use std::io;

use ::image::codecs::jpeg::JpegEncoder;
use ::image::{ExtendedColorType, ImageEncoder};

use crate::image::Picture;

/// A picture as JPEG of a quality from 1 to 100.
///
/// # Errors
/// A picture without pixels.
pub fn encode(picture: &Picture, quality: u8) -> io::Result<Vec<u8>> {
    let mut file = Vec::new();
    let (width, height) = (picture.width() as u32, picture.height() as u32);
    let pixels = picture.values().as_flattened();
    JpegEncoder::new_with_quality(&mut file, quality)
        .write_image(pixels, width, height, ExtendedColorType::Rgb8)
        .map_err(io::Error::other)?;
    Ok(file)
}
