//! One mask, from its file: of one person, or with a value for each.

use std::io;
use std::path::Path;

use image::{DynamicImage, ImageDecoder, ImageError, ImageFormat};

use super::image_decoder::{MOST_PX, decoder};
use crate::image::{Mask, Plane};
use crate::io::input::{self, MOST_OF_AN_IMAGE};

/// A picture with nothing brighter than this fraction of its range has a value for each person, and 0 for nobody.
const LABEL_FRACTION: f64 = 0.125;

/// Why a mask could not be used.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum MaskFault {
    /// The file cannot be read.
    #[error("the mask cannot be read: {0}")]
    Unreadable(#[source] io::Error),
    /// The file is no image, or a broken one.
    #[error("the mask cannot be decoded: {0}")]
    Undecodable(#[source] ImageError),
    /// Larger than any camera's image.
    #[error("the mask is larger than {MOST_PX} × {MOST_PX} px: {0}")]
    TooLarge(#[source] ImageError),
    /// Another size than the camera was calibrated for.
    #[error(
        "the mask is {} × {} px, expected {} × {} px as calibrated",
        found[0], found[1], expected[0], expected[1]
    )]
    Size {
        /// Width and height of the calibration.
        expected: [u32; 2],
        /// Width and height of the mask.
        found: [u32; 2],
    },
    /// All values are small, and some are zero: a value for each person, which a JPEG file does not keep.
    #[error(
        "the mask's values are 0 to {brightest} of {range}: a value for each person needs a file without loss (PNG), and white on black a foreground brighter than {}",
        range / 2
    )]
    LossyLabels {
        /// Largest value.
        brightest: u32,
        /// Largest value possible.
        range: u32,
    },
}

/// Width and height that the header of an image states.
pub(super) fn size_of(path: &Path) -> Result<[u32; 2], MaskFault> {
    let bytes = input::read(path, MOST_OF_AN_IMAGE).map_err(MaskFault::Unreadable)?;
    let (width, height) = decoder(&bytes).map_err(fault)?.dimensions();
    Ok([width, height])
}

/// What a mask's file holds.
pub(super) enum Painted {
    /// The person, or all people, white.
    White(Mask),
    /// A value for each person, 0 for nobody.
    Labels(Plane<u16>),
}

impl Painted {
    /// Everybody.
    pub(super) fn everybody(self) -> Mask {
        match self {
            Self::White(mask) => mask,
            Self::Labels(labels) => Mask::brighter_than(&labels, 0),
        }
    }
}

/// Reads a mask: pixels brighter than half of the range are foreground; where nothing is brighter than an eighth of it, each value is a person.
///
/// The brightness of a colour image is its luma. In an image with transparency the opacity counts instead, unless it is
/// opaque everywhere: both a white figure and a photograph cut out on a transparent ground are masks.
pub(super) fn read(path: &Path, expected: [u32; 2]) -> Result<Painted, MaskFault> {
    let bytes = input::read(path, MOST_OF_AN_IMAGE).map_err(MaskFault::Unreadable)?;
    let is_lossy = image::guess_format(&bytes).is_ok_and(|format| format == ImageFormat::Jpeg);
    let decoder = decoder(&bytes).map_err(fault)?;
    let found = decoder.dimensions().into();
    if found != expected {
        return Err(MaskFault::Size { expected, found });
    }

    let picture = DynamicImage::from_decoder(decoder).map_err(fault)?;
    let colour = picture.color();
    let painted = if colour.has_alpha() {
        let pixels = picture.into_luma_alpha16();
        let is_cut_out = pixels.pixels().any(|pixel| pixel.0[1] <= u16::MAX / 2);
        let channel = usize::from(is_cut_out);
        let values = pixels.pixels().map(|pixel| pixel.0[channel]).collect();
        painted(values, found, u16::MAX / 2)
    } else if colour.bytes_per_pixel() == colour.channel_count() {
        painted(picture.into_luma8().into_raw(), found, u8::MAX / 2)
    } else {
        painted(picture.into_luma16().into_raw(), found, u16::MAX / 2)
    };
    match painted {
        Painted::Labels(labels) if is_lossy => {
            let brightest = labels.values().iter().copied().max().unwrap_or(0).into();
            Err(MaskFault::LossyLabels { brightest, range: u8::MAX.into() })
        }
        painted => Ok(painted),
    }
}

fn fault(error: ImageError) -> MaskFault {
    match error {
        ImageError::Limits(_) => MaskFault::TooLarge(error),
        error => MaskFault::Undecodable(error),
    }
}

/// The mask of one value a pixel; foreground is above `half` of the range, rounded down.
fn painted<T>(values: Vec<T>, size: [u32; 2], half: T) -> Painted
where
    T: Copy + Ord + Default + Into<u16> + Into<u32>,
{
    let range = 2 * Into::<u32>::into(half) + 1;
    let brightest: u32 = values.iter().copied().max().unwrap_or_default().into();
    let darkest: u32 = values.iter().copied().min().unwrap_or_default().into();
    let is_dim = f64::from(brightest) < LABEL_FRACTION * f64::from(range);

    // a decoder gives as many values as it promised pixels
    let plane = Plane::from_values(size[0] as usize, size[1] as usize, values);
    let plane = plane.unwrap_or_else(|| Plane::filled(0, 0, T::default()));
    if is_dim && darkest == 0 && brightest > 0 {
        Painted::Labels(plane.map(Into::into))
    } else {
        Painted::White(Mask::brighter_than(&plane, half))
    }
}
