//! Pictures as PNG.

use std::io;

use ::image::codecs::png::{CompressionType, FilterType, PngEncoder};
use ::image::{ExtendedColorType, ImageEncoder};

use crate::image::{Mask, Picture};

/// What a file is to be.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(in crate::io) enum Effort {
    /// Written at once.
    Quick,
    /// As small as can be, to be kept.
    Small,
}

/// A picture of these bytes, row by row.
pub(in crate::io) fn encode(
    bytes: &[u8],
    width: usize,
    height: usize,
    colour: ExtendedColorType,
    effort: Effort,
) -> io::Result<Vec<u8>> {
    let (compression, filter) = match effort {
        Effort::Quick => (CompressionType::Fast, FilterType::Adaptive),
        Effort::Small => (CompressionType::Best, FilterType::Up),
    };
    let mut file = Vec::new();
    PngEncoder::new_with_quality(&mut file, compression, filter)
        .write_image(bytes, width as u32, height as u32, colour)
        .map_err(io::Error::other)?;
    Ok(file)
}

/// A mask: 8 bits, grey, 0 and 255.
pub(in crate::io) fn encode_mask(mask: &Mask, effort: Effort) -> io::Result<Vec<u8>> {
    let rows = (0..mask.height()).flat_map(|y| mask.row(y));
    let pixels: Vec<u8> = rows.map(|v| 255 * v).collect();
    encode(&pixels, mask.width(), mask.height(), ExtendedColorType::L8, effort)
}

/// A picture in colours: 8 bits each.
pub(in crate::io) fn encode_picture(picture: &Picture, effort: Effort) -> io::Result<Vec<u8>> {
    let bytes = picture.values().as_flattened();
    let (width, height) = (picture.width(), picture.height());
    encode(bytes, width, height, ExtendedColorType::Rgb8, effort)
}
