//! A decoder of image files, within limits.

use std::io::Cursor;

use image::{ImageDecoder, ImageReader, ImageResult, Limits};

/// No camera of a laboratory has more columns or rows.
pub(super) const MOST_PX: u32 = 32_768;
/// Bytes that a decoder may take.
const MOST_BYTES: u64 = 1 << 30;

/// The decoder of an image file; the bytes show its format.
pub(super) fn decoder(bytes: &[u8]) -> ImageResult<impl ImageDecoder + '_> {
    let mut limits = Limits::default();
    limits.max_image_width = Some(MOST_PX);
    limits.max_image_height = Some(MOST_PX);
    limits.max_alloc = Some(MOST_BYTES);

    let mut reader = ImageReader::new(Cursor::new(bytes)).with_guessed_format()?;
    reader.limits(limits);
    reader.into_decoder()
}
