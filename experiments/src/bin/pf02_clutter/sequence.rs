//! A sequence on disk, what a pipeline makes of it, and how far that is from the truth.

use std::path::{Path, PathBuf};
use std::time::Instant;

use experiments::contours::{Score, mask_path, read_mask, score_of_view};
use experiments::film::photographed;
use maquette::Recording;
use maquette::camera::CameraId;
use maquette::image::{Mask, Picture};
use maquette::io::folder::silhouettes::SilhouetteExtras;
use maquette::math::stats::median;
use maquette::pipeline::silhouettes::SilhouettePipeline;
use maquette::pipeline::{FrameRange, NoProgress};
use maquette::silhouette::FrameIndex;
use maquette::synth::{Film, FilmRecipe, Studio};
use maquette::workflow::{DEFAULT_BODY, SilhouetteFiles};
use rayon::prelude::*;

use crate::Fault;

/// The pipelines and their names: PF02's simple one, ours, and the joint one as published.
pub(crate) const PIPELINES: [(&str, SilhouettePipeline); 3] = [
    ("simple", SilhouettePipeline::Simple),
    ("joint", SilhouettePipeline::Joint),
    ("frame_after_frame", SilhouettePipeline::FrameAfterFrame),
];
/// The camera in the middle.
pub(crate) const CENTRE: usize = 1;

/// A recording with its truth.
pub(crate) struct Sequence {
    pub(crate) film: Film,
    folder: PathBuf,
}

/// The silhouettes of a pipeline.
pub(crate) struct Traced {
    pub(crate) pipeline: &'static str,
    /// Of each frame, of each camera.
    pub(crate) scores: Vec<Vec<Score>>,
    pub(crate) seconds_a_frame: f64,
    out: PathBuf,
}

impl Sequence {
    /// Makes a recording and writes it into `folder`, over what was there.
    pub(crate) fn photographed(
        seed: u64,
        (frames, fps): (usize, f64),
        folder: &Path,
    ) -> Result<Self, Fault> {
        let recipe = FilmRecipe { seed, frames, fps, ..FilmRecipe::default() };
        let film = photographed(&recipe, &folder.join("recording"))?;
        Ok(Self { film, folder: folder.to_owned() })
    }

    /// Runs a pipeline as a user would, and compares what it wrote with the true masks.
    pub(crate) fn traced(
        &self,
        (name, pipeline): (&'static str, SilhouettePipeline),
    ) -> Result<Traced, Fault> {
        let out = self.folder.join(name);
        let recording = self.folder.join("recording");
        let files = SilhouetteFiles {
            folder: &out,
            body: DEFAULT_BODY,
            frames: FrameRange::default(),
            pipeline,
            start: None,
            extras: SilhouetteExtras::default(),
        };
        let start = Instant::now();
        Recording::open(recording)?.write_silhouettes(&files, &NoProgress)?;
        let seconds = start.elapsed().as_secs_f64();
        let frames = self.film.synthetic.frames();
        let numbers: Vec<usize> = (0..frames).collect();
        let scores = numbers.into_par_iter().map(|frame| self.scores(frame, &out));
        Ok(Traced {
            pipeline: name,
            scores: scores.collect::<Result<_, String>>()?,
            seconds_a_frame: seconds / frames as f64,
            out,
        })
    }

    fn scores(&self, frame: usize, out: &Path) -> Result<Vec<Score>, String> {
        let names = self.film.synthetic.rig.names();
        let truth = self.folder.join("recording/truth");
        names.into_iter().map(|name| score_of_view(out, &truth, name, frame)).collect()
    }

    /// The centre camera's photographs and true masks.
    pub(crate) fn studio(&self) -> Option<Studio<'_>> {
        self.film.studio(CameraId(CENTRE))
    }

    /// The centre camera's photograph, the mask that a pipeline found, and the true one.
    pub(crate) fn shown(
        &self,
        studio: &Studio<'_>,
        traced: &Traced,
        frame: usize,
    ) -> Result<(Picture, Mask, Mask), Fault> {
        let shot = studio.shot(FrameIndex(frame)).ok_or("no such frame")?;
        let name = &self.film.synthetic.rig.cameras[CENTRE].name;
        let found = read_mask(&mask_path(&traced.out, name, frame))?;
        Ok((shot.picture, found, shot.mask))
    }
}

impl Traced {
    /// Frames in error in any camera.
    pub(crate) fn errors(&self) -> Vec<usize> {
        let is_error = |frame: &usize| self.scores[*frame].iter().any(Score::is_error);
        (0..self.scores.len()).filter(is_error).collect()
    }

    /// How many frames are in error in the centre camera.
    pub(crate) fn errors_of_centre(&self) -> usize {
        let of_centre = self.scores.iter().filter_map(|cameras| cameras.get(CENTRE));
        of_centre.filter(|score| score.is_error()).count()
    }

    /// Of all frames and cameras: mean distance of the contour, px; median and least overlap.
    pub(crate) fn summary(&self) -> (f64, f64, f64) {
        let all = || self.scores.iter().flatten();
        let mut overlaps: Vec<f64> = all().map(|score| score.overlap).collect();
        let distance = all().map(|score| score.distance_px).sum::<f64>();
        let mean = distance / overlaps.len().max(1) as f64;
        let least = overlaps.iter().copied().fold(1.0, f64::min);
        (mean, median(&mut overlaps).unwrap_or(f64::NAN), least)
    }

    /// How far the centre camera's contour is off in a frame, px.
    pub(crate) fn distance_px(&self, frame: usize) -> f64 {
        let of_centre = self.scores.get(frame).and_then(|cameras| cameras.get(CENTRE));
        of_centre.map_or(f64::NAN, |score| score.distance_px)
    }
}
