//! Pictures that are in memory already.

use std::collections::BTreeMap;
use std::ops::RangeInclusive;

use super::{FramePictures, PictureSource, PictureStream};
use crate::camera::{CameraId, Rig};
use crate::image::Picture;
use crate::silhouette::FrameIndex;

/// The pictures of calibrated cameras, in memory.
#[derive(Clone, Debug, Default)]
pub struct MemoryPictures {
    /// The cameras.
    pub rig: Rig,
    /// Frames per second.
    pub fps: f64,
    /// Of each frame a place for each camera of the rig; `None` where a camera has no picture.
    pub frames: BTreeMap<FrameIndex, Vec<Option<Picture>>>,
    /// Pictures of the empty scene.
    pub empty_scenes: BTreeMap<CameraId, Vec<Picture>>,
}

impl PictureSource for MemoryPictures {
    fn rig(&self) -> &Rig {
        &self.rig
    }

    fn fps(&self) -> f64 {
        self.fps
    }

    fn frames(&self) -> Vec<FrameIndex> {
        self.frames.keys().copied().collect()
    }

    fn pictures(
        &self,
        frames: RangeInclusive<usize>,
    ) -> Box<dyn PictureStream<FramePictures> + '_> {
        let wanted = self.frames.iter();
        let wanted = wanted.filter(move |(frame, _)| frames.contains(&frame.0));
        Box::new(Copies(wanted.map(|(f, pictures)| (*f, pictures.clone()))))
    }

    fn empty_scene(&self, camera: CameraId) -> Box<dyn PictureStream<Picture> + '_> {
        let pictures = self.empty_scenes.get(&camera).into_iter().flatten();
        Box::new(Copies(pictures.cloned()))
    }
}

/// Copies of what is in memory: all of it can be read.
struct Copies<I>(I);

impl<I: Iterator> Iterator for Copies<I> {
    type Item = I::Item;

    fn next(&mut self) -> Option<I::Item> {
        self.0.next()
    }
}

impl<I: Iterator> PictureStream<I::Item> for Copies<I> {
    fn notes(&self) -> Vec<String> {
        Vec::new()
    }
}
