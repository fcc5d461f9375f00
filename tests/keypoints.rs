//! Detections of joints as evidence: the law of the term, exchanged sides, and what a detector means by a joint.

use std::path::Path;

use maquette::body::{BodyModel, Layout, Motion, Posed, Shape, State};
use maquette::camera::{Camera, CameraId, Rig};
use maquette::inference::frame::KeyframePosterior;
use maquette::inference::prior::{PosePrior, ShapePrior};
use maquette::io::model;
use maquette::likelihood::{KeypointOptions, KeypointView, Keypoints, Term};
use maquette::silhouette::{Detection, Keypoint};
use maquette::solver::{Options, check_linearization, levenberg_marquardt};
use maquette::synth::Ring;
use nalgebra::{DVector, Rotation3, Vector2, Vector3};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

const NAMES: [&str; 14] = [
    "RHip",
    "LHip",
    "RKnee",
    "LKnee",
    "RAnkle",
    "LAnkle",
    "RBigToe",
    "LBigToe",
    "RShoulder",
    "LShoulder",
    "RElbow",
    "LElbow",
    "Neck",
    "Head",
];

/// A person before cameras, of whom keypoints alone are seen.
struct Scene {
    model: BodyModel,
    rig: Rig,
    truth: State,
}

impl Scene {
    fn new() -> Self {
        let plain = model::load("human-ellipsoids", Path::new("")).expect("a shipped model");
        let model = plain.detailed().with_keypoints(&NAMES);
        let mut motion = Motion::rest(&model);
        motion.position_world = Vector3::new(0.1, -0.2, 0.95);
        motion.world_from_root = Rotation3::from_scaled_axis(Vector3::new(0.05, -0.02, 0.6));
        let swing = |(i, angle): (usize, &mut f64)| *angle += 0.2 * (1.7 * i as f64).sin();
        motion.angles.iter_mut().enumerate().for_each(swing);
        let shape = Shape(model.statistics.mean.clone());
        let rig = Ring { cameras: 3, ..Ring::default() }.regular();
        Self { model, rig, truth: State { motion, shape } }
    }

    /// What detectors see of a body whose keypoints lie where `names` say, each `noise_px` off.
    fn seen(
        &self,
        body: &Posed<'_>,
        names: &dyn Fn(usize, &'static str) -> &'static str,
        noise_px: f64,
    ) -> Vec<(CameraId, Detection)> {
        let mut rng = ChaCha8Rng::seed_from_u64(7);
        let of_camera = |(id, camera): (CameraId, &Camera)| {
            let keypoint = |name: &'static str| {
                let shown = names(id.0, name);
                let point = self.model.keypoints.iter().find(|k| k.name == shown)?;
                let pixel = camera.project_undistorted(&body.named_point(point))?;
                let noise = Vector2::from_fn(|_, _| noise_px * rng.random_range(-1.0..1.0));
                Some(Keypoint { name, pixel: pixel + noise, confidence: 0.9 })
            };
            let keypoints = NAMES.iter().copied().filter_map(keypoint).collect();
            (id, Detection { keypoints, size_px: 80.0 })
        };
        self.rig.iter().map(of_camera).collect()
    }

    fn terms(&self, seen: &[(CameraId, Detection)]) -> Vec<Box<dyn Term>> {
        let view = |(id, detection): &(CameraId, Detection)| {
            KeypointView::new(&self.model, &self.rig.cameras[id.0], detection, 4.6)
        };
        vec![Box::new(Keypoints::new(seen.iter().map(view).collect(), KeypointOptions::default()))]
    }

