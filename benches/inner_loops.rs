//! The two inner loops of a fit, seven cameras of 800 × 600: one linearisation, and one frame of a hypothesis.
//!
//! `cargo bench`; items per second are border points × ellipses, and hypothesis-frames.

#![allow(missing_docs, reason = "divan's macros make items without documentation")]

use std::path::Path;

use divan::counter::ItemsCount;
use maquette::body::metaball::{Field, FieldRow, FieldSample, FieldSlopes, Sampler};
use maquette::body::{BodyModel, Layout, Motion, Posed, Shape};
use maquette::camera::CameraId;
use maquette::inference::frame::FramePosterior;
use maquette::inference::hull;
use maquette::inference::start::{StartOptions, readings};
use maquette::inference::step::StepPrior;
use maquette::inference::{Detail, Evidence};
use maquette::io::model;
use maquette::likelihood::{
    EllipseOptions, PointField, PointOptions, RayOptions, RayView, SilhouetteRays, SkinScale,
    SurfacePoint, Term,
};
use maquette::silhouette::{FrameIndex, FrameObservations, SilhouetteOptions, extract};
use maquette::solver::{
    BorderedChain, NormalEquations, Options, QuadraticModel, levenberg_marquardt,
};
use maquette::synth::{Recipe, Ring, Synthetic};
use nalgebra::Vector3;

#[allow(clippy::print_stdout, reason = "a benchmark reports to the terminal")]
fn main() {
    let (peak, reached) = (multiply_add_peak(), field_rate());
    println!("one core, multiply and add from registers: {peak:.2} Gflop/s");
    println!(
        "field with all slopes: {reached:.2} Gflop/s, {:.0} % of that",
        100.0 * reached / peak
    );
    divan::main();
}

/// Least time of several runs, seconds.
fn fastest(mut run: impl FnMut()) -> f64 {
    let time = |_| {
        let start = std::time::Instant::now();
        run();
        start.elapsed().as_secs_f64()
    };
    (0..50).map(time).fold(f64::INFINITY, f64::min)
}

/// Gflop/s of x ← x·a + b in registers, for the instructions that this build may use.
fn multiply_add_peak() -> f64 {
    const LANES: usize = 24;
    const TURNS: usize = 100_000;
    let (a, b) = (divan::black_box(0.999_999), divan::black_box(1e-6));
    let seconds = fastest(|| {
        let mut x = [1.0_f64; LANES];
        for _ in 0..TURNS {
            x.iter_mut().for_each(|x| *x = *x * a + b);
        }
        divan::black_box(x);
    });
    (2 * LANES * TURNS) as f64 / seconds * 1e-9
}

/// Gflop/s of [`field_with_slopes`], counted from the source: 19 for each distance and 220 for each metaball that has
/// a say, an exponential as 20.
fn field_rate() -> f64 {
    let walker = Walker::new();
    let body = Posed::new(&walker.model, &walker.shape, &walker.motion);
    let field = Field::from_body(&body);
    let slopes = FieldSlopes::new(&body, &field);
    let touched = walker.rays.residuals(&body);
    let (mut sampler, mut sample) = (Sampler::new(&field), FieldSample::default());
    let mut row = FieldRow::default();
    let mut shares = 0;
    let seconds = fastest(|| {
        shares = 0;
        for r in &touched {
            sampler.sample(&r.place_world.coords, &mut sample);
            slopes.row(&sample, |_| 1.0, &Vector3::zeros(), &mut row);
            shares += sample.shares.len();
            divan::black_box(&row);
        }
    });
    (19 * walker.pairs.1 + 220 * shares) as f64 / seconds * 1e-9
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
        let ring = Ring { cameras: 7, width_px: 800, height_px: 600, ..Ring::default() };
        let recipe = Recipe { frames: Some(2), ring, ..Recipe::default() };
        let recording = recipe.walker(&load("walker-metaballs")).expect("a walk");
        let frames = (0..2).map(|i| observe(&recording, FrameIndex(i))).collect();
        Self { model: load("human-ellipsoids"), recording, frames }
    }

    fn evidence(&self) -> Evidence<'_> {
        Evidence::with_ellipses(&self.model, &self.recording.rig, EllipseOptions::default())
    }
}

fn observe(recording: &Synthetic, frame: FrameIndex) -> FrameObservations {
    let view = |(id, camera): (CameraId, _)| {
        let mask = recording.mask(frame, id).expect("the frame and the camera are there");
        Some((id, extract(&mask, camera, &SilhouetteOptions::default()).ok()?))
    };
    let views = recording.rig.iter().filter_map(view).collect();
    FrameObservations { views, ..FrameObservations::nothing(frame) }
}

/// JᵀWJ and JᵀWr of one frame's silhouettes, for the motion alone.
#[divan::bench]
fn frame_linearization(bencher: divan::Bencher<'_, '_>) {
    let scene = Scene::new();
    let evidence = scene.evidence();
    let terms = evidence.terms(&scene.frames[0], Detail::Fine);
    let term = terms.first().expect("ellipses are compared");
    let hull = hull::carve(&scene.recording.rig, &scene.frames[0]).expect("a body is seen");
    let shape = Shape(scene.model.statistics.mean.clone());
    let motion =
        Motion { position_world: hull.centroid_world.coords, ..Motion::rest(&scene.model) };
    let mut equations = NormalEquations::zeros(Layout::new(&scene.model).motion());
    let points = term.placed_residuals(&Posed::new(&scene.model, &shape, &motion));
    let items = points.len() * scene.model.ellipsoids.len();
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
    let options = Options { max_iterations: 5, damping: 1e-4, relative_decrease: 1e-4 };
    bencher
        .counter(ItemsCount::new(1_usize))
        .bench_local(|| levenberg_marquardt(&posterior, before.motion.clone(), &options).cost);
}

