//! Persons who stand before a ring of cameras, for tests.

use std::f64::consts::PI;
use std::path::Path;

use nalgebra::{Point3, Vector2, Vector3};
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, StandardNormal};

use super::{CameraFaults, Diagnosis};
use crate::body::metaball::Field;
use crate::body::{BodyModel, Motion, Posed, Shape};
use crate::camera::{Camera, CameraId, Rig};
use crate::image::Mask;
use crate::inference::Evidence;
#[cfg(test)]
use crate::io::model;
use crate::likelihood::{LikelihoodOptions, Measure, label_sigma_px};
use crate::math::Rigid3;
use crate::pipeline::{CameraQuality, FittedFrame};
use crate::render;
use crate::silhouette::{
    Detection, FrameIndex, FrameObservations, Keypoint, SilhouetteOptions, extract,
};
use crate::synth::{Recipe, Ring};

/// A usual person, and cameras all around.
pub(in crate::pipeline) struct Figures {
    pub(in crate::pipeline) model: BodyModel,
    pub(in crate::pipeline) shape: Shape,
    pub(in crate::pipeline) rig: Rig,
}

impl Figures {
    pub(in crate::pipeline) fn new() -> Self {
        let model = model::load("human-metaballs", Path::new("")).unwrap();
        let shape = Shape(model.statistics.mean.clone());
        let ring = Ring { width_px: 320, height_px: 240, focal_px: 250.0, ..Ring::default() };
        Self { model, shape, rig: ring.regular() }
    }

    /// Upright, this far along x and y.
    pub(in crate::pipeline) fn standing(&self, x: f64, y: f64) -> Motion {
        let mut motion = Motion::rest(&self.model);
        let lowest = self.posed(&motion).bounds().unwrap().0.z;
        motion.position_world += Vector3::new(x, y, -lowest);
        motion
    }

    pub(in crate::pipeline) fn posed(&self, motion: &Motion) -> Posed<'_> {
        Posed::new(&self.model, &self.shape, motion)
    }

    /// What a diagnosis says of this person, of whom nothing but fitted frames and cameras is known.
    pub(in crate::pipeline) fn diagnosed<T>(
        &self,
        frames: &[FittedFrame],
        cameras: &[CameraQuality],
        say: impl Fn(&Diagnosis<'_>) -> T,
    ) -> T {
        let (model, rig) = (&self.model, &self.rig);
        say(&Diagnosis {
            evidence: &Evidence::new(model, rig, LikelihoodOptions::default(), Measure::Metaballs),
            faults: &CameraFaults::of(rig, &[]),
            left_out: &[],
            observations: &[],
            fps: 25.0,
            shape: &self.shape,
            uncertainty: None,
            height_m: None,
            frames,
            cameras,
        })
    }

    /// The masks of one person, camera by camera.
    pub(in crate::pipeline) fn masks(&self, motion: &Motion) -> Vec<Mask> {
        let field = Field::from_body(&self.posed(motion));
        self.rig.cameras.iter().map(|camera| render::silhouette(camera, &field)).collect()
    }

    /// What masks show of one frame.
    pub(in crate::pipeline) fn frame(&self, number: usize, masks: &[Mask]) -> FrameObservations {
        let mut seen = FrameObservations::nothing(FrameIndex(number));
        for ((id, camera), mask) in self.rig.iter().zip(masks) {
            let silhouette = extract(mask, camera, &SilhouetteOptions::default()).unwrap();
            seen.views.push((id, silhouette));
        }
        seen
    }
}

/// What either mask shows.
pub(in crate::pipeline) fn joined(a: &[Mask], b: &[Mask]) -> Vec<Mask> {
    let both = |(a, b): (&Mask, &Mask)| {
        Mask::from_fn(a.width(), a.height(), |x, y| a.is_foreground(x, y) || b.is_foreground(x, y))
    };
    a.iter().zip(b).map(both).collect()
}

