//! One pass over the pictures: every pixel's mixture, and the key frames.

use super::SegmentOptions;
use super::figures::Figures;
use crate::camera::{Camera, CameraId, Rig};
use crate::image::{Mixture, MixtureOptions, Picture, shrink};
use crate::math::stats::median_of_counts;
use crate::pipeline::Person;
use crate::silhouette::{FrameIndex, ShrunkSize};

/// From so many pictures of the empty scene on its mixture is left as it is; fewer say too little of the noise.
const ENOUGH_EMPTY: usize = 20;
/// A background's σ never falls below this, grey levels: what codecs and lamps do to a still scene over minutes.
const LEAST_SIGMA: f32 = 5.0;
/// The hue's noise is no smaller a part of the brightness's.
const LEAST_HUE_NOISE: f32 = 0.2;
/// Few pictures of the empty scene count so many times as much as all of the recording.
const EMPTY_WEIGHT: f32 = 4.0;
/// σ of a normal distribution over its median absolute value.
const SIGMA_OF_MEDIAN: f32 = 1.4826;

/// What is taken from the pictures while they pass.
#[derive(Clone, Debug)]
pub struct Training {
    pub(super) rig: Rig,
    pub(super) options: SegmentOptions,
    pub(super) cameras: Vec<CameraTraining>,
    /// Each key frame and its pictures, shrunk.
    pub(super) keys: Vec<(FrameIndex, Vec<Option<Picture>>)>,
    /// Where detections show people.
    pub(super) figures: Figures,
    frames: usize,
    seen: usize,
}

/// What one camera has learned.
#[derive(Clone, Debug)]
pub(super) struct CameraTraining {
    pub(super) shrunk: ShrunkSize,
    pub(super) mixture: Option<Mixture>,
    /// Pictures of the empty scene.
    pub(super) empty: usize,
    /// All that taught the mixture, each counted as often as it weighs.
    taught: f32,
    /// σ of the hue over that of the brightness.
    pub(super) hue_noise: f32,
    /// The first picture, until a second tells the noise.
    first: Option<Picture>,
}

impl Training {
    /// For a recording of so many frames.
    pub fn new(rig: &Rig, frames: usize, options: SegmentOptions) -> Self {
        let cameras = rig.cameras.iter();
        Self {
            cameras: cameras.map(|camera| CameraTraining::new(camera, options.most_px)).collect(),
            rig: rig.clone(),
            options,
            keys: Vec::new(),
            figures: Figures::default(),
            frames,
            seen: 0,
        }
    }

    /// Takes what detections tell of where these people are.
    pub fn told(mut self, people: &[Person]) -> Self {
        self.figures = Figures::new(&self.rig, people);
        self
    }

    /// Learns a picture of the empty scene; all of them come before the recording's.
    pub(super) fn add_empty(&mut self, camera: CameraId, picture: &Picture) {
        if let Some(camera) = self.cameras.get_mut(camera.0) {
            camera.empty += 1;
            let small = shrink(picture, camera.shrunk.factor);
            camera.learn(&small, 1.0);
        }
    }

