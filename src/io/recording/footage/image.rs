//! Pictures out of image files.

use std::io::Cursor;
use std::path::Path;

use ::image::{DynamicImage, ImageDecoder, ImageReader, Limits};

use super::FootageError;
use crate::image::Picture;

/// No camera of a laboratory has more columns or rows.
const MOST_PX: u32 = 32_768;
/// Bytes that a decoder may take.
const MOST_BYTES: u64 = 1 << 30;

/// Reads an image of any bit depth and colour type as RGB, turned as its metadata say; opacity is passed over.
pub(super) fn read(path: &Path) -> Result<Picture, FootageError> {
    let unreadable = |reason: String| FootageError::Image {
        path: path.into(),
        reason,
    };
    let bytes = std::fs::read(path).map_err(|e| unreadable(e.to_string()))?;
    let mut decoder = decoder(&bytes).map_err(unreadable)?;
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

fn decoder(bytes: &[u8]) -> Result<impl ImageDecoder + '_, String> {
    let mut reader = ImageReader::new(Cursor::new(bytes))
        .with_guessed_format()
        .map_err(|e| e.to_string())?;
    let mut limits = Limits::default();
    limits.max_image_width = Some(MOST_PX);
    limits.max_image_height = Some(MOST_PX);
    limits.max_alloc = Some(MOST_BYTES);
    reader.limits(limits);
    reader.into_decoder().map_err(|e| e.to_string())
}
