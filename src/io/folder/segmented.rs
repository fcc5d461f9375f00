//! What `maquette segment` writes: `masks/<camera>/%06d.png`, pictures beside them, and `quality.csv`.

use std::io;
use std::path::PathBuf;

use ::image::ExtendedColorType;
use serde::Serialize;

use super::jpeg;
use super::png::{self, Effort};
use super::table;
use super::{OutError, OutFolder, file_name, make_folder, write_encoded};
use crate::camera::Rig;
use crate::image::{Mask, Picture, Plane};
use crate::pipeline::segment::{MaskQuality, SegmentedFrame};

/// Pictures that are written beside the masks.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default)]
pub struct MaskExtras {
    /// `probability/<camera>/%06d.png`.
    pub probability: bool,
    /// `mask-overlays/<camera>/%06d.jpg`.
    pub overlays: bool,
}

/// Quality of the overlays, which are only looked at.
const JPEG_QUALITY: u8 = 85;

/// The table of the masks; it is written last: where it stands the masks are complete.
pub const QUALITY: &str = "quality.csv";

/// Begins a run that writes masks, and removes what an older one of either kind left there.
pub(super) fn begin(out: &OutFolder) -> Result<(), OutError> {
    let mut older = vec!["masks", "probability", "mask-overlays", "contours", "stages"];
    // those of a fit are replaced with its result
    if !out.path().join("result.json").exists() {
        older.push("overlays");
    }
    out.begin(QUALITY, &older)
}

/// One line of `quality.csv`.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct QualityRow {
    /// Number of the frame.
    pub frame: usize,
    /// Name of the camera.
    pub camera: String,
    /// Pixels of the mask.
    pub area_px: usize,
    /// Connected pieces of it.
    pub pieces: usize,
    /// Whether it reaches the edge of the picture.
    pub touches_edge: bool,
    /// See [`crate::pipeline::segment::CutQuality`].
    pub undecided: f64,
    /// See [`crate::pipeline::segment::CutQuality`].
    pub unsupported: f64,
    /// See [`crate::pipeline::segment::CutQuality`].
    pub filled_in: f64,
}

/// Where the masks of a recording go.
#[derive(Debug)]
pub struct MaskFolder<'a> {
    out: &'a OutFolder,
    /// Of each camera, its name and that of its folders.
    cameras: Vec<(String, PathBuf)>,
    extras: MaskExtras,
}

impl<'a> MaskFolder<'a> {
    /// Makes the folders within it, without what an older run left there.
    ///
    /// # Errors
    /// [`OutError::Write`].
    pub fn open(out: &'a OutFolder, rig: &Rig, extras: MaskExtras) -> Result<Self, OutError> {
        let names = rig.names();
        let cameras: Vec<(String, PathBuf)> =
            names.map(|name| (name.to_owned(), file_name(name).into())).collect();
        let kinds = [
            ("masks", true),
            ("probability", extras.probability),
            ("mask-overlays", extras.overlays),
        ];

        begin(out)?;
        for (kind, _) in kinds.iter().filter(|(_, is_wanted)| *is_wanted) {
            for (_, folder) in &cameras {
                make_folder(&out.path().join(kind).join(folder))?;
            }
        }
        Ok(Self { out, cameras, extras })
    }

    /// Writes the masks of a frame, and what was asked for beside them.
    ///
    /// # Errors
    /// [`OutError::Write`] for the first file that cannot be written.
    pub fn write(&self, segmented: &SegmentedFrame) -> Result<(), OutError> {
        let views = segmented.pictures.iter().zip(&segmented.cuts);
        for ((_, folder), view) in self.cameras.iter().zip(views) {
            let (Some(picture), Some(cut)) = view else {
                continue;
            };
            let path = |kind: &str, extension: &str| {
                let name = format!("{:06}.{extension}", segmented.frame.0);
                self.out.path().join(kind).join(folder).join(name)
            };

            let mask = match &cut.labels {
                Some(labels) => encoded(labels),
                None => png::encode_mask(&cut.mask, Effort::Quick),
            };
            write_encoded(&path("masks", "png"), mask)?;
            if self.extras.probability {
                write_encoded(&path("probability", "png"), grey(&cut.probability))?;
            }
            if self.extras.overlays {
                let overlay = jpeg::encode(&overlay(picture, &cut.mask), JPEG_QUALITY);
                write_encoded(&path("mask-overlays", "jpg"), overlay)?;
            }
        }
        Ok(())
    }

    /// Writes `quality.csv`, a line for each mask: where it stands all is complete.
    ///
    /// # Errors
    /// [`OutError::Write`].
    pub fn finish(self, masks: &[MaskQuality]) -> Result<Vec<QualityRow>, OutError> {
        let row = |mask: &MaskQuality| {
            let quality = mask.quality;
            Some(QualityRow {
                frame: mask.frame.0,
                camera: self.cameras.get(mask.camera.0)?.0.clone(),
                area_px: quality.area_px,
                pieces: quality.pieces,
                touches_edge: quality.touches_edge,
                undecided: rounded(quality.undecided),
                unsupported: rounded(quality.unsupported),
                filled_in: rounded(quality.filled_in),
            })
        };
        let rows: Vec<QualityRow> = masks.iter().filter_map(row).collect();
        table::finish(self.out, QUALITY, &rows)?;
        Ok(rows)
    }
}

fn rounded(share: f64) -> f64 {
    (share * 1e4).round() / 1e4
}

/// The picture, darker where the person is not, with a yellow border.
fn overlay(picture: &Picture, mask: &Mask) -> Picture {
    let mut overlay = picture.clone();
    for y in 0..picture.height() {
        for (x, pixel) in overlay.row_mut(y).iter_mut().enumerate() {
            let is_person = mask.is_foreground(x, y);
            let is_border = is_person
                && !(mask.is_foreground(x + 1, y)
                    && mask.is_foreground(x, y + 1)
                    && mask.is_foreground(x.wrapping_sub(1), y)
                    && mask.is_foreground(x, y.wrapping_sub(1)));
            if is_border {
                *pixel = [255, 220, 0];
            } else if !is_person {
                *pixel = pixel.map(|v| v / 3);
            }
        }
    }
    overlay
}

fn grey(probability: &Plane<f32>) -> io::Result<Vec<u8>> {
    encoded(&probability.map(|p| (255.0 * p).round() as u8))
}

fn encoded(grey: &Plane<u8>) -> io::Result<Vec<u8>> {
    let (width, height) = (grey.width(), grey.height());
    png::encode(grey.values(), width, height, ExtendedColorType::L8, Effort::Quick)
}