    fn truth(&self) -> Posed<'_> {
        Posed::new(&self.model, &self.truth.shape, &self.truth.motion)
    }

    fn moved(&self, size: f64, seed: u64) -> State {
        let mut rng = ChaCha8Rng::seed_from_u64(seed);
        let layout = Layout::new(&self.model);
        let delta = DVector::from_fn(layout.total(), |_, _| size * rng.random_range(-1.0..1.0));
        layout.retract(&self.truth, &delta)
    }

    fn problem<T>(
        &self,
        terms: &[Box<dyn Term>],
        of: impl FnOnce(&KeyframePosterior<'_>) -> T,
    ) -> T {
        let (shape_prior, pose_prior) = (ShapePrior::new(&self.model), PosePrior::new(&self.model));
        let (shape_prior, pose_prior) = (&shape_prior, &pose_prior);
        of(&KeyframePosterior { model: &self.model, shape_prior, pose_prior, terms })
    }
}

fn as_they_are(_: usize, name: &'static str) -> &'static str {
    name
}

/// The first camera's detector takes each leg for the other.
fn legs_exchanged(camera: usize, name: &'static str) -> &'static str {
    let is_leg = ["Hip", "Knee", "Ankle", "BigToe"].iter().any(|leg| name.ends_with(leg));
    let twin = NAMES.iter().find(|other| other[1..] == name[1..] && **other != name);
    if camera == 0 && is_leg { twin.copied().unwrap_or(name) } else { name }
}

#[test]
fn the_law_holds_at_the_truth_away_from_it_and_where_sides_are_exchanged() {
    let scene = Scene::new();
    for (what, names) in [
        ("as given", &as_they_are as &dyn Fn(usize, &'static str) -> &'static str),
        ("exchanged", &legs_exchanged),
    ] {
        let terms = scene.terms(&scene.seen(&scene.truth(), names, 2.0));
        let mut straight = scene.truth.clone();
        straight.motion.angles.fill(1e-8);
        for (regime, state) in [
            ("truth", scene.truth.clone()),
            ("moved", scene.moved(0.05, 1)),
            ("far", scene.moved(0.4, 2)),
            ("straight", straight),
        ] {
            scene.problem(&terms, |problem| {
                check_linearization(problem, &state, 1e-6, 1e-4)
                    .unwrap_or_else(|fault| panic!("{what}, {regime}: {fault}"));
            });
        }
    }
}

#[test]
fn keypoints_of_the_body_itself_cost_next_to_nothing() {
    let scene = Scene::new();
    let terms = scene.terms(&scene.seen(&scene.truth(), &as_they_are, 0.0));
    let (views, groups) = (3.0, 2.0);
    approx::assert_relative_eq!(
        terms[0].cost(&scene.truth()),
        -views * groups * 0.99_f64.ln(),
        max_relative = 1e-3
    );
    approx::assert_relative_eq!(terms[0].observations(), 2.0 * 3.0 * NAMES.len() as f64);
}

#[test]
fn one_picture_with_exchanged_legs_does_not_cross_the_legs() {
    let scene = Scene::new();
    let knees = |state: &State| {
        let body = Posed::new(&scene.model, &state.shape, &state.motion);
        ["RKnee", "LKnee"].map(|name| body.points()[scene.model.point(name).unwrap()])
    };
    let fitted = |options: KeypointOptions| {
        let seen = scene.seen(&scene.truth(), &legs_exchanged, 0.5);
        let view = |(id, detection): &(CameraId, Detection)| {
            KeypointView::new(&scene.model, &scene.rig.cameras[id.0], detection, 4.6)
        };
        let views = seen.iter().map(view).collect();
        let terms: Vec<Box<dyn Term>> = vec![Box::new(Keypoints::new(views, options))];
        scene.problem(&terms, |problem| {
            levenberg_marquardt(problem, scene.moved(0.02, 3), &Options::default()).state
        })
    };
    let off = |state: &State| {
        let pairs = knees(state).into_iter().zip(knees(&scene.truth));
        pairs.map(|(a, b)| (a - b).norm()).fold(0.0, f64::max)
    };
    let aware = off(&fitted(KeypointOptions::default()));
    let unaware = off(&fitted(KeypointOptions { exchanged: 1e-300, ..KeypointOptions::default() }));
    assert!(aware < 0.02 && aware < 0.5 * unaware, "{aware} {unaware}");
}