/// The metaball walker himself, his lines of sight and points of his skin.
struct Walker {
    model: BodyModel,
    shape: Shape,
    motion: Motion,
    rays: SilhouetteRays,
    points: PointField,
    /// Ray–metaball and point–metaball pairs.
    pairs: (usize, usize),
}

impl Walker {
    fn new() -> Self {
        let scene = Scene::new();
        let model = model::load("walker-metaballs", Path::new("")).expect("a shipped model");
        let (shape, scale) = (Shape(model.statistics.mean.clone()), SkinScale::new(&model));
        let hull = hull::carve(&scene.recording.rig, &scene.frames[0]).expect("a body is seen");
        let motion = Motion { position_world: hull.centroid_world.coords, ..Motion::rest(&model) };
        let views = scene.frames[0].views.iter().map(|(id, silhouette)| {
            let camera = scene.recording.rig.camera(*id).expect("the rig's own camera");
            RayView::new(camera, silhouette, 4.6, 0.02)
        });
        let rays = SilhouetteRays::new(views.collect(), RayOptions::default(), scale.clone());
        let touched = rays.residuals(&Posed::new(&model, &shape, &motion));
        let points = touched.iter().map(|r| SurfacePoint::isotropic(r.place_world, 0.002));
        let points = PointField::new(points.collect(), PointOptions::default(), scale);
        let balls = model.metaballs.len();
        let pairs = (rays.border_points() * balls, touched.len() * balls);
        Self { model, shape, motion, rays, points, pairs }
    }

    fn linearize(&self, bencher: divan::Bencher<'_, '_>, term: &dyn Term, pairs: usize) {
        let mut equations = NormalEquations::zeros(Layout::new(&self.model).total());
        bencher.counter(ItemsCount::new(pairs)).bench_local(|| {
            equations.clear();
            let body = Posed::new(&self.model, &self.shape, &self.motion);
            term.linearize(&body, &mut equations)
        });
    }
}

/// JᵀWJ and JᵀWr of one frame's lines of sight, shape and motion; items are ray–metaball pairs.
#[divan::bench]
fn ray_linearization(bencher: divan::Bencher<'_, '_>) {
    let walker = Walker::new();
    walker.linearize(bencher, &walker.rays, walker.pairs.0);
}

/// The cost of one frame's lines of sight alone.
#[divan::bench]
fn ray_cost(bencher: divan::Bencher<'_, '_>) {
    let walker = Walker::new();
    let items = ItemsCount::new(walker.pairs.0);
    bencher.counter(items).bench_local(|| {
        walker.rays.cost(&Posed::new(&walker.model, &walker.shape, &walker.motion))
    });
}

/// JᵀWJ and JᵀWr of as many points on the skin, shape and motion; items are point–metaball pairs.
#[divan::bench]
fn point_linearization(bencher: divan::Bencher<'_, '_>) {
    let walker = Walker::new();
    walker.linearize(bencher, &walker.points, walker.pairs.1);
}

/// F with ∇ and ∂/∂θ at points on the skin; items are point–metaball pairs.
#[divan::bench]
fn field_with_slopes(bencher: divan::Bencher<'_, '_>) {
    let walker = Walker::new();
    let body = Posed::new(&walker.model, &walker.shape, &walker.motion);
    let field = Field::from_body(&body);
    let slopes = FieldSlopes::new(&body, &field);
    let touched = walker.rays.residuals(&body);
    let (mut sampler, mut sample) = (Sampler::new(&field), FieldSample::default());
    let mut row = FieldRow::default();
    let items = ItemsCount::new(walker.pairs.1);
    bencher.counter(items).bench_local(|| {
        let mut sum = 0.0;
        for r in &touched {
            sampler.sample(&r.place_world.coords, &mut sample);
            slopes.row(&sample, |_| 1.0, &Vector3::zeros(), &mut row);
            sum += row.values.iter().sum::<f64>();
        }
        sum
    });
}

/// One step of the joint optimum: factor, forwards, backwards; a person's motions and shape, constant velocity.
/// Items are frames.
#[divan::bench(args = [200, 2000])]
fn joint_step(bencher: divan::Bencher<'_, '_>, frames: usize) {
    let chain = person_chain(frames);
    bencher.counter(ItemsCount::new(frames)).bench_local(|| chain.minimizer(1e-4));
}

/// The marginal covariances of every frame; items are frames.
#[divan::bench(args = [200, 2000])]
fn joint_marginals(bencher: divan::Bencher<'_, '_>, frames: usize) {
    let chain = person_chain(frames);
    bencher.counter(ItemsCount::new(frames)).bench_local(|| {
        chain.marginals(|_, marginal| {
            let _ = divan::black_box(marginal.frame[(0, 0)]);
        })
    });
}

/// A positive definite chain of the size of `human-metaballs`.
fn person_chain(frames: usize) -> BorderedChain {
    let model = model::load("human-metaballs", Path::new("")).expect("a shipped model");
    let layout = Layout::new(&model);
    let (m, p) = (layout.motion(), layout.total() - layout.motion());
    let mut chain = BorderedChain::zeros(frames, m, p, 2);
    for (i, link) in chain.links.iter_mut().enumerate() {
        link.diagonal.fill_with_identity();
        link.diagonal *= 10.0;
        let couplings = link.couplings.iter_mut();
        couplings.for_each(|c| *c = -nalgebra::DMatrix::identity(m, m));
        link.border.fill(1e-3);
        link.gradient.fill((i as f64).sin());
    }
    chain.corner.fill_with_identity();
    chain.corner *= frames as f64;
    chain.corner_gradient.fill(1.0);
    chain
}
