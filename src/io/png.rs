//! Pictures as PNG.

use ::image::codecs::png::{CompressionType, FilterType, PngEncoder};
use ::image::{ExtendedColorType, ImageEncoder, ImageError};

use crate::image::Mask;

/// What a file is to be.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Effort {
    /// Written at once.
    Quick,
    /// As small as can be, to be kept.
    Small,
}

/// A picture of these bytes, row by row.
pub(super) fn encode(
    bytes: &[u8],
    (width, height): (usize, usize),
    colour: ExtendedColorType,
    effort: Effort,
) -> Result<Vec<u8>, ImageError> {
    let (compression, filter) = match effort {
        Effort::Quick => (CompressionType::Fast, FilterType::Adaptive),
        Effort::Small => (CompressionType::Best, FilterType::Up),
    };
    let mut file = Vec::new();
    PngEncoder::new_with_quality(&mut file, compression, filter).write_image(
        bytes,
        width as u32,
        height as u32,
        colour,
    )?;
    Ok(file)
}

/// A mask: 8 bits, grey, 0 and 255.
pub(super) fn of_mask(mask: &Mask, effort: Effort) -> Result<Vec<u8>, ImageError> {
    let rows = (0..mask.height()).flat_map(|y| mask.row(y));
    let pixels: Vec<u8> = rows.map(|v| 255 * v).collect();
    let size = (mask.width(), mask.height());
    encode(&pixels, size, ExtendedColorType::L8, effort)
}
