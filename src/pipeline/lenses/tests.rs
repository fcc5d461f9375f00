use std::path::Path;

use nalgebra::{Point2, Vector3};
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, StandardNormal};

use super::*;
use crate::camera::CameraId;
#[cfg(test)]
use crate::io::model;
use crate::silhouette::{FrameIndex, Keypoint};
use crate::solver::check_linearization;
use crate::synth::{Recipe, Ring, Synthetic};

const NAMES: [&str; 15] = [
    "RHip",
    "RKnee",
    "RAnkle",
    "LHip",
    "LKnee",
    "LAnkle",
    "RShoulder",
    "RElbow",
    "RWrist",
    "LShoulder",
    "LElbow",
    "LWrist",
    "Neck",
    "RBigToe",
    "LBigToe",
];
const FPS: f64 = 10.0;
const NOISE_PX: f64 = 2.0;

fn person() -> BodyModel {
    model::load("walker-metaballs", Path::new("")).unwrap()
}

fn walker(frames: usize) -> Synthetic {
    let ring = Ring { cameras: 5, ..Ring::default() };
    let recipe = Recipe { frames: Some(frames), fps: FPS, ring, seed: 3, ..Recipe::default() };
    recipe.walker(&person()).unwrap()
}

/// What detectors see of the walker; of `shown` gives which moment each camera shows of a frame.
fn seen(walk: &Synthetic, shown: impl Fn(usize, CameraId) -> Option<usize>) -> Vec<FramePeople> {
    let mut rng = ChaCha8Rng::seed_from_u64(1);
    let mut noise = || -> f64 { NOISE_PX * Distribution::<f64>::sample(&StandardNormal, &mut rng) };
    let mut frame = |i: usize| {
        let mut pictures = Vec::new();
        for (id, camera) in walk.rig.iter() {
            let Some(points) = shown(i, id).and_then(|i| walk.points(FrameIndex(i))) else {
                continue;
            };
            let mut keypoint = |name: &&'static str| {
                let at = points[walk.model.point(name)?];
                let pixel = camera.project_undistorted(&at)?;
                let pixel = Point2::new(pixel.x + noise(), pixel.y + noise());
                Some(Keypoint { name, pixel, confidence: 0.9 })
            };
            let keypoints: Vec<Keypoint> = NAMES.iter().filter_map(&mut keypoint).collect();
            pictures.push((id, vec![keypoints]));
        }
        FramePeople { frame: FrameIndex(i), pictures }
    };
    (0..walk.frames()).map(&mut frame).collect()
}

fn lenses(walk: &Synthetic) -> Rig {
    let mut rig = walk.rig.clone();
    rig.cameras.iter_mut().for_each(|camera| camera.camera_from_world = Rigid3::identity());
    rig
}

fn placed(walk: &Synthetic, frames: &[FramePeople]) -> Result<PlacedRig, LensError> {
    let height_m = Some(stature_m(&walk.model, &walk.shape));
    placed_rig(&lenses(walk), frames, Walker { model: &walk.model, height_m, fps: FPS })
}

/// By how many times the cameras' distances are too large on the mean.
fn scale(found: &Rig, truth: &Rig) -> f64 {
    let sum = |rig: &Rig| -> f64 {
        let centres = rig.cameras.iter().map(|camera| camera.centre_world());
        let centres: Vec<Point3<f64>> = centres.collect();
        centres.iter().flat_map(|a| centres.iter().map(move |b| (a - b).norm())).sum()
    };
    sum(found) / sum(truth)
}

/// By how much pairs of cameras are turned against each other and their distances are wrong, at most, scale apart: degrees and metres.
fn off(found: &Rig, truth: &Rig) -> (f64, f64) {
    let scale = scale(found, truth);
    let (mut turned, mut displaced) = (0.0_f64, 0.0_f64);
    for b in 0..truth.cameras.len() {
        for a in 0..b {
            let turn = |rig: &Rig| {
                let [a, b] = [a, b].map(|i| rig.cameras[i].camera_from_world.rotation);
                b * a.inverse()
            };
            let way =
                |rig: &Rig| (rig.cameras[a].centre_world() - rig.cameras[b].centre_world()).norm();
            turned = turned.max(turn(found).angle_to(&turn(truth)).to_degrees());
            displaced = displaced.max((way(found) / scale - way(truth)).abs());
        }
    }
    (turned, displaced)
}

#[test]
fn the_gradient_of_the_bundle_is_that_of_its_cost() {
    let walk = walker(4);
    let sights = Sights::new(&walk.rig, &seen(&walk, |i, _| Some(i)));
    let poses = walk.rig.cameras.iter().map(|camera| {
        let moved = Rigid3::new(Vector3::new(0.03, -0.02, 0.05), Vector3::new(0.01, 0.02, -0.01));
        Some(moved * camera.camera_from_world)
    });
    let placed = Placed::new(&sights, poses.collect());
    bundle::check(&sights, &placed, |bundle, state| {
        check_linearization(bundle, state, 1e-4, 1e-5).unwrap();
    });
}

#[test]
fn cameras_are_placed_by_a_walker_whose_height_is_known_upright_and_on_the_floor() {
    let walk = walker(40);
    let found = placed(&walk, &seen(&walk, |i, _| Some(i))).unwrap();
    let (turned_deg, displaced_m) = off(&found.rig, &walk.rig);
    assert!(turned_deg < 0.5 && displaced_m < 0.04, "{turned_deg}° {displaced_m} m");
    let scale = scale(&found.rig, &walk.rig);
    assert!((scale - 1.0).abs() < 0.03, "{scale}");
    assert!((0.1..1.0).contains(&found.spread), "{}", found.spread);

    // up and the floor, by what both rigs have of one camera
    let both = found.rig.cameras.iter().zip(&walk.rig.cameras);
    for (a, b) in both {
        let up = |camera: &crate::camera::Camera| camera.camera_from_world.rotation * Vector3::z();
        let tilt_deg = up(a).angle(&up(b)).to_degrees();
        let raised_m = a.centre_world().z - b.centre_world().z;
        assert!(tilt_deg < 2.5 && raised_m.abs() < 0.12, "{tilt_deg}° {raised_m} m");
    }
}

#[test]
fn what_the_motion_does_not_tell_is_refused_in_words() {
    let walk = walker(30);
    // one camera sees the person when the others do not
    let apart = |i: usize, id: CameraId| ((i < 10) == (id.0 == 2)).then_some(i);
    let fault = placed(&walk, &seen(&walk, apart)).unwrap_err();
    assert!(fault.to_string().starts_with(&walk.rig.cameras[2].name), "{fault}");
    let never = |i: usize, id: CameraId| (i % 5 == id.0).then_some(i);
    let fault = placed(&walk, &seen(&walk, never)).unwrap_err();
    assert!(matches!(fault, LensError::NeverTogether { .. }), "{fault}");

    // somebody who stands still shows the same over and over again
    let still = |_: usize, _: CameraId| Some(0);
    let fault = placed(&walk, &still_errors(seen(&walk, still))).unwrap_err();
    assert!(matches!(fault, LensError::Undetermined { .. }), "{fault}");
}

/// The same errors in every frame, as a detector makes them of a person who stands.
fn still_errors(frames: Vec<FramePeople>) -> Vec<FramePeople> {
    let first = frames[0].clone();
    frames.iter().map(|f| FramePeople { frame: f.frame, ..first.clone() }).collect()
}
