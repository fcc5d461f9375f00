//! The two inner loops of a fit, seven cameras of 800 × 600: one linearisation, and one frame of a hypothesis.
//!
//! `cargo bench`; items per second are border points × ellipses, and hypothesis-frames.

#![allow(
    missing_docs,
    reason = "divan's macros make items without documentation"
)]

use std::path::Path;

use divan::counter::ItemsCount;
use maquette::body::{BodyModel, Layout, Motion, Posed, Shape};
use maquette::camera::CameraId;
use maquette::inference::Evidence;
use maquette::inference::frame::FramePosterior;
use maquette::inference::hull;
use maquette::inference::prior::StepPrior;
use maquette::inference::start::{Detail, StartOptions, readings};
use maquette::io::model;
use maquette::likelihood::{EllipseOptions, Term};
use maquette::silhouette::{FrameIndex, FrameObservations, SilhouetteOptions, extract};
use maquette::solver::{NormalEquations, Options, levenberg_marquardt};
use maquette::synth::{Recipe, Ring, Synthetic};

fn main() {
    divan::main();
}

/// A synthetic walk before seven cameras, two of its frames, and the fit of the first.
struct Scene {
    model: BodyModel,
    recording: Synthetic,
    frames: Vec<FrameObservations>,
}

impl Scene {
    fn new() -> Self {
        let load = |name| model::load(name, Path::new("")).expect("a shipped model");
        let ring = Ring {
            cameras: 7,
            width_px: 800,
            height_px: 600,
            ..Ring::default()
        };
        let recipe = Recipe {
            frames: Some(2),
            ring,
            ..Recipe::default()
        };
        let recording = recipe.walker(&load("walker-metaballs")).expect("a walk");
        let frames = (0..2).map(|i| observe(&recording, FrameIndex(i))).collect();
        Self {
            model: load("human-ellipsoids"),
            recording,
            frames,
        }
    }

    fn evidence(&self) -> Evidence<'_> {
        Evidence::new(&self.model, &self.recording.rig, EllipseOptions::default())
    }
}

fn observe(recording: &Synthetic, frame: FrameIndex) -> FrameObservations {
    let view = |(id, camera): (CameraId, _)| {
        let mask = recording
            .mask(frame, id)
            .expect("the frame and the camera are there");
        Some((
            id,
            extract(&mask, camera, &SilhouetteOptions::default()).ok()?,
        ))
    };
    let views = recording.rig.iter().filter_map(view).collect();
    FrameObservations {
        views,
        ..FrameObservations::nothing(frame)
    }
}

/// JᵀWJ and JᵀWr of one frame's silhouettes, for the motion alone.
#[divan::bench]
fn frame_linearization(bencher: divan::Bencher<'_, '_>) {
    let scene = Scene::new();
    let evidence = scene.evidence();
    let term = evidence.silhouettes(&scene.frames[0], Detail::Fine);
    let hull = hull::carve(&scene.recording.rig, &scene.frames[0]).expect("a body is seen");
    let shape = Shape(scene.model.statistics.mean.clone());
    let motion = Motion {
        position_world: hull.centroid_world.coords,
        ..Motion::rest(&scene.model)
    };
    let mut equations = NormalEquations::zeros(Layout::of(&scene.model).motion());
    let items = term.border_points() * scene.model.ellipsoids.len();
    bencher.counter(ItemsCount::new(items)).bench_local(|| {
        equations.clear();
        term.linearize(&Posed::new(&scene.model, &shape, &motion), &mut equations)
    });
}

/// argmax p(m₁ | m₀, s, Z₁): one frame of one hypothesis, from the fit of the frame before.
#[divan::bench]
fn hypothesis_frame(bencher: divan::Bencher<'_, '_>) {
    let scene = Scene::new();
    let evidence = scene.evidence();
    let found = readings(&evidence, &scene.frames[0], &StartOptions::default());
    let before = &found.first().expect("a body is seen").state;
    let terms = evidence.terms(&scene.frames[1], Detail::Fine);
    let step = StepPrior::new(&scene.model, 1.0 / scene.recording.fps);
    let posterior = FramePosterior {
        model: &scene.model,
        shape: &before.shape,
        pose_prior: &evidence.pose_prior,
        step: Some((&step, &before.motion)),
        terms: &terms,
    };
    let options = Options {
        max_iterations: 5,
        damping: 1e-4,
        relative_decrease: 1e-4,
    };
    bencher
        .counter(ItemsCount::new(1_usize))
        .bench_local(|| levenberg_marquardt(&posterior, before.motion.clone(), &options).cost);
}