/// Turns a camera by half a turn about its line of sight: its pictures are upside down then.
pub(super) fn hang(camera: &mut Camera) {
    camera.camera_from_world = Rigid3::rotation(Vector3::z() * PI) * camera.camera_from_world;
}

/// A walker before a ring of cameras.
pub(in crate::pipeline) fn walker() -> (Rig, Vec<FrameObservations>) {
    let person = model::load("walker-metaballs", Path::new("")).unwrap();
    let recipe = Recipe { frames: Some(16), fps: 25.0, ..Recipe::default() };
    let walker = recipe.walker(&person).unwrap();
    let shown = |number: usize| {
        let mut seen = FrameObservations::nothing(FrameIndex(number));
        for (id, camera) in walker.rig.iter() {
            let mask = walker.mask(seen.frame, id).unwrap();
            if let Ok(silhouette) = extract(&mask, camera, &SilhouetteOptions::default()) {
                seen.views.push((id, silhouette));
            }
        }
        seen
    };
    (walker.rig.clone(), (0..walker.frames()).map(shown).collect())
}

/// A walker before a ring of cameras, of whom only detections show anything: half as far off as published labels.
pub(super) fn detected_walker() -> (Rig, Vec<FrameObservations>) {
    let person = model::load("walker-metaballs", Path::new("")).unwrap();
    let recipe = Recipe { frames: Some(40), fps: 25.0, ..Recipe::default() };
    let walker = recipe.walker(&person).unwrap();
    let mut rng = ChaCha8Rng::seed_from_u64(4);
    let mut seen_by = |camera: &Camera, points: &[Point3<f64>]| {
        let names = ["RHip", "LHip", "RKnee", "LKnee", "RAnkle", "LAnkle", "Neck"];
        let arms = ["RShoulder", "LShoulder", "RElbow", "LElbow", "RWrist", "LWrist"];
        let keypoint = |name: &'static str| {
            let pixel = camera.project_undistorted(&points[walker.model.point(name)?])?;
            Some(Keypoint { name, pixel, confidence: 0.9 })
        };
        let clean: Vec<Keypoint> = names.into_iter().chain(arms).filter_map(keypoint).collect();
        let mut detection = Detection::new(clean)?;
        for keypoint in &mut detection.keypoints {
            let sigma_px = 0.5 * label_sigma_px(keypoint.name, detection.size_px, 1.0);
            let mut noise = || sigma_px * Distribution::<f64>::sample(&StandardNormal, &mut rng);
            keypoint.pixel += Vector2::new(noise(), noise());
        }
        Some(detection)
    };
    let mut shown = |number: usize| {
        let mut seen = FrameObservations::nothing(FrameIndex(number));
        let points = walker.points(seen.frame).unwrap();
        for (id, camera) in walker.rig.iter() {
            seen.detections.extend(seen_by(camera, &points).map(|detection| (id, detection)));
        }
        seen
    };
    let frames = (0..walker.frames()).map(&mut shown).collect();
    (walker.rig.clone(), frames)
}

/// The same with a camera that shows everything so many frames late.
pub(in crate::pipeline) fn late(
    frames: &[FrameObservations],
    camera: usize,
    by: isize,
) -> Vec<FrameObservations> {
    let mut spoiled = frames.to_vec();
    for (i, frame) in spoiled.iter_mut().enumerate() {
        let moment = i.checked_add_signed(-by).and_then(|i| frames.get(i));
        let others = |id: &CameraId| id.0 != camera;
        let shown = moment.and_then(|m| m.views.iter().find(|(id, _)| !others(id)));
        frame.views.retain(|(id, _)| others(id));
        frame.views.extend(shown.cloned());
        frame.views.sort_by_key(|(id, _)| *id);
        let seen = moment.and_then(|m| m.detections.iter().find(|(id, _)| !others(id)));
        frame.detections.retain(|(id, _)| others(id));
        frame.detections.extend(seen.cloned());
        frame.detections.sort_by_key(|(id, _)| *id);
    }
    spoiled
}
