//! The laws of kinematics, on every shipped model, in ordinary, near-singular and random regimes.

use std::path::Path;

use maquette::body::{
    BodyModel, Joint, Layout, Motion, PlacedBody, Posed, Shape, State, check_kinematics,
};
use maquette::io::model;
use nalgebra::{DMatrix, DVector};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

fn shipped() -> Vec<BodyModel> {
    let load = |(name, _): &(&str, &str)| {
        model::load(name, Path::new("")).expect("shipped models are right")
    };
    model::SHIPPED.iter().map(load).collect()
}

fn at_rest(model: &BodyModel) -> State {
    State { motion: Motion::rest(model), shape: Shape(model.statistics.mean.clone()) }
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
        let layout = Layout::new(&model);
        let state = layout.retract(&at_rest(&model), &DVector::from_element(layout.total(), 1e-8));
        check_kinematics(&model, &state, 1e-9).unwrap();
    }
}

#[test]
fn derivatives_hold_in_random_poses_and_shapes() {
    let mut rng = ChaCha8Rng::seed_from_u64(20);
    for model in shipped() {
        let layout = Layout::new(&model);
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
        let layout = Layout::new(&model);
        let from = Motion::rest(&model);
        let delta = DVector::from_fn(layout.motion(), |_, _| rng.random_range(-0.5..0.5));
        let back = layout.motion_difference(&from, &layout.retract_motion(&from, &delta));
        approx::assert_relative_eq!(back, delta, epsilon = 1e-12);
    }
}

/// What the places of a body's joints do to a point, a column for each: metres per standard deviation.
fn moved_by_places(model: &BodyModel, placed: &PlacedBody, index: usize) -> DMatrix<f64> {
    let shape = placed.shape(&Shape(model.statistics.mean.clone()));
    let mut motion = placed.motion(&Motion::rest(model));
    motion.angles.fill(0.0);
    let jacobian = Posed::new(&placed.model, &shape, &motion).point_jacobian(index);
    let first = jacobian.ncols() - placed.count();
    jacobian.columns(first, placed.count()).into_owned()
}

#[test]
fn a_thigh_turns_in_its_flesh_as_far_as_hip_and_knee_lie_elsewhere_over_its_length() {
    let model = model::load("human-ellipsoids", Path::new("")).unwrap();
    let shape = Shape(model.statistics.mean.clone());
    let placed = PlacedBody::new(&model, &shape);
    let body = Posed::new(&model, &shape, &Motion::rest(&model));
    let place = |name: &str| body.points()[model.point(name).unwrap()];
    let length = (place("RKnee") - place("RHip")).norm();
    let forward = |name: &str| model.points[model.point(name).unwrap()].sd_m.x;
    let expected = forward("RHip").hypot(forward("RKnee")) / length;
    // joints x, y, z that turn the flesh of the thigh; y across it
    let first = |joint: &Joint| joint.name.ends_with("of thigh_r");
    let first = placed.model.joints.iter().position(first).unwrap();
    let across = placed.turns.row(first + 1 - model.joints.len()).norm();
    approx::assert_relative_eq!(across, expected, max_relative = 1e-9);
}

#[test]
fn flesh_that_is_not_told_from_its_bones_has_no_places() {
    let model = model::load("arm", Path::new("")).unwrap();
    let placed = PlacedBody::new(&model, &Shape(model.statistics.mean.clone()));
    assert_eq!((placed.count(), placed.turns.nrows()), (0, 0));
    assert_eq!(placed.model, model);
}

#[test]
fn what_hips_leave_open_of_their_distance_is_their_sideways_doubt_twice() {
    let model = model::load("human-ellipsoids", Path::new("")).unwrap();
    let placed = PlacedBody::new(&model, &Shape(model.statistics.mean.clone()));
    let [right, left] = ["RHip", "LHip"].map(|name| model.point(name).unwrap());
    let sd = model.points[right].sd_m;
    let [at_right, at_left] = [right, left].map(|index| moved_by_places(&model, &placed, index));
    let between = at_left - &at_right;
    approx::assert_relative_eq!(between.row(1).norm(), 2.0 * sd.y, epsilon = 1e-12);
    approx::assert_relative_eq!(between.row(0).norm(), 0.0, epsilon = 1e-12);
    approx::assert_relative_eq!(at_right.row(0).norm(), sd.x, epsilon = 1e-12);
}
