//! All frames of a recording: what is learned of them, then their masks.

use std::ops::RangeInclusive;

use rayon::prelude::*;

use super::notes::Notes;
use super::{Cut, CutQuality, SegmentOptions, Segmenter, Training};
use crate::camera::CameraId;
use crate::image::Picture;
use crate::pipeline::{Person, PictureSource, Progress};
use crate::silhouette::FrameIndex;

/// One frame with its masks.
#[derive(Clone, Debug)]
pub struct SegmentedFrame {
    /// Which frame.
    pub frame: FrameIndex,
    /// The pictures, a place for each camera of the rig.
    pub pictures: Vec<Option<Picture>>,
    /// The person in each; `None` without a picture, and in one most of which is other than the empty scene.
    pub cuts: Vec<Option<Cut>>,
}

/// How good one mask is likely to be.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MaskQuality {
    /// Of which frame.
    pub frame: FrameIndex,
    /// Of which camera.
    pub camera: CameraId,
    /// Its figures.
    pub quality: CutQuality,
}

/// What was segmented.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Segmented {
    /// Every mask, frame by frame.
    pub masks: Vec<MaskQuality>,
    /// What the user should know.
    pub notes: Vec<String>,
}

/// Learns background and person from all pictures, and hands the masks of the frames of these numbers, both included, to `take`. The
/// detections of `people`, if there are any, say where they are.
///
/// As many frames as there are threads are segmented at once, each handed over by its own thread.
///
/// # Errors
/// What `take` fails with, of the first frame.
pub fn segment<E: Send>(
    pictures: &dyn PictureSource,
    people: &[Person],
    frames: RangeInclusive<usize>,
    options: SegmentOptions,
    progress: &dyn Progress,
    take: impl Fn(&SegmentedFrame) -> Result<(), E> + Sync,
) -> Result<Segmented, E> {
    let mut notes = Notes::new(pictures.rig());
    let segmenter = learn(pictures, people, options, progress, &mut notes);

    let all = pictures.frames();
    let count = all.iter().filter(|frame| frames.contains(&frame.0)).count();
    progress.begin("masks", count);
    let cut = |(frame, pictures): (FrameIndex, Vec<Option<Picture>>)| {
        let cuts = segmenter.segment(frame, &pictures);
        let segmented = SegmentedFrame { frame, pictures, cuts };
        let taken = take(&segmented);
        progress.step();
        taken.map(|()| segmented)
    };

    let mut masks = Vec::new();
    let mut stream = pictures.pictures(frames);
    loop {
        let batch: Vec<_> = stream.by_ref().take(rayon::current_num_threads()).collect();
        if batch.is_empty() {
            break;
        }
        let segmented: Vec<Result<SegmentedFrame, E>> = batch.into_par_iter().map(&cut).collect();
        for frame in segmented {
            let frame = frame?;
            masks.extend(frame.qualities());
            notes.count_refused(&frame);
        }
    }
    progress.end();

    notes.add_masks(&masks);
    notes.add_background(&segmenter);
    Ok(Segmented { masks, notes: notes.lines })
}

/// Learns background and person from the empty scenes and all pictures.
fn learn(
    pictures: &dyn PictureSource,
    people: &[Person],
    options: SegmentOptions,
    progress: &dyn Progress,
    notes: &mut Notes<'_>,
) -> Segmenter {
    let frames = pictures.frames().len();
    progress.begin("background", frames);
    let mut training = Training::new(pictures.rig(), frames, options).told(people);
    for (camera, _) in pictures.rig().iter() {
        let mut empty = pictures.empty_scene(camera);
        for picture in empty.by_ref() {
            training.add_empty(camera, &picture);
        }
        notes.lines.extend(empty.notes());
    }

    let mut stream = pictures.pictures(0..=usize::MAX);
    for (frame, pictures) in stream.by_ref() {
        training.add(frame, &pictures);
        progress.step();
    }
    notes.lines.extend(stream.notes());

    progress.end();

    // the bar of the pictures would stand at its end for as long
    progress.begin("learning", 1);
    let segmenter = training.learn();
    progress.step();
    progress.end();
    segmenter
}

impl SegmentedFrame {
    fn qualities(&self) -> impl Iterator<Item = MaskQuality> {
        let cuts = self.cuts.iter().enumerate();
        cuts.filter_map(|(camera, cut)| {
            Some(MaskQuality {
                frame: self.frame,
                camera: CameraId(camera),
                quality: cut.as_ref()?.quality,
            })
        })
    }
}
