//! The waving arm, and how a model is fitted to its clouds.

use std::f64::consts::TAU;

use experiments::limb::{ArmTruth, LimbFit, joints, surface_points};
use maquette::body::{BodyModel, Motion, Posed, Shape, State};
use maquette::camera::Rig;
use maquette::inference::frame::FramePosterior;
use maquette::inference::prior::{PosePrior, ShapePrior};
use maquette::inference::step::StepPrior;
use maquette::likelihood::{PointField, PointOptions, SkinScale, SurfacePoint, Term};
use maquette::solver::{Options, levenberg_marquardt};
use maquette::synth::StereoPair;
use nalgebra::{DVector, Point3, Rotation3, Vector3};
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, StandardNormal};
use rayon::prelude::*;

pub(crate) const FRAMES: usize = 50;
pub(crate) const FPS: f64 = 25.0;
/// Standard deviation of a tracked joint in each coordinate, metres.
const TRACKED_SD: f64 = 0.02;
/// Frames between two of those that the sizes are estimated from.
const KEYFRAME_EVERY: usize = 10;
const PAIR: StereoPair = StereoPair {
    baseline: 0.3,
    disparity_sd_px: 0.2,
    step_px: 5,
    steepest: 1.2,
    outliers: 0.02,
    outlier_range: 0.15,
};
/// No noise: where the skin is.
const TRUE: StereoPair = StereoPair { disparity_sd_px: 0.0, outliers: 0.0, ..PAIR };

/// One frame: what is true and what is seen.
pub(crate) struct ArmFrame {
    pub(crate) truth: ArmTruth,
    pub(crate) points: Vec<SurfacePoint>,
    /// Points of the same pixels on the skin itself.
    pub(crate) skin: Vec<SurfacePoint>,
}

/// Waves: the elbow bends between 25° and 105°, the upper arm swings by 30°.
pub(crate) fn sequence(arm: &BodyModel, rig: &Rig, seed: u64) -> Vec<ArmFrame> {
    let frame = |i: usize| {
        let phase = TAU * 0.8 * i as f64 / FPS;
        let mut motion = Motion::rest(arm);
        let swing = Vector3::new(0.5 * (phase + 1.0).sin(), -0.6, 0.3 * phase.cos());
        motion.world_from_root = Rotation3::from_scaled_axis(swing);
        motion.position_world = Vector3::new(0.0, 0.0, 1.35 + 0.02 * (2.0 * phase).sin());
        motion.angles[0] = 1.13 + 0.7 * phase.sin();
        let truth = ArmTruth { model: arm.clone(), motion, shape: Shape(DVector::zeros(0)) };
        let seen = |pair: &StereoPair| {
            let mut rng = ChaCha8Rng::seed_from_u64(seed);
            rng.set_stream(i as u64);
            let each = rig.cameras.iter();
            each.flat_map(|camera| surface_points(&truth, camera, pair, &mut rng)).collect()
        };
        ArmFrame { points: seen(&PAIR), skin: seen(&TRUE), truth }
    };
    (0..FRAMES).into_par_iter().map(frame).collect()
}

/// A shape for all frames and a motion for each.
pub(crate) struct Track {
    pub(crate) shape: Shape,
    pub(crate) motions: Vec<Motion>,
}

/// Sizes from the keyframes, then the motion of every frame, from `starts` or from the frame before.
pub(crate) fn fit(arm: &BodyModel, frames: &[ArmFrame], starts: &[Motion]) -> Track {
    let shape = shape_of(arm, frames, starts);
    let motions = follow(arm, &shape, frames, starts);
    Track { shape, motions }
}

/// Shoulder, elbow and wrist of each frame as tracked points of the surface give them: off by 2 cm in each coordinate.
pub(crate) fn tracked_joints(frames: &[ArmFrame], seed: u64) -> Vec<[Point3<f64>; 3]> {
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    rng.set_stream(1 << 20);
    let mut off = |p: Point3<f64>| {
        p + Vector3::from_fn(|_, _| {
            let drawn: f64 = StandardNormal.sample(&mut rng);
            TRACKED_SD * drawn
        })
    };
    frames.iter().map(|frame| joints(&frame.truth.posed()).map(&mut off)).collect()
}

/// Mean over the keyframes of argmax p(m, s | Z).
fn shape_of(arm: &BodyModel, frames: &[ArmFrame], motions: &[Motion]) -> Shape {
    let (prior, pose_prior) = (ShapePrior::new(arm), PosePrior::new(arm));
    let keyframes: Vec<usize> = (0..frames.len()).step_by(KEYFRAME_EVERY).collect();
    let each = keyframes.par_iter().map(|&i| {
        let terms = terms(arm, &frames[i]);
        let fit = LimbFit::new(arm, (&prior, &pose_prior), &terms);
        let start = State { motion: motions[i].clone(), shape: Shape(arm.statistics.mean.clone()) };
        fit.solve(start, 100).state.shape.0
    });
    let shapes: Vec<DVector<f64>> = each.collect();
    Shape(shapes.iter().sum::<DVector<f64>>() / shapes.len() as f64)
}

fn follow(arm: &BodyModel, shape: &Shape, frames: &[ArmFrame], starts: &[Motion]) -> Vec<Motion> {
    let (pose_prior, step) = (PosePrior::new(arm), StepPrior::new(arm, 1.0 / FPS));
    let mut motions: Vec<Motion> = Vec::new();
    for (frame, start) in frames.iter().zip(starts) {
        let terms = terms(arm, frame);
        let last = motions.last().cloned();
        let posterior = FramePosterior {
            model: arm,
            shape,
            pose_prior: &pose_prior,
            step: last.as_ref().map(|motion| (&step, motion)),
            terms: &terms,
        };
        let solve = |start: Motion| levenberg_marquardt(&posterior, start, &Options::default());
        let tracked = solve(start.clone());
        let followed = last.clone().map(solve).filter(|s| s.cost < tracked.cost);
        motions.push(followed.unwrap_or(tracked).state);
    }
    motions
}

fn terms<'a>(arm: &BodyModel, frame: &ArmFrame) -> Vec<Box<dyn Term + 'a>> {
    let options = PointOptions::default();
    let term = PointField::new(frame.points.clone(), options, SkinScale::new(arm));
    vec![Box::new(term)]
}

/// Mean distance of the true skin's points from a fitted skin, mm.
pub(crate) fn skin_off_mm(arm: &BodyModel, body: &Posed<'_>, frame: &ArmFrame) -> f64 {
    let term = PointField::new(frame.skin.clone(), PointOptions::default(), SkinScale::new(arm));
    let residuals = term.residuals(body);
    let sum: f64 = residuals.iter().map(|r| r.residual_m.abs()).sum();
    1000.0 * sum / residuals.len().max(1) as f64
}

/// The joints of a track in one frame.
pub(crate) fn joints_of(arm: &BodyModel, track: &Track, frame: usize) -> [Point3<f64>; 3] {
    joints(&Posed::new(arm, &track.shape, &track.motions[frame]))
}
