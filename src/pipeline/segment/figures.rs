//! Where detections of joints say that people are in a picture.
//!
//! A person covers the bones between their joints, and nothing that is far from all of these. With δ(x) the distance of pixel x from the
//! nearest bone, over the person's size s in the picture ([`Detection::size_px`], about half a metre), what a detection tells is
//!
//! t(x) = 1 where δ < 0.05, 0 from there to 0.5, and from 0.5 to 0.75 down to −1.
//!
//! - 0.05 s, 3 cm, is a wrist's radius.
//! - Nearer than 0.25 s, 13 cm, may be the person, who is nowhere thicker about a bone.
//! - 0.5 s, 27 cm: a hand ends .11 H beyond the wrist, a foot .15 H beyond the ankle (Drillis and Contini 1966). The rest is for cloth.
//!
//! A detection that lacks a limb tells nothing of what is far.
//!
//! Of several people each pixel is the one's to whom it is nearest.

use std::collections::BTreeMap;

use nalgebra::{Point2, Vector2};

use super::subject;
use crate::camera::{Camera, CameraId, Rig};
use crate::image::{Mask, Plane};
use crate::inference::joints::Joints;
use crate::pipeline::Person;
use crate::silhouette::{Detection, FrameIndex, ShrunkSize, Volume};

/// Nearer to a bone is the person, farther than the next two is not, over their size.
const ON_BONE: f32 = 0.05;
const FAR: [f32; 2] = [0.5, 0.75];
/// Nearer may be the person.
const ABOUT: f32 = 0.25;

/// The bones that people's outlines are about, and the head's and the feet's where a detector has such points.
#[rustfmt::skip]
const BONES: [[&str; 2]; 18] = [
    ["RShoulder", "LShoulder"], ["RHip", "LHip"],
    ["RShoulder", "RHip"], ["LShoulder", "LHip"], ["RShoulder", "LHip"], ["LShoulder", "RHip"],
    ["RHip", "RKnee"], ["RKnee", "RAnkle"], ["RAnkle", "RBigToe"],
    ["LHip", "LKnee"], ["LKnee", "LAnkle"], ["LAnkle", "LBigToe"],
    ["RShoulder", "RElbow"], ["RElbow", "RWrist"],
    ["LShoulder", "LElbow"], ["LElbow", "LWrist"],
    ["Neck", "Nose"], ["Neck", "Head"],
];
/// Without one of these a part of the person may be anywhere.
#[rustfmt::skip]
const LIMBS: [&str; 12] = [
    "RShoulder", "LShoulder", "RElbow", "LElbow", "RWrist", "LWrist",
    "RHip", "LHip", "RKnee", "LKnee", "RAnkle", "LAnkle",
];
/// From the middle of the hips to that of the shoulders, and so much of it on, is the top of the head (Drillis and Contini 1966: .30 H and .18 H).
const HEAD: f64 = 0.6;

/// The people in the pictures of a recording, as stick figures.
#[derive(Clone, Debug, Default)]
pub(super) struct Figures {
    rig: Rig,
    people: usize,
    volume: Option<Volume>,
    /// Of each frame the camera and the position of each person, and what is seen of them.
    frames: BTreeMap<FrameIndex, Vec<(CameraId, usize, Detection)>>,
}

/// What the detections tell of one picture.
#[derive(Clone, Debug)]
pub(super) struct Told {
    /// δ of each pixel, up to where nobody is.
    distances: Plane<f32>,
    /// Who is nearest, by position.
    nearest: Plane<u8>,
    /// Whether every limb of everybody was detected, so that what is far is nobody.
    is_whole: bool,
}

impl Told {
    /// t: from −1, nobody is here, to 1, somebody is.
    fn presence(&self, distance: f32) -> f32 {
        match distance {
            on if on < ON_BONE => 1.0,
            _ if !self.is_whole => 0.0,
            off => -((off - FAR[0]) / (FAR[1] - FAR[0])).clamp(0.0, 1.0),
        }
    }

    /// Whether somebody may be here.
    pub(super) fn is_about(&self, x: usize, y: usize) -> bool {
        self.distances.row(y)[x] < ABOUT
    }

    /// The other cameras' support of each pixel, or what is told where that says more.
    pub(super) fn over(&self, others: Option<Plane<f32>>) -> Plane<f32> {
        let told = self.distances.map(|distance| self.presence(distance));
        let Some(mut support) = others else { return told };
        for y in 0..support.height() {
            for (support, told) in support.row_mut(y).iter_mut().zip(told.row(y)) {
                *support = match *told {
                    here if here > 0.0 => support.max(here),
                    absent if absent < 0.0 => support.min(absent),
                    _ => *support,
                };
            }
        }
        support
    }

    /// Adds the bones to a mask of 0 and 1.
    pub(super) fn add_bones(&self, mask: &mut Plane<u8>) {
        for y in 0..mask.height() {
            for (pixel, distance) in mask.row_mut(y).iter_mut().zip(self.distances.row(y)) {
                *pixel = (*pixel).max(u8::from(*distance < ON_BONE));
            }
        }
    }

    /// Whose each pixel of a mask is, from 1 on, 0 of one that is too far from everybody; of a picture of which so many pixels along each
    /// side became one.
    pub(super) fn labels(&self, mask: &Mask, factor: usize) -> Plane<u8> {
        let last = [self.nearest.width() - 1, self.nearest.height() - 1];
        let mut labels = Plane::filled(mask.width(), mask.height(), 0);
        for y in 0..mask.height() {
            let row = (y / factor).min(last[1]);
            let (nearest, distances) = (self.nearest.row(row), self.distances.row(row));
            for (x, label) in labels.row_mut(y).iter_mut().enumerate() {
                let column = (x / factor).min(last[0]);
                if mask.is_foreground(x, y) && distances[column] < FAR[1] {
                    *label = nearest[column] + 1;
                }
            }
        }
        labels
    }
}

