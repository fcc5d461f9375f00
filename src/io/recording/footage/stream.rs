//! Decoding ahead, with bounded memory.

use std::collections::BTreeSet;
use std::ops::RangeInclusive;
use std::path::Path;
use std::sync::mpsc::{Receiver, SyncSender, sync_channel};
use std::thread::JoinHandle;

use super::numbers::Numbering;
use super::probe::probe;
use super::video::Decoder;
use super::{CameraFootage, FootageError, FootageNote, Source, image};
use crate::camera::Camera;
use crate::image::Picture;
use crate::io::recording::layout::numbered_files::is_image;
use crate::pipeline::{FramePictures, Frames, PictureStream};
use crate::silhouette::FrameIndex;

/// Pictures that are decoded ahead of the reader, for each camera.
const AHEAD: usize = 4;

/// The pictures of one camera, in order.
///
/// Dropping it ends the decoder.
#[derive(Debug)]
pub struct Pictures {
    decoded: Option<Receiver<(FrameIndex, Picture)>>,
    worker: Option<JoinHandle<Vec<FootageNote>>>,
    notes: Vec<FootageNote>,
}

impl Pictures {
    pub(super) fn none() -> Self {
        Self { decoded: None, worker: None, notes: Vec::new() }
    }

    pub(super) fn start(
        footage: &CameraFootage,
        camera: &Camera,
        frames: RangeInclusive<usize>,
    ) -> Self {
        let footage = footage.clone();
        Self::run(format!("camera {}", camera.name), camera, move |decoding| {
            let wanted = footage.frames().into_iter().filter(|f| frames.contains(&f.0));
            decoding.promised = wanted.collect();

            match &footage.source {
                Source::Images(files) => {
                    let files =
                        files.iter().filter_map(|(n, path)| Some((footage.frame(*n)?, path)));
                    decoding.read_images(files.filter(|(frame, _)| frames.contains(&frame.0)));
                }
                Source::Video { path, numbering } => {
                    decoding.read_video(path, numbering, |n| footage.frame(n));
                }
            }
        })
    }

    pub(super) fn start_background(path: &Path, camera: &Camera) -> Self {
        let path = path.to_owned();
        Self::run(path.display().to_string(), camera, move |decoding| {
            if is_image(&path) {
                decoding.promised = [FrameIndex(0)].into();
                decoding.read_images([(FrameIndex(0), &path)].into_iter());
                return;
            }
            match probe(&path) {
                Ok(probe) => {
                    let numbering = probe.numbering(probe.rate_hz.unwrap_or(25.0));
                    let frame = |n| usize::try_from(n).ok().map(FrameIndex);
                    decoding.promised = numbering.numbers().into_iter().filter_map(frame).collect();
                    decoding.read_video(&path, &numbering, frame);
                }
                Err(fault) => decoding.stop(&path, &fault),
            }
        })
    }

    fn run(
        whose: String,
        camera: &Camera,
        job: impl FnOnce(&mut Decoding) + Send + 'static,
    ) -> Self {
        let (sender, decoded) = sync_channel(AHEAD);
        let size = [camera.width_px as usize, camera.height_px as usize];
        let worker = std::thread::spawn(move || {
            let mut decoding = Decoding::new(whose, size, sender);
            job(&mut decoding);
            decoding.notes()
        });
        Self { decoded: Some(decoded), worker: Some(worker), notes: Vec::new() }
    }

    /// Notes on what was odd; complete when all pictures have been taken.
    pub fn notes(&self) -> &[FootageNote] {
        &self.notes
    }
}

impl Iterator for Pictures {
    type Item = (FrameIndex, Picture);

    fn next(&mut self) -> Option<Self::Item> {
        let next = self.decoded.as_ref()?.recv().ok();
        if next.is_none() {
            self.decoded = None;
            let notes = self.worker.take().map(JoinHandle::join);
            self.notes = notes.and_then(Result::ok).unwrap_or_default();
        }
        next
    }
}

impl Drop for Pictures {
    fn drop(&mut self) {
        // without a receiver the worker stops at its next picture
        self.decoded = None;
        if let Some(worker) = self.worker.take() {
            let _ = worker.join();
        }
    }
}

/// The pictures of several cameras, frame by frame.
#[derive(Debug)]
pub(super) struct FrameSets {
    /// Each camera's pictures, and the one already taken but not yet due.
    cameras: Vec<(Pictures, Option<(FrameIndex, Picture)>)>,
}

impl FrameSets {
    pub(super) fn new(cameras: Vec<Pictures>) -> Self {
        Self { cameras: cameras.into_iter().map(|camera| (camera, None)).collect() }
    }
}

impl Iterator for FrameSets {
    /// Frame, and for each camera of the rig its picture if there is one.
    type Item = (FrameIndex, Vec<Option<Picture>>);

