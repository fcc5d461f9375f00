//! The pictures of a recording: images or videos of calibrated cameras, decoded ahead, frame by frame.
//!
//! [`Recording::footage`](super::Recording::footage) finds which frames each camera has;
//! [`Footage::stream`] gives the pictures of one camera in order, [`Footage::frame_sets`] those of all cameras frame by
//! frame. Each camera is decoded by a thread of its own, at most four pictures ahead of the reader, so
//! memory stays bounded for any length of recording. Videos are piped through the installed program `ffmpeg`.
//!
//! A picture that cannot be read is left out; [`Pictures::notes`] says in one line what happened.
//!
//! | file         | holds                                                                   |
//! |--------------|-------------------------------------------------------------------------|
//! | `open.rs`    | from a folder or manifest to cameras and frame numbers                   |
//! | `numbers.rs` | which frame each picture of a video is, from its time stamps              |
//! | `probe.rs`   | what `ffprobe` says of a video                                           |
//! | `video.rs`   | pictures out of `ffmpeg`'s pipe                                          |
//! | `image.rs`   | pictures out of image files                                              |
//! | `sound.rs`   | [`Loudness`] of a video                                                  |
//! | `stream.rs`  | [`Pictures`] of one camera, or of all frame by frame: decoding ahead      |

mod error;
mod image;
mod note;
mod numbers;
mod open;
mod probe;
mod sound;
mod stream;
mod video;

use std::collections::{BTreeMap, BTreeSet};
use std::ops::RangeInclusive;
use std::path::PathBuf;

use super::manifest::Beginning;
use crate::camera::{CameraId, Rig, UpAxis};
use crate::image::Picture;
use crate::pipeline::{FramePictures, PictureSource, PictureStream};
use crate::silhouette::FrameIndex;
use stream::EmptyScene;

pub use error::FootageError;
pub use note::FootageNote;
use numbers::Numbering;
pub(super) use open::{ENDINGS, open};
pub use sound::Loudness;
use stream::FrameSets;
pub use stream::Pictures;

/// Calibrated pictures, frame by frame.
#[derive(Clone, Debug)]
pub struct Footage {
    /// Frames per second.
    pub fps: f64,
    /// The cameras that have pictures, in the order of the manifest.
    pub rig: Rig,
    /// What each camera of the rig recorded.
    pub(crate) cameras: Vec<CameraFootage>,
    /// What the user should know.
    pub notes: Vec<FootageNote>,
    /// Which axis of the files' world points up.
    pub up: UpAxis,
}

/// What one camera recorded.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct CameraFootage {
    /// Its pictures.
    pub source: Source,
    /// When it began: added to the numbers of the source's pictures.
    pub beginning: Beginning,
    /// An image or a video of the empty scene.
    pub background: Option<PathBuf>,
}

/// Where pictures come from.
#[derive(Clone, Debug, PartialEq)]
pub(crate) enum Source {
    /// An image for each number.
    Images(BTreeMap<u64, PathBuf>),
    /// A video.
    Video {
        /// The file.
        path: PathBuf,
        /// Which number each of its pictures has.
        numbering: Numbering,
    },
}

impl CameraFootage {
    /// Every file that it is read from: the pictures and those of the empty scene.
    pub(crate) fn paths(&self) -> Vec<&PathBuf> {
        let pictures: Vec<&PathBuf> = match &self.source {
            Source::Images(files) => files.values().collect(),
            Source::Video { path, .. } => vec![path],
        };
        pictures.into_iter().chain(&self.background).collect()
    }

    /// The frames that should have a picture, ascending.
    pub(crate) fn frames(&self) -> Vec<FrameIndex> {
        let numbers: Vec<u64> = match &self.source {
            Source::Images(files) => files.keys().copied().collect(),
            Source::Video { numbering, .. } => numbering.numbers(),
        };
        let frames = numbers.into_iter().filter_map(|n| self.frame(n));
        frames.collect()
    }

    /// The frame of the picture of this number; `None` before frame 0.
    fn frame(&self, number: u64) -> Option<FrameIndex> {
        let shifted = number.checked_add_signed(self.beginning.whole())?;
        Some(FrameIndex(usize::try_from(shifted).ok()?))
    }
}

impl Footage {
    /// The frames that should have a picture from at least one camera, ascending.
    pub fn frames(&self) -> Vec<FrameIndex> {
        let all: BTreeSet<FrameIndex> = self.cameras.iter().flat_map(|c| c.frames()).collect();
        all.into_iter().collect()
    }

    /// The pictures of a camera in these frames (both included), in order; none for a camera that is not there.
    pub fn stream(&self, camera: CameraId, frames: RangeInclusive<usize>) -> Pictures {
        match (self.cameras.get(camera.0), self.rig.camera(camera)) {
            (Some(footage), Some(known)) => Pictures::start(footage, known, frames),
            _ => Pictures::none(),
        }
    }

    /// The pictures of all cameras in these frames (both included), frame by frame.
    pub fn frame_sets(
        &self,
        frames: RangeInclusive<usize>,
    ) -> impl PictureStream<FramePictures> + use<> {
        let cameras = self.rig.iter().map(|(id, _)| id);
        FrameSets::new(cameras.map(|id| self.stream(id, frames.clone())).collect())
    }

    /// The pictures of a camera's empty scene, in order: of an image one, of a video all; none if there is no such file.
    pub fn background(&self, camera: CameraId) -> Pictures {
        let footage = self.cameras.get(camera.0);
        match (footage.and_then(|f| f.background.as_ref()), self.rig.camera(camera)) {
            (Some(path), Some(known)) => Pictures::start_background(path, known),
            _ => Pictures::none(),
        }
    }
}

impl PictureSource for Footage {
    fn rig(&self) -> &Rig {
        &self.rig
    }

    fn fps(&self) -> f64 {
        self.fps
    }

    fn frames(&self) -> Vec<FrameIndex> {
        self.frames()
    }

    fn pictures(
        &self,
        frames: RangeInclusive<usize>,
    ) -> Box<dyn PictureStream<FramePictures> + '_> {
        Box::new(self.frame_sets(frames))
    }

    fn empty_scene(&self, camera: CameraId) -> Box<dyn PictureStream<Picture> + '_> {
        Box::new(EmptyScene(self.background(camera)))
    }
}
