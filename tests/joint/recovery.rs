//! Truth in, estimate out.

use maquette::inference::SequenceState;
use maquette::inference::joint::{JointOptimum, JointOptions, Rounds, joint_optimum};
use maquette::inference::step::MotionModel;
use maquette::likelihood::Measure;

use crate::scene::Scene;

fn start(scene: &Scene, size: f64) -> SequenceState {
    let mut start = scene.moved(&scene.truth, size, 60);
    start.shape.0.copy_from(&scene.model.statistics.mean);
    start
}

fn fitted(scene: &Scene, measure: Measure, size: f64) -> (f64, JointOptimum) {
    let start = start(scene, size);
    let before = scene.error_mm(&start.shape, &start.motions);
    let evidence = scene.evidence(measure);
    let options = JointOptions::default();
    (before, joint_optimum(&evidence, scene.sequence(), start, &options))
}

fn after(scene: &Scene, joint: &JointOptimum) -> f64 {
    let motions: Vec<_> = joint.frames.iter().map(|f| f.motion.clone()).collect();
    scene.error_mm(&joint.shape, &motions)
}

fn never_rises(joint: &JointOptimum) {
    let costs = &joint.report.costs;
    assert!(costs.is_sorted_by(|a, b| a >= b), "{costs:?}");
}

#[test]
fn an_arm_is_found_from_lines_of_sight_and_points() {
    let scene = Scene::arm(8);
    let (before, joint) = fitted(&scene, Measure::Metaballs, 0.15);
    let after = after(&scene, &joint);
    assert!(before > 20.0 && after < 4.0, "{before} {after} mm");
    never_rises(&joint);
    // the lengths, which the prior has three hundredths off
    for k in [0, 1] {
        let off = joint.shape.0[k] - scene.truth.shape.0[k];
        assert!(off.abs() < 0.015, "{k}: {off}");
    }
}

#[test]
fn an_arm_is_found_by_its_ellipsoids() {
    let scene = Scene::arm(8);
    let (before, joint) = fitted(&scene, Measure::Ellipses, 0.15);
    let after = after(&scene, &joint);
    assert!(before > 20.0 && after < 10.0, "{before} {after} mm");
    never_rises(&joint);
}

#[test]
fn a_walking_person_is_found() {
    let scene = Scene::person("walker-metaballs", 6);
    let (before, joint) = fitted(&scene, Measure::Metaballs, 0.06);
    let after = after(&scene, &joint);
    assert!(before > 40.0 && after < 10.0, "{before} {after} mm");
    never_rises(&joint);
}

#[test]
fn every_standard_deviation_is_finite_and_the_truth_lies_within_a_few() {
    let scene = Scene::arm(8);
    let (_, joint) = fitted(&scene, Measure::Metaballs, 0.05);
    let uncertainty = joint.uncertainty.expect("the prior holds everything");
    assert_eq!(uncertainty.frames.len(), 8);
    let mut far = 0;
    for (i, frame) in uncertainty.frames.iter().enumerate() {
        for (k, sd) in frame.angles_sd.iter().enumerate() {
            assert!(sd.is_finite() && *sd > 0.0, "frame {i}, angle {k}: {sd}");
            let off = joint.frames[i].motion.angles[k] - scene.truth.motions[i].angles[k];
            far += usize::from(off.abs() > 3.0 * sd);
        }
        assert!(frame.points.iter().all(|c| c.iter().all(|v| v.is_finite())));
    }
    // 32 angles that err together: one in twenty may be beyond three
    assert!(far <= 2, "{far}");
}

#[test]
fn the_optimum_is_the_same_bit_by_bit_with_one_and_two_threads() {
    let scene = Scene::arm(12);
    let with = |threads| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build();
        pool.expect("threads are there").install(|| fitted(&scene, Measure::Both, 0.1).1)
    };
    let (one, two) = (with(1), with(2));
    assert_eq!(one.shape, two.shape);
    assert_eq!(one.frames, two.frames);
    assert_eq!(one.noise, two.noise);
    assert_eq!(one.uncertainty, two.uncertainty);
}

#[test]
fn both_motion_models_find_it_and_not_the_same_way() {
    let scene = Scene::arm(6);
    let with = |motion_model| {
        let options = JointOptions { motion_model, ..JointOptions::default() };
        let evidence = scene.evidence(Measure::Metaballs);
        joint_optimum(&evidence, scene.sequence(), start(&scene, 0.1), &options)
    };
    let [position, velocity] =
        [MotionModel::ConstantPosition, MotionModel::ConstantVelocity].map(with);
    assert!(after(&scene, &position) < 5.0 && after(&scene, &velocity) < 5.0);
    assert_ne!(position.frames, velocity.frames);
}

#[test]
fn an_optimum_before_a_part_of_the_border_leads_to_that_before_all() {
    let scene = Scene::arm(8);
    let evidence = scene.evidence(Measure::Metaballs);
    let optimum = |start, rounds| {
        let options = JointOptions { rounds, ..JointOptions::default() };
        joint_optimum(&evidence, scene.sequence(), start, &options)
    };
    let at_once = optimum(start(&scene, 0.1), Rounds::All);
    let thinned = optimum(start(&scene, 0.1), Rounds::Thinned);
    let later = optimum(thinned.state(), Rounds::FromThinned);

    // a part of the border is another optimum; from there the way leads to the same
    let known = at_once.uncertainty.as_ref().expect("the matrix is regular");
    let sd = known.shape.covariance.diagonal().map(f64::sqrt);
    let apart =
        |other: &JointOptimum| (&other.shape.0 - &at_once.shape.0).component_div(&sd).amax();
    let (apart_later, apart_thinned) = (apart(&later), apart(&thinned));
    assert!(
        apart_later < 0.5 && apart_thinned > 2.0 * apart_later,
        "{apart_later} {apart_thinned}"
    );
}
