//! The laws of kinematics, on every shipped model, in ordinary, near-singular and random regimes.

use std::path::Path;

use maquette::body::{BodyModel, Layout, Motion, Posed, Primitive, Shape, State, check_kinematics};
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

/// Components of the places of a body's joints, in the order of its coefficients.
fn places(model: &BodyModel) -> Vec<usize> {
    let first = Layout::new(model).motion();
    let names = model.coefficients.iter().enumerate();
    names.filter(|(_, name)| name.contains(" place ")).map(|(k, _)| first + k).collect()
}

/// What the places of a body's joints do to a point, a column for each: metres per standard deviation.
fn moved_by_places(model: &BodyModel, index: usize) -> DMatrix<f64> {
    let shape = Shape(model.statistics.mean.clone());
    let body = Posed::new(model, &shape, &Motion::straight(model));
    body.point_jacobian(index).select_columns(&places(model))
}

#[test]
fn flesh_turns_about_a_joint_that_lies_elsewhere_and_stays_at_the_other_end_of_the_bone() {
    let model = model::load("human-ellipsoids", Path::new("")).unwrap().detailed();
    let shape = Shape(model.statistics.mean.clone());
    let place = model.coefficients.iter().position(|c| c == "shank place forward").unwrap();
    let shank = model.parts.iter().position(|p| p.name == "shank_r").unwrap();
    let sd = model.parts[shank].sd_m.x;
    let body = Posed::new(&model, &shape, &Motion::straight(&model));
    let point = |name: &str| body.points()[model.point(name).unwrap()];
    let length = point("RKnee").z - point("RAnkle").z;
    let mut fleshy = 0;
    for ellipsoid in model.ellipsoids.iter().filter(|e| e.part.0 == shank) {
        let shift = ellipsoid.centre.shifts.iter().find(|s| s.coefficient.0 == place).unwrap();
        let down = -ellipsoid.centre.value.z / length;
        approx::assert_relative_eq!(shift.direction.x, -sd * (1.0 - down), max_relative = 0.05);
        fleshy += 1;
    }
    assert!(fleshy > 0);
}

#[test]
fn flesh_that_is_not_told_from_its_bones_has_no_places() {
    let model = model::load("arm", Path::new("")).unwrap();
    let detailed = model.detailed();
    assert!(places(&detailed).is_empty());
    // but for their homes in the mean arm, which has the factors 1
    let at_home = |ball: &Primitive| Primitive { home: ball.centre.value, ..ball.clone() };
    assert_eq!(detailed.metaballs, model.metaballs.iter().map(at_home).collect::<Vec<_>>());
    let offsets = detailed.offsets.as_ref().unwrap().count();
    assert_eq!(detailed.coefficients.len(), model.coefficients.len() + offsets);
}

#[test]
fn what_hips_leave_open_of_their_distance_is_their_sideways_doubt_twice() {
    let model = model::load("human-ellipsoids", Path::new("")).unwrap().detailed();
    let [right, left] = ["RHip", "LHip"].map(|name| model.point(name).unwrap());
    let thigh = model.parts.iter().position(|p| p.name == "thigh_r").unwrap();
    let sd = model.parts[thigh].sd_m;
    let [at_right, at_left] = [right, left].map(|index| moved_by_places(&model, index));
    let between = at_left - &at_right;
    approx::assert_relative_eq!(between.row(1).norm(), 2.0 * sd.y, epsilon = 1e-12);
    approx::assert_relative_eq!(between.row(0).norm(), 0.0, epsilon = 1e-12);
    approx::assert_relative_eq!(at_right.row(0).norm(), sd.x, epsilon = 1e-12);
}
