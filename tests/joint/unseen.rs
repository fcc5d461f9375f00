//! A part that nothing sees keeps its prior.

use maquette::body::Posed;
use maquette::body::metaball::Field;
use maquette::inference::joint::{JointOptimum, JointOptions, joint_optimum};
use maquette::inference::motion_prior::MotionPrior;
use maquette::likelihood::Measure;
use maquette::pipeline::prior_angles_sd;
use nalgebra::DVector;

use crate::scene::{FPS, Scene, surface};

const ELBOW: usize = 3;

/// An arm of which only points on the upper half of the upper arm are seen.
fn half_seen(frames: usize) -> Scene {
    let mut scene = Scene::arm(frames);
    for (frame, motion) in scene.frames.iter_mut().zip(&scene.truth.motions) {
        let body = Posed::new(&scene.model, &scene.truth.shape, motion);
        let upper = scene.model.parts.iter().position(|p| p.name == "upper_arm");
        let upper = maquette::body::PartId(upper.expect("an arm"));
        frame.views.clear();
        frame.points = surface(&Field::from_body(&body), 60, 7);
        frame.points.retain(|p| body.in_part(upper, &p.position_world).z > -0.05);
        assert!(frame.points.len() > 20);
    }
    scene
}

fn fitted(scene: &Scene) -> (JointOptimum, Vec<DVector<f64>>) {
    let options = JointOptions::default();
    let evidence = scene.evidence(Measure::Metaballs);
    let start = scene.moved(&scene.truth, 0.02, 61);
    let joint = joint_optimum(&evidence, scene.sequence(), start, &options);
    let motions: Vec<_> = joint.frames.iter().map(|f| f.motion.clone()).collect();
    let seconds = scene.sequence().intervals_s();
    let prior = prior_angles_sd(&scene.model, &joint.motion_prior, &motions, &seconds);
    (joint, prior.expect("priors hold every angle"))
}

#[test]
fn an_angle_that_nothing_sees_is_as_uncertain_as_its_prior() {
    let scene = half_seen(8);
    let (joint, prior) = fitted(&scene);
    let uncertainty = joint.uncertainty.expect("the priors hold it");
    for (frame, prior) in uncertainty.frames.iter().zip(&prior) {
        assert!(frame.angles_sd.iter().all(|sd| sd.is_finite()));
        // the points at the shoulder feel the forearm's metaballs by e⁻¹⁰
        approx::assert_relative_eq!(frame.angles_sd[ELBOW], prior[ELBOW], max_relative = 0.02);
        for seen in [0, 1] {
            assert!(frame.angles_sd[seen] < 0.5 * prior[seen], "{seen}");
        }
    }
}

/// Once more the priors, by another way: constant position alone is a tridiagonal matrix, one angle at a time.
#[test]
fn the_priors_alone_leave_what_a_tridiagonal_matrix_of_one_angle_leaves() {
    let scene = Scene::arm(5);
    let model = maquette::inference::step::MotionModel::ConstantPosition;
    let prior = MotionPrior::new(&scene.model, model);
    let seconds = scene.sequence().intervals_s();
    let found = prior_angles_sd(&scene.model, &prior, &scene.truth.motions, &seconds);
    let joint = &scene.model.joints[ELBOW];
    // p(m) whole, then for each frame vΔ/4S of it and θ̇²Δ/2Sv of its velocity
    let rest = joint.spread.powi(-2);
    let step = FPS / (2.0 * joint.spread * joint.speed);
    let mut precision = nalgebra::DMatrix::zeros(5, 5);
    precision[(0, 0)] = rest;
    for i in 1..5 {
        precision[(i, i)] = 0.25 * joint.speed / (FPS * joint.spread) * rest;
    }
    for i in 1..5 {
        precision[(i, i)] += step;
        precision[(i - 1, i - 1)] += step;
        precision[(i, i - 1)] -= step;
        precision[(i - 1, i)] -= step;
    }
    let covariance = precision.cholesky().expect("positive").inverse();
    for (i, found) in found.expect("priors hold every angle").iter().enumerate() {
        approx::assert_relative_eq!(found[ELBOW], covariance[(i, i)].sqrt(), max_relative = 1e-9);
    }
}

#[test]
fn a_coefficient_that_nothing_sees_keeps_its_prior_too() {
    let scene = half_seen(8);
    let (joint, _) = fitted(&scene);
    let covariance = joint.uncertainty.expect("the priors hold it").shape.covariance;
    let wrist = scene.model.coefficients.iter().position(|c| c == "wrist_width");
    let wrist = wrist.expect("the arm has one");
    let prior = scene.model.statistics.covariance[(wrist, wrist)].sqrt();
    let found = covariance[(wrist, wrist)].sqrt();
    // what its factors share with the upper arm, which is seen, is learnt
    assert!(found <= prior * 1.001 && found > 0.3 * prior, "{found} {prior}");
}

#[test]
fn frames_that_nothing_sees_are_less_certain_the_farther_they_are_from_those_that_are() {
    let mut scene = Scene::arm(9);
    for frame in &mut scene.frames[3..] {
        frame.views.clear();
        frame.points.clear();
    }
    let (joint, prior) = fitted(&scene);
    let uncertainty = joint.uncertainty.expect("the priors hold it");
    let elbow: Vec<f64> = uncertainty.frames.iter().map(|f| f.angles_sd[ELBOW]).collect();
    assert!(elbow[2..].is_sorted(), "{elbow:?}");
    assert!(elbow[8] > 3.0 * elbow[2], "{elbow:?}");
    assert!(elbow[8] <= prior[8][ELBOW] * 1.001, "{elbow:?}");
}
