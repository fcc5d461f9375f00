//! A person who walks, or does not.

use std::ops::Range;
use std::path::Path;

use maquette::body::{BodyModel, Motion, Posed, Shape};
use maquette::gait::{Movement, MovementError};
use maquette::io::model;
use maquette::io::points::trc::{Trajectories, write_trc};
use maquette::pipeline::{FittedBody, FittedMotion, FramePose};
use maquette::silhouette::FrameIndex;
use maquette::synth::{Ground, Walk, WalkingStyle};
use nalgebra::{Point3, Vector2, Vector3};

pub(crate) const RATE_HZ: f64 = 100.0;
/// Of the mean of healthy adults, 0.94 strides a second.
pub(crate) const STRIDE_S: f64 = 1.0 / 0.94;
const FRAMES: usize = 420;
/// How far the knees bend in a squat, radians.
const SQUAT_KNEES: f64 = 1.5;

#[derive(Clone)]
pub(crate) struct Walker {
    pub(crate) model: BodyModel,
    pub(crate) shape: Shape,
    pub(crate) motions: Vec<Motion>,
    names: Vec<String>,
    frames: Vec<Vec<Option<Point3<f64>>>>,
    heading: f64,
}

impl Walker {
    /// Somebody who walks straight on, `heading` radians from the world's x axis.
    pub(crate) fn new(heading: f64) -> Self {
        let model = model::load("human-ellipsoids", Path::new("")).expect("a shipped model");
        let shape = Shape(model.statistics.mean.clone());
        let walk = Walk {
            style: WalkingStyle::normative(),
            heading,
            middle_world: Vector2::new(0.4, -0.3),
            start_phase: 0.2,
            ground: Ground::Floor,
        };
        let motions = walk.motions(&model, &shape, RATE_HZ, FRAMES).expect("feet");
        Self::from_motions(model, shape, motions, heading)
    }

    fn from_motions(model: BodyModel, shape: Shape, motions: Vec<Motion>, heading: f64) -> Self {
        let points = |motion: &Motion| {
            let points = Posed::new(&model, &shape, motion).points();
            points.into_iter().map(Some).collect()
        };
        Self {
            names: model.points.iter().map(|p| p.name.clone()).collect(),
            frames: motions.iter().map(points).collect(),
            model,
            shape,
            motions,
            heading,
        }
    }

    /// Somebody who bends hips and knees twice, feet in their place.
    pub(crate) fn squat() -> Self {
        Self::on_the_spot(|frame| 0.5 * (1.0 - (0.03 * frame as f64).cos()))
    }

    /// Somebody who stands still with knees bent, radians.
    pub(crate) fn standing(knees: f64) -> Self {
        Self::on_the_spot(|_| knees / SQUAT_KNEES)
    }

    /// Somebody whose hips, knees and ankles bend by a share of a squat, frame by frame.
    fn on_the_spot(bend: impl Fn(usize) -> f64) -> Self {
        let mut walker = Self::new(0.0);
        let joint = |name: &str| walker.model.joint(name).expect("a leg").0;
        let [hips, knees, ankles] = ["hip_flexion", "knee_flexion", "ankle_dorsiflexion"]
            .map(|name| [joint(&format!("{name}_l")), joint(&format!("{name}_r"))]);
        let foot = walker.model.point("LAnkle").expect("an ankle");
        for (i, motion) in walker.motions.iter_mut().enumerate() {
            let bend = bend(i);
            *motion = Motion::rest(&walker.model);
            for side in 0..2 {
                motion.angles[hips[side]] = 1.2 * bend;
                motion.angles[knees[side]] = SQUAT_KNEES * bend;
                motion.angles[ankles[side]] = 0.3 * bend;
            }
            // stand on the ankle
            let ankle = Posed::new(&walker.model, &walker.shape, motion).points()[foot];
            motion.position_world = -ankle.coords;
        }
        Self::from_motions(walker.model, walker.shape, walker.motions, 0.0)
    }

    pub(crate) fn movement(&self) -> Result<Movement, MovementError> {
        Movement::from_points(RATE_HZ, 0, &self.names, &self.frames)
    }

