//! The laws of kinematics, on every shipped model, in ordinary, near-singular and random regimes.

use std::path::Path;

use maquette::body::{BodyModel, Layout, Motion, Shape, State, check_kinematics};
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