impl Figures {
    pub(super) fn new(rig: &Rig, people: &[Person]) -> Self {
        let (mut frames, mut middles) = (BTreeMap::<FrameIndex, Vec<_>>::new(), Vec::new());
        for (who, person) in people.iter().enumerate() {
            for (frame, seen) in &person.detections {
                middles.extend(Joints::new(rig, seen).map(|joints| joints.middle()));
                let seen = seen.iter().map(|(camera, d)| (*camera, who, d.clone()));
                frames.entry(*frame).or_default().extend(seen);
            }
        }
        let volume = subject::volume_about(&middles);
        Self { rig: rig.clone(), people: people.len(), frames, volume }
    }

    /// How many people there are.
    pub(super) fn people(&self) -> usize {
        self.people
    }

    /// The box in which the people move; `None` if no two cameras see anybody together.
    pub(super) fn volume(&self) -> Option<Volume> {
        self.volume
    }

    /// What is told of a picture; `None` where nobody was detected.
    pub(super) fn told(
        &self,
        frame: FrameIndex,
        camera: CameraId,
        shrunk: &ShrunkSize,
    ) -> Option<Told> {
        let calibrated = self.rig.camera(camera)?;
        let all = self.frames.get(&frame)?;
        let here: Vec<_> = all.iter().filter(|(of, ..)| *of == camera).collect();
        if here.is_empty() {
            return None;
        }

        // who is known to be there and was not detected here may be anywhere, and so may be a limb
        let is_here = |who: &usize| here.iter().any(|(_, is, _)| is == who);
        let has_limbs =
            |detection: &Detection| LIMBS.iter().all(|name| detection.keypoint(name).is_some());
        let mut told = Told {
            distances: Plane::filled(shrunk.width, shrunk.height, FAR[1]),
            nearest: Plane::filled(shrunk.width, shrunk.height, 0),
            is_whole: all.iter().all(|(_, who, _)| is_here(who))
                && here.iter().all(|(.., detection)| has_limbs(detection)),
        };
        for (_, who, detection) in here {
            let figure = Figure::new(calibrated, shrunk, detection);
            figure.bones.iter().for_each(|bone| figure.add(bone, *who as u8, &mut told));
        }
        Some(told)
    }
}

/// One person in one shrunk picture.
struct Figure {
    size_px: f64,
    bones: Vec<Bone>,
}

/// A line within a person, and how near a pixel on it counts, over the person's size.
struct Bone {
    ends: [Point2<f64>; 2],
    least: f32,
}

impl Figure {
    fn new(camera: &Camera, shrunk: &ShrunkSize, detection: &Detection) -> Self {
        let factor = shrunk.factor as f64;
        let recorded = |pixel: Point2<f64>| {
            Point2::from((camera.distort(&pixel).coords.add_scalar(0.5) / factor).add_scalar(-0.5))
        };
        let bone = |[from, to]: &[&str; 2]| {
            let ends = [place(detection, from)?, place(detection, to)?];
            Some(Bone { ends: ends.map(recorded), least: 0.0 })
        };
        let mut bones: Vec<_> = BONES.iter().filter_map(bone).collect();
        // who bends their neck has the head near this line, not on it
        bones.extend(head(detection).map(|ends| Bone { ends: ends.map(recorded), least: ON_BONE }));
        Self { size_px: detection.size_px / factor, bones }
    }

    /// Adds a bone of somebody, where it is the nearest so far.
    fn add(&self, Bone { ends: [from, to], least }: &Bone, who: u8, told: &mut Told) {
        let (width, height) = (told.distances.width(), told.distances.height());
        let reach = Vector2::repeat(f64::from(FAR[1]) * self.size_px);
        let (low, high) = (from.inf(to) - reach, from.sup(to) + reach);
        let within = |low: f64, high: f64, count: usize| {
            (low.max(0.0) as usize).min(count)..((high + 1.0).max(0.0) as usize).min(count)
        };
        let along = to - from;
        let square = along.norm_squared().max(f64::MIN_POSITIVE);
        for y in within(low.y, high.y, height) {
            for x in within(low.x, high.x, width) {
                let offset = Point2::new(x as f64, y as f64) - from;
                let share = (offset.dot(&along) / square).clamp(0.0, 1.0);
                let distance = ((offset - along * share).norm() / self.size_px) as f32;
                let distance = distance.max(*least);
                if distance < told.distances.row(y)[x] {
                    told.distances.row_mut(y)[x] = distance;
                    told.nearest.row_mut(y)[x] = who;
                }
            }
        }
    }
}

/// Where a point was seen, undistorted pixels.
fn place(detection: &Detection, name: &str) -> Option<Point2<f64>> {
    detection.keypoint(name).map(|k| k.pixel)
}

/// From the middle of the shoulders to the top of the head of one who holds it straight.
fn head(detection: &Detection) -> Option<[Point2<f64>; 2]> {
    let middle = |of: &str| {
        let side = |side: &str| place(detection, &format!("{side}{of}"));
        Some(nalgebra::center(&side("R")?, &side("L")?))
    };
    let (hips, shoulders) = (middle("Hip")?, middle("Shoulder")?);
    Some([shoulders, shoulders + (shoulders - hips) * HEAD])
}