    fn next(&mut self) -> Option<Self::Item> {
        for (camera, next) in &mut self.cameras {
            if next.is_none() {
                *next = camera.next();
            }
        }
        let ahead = self.cameras.iter().filter_map(|(_, next)| next.as_ref());
        let frame = ahead.map(|(frame, _)| *frame).min()?;
        let pictures = self.cameras.iter_mut().map(|(_, next)| {
            let due = next.take_if(|(theirs, _)| *theirs == frame);
            due.map(|(_, picture)| picture)
        });
        Some((frame, pictures.collect()))
    }
}

impl PictureStream<FramePictures> for FrameSets {
    fn notes(&self) -> Vec<String> {
        let notes = self.cameras.iter().flat_map(|(camera, _)| camera.notes());
        notes.map(ToString::to_string).collect()
    }
}

/// The pictures of an empty scene.
pub(super) struct EmptyScene(pub(super) Pictures);

impl Iterator for EmptyScene {
    type Item = Picture;

    fn next(&mut self) -> Option<Picture> {
        self.0.next().map(|(_, picture)| picture)
    }
}

impl PictureStream<Picture> for EmptyScene {
    fn notes(&self) -> Vec<String> {
        self.0.notes().iter().map(ToString::to_string).collect()
    }
}

/// What the thread of one camera knows.
struct Decoding {
    whose: String,
    size: [usize; 2],
    sender: SyncSender<(FrameIndex, Picture)>,
    promised: BTreeSet<FrameIndex>,
    sent: BTreeSet<FrameIndex>,
    wrong_size: (usize, [usize; 2]),
    complaints: Vec<String>,
    is_counted: bool,
    notes: Vec<FootageNote>,
}

impl Decoding {
    fn new(whose: String, size: [usize; 2], sender: SyncSender<(FrameIndex, Picture)>) -> Self {
        Self {
            whose,
            size,
            sender,
            promised: BTreeSet::new(),
            sent: BTreeSet::new(),
            wrong_size: (0, [0; 2]),
            complaints: Vec::new(),
            is_counted: false,
            notes: Vec::new(),
        }
    }

    fn read_images<'a>(
        &mut self,
        files: impl Iterator<Item = (FrameIndex, &'a std::path::PathBuf)>,
    ) {
        for (frame, path) in files {
            match image::read(path) {
                Ok(picture) => {
                    if !self.send(frame, picture) {
                        return;
                    }
                }
                Err(fault) => self.complaints.push(fault.to_string()),
            }
        }
    }

    fn read_video(
        &mut self,
        path: &Path,
        numbering: &Numbering,
        frame: impl Fn(u64) -> Option<FrameIndex>,
    ) {
        self.is_counted = matches!(numbering, Numbering::Count { .. });
        let Some(last) = self.promised.last().copied() else {
            return;
        };
        let mut decoder = match Decoder::start(path) {
            Ok(decoder) => decoder,
            Err(fault) => return self.stop(path, &fault),
        };
        let mut first_s = None;
        while let Some((time_s, picture)) = decoder.next() {
            let first_s = *first_s.get_or_insert(time_s);
            let Some(frame) = numbering.number(time_s, first_s).and_then(&frame) else {
                continue;
            };
            // two pictures at the time of one frame: the first counts
            if self.promised.contains(&frame)
                && !self.sent.contains(&frame)
                && !self.send(frame, picture)
            {
                break;
            }
            if frame >= last {
                break;
            }
        }
        self.complaints = decoder.finish();
    }

    /// Whether anybody wants more.
    fn send(&mut self, frame: FrameIndex, picture: Picture) -> bool {
        let found = [picture.width(), picture.height()];
        self.sent.insert(frame);
        if found != self.size {
            let first = if self.wrong_size.0 == 0 { found } else { self.wrong_size.1 };
            self.wrong_size = (self.wrong_size.0 + 1, first);
            return true;
        }
        self.sender.send((frame, picture)).is_ok()
    }

    fn stop(&mut self, path: &Path, fault: &FootageError) {
        self.sent = std::mem::take(&mut self.promised);
        self.notes.push(FootageNote::Stopped {
            whose: self.whose.clone(),
            path: path.into(),
            reason: fault.to_string(),
        });
    }

    fn notes(mut self) -> Vec<FootageNote> {
        let whose = self.whose;
        let lost: Vec<FrameIndex> = self.promised.difference(&self.sent).copied().collect();
        let times = self.complaints.len();
        let reason = self.complaints.into_iter().next();
        // a file without times promises what its decoder may need to get going
        let is_lost = !lost.is_empty() && (reason.is_some() || !self.is_counted);
        if is_lost {
            self.notes.push(FootageNote::Undecodable {
                whose: whose.clone(),
                frames: Frames(lost),
                of: self.promised.len(),
                reason: reason.unwrap_or_else(|| "the file ends early".into()),
            });
        } else if let Some(reason) = reason {
            self.notes.push(FootageNote::Damaged { whose: whose.clone(), times, reason });
        }
        if let (pictures @ 1.., found) = self.wrong_size {
            self.notes.push(FootageNote::WrongSize { whose, pictures, found, expected: self.size });
        }
        self.notes
    }
}
