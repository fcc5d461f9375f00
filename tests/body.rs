//! The laws of kinematics, on every shipped model, in ordinary, near-singular and random regimes.

use std::path::Path;

use maquette::body::{BodyModel, Layout, Motion, Posed, Shape, State, check_kinematics};
use maquette::io::model;
use nalgebra::DVector;
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

fn shipped() -> Vec<BodyModel> {
    let load = |(name, _): &(&str, &str)| {
        model::load(name, Path::new("")).expect("shipped models are right")
    };
    model::SHIPPED.iter().map(load).collect()
}

fn at_rest(model: &BodyModel) -> State {
    State {
        motion: Motion::rest(model),
        shape: Shape(model.statistics.mean.clone()),
    }
}

#[test]
fn derivatives_are_those_of_the_positions_at_rest() {
    for model in shipped() {
        check_kinematics(&model, &at_rest(&model), 1e-9).unwrap();
    }
}

#[test]
fn derivatives_hold_at_angles_of_a_hundred_millionth() {
    for model in shipped() {
        let layout = Layout::of(&model);
        let state = layout.retract(
            &at_rest(&model),
            &DVector::from_element(layout.total(), 1e-8),
        );
        check_kinematics(&model, &state, 1e-9).unwrap();
    }
}

#[test]
fn derivatives_hold_in_random_poses_and_shapes() {
    let mut rng = ChaCha8Rng::seed_from_u64(20);
    for model in shipped() {
        let layout = Layout::of(&model);
        for _ in 0..5 {
            let delta = DVector::from_fn(layout.total(), |_, _| rng.random_range(-1.0..1.0));
            check_kinematics(&model, &layout.retract(&at_rest(&model), &delta), 1e-8).unwrap();
        }
    }
}

#[test]
fn the_motion_difference_undoes_the_retraction() {
    let mut rng = ChaCha8Rng::seed_from_u64(21);
    for model in shipped() {
        let layout = Layout::of(&model);
        let from = Motion::rest(&model);
        let delta = DVector::from_fn(layout.motion(), |_, _| rng.random_range(-0.5..0.5));
        let back = layout.motion_difference(&from, &layout.retract_motion(&from, &delta));
        approx::assert_relative_eq!(back, delta, epsilon = 1e-12);
    }
}

#[test]
fn a_knees_angle_is_in_doubt_as_the_centres_of_hip_knee_and_ankle_are() {
    let model = model::load("human-ellipsoids", Path::new("")).unwrap();
    let shape = Shape(model.statistics.mean.clone());
    let mut motion = Motion::rest(&model);
    motion.angles.fill(0.0);
    let body = Posed::new(&model, &shape, &motion);
    let place = |name: &str| body.points()[model.point(name).unwrap()];
    let (hip, knee, ankle) = (place("RHip"), place("RKnee"), place("RAnkle"));
    let (thigh, shank) = ((knee - hip).norm(), (ankle - knee).norm());
    let forward = |name: &str| model.points[model.point(name).unwrap()].sd_m.x;
    // a straight leg: the knee's centre turns both bones, the same way
    let expected = (forward("RHip") / thigh).powi(2)
        + (forward("RKnee") * (1.0 / thigh + 1.0 / shank)).powi(2)
        + (forward("RAnkle") / shank).powi(2);
    let found = body.angle_spread()[model.joint("knee_flexion_r").unwrap().0];
    approx::assert_relative_eq!(found, expected, max_relative = 1e-3);
    // what no centre tells
    let neck = model.joint("thorax_rotation").unwrap();
    approx::assert_abs_diff_eq!(body.angle_spread()[neck.0], 0.0);
}