    /// The movement as of a fitted body, and the body.
    pub(crate) fn fitted(&self) -> (Movement, FittedBody) {
        self.fitted_without(0..0)
    }

    /// The same with the person not seen in some frames.
    pub(crate) fn fitted_without(&self, unseen: Range<usize>) -> (Movement, FittedBody) {
        let pose = |(i, motion): (usize, &Motion)| {
            let points = Posed::new(&self.model, &self.shape, motion).points();
            FramePose {
                frame: FrameIndex(i),
                is_seen: !unseen.contains(&i),
                motion: motion.clone(),
                points_m: points.iter().map(|p| p.coords.into()).collect(),
                sd: None,
                cameras: 0,
            }
        };
        let fitted = FittedMotion {
            model: self.model.clone(),
            shape: self.shape.clone(),
            rate_hz: RATE_HZ,
            points: self.names.clone(),
            frames: self.motions.iter().enumerate().map(pose).collect(),
        };
        fitted.into_movement().expect("a body")
    }

    /// Metres between two prints of one foot: what the pelvis moves in a stride.
    pub(crate) fn stride_length(&self) -> f64 {
        let (first, last) = (&self.motions[0], &self.motions[FRAMES - 1]);
        let way = (last.position_world - first.position_world).xy().norm();
        way / ((FRAMES - 1) as f64 / RATE_HZ) * STRIDE_S
    }

    /// A joint's angle in every frame.
    pub(crate) fn angle(&self, joint: &str) -> Vec<f64> {
        let joint = self.model.joint(joint).expect("a joint");
        self.motions.iter().map(|m| m.angles[joint.0]).collect()
    }

    fn changed(mut self, change: impl Fn(usize, Point3<f64>) -> Point3<f64>) -> Self {
        for (i, frame) in self.frames.iter_mut().enumerate() {
            for point in frame.iter_mut().flatten() {
                *point = change(i, *point);
            }
        }
        self
    }

    /// The same with the room moving backwards as fast as the body moves on.
    pub(crate) fn on_a_treadmill(&self) -> Self {
        let speed = self.stride_length() / STRIDE_S;
        let along = Vector3::new(self.heading.cos(), self.heading.sin(), 0.0) * speed;
        self.clone().changed(|i, p| p - along * (i as f64 / RATE_HZ))
    }

    /// The film run backwards.
    pub(crate) fn reversed(mut self) -> Self {
        self.frames.reverse();
        self
    }

    pub(crate) fn scaled(&self, factor: f64) -> Self {
        self.clone().changed(|_, p| p * factor)
    }

    pub(crate) fn moved(&self, by: Vector3<f64>) -> Self {
        self.clone().changed(|_, p| p + by)
    }

    pub(crate) fn keep(&mut self, range: Range<usize>) {
        self.frames = self.frames[range].to_vec();
    }

    /// The same person who leaves, is not seen for some frames, comes back elsewhere and walks as far again.
    pub(crate) fn who_returns(&self, unseen: usize, elsewhere: Vector3<f64>) -> Self {
        let mut walker = self.clone();
        let nobody = vec![None; self.names.len()];
        walker.frames.extend(std::iter::repeat_n(nobody, unseen));
        walker.frames.extend(self.moved(elsewhere).frames);
        walker
    }

    /// The same person whom the cameras lose: from some frame on all places are elsewhere.
    pub(crate) fn lost_from(&self, frame: usize, elsewhere: Vector3<f64>) -> Self {
        self.clone().changed(|i, p| if i < frame { p } else { p + elsewhere })
    }

    /// The legs are not known in these frames.
    pub(crate) fn forget(&mut self, range: Range<usize>) {
        for frame in &mut self.frames[range] {
            frame.fill(None);
        }
    }

    pub(crate) fn rename(&mut self, from: &str, to: &str) {
        for name in self.names.iter_mut().filter(|n| *n == from) {
            *name = to.to_owned();
        }
    }

    /// The text of a TRC, metres.
    pub(crate) fn trc(&self) -> String {
        let trajectories = Trajectories {
            rate_hz: RATE_HZ,
            first_frame: 0,
            names: self.names.clone(),
            frames: self.frames.clone(),
        };
        write_trc(&trajectories, "walk.trc")
    }
}
