//! From footage on disk to masks on disk: `masks/<camera>/%06d.png` and `quality.csv`.

use std::fs;
use std::io;
use std::ops::RangeInclusive;
use std::path::{Path, PathBuf};

use ::image::ExtendedColorType;
use rayon::prelude::*;
use serde::Serialize;

use super::jpeg;
use super::png::{self, Effort};
use super::table;
use super::{OutError, OutFolder, file_name};
use crate::camera::CameraId;
use crate::image::{Mask, Picture, Plane};
use crate::io::recording::footage::{Footage, FootageNote};
use crate::pipeline::Frames;
use crate::pipeline::segment::{Cut, SegmentOptions, Segmenter, Training};
use crate::silhouette::FrameIndex;

/// Pictures that are written beside the masks.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default)]
pub struct Extras {
    /// `probability/<camera>/%06d.png`.
    pub probability: bool,
    /// `mask-overlays/<camera>/%06d.jpg`.
    pub overlays: bool,
}

/// Of the overlays, which are only looked at.
const JPEG_QUALITY: u8 = 85;

/// The table of the masks; it is written last: where it stands the masks are complete.
pub const QUALITY: &str = "quality.csv";

/// Makes a folder for masks, without those of an older run and what stood beside them, whichever way it found them.
///
/// # Errors
/// [`OutError::Write`].
pub(super) fn open(root: &Path) -> Result<OutFolder, OutError> {
    let folder = OutFolder::open(root)?;
    let mut older = vec![
        "masks",
        "probability",
        "mask-overlays",
        "contours",
        "stages",
    ];
    // those of a fit are replaced with its result
    if !root.join("result.json").exists() {
        older.push("overlays");
    }
    folder.begin(QUALITY, &older)?;
    Ok(folder)
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

/// Learns background and person from all of the footage; `done` is called after each frame.
pub fn learn(
    footage: &Footage,
    options: SegmentOptions,
    done: &dyn Fn(),
) -> (Segmenter, Vec<FootageNote>) {
    let mut training = Training::new(&footage.rig, footage.frames().len(), options);
    let mut notes = Vec::new();
    for (id, _) in footage.rig.iter() {
        let mut empty = footage.background(id);
        for (_, picture) in empty.by_ref() {
            training.add_empty(id, &picture);
        }
        notes.extend(empty.notes().iter().cloned());
    }
    let mut sets = footage.frame_sets(0..=usize::MAX);
    for (_, pictures) in sets.by_ref() {
        training.add(&pictures);
        done();
    }
    notes.extend(sets.notes());
    (training.learn(), notes)
}

/// Segments frames and writes their masks into a folder, in which those of an older run are removed; `done` is called after each frame.
///
/// A note for each camera in whose pictures nobody is, or whose pictures could not be segmented.
///
/// # Errors
/// [`OutError`] for the first file that cannot be written.
pub fn write(
    folder: &Path,
    footage: &Footage,
    segmenter: &Segmenter,
    frames: RangeInclusive<usize>,
    extras: Extras,
    done: &(dyn Fn() + Sync),
) -> Result<(Vec<QualityRow>, Vec<FootageNote>), OutError> {
    let writer = Writer::new(folder, footage, extras)?;
    let (mut rows, mut without) = (Vec::new(), vec![Vec::new(); footage.rig.cameras.len()]);
    let mut sets = footage.frame_sets(frames);
    let at_once = rayon::current_num_threads();
    loop {
        let batch: Vec<_> = sets.by_ref().take(at_once).collect();
        if batch.is_empty() {
            break;
        }
        let cut: Vec<(Vec<Option<Cut>>, Result<_, OutError>)> = batch
            .par_iter()
            .map(|(frame, pictures)| {
                let cuts = segmenter.segment(pictures);
                let rows = writer.write(*frame, pictures, &cuts);
                done();
                (cuts, rows)
            })
            .collect();
        for ((frame, pictures), (cuts, written)) in batch.iter().zip(cut) {
            rows.extend(written?);
            for ((without, picture), cut) in without.iter_mut().zip(pictures).zip(cuts) {
                without.extend((picture.is_some() && cut.is_none()).then_some(*frame));
            }
        }
    }
    table::finish(&writer.out, QUALITY, &rows)?;
    let notes = notes(footage, &rows, without);
    Ok((rows, notes))
}

/// What is odd about the masks of each camera.
fn notes(
    footage: &Footage,
    rows: &[QualityRow],
    without: Vec<Vec<FrameIndex>>,
) -> Vec<FootageNote> {
    let names = || footage.rig.names().map(str::to_owned);
    let lost = names()
        .zip(without)
        .filter(|(_, frames)| !frames.is_empty());
    let lost = lost.map(|(camera, frames)| FootageNote::OtherLight {
        camera,
        frames: Frames(frames),
    });
    let nobody = names().filter_map(|camera| {
        let own = || rows.iter().filter(|row| row.camera == camera);
        let pictures = own().count();
        let is_empty = pictures > 0 && own().all(|row| row.area_px == 0);
        is_empty.then_some(FootageNote::Nobody { camera, pictures })
    });
    lost.chain(nobody).collect()
}

/// Where each camera's files go.
struct Writer {
    names: Vec<String>,
    folders: Vec<PathBuf>,
    out: OutFolder,
    root: PathBuf,
    extras: Extras,
}

impl Writer {
    fn new(root: &Path, footage: &Footage, extras: Extras) -> Result<Self, OutError> {
        let folders: Vec<PathBuf> = footage
            .rig
            .names()
            .map(|name| file_name(name).into())
            .collect();
        let kinds = [
            ("masks", true),
            ("probability", extras.probability),
            ("mask-overlays", extras.overlays),
        ];
        let out = open(root)?;
        for (kind, _) in kinds.iter().filter(|(_, is_wanted)| *is_wanted) {
            for folder in &folders {
                let path = root.join(kind).join(folder);
                fs::create_dir_all(&path).map_err(|source| OutError::Write { path, source })?;
            }
        }
        Ok(Self {
            names: footage.rig.names().map(str::to_owned).collect(),
            folders,
            out,
            root: root.into(),
            extras,
        })
    }

    fn write(
        &self,
        frame: FrameIndex,
        pictures: &[Option<Picture>],
        cuts: &[Option<Cut>],
    ) -> Result<Vec<QualityRow>, OutError> {
        let mut rows = Vec::new();
        for (c, cut) in cuts.iter().enumerate() {
            let (Some(cut), Some(Some(picture))) = (cut, pictures.get(c)) else {
                continue;
            };
            let path = |kind: &str, extension: &str| {
                let name = format!("{:06}.{extension}", frame.0);
                self.root.join(kind).join(&self.folders[c]).join(name)
            };
            let mask = png::of_mask(&cut.mask, Effort::Quick);
            written(path("masks", "png"), mask)?;
            if self.extras.probability {
                written(path("probability", "png"), grey(&cut.probability))?;
            }
            if self.extras.overlays {
                let overlay = jpeg::encode(&over(picture, &cut.mask), JPEG_QUALITY);
                written(path("mask-overlays", "jpg"), overlay)?;
            }
            let q = cut.quality;
            rows.push(QualityRow {
                frame: frame.0,
                camera: self.names[c].clone(),
                area_px: q.area_px,
                pieces: q.pieces,
                touches_edge: q.touches_edge,
                undecided: rounded(q.undecided),
                unsupported: rounded(q.unsupported),
                filled_in: rounded(q.filled_in),
            });
        }
        Ok(rows)
    }
}

fn rounded(share: f64) -> f64 {
    (share * 1e4).round() / 1e4
}

/// The picture, darker where the person is not, with a yellow border.
fn over(picture: &Picture, mask: &Mask) -> Picture {
    let mut over = picture.clone();
    for y in 0..picture.height() {
        for (x, pixel) in over.row_mut(y).iter_mut().enumerate() {
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
    over
}

fn written(path: PathBuf, file: io::Result<Vec<u8>>) -> Result<(), OutError> {
    let written = file.and_then(|bytes| fs::write(&path, bytes));
    written.map_err(|source| OutError::Write { path, source })
}

fn grey(probability: &Plane<f32>) -> io::Result<Vec<u8>> {
    let grey = probability.map(|p| (255.0 * p).round() as u8);
    let size = (grey.width(), grey.height());
    png::encode(grey.values(), size, ExtendedColorType::L8, Effort::Quick)
}

/// Each camera whose person stands before a background that was never seen, and the share of the place.
pub fn never_left(footage: &Footage, segmenter: &Segmenter) -> Vec<(CameraId, f64)> {
    let ids = footage.rig.iter().map(|(id, _)| id);
    let shares = ids.zip(segmenter.never_left());
    shares.filter(|(_, share)| *share > NOTEWORTHY).collect()
}

/// Below this share of the person's place an unknown background does no harm.
const NOTEWORTHY: f64 = 0.01;
