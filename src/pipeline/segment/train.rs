//! One pass over the pictures: every pixel's mixture, and the key frames.

use super::SegmentOptions;
use crate::camera::{CameraId, Rig};
use crate::image::{Mixture, MixtureOptions, Picture, shrink};
use crate::silhouette::Shrunk;

/// From so many pictures of the empty scene on its mixture is left as it is; fewer say too little of the noise.
const ENOUGH_EMPTY: usize = 20;
/// σ of a normal distribution over its median absolute value.
const SIGMA_OF_MEDIAN: f32 = 1.4826;

/// What is taken from the pictures while they pass.
#[derive(Clone, Debug)]
pub struct Training {
    pub(super) rig: Rig,
    pub(super) options: SegmentOptions,
    pub(super) cameras: Vec<CameraTraining>,
    /// Pictures of each key frame, shrunk.
    pub(super) keys: Vec<Vec<Option<Picture>>>,
    frames: usize,
    seen: usize,
}

/// What one camera has learned.
#[derive(Clone, Debug)]
pub(super) struct CameraTraining {
    pub(super) shrunk: Shrunk,
    pub(super) mixture: Option<Mixture>,
    /// Pictures of the empty scene.
    pub(super) empty: usize,
    /// All that taught the mixture, each counted as often as it weighs.
    taught: f32,
    /// The first picture, until a second tells the noise.
    first: Option<Picture>,
}

impl Training {
    /// For a recording of so many frames.
    pub fn new(rig: &Rig, frames: usize, options: SegmentOptions) -> Self {
        let camera = |camera: &crate::camera::Camera| {
            let (width, height) = (camera.width_px as usize, camera.height_px as usize);
            let factor = (1..).find(|f| (width / f) * (height / f) <= options.most_px.max(1));
            let factor = factor.unwrap_or(1);
            CameraTraining {
                shrunk: Shrunk {
                    width: width / factor,
                    height: height / factor,
                    factor,
                },
                mixture: None,
                empty: 0,
                taught: 0.0,
                first: None,
            }
        };
        Self {
            cameras: rig.cameras.iter().map(camera).collect(),
            rig: rig.clone(),
            options,
            keys: Vec::new(),
            frames,
            seen: 0,
        }
    }

    /// Learns a picture of the empty scene; all of them come before the recording's.
    pub fn add_empty(&mut self, camera: CameraId, picture: &Picture) {
        if let Some(camera) = self.cameras.get_mut(camera.0) {
            camera.empty += 1;
            let small = shrink(picture, camera.shrunk.factor);
            camera.learn(&small, 1.0);
        }
    }

    /// Learns the pictures of the next frame.
    pub fn add(&mut self, pictures: &[Option<Picture>]) {
        let options = self.options;
        let (teaches, is_key) = (
            self.seen.is_multiple_of(
                self.frames
                    .div_ceil(options.training_pictures.max(1))
                    .max(1),
            ),
            is_key(self.seen, self.frames, options.key_frames),
        );
        self.seen += 1;
        if !(teaches || is_key) {
            return;
        }
        let mut small = Vec::new();
        let weight = self.frames.min(options.training_pictures) as f32;
        for (camera, picture) in self.cameras.iter_mut().zip(pictures) {
            let picture = picture.as_ref().map(|p| shrink(p, camera.shrunk.factor));
            if let Some(picture) = picture.as_ref().filter(|_| teaches) {
                camera.learn_recorded(picture, weight);
            }
            small.push(picture);
        }
        if is_key {
            self.keys.push(small);
        }
    }
}

/// Whether the frame at a position is one of about `keys` evenly spaced ones.
fn is_key(position: usize, frames: usize, keys: usize) -> bool {
    let of = |position: usize| (position * keys.max(1)) / frames.max(1);
    let half = frames / (2 * keys.max(1));
    frames <= keys || (position + half >= 1 && of(position + half) != of(position + half - 1))
}

impl CameraTraining {
    /// Whether pictures of the empty scene say what the background is.
    pub(super) fn is_given(&self) -> bool {
        self.empty > 0
    }

    fn learn_recorded(&mut self, picture: &Picture, frames: f32) {
        if self.empty >= ENOUGH_EMPTY {
            return;
        }
        // few pictures of the empty scene count as much as all of the recording, or the person would replace them
        if self.is_given() && self.taught < frames {
            self.taught = self.taught.max(frames);
        }
        self.learn(picture, 1.0);
    }

    fn learn(&mut self, picture: &Picture, weight: f32) {
        if self.mixture.is_none() {
            let Some(first) = self.first.take() else {
                self.first = Some(picture.clone());
                return;
            };
            let sigma = noise(&first, picture);
            let options = MixtureOptions {
                first_sigma: (2.0 * sigma).max(MixtureOptions::default().first_sigma),
                least_sigma: (0.8 * sigma).max(MixtureOptions::default().least_sigma),
                ..MixtureOptions::default()
            };
            let mut mixture = Mixture::new(first.width(), first.height(), options);
            mixture.update(&first, 1.0);
            self.taught = self.taught.max(1.0);
            self.mixture = Some(mixture);
        }
        if let Some(mixture) = &mut self.mixture {
            self.taught += weight;
            mixture.update(picture, weight / self.taught);
        }
    }

    /// The mixture, also of a single picture.
    pub(super) fn finished(&self) -> Mixture {
        match (&self.mixture, &self.first) {
            (Some(mixture), _) => mixture.clone(),
            (None, first) => {
                let Shrunk { width, height, .. } = self.shrunk;
                let mut mixture = Mixture::new(width, height, MixtureOptions::default());
                if let Some(first) = first {
                    mixture.update(first, 1.0);
                }
                mixture
            }
        }
    }
}

/// σ of one picture's noise, by the median difference of two; the person moves in less than half of the picture.
fn noise(a: &Picture, b: &Picture) -> f32 {
    let mut counts = [0_usize; 256];
    for (a, b) in a
        .values()
        .as_flattened()
        .iter()
        .zip(b.values().as_flattened())
    {
        counts[usize::from(a.abs_diff(*b))] += 1;
    }
    let half = counts.iter().sum::<usize>() / 2;
    let mut below = 0;
    let median = counts.iter().position(|count| {
        below += count;
        below > half
    });
    SIGMA_OF_MEDIAN / 2_f32.sqrt() * median.unwrap_or(0) as f32
}
