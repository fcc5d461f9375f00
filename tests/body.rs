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
}

#[test]
fn an_upper_arm_turns_about_itself_for_what_tilts_the_forearm_and_the_more_the_straighter_the_elbow_is()
 {
    let model = model::load("human-ellipsoids", Path::new("")).unwrap();
    let shape = Shape(model.statistics.mean.clone());
    let angle = |name: &str| model.joint(name).unwrap().0;
    let turn_sd = |elbow_deg: f64| {
        let mut motion = Motion::rest(&model);
        motion.angles.fill(0.0);
        motion.angles[angle("elbow_flexion_r")] = elbow_deg.to_radians();
        let body = Posed::new(&model, &shape, &motion);
        body.angle_spread()[angle("shoulder_rotation_r")].sqrt()
    };
    let sideways = |part: &str| {
        let part = model.parts.iter().find(|p| p.name == part).unwrap();
        part.sd_m.y
    };
    let body = Posed::new(&model, &shape, &Motion::rest(&model));
    let place = |name: &str| body.points()[model.point(name).unwrap()];
    let upper_arm = (place("RElbow") - place("RShoulder")).norm();
    let forearm = (place("RWrist") - place("RElbow")).norm();
    // a forearm's tilt to the side, beside what it has from the upper arm, over what a turn of that gives it
    let expected = |elbow_deg: f64| {
        let (sin, cos) = elbow_deg.to_radians().sin_cos();
        let elbow = sideways("forearm_r") * (1.0 / forearm + cos / upper_arm);
        let shoulder = sideways("upper_arm_r") * cos / upper_arm;
        let wrist = sideways("hand_r") / forearm;
        (elbow.powi(2) + shoulder.powi(2) + wrist.powi(2)).sqrt() / sin
    };
    for elbow_deg in [90.0, 60.0] {
        let found = turn_sd(elbow_deg);
        approx::assert_relative_eq!(found, expected(elbow_deg), max_relative = 0.05);
    }
    assert!(turn_sd(30.0) > 1.5 * turn_sd(60.0));
    assert!(turn_sd(0.0) < 4.0 * turn_sd(30.0), "it ends somewhere");
}

#[test]
fn bones_whose_ends_are_known_leave_no_angle_in_doubt() {
    let model = model::load("arm", Path::new("")).unwrap();
    let shape = Shape(model.statistics.mean.clone());
    let body = Posed::new(&model, &shape, &Motion::rest(&model));
    approx::assert_abs_diff_eq!(body.angle_spread().amax(), 0.0);
}

#[test]
fn what_hips_leave_open_of_their_distance_is_their_sideways_doubt_twice() {
    let model = model::load("human-ellipsoids", Path::new("")).unwrap();
    let shape = Shape(model.statistics.mean.clone());
    let body = Posed::new(&model, &shape, &Motion::rest(&model));
    let [right, left, knee] = ["RHip", "LHip", "RKnee"].map(|name| model.point(name).unwrap());
    let sd = model.points[right].sd_m;
    let between = body.way_spread(right, left);
    approx::assert_relative_eq!(between[(1, 1)], 4.0 * sd.y * sd.y, epsilon = 1e-12);
    approx::assert_relative_eq!(between[(0, 0)], 0.0, epsilon = 1e-12);
    let ends = body.point_spread(right) + body.point_spread(knee);
    approx::assert_relative_eq!(body.way_spread(right, knee), ends, epsilon = 1e-12);
}