    /// Learns the pictures of the next frame.
    pub fn add(&mut self, frame: FrameIndex, pictures: &[Option<Picture>]) {
        let options = self.options;
        let spacing = self.frames.div_ceil(options.training_pictures.max(1));
        let teaches = self.seen.is_multiple_of(spacing.max(1));
        let is_key = is_key(self.seen, self.frames, options.key_frames);
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
            self.keys.push((frame, small));
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
    /// Of pictures shrunk by a whole factor to no more than so many pixels.
    fn new(camera: &Camera, most_px: usize) -> Self {
        let (width, height) = (camera.width_px as usize, camera.height_px as usize);
        let factor = (1..).find(|f| (width / f) * (height / f) <= most_px.max(1));
        let factor = factor.unwrap_or(1);

        Self {
            shrunk: ShrunkSize { width: width / factor, height: height / factor, factor },
            mixture: None,
            empty: 0,
            taught: 0.0,
            hue_noise: 1.0,
            first: None,
        }
    }

    /// Whether pictures of the empty scene say what the background is.
    pub(super) fn is_given(&self) -> bool {
        self.empty > 0
    }

    fn learn_recorded(&mut self, picture: &Picture, frames: f32) {
        if self.empty >= ENOUGH_EMPTY {
            return;
        }
        // a person who never moves must not outweigh them
        if self.is_given() {
            self.taught = self.taught.max(EMPTY_WEIGHT * frames);
        }
        self.learn(picture, 1.0);
    }

    fn learn(&mut self, picture: &Picture, weight: f32) {
        if self.mixture.is_none() {
            let Some(first) = self.first.take() else {
                self.first = Some(picture.clone());
                return;
            };

            // two pictures tell the noise
            let [along, across] = noise(&first, picture);
            let sigma = ((along * along + 2.0 * across * across) / 3.0).sqrt();
            self.hue_noise = (across.max(1.0) / along.max(2.0)).clamp(LEAST_HUE_NOISE, 1.0);
            let options = MixtureOptions {
                first_sigma: sigma.max(MixtureOptions::default().first_sigma),
                least_sigma: (0.8 * sigma).max(LEAST_SIGMA),
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
                let ShrunkSize { width, height, .. } = self.shrunk;
                let mut mixture = Mixture::new(width, height, MixtureOptions::default());
                if let Some(first) = first {
                    mixture.update(first, 1.0);
                }
                mixture
            }
        }
    }
}

/// σ of one picture's noise in brightness, (r + g + b)/√3, and in hue, by the median differences of two pictures; the
/// person moves in less than half of them.
fn noise(a: &Picture, b: &Picture) -> [f32; 2] {
    let mut counts = [[0_usize; 3 * 256]; 2];
    for (a, b) in a.values().iter().zip(b.values()) {
        let [r, g, b] = [0, 1, 2].map(|i| i32::from(a[i]) - i32::from(b[i]));
        counts[0][(r + g + b).unsigned_abs() as usize] += 1;
        counts[1][(r - g).unsigned_abs() as usize] += 1;
    }
    let [sum, difference] =
        counts.map(|counts| median_of_counts(&counts) as f32 * SIGMA_OF_MEDIAN / 2_f32.sqrt());
    [sum / 3_f32.sqrt(), difference / 2_f32.sqrt()]
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::synth::Ring;

    #[test]
    fn key_frames_are_evenly_spaced_and_as_many_as_asked_for() {
        let keys =
            |frames, keys| (0..frames).filter(|p| is_key(*p, frames, keys)).collect::<Vec<_>>();
        assert_eq!(keys(3, 16), [0, 1, 2]);
        assert_eq!(keys(100, 4), [13, 38, 63, 88]);
        assert_eq!(keys(1000, 16).len(), 16);
    }

    /// A picture of one colour with grain of σ in all channels alike.
    fn grainy(random: &mut u32, sigma: f64) -> Picture {
        let mut grain = || {
            *random = random.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
            // nearly normal
            let sum: u32 = (0..4).map(|i| (*random >> (8 * i)) & 0xff).sum();
            (f64::from(sum) - 510.0) / 147.8 * sigma
        };
        let values = (0..4000).map(|_| {
            let light = grain();
            [100.0, 130.0, 90.0].map(|c| (c + light).round() as u8)
        });
        Picture::from_values(80, 50, values.collect()).unwrap()
    }

    #[test]
    fn the_noise_of_brightness_and_hue_is_told_from_two_pictures() {
        let mut random = 7;
        let [along, across] = noise(&grainy(&mut random, 4.0), &grainy(&mut random, 4.0));
        assert!((along - 4.0 * 3_f32.sqrt()).abs() < 0.7, "{along}");
        assert!(across < 0.5, "{across}");
    }

    #[test]
    fn one_picture_of_the_empty_scene_is_no_noisier_than_the_recording_shows() {
        let ring = Ring { cameras: 1, width_px: 80, height_px: 50, ..Ring::default() };
        let mut training = Training::new(&ring.regular(), 20, SegmentOptions::default());
        let mut random = 3;
        training.add_empty(CameraId(0), &grainy(&mut random, 12.0));
        for frame in 0..20 {
            training.add(FrameIndex(frame), &[Some(grainy(&mut random, 12.0))]);
        }
        let mixture = training.cameras[0].finished();
        let variances = (0..50).flat_map(|y| (0..80).map(move |x| (x, y)));
        let variances = variances.map(|(x, y)| mixture.mode(0, x, y).variance);
        let sigma = (variances.sum::<f32>() / 4000.0).sqrt();
        assert!((11.0..14.5).contains(&sigma), "{sigma}");
    }
}
