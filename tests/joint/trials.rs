//! Trials that lie end to end in one chain: what they share, and that nothing else couples them.

use maquette::body::Layout;
use maquette::camera::Rig;
use maquette::inference::SequenceState;
use maquette::inference::camera_offset::CameraOffset;
use maquette::inference::camera_prior::{CameraPrior, Free};
use maquette::inference::chain::ChainPrior;
use maquette::inference::contrasts::Contrasts;
use maquette::inference::motion_prior::MotionPrior;
use maquette::inference::noise::DataWeights;
use maquette::inference::prior::ShapePrior;
use maquette::inference::sequence_posterior::SequencePosterior;
use maquette::inference::step::MotionModel;
use maquette::likelihood::Measure;
use maquette::solver::{BorderedChain, Problem, QuadraticModel, check_linearization};
use nalgebra::{UnitQuaternion, Vector3};

use crate::scene::{FPS, Scene};

/// Two trials of two frames.
const SECONDS: [f64; 4] = [0.02, 0.1, f64::INFINITY, 0.1];

#[test]
fn no_factor_of_the_motion_reaches_from_one_trial_to_the_next() {
    let scene = Scene::person("human-ellipsoids", 4);
    let chain = ChainPrior::new(&scene.model, MotionModel::ConstantVelocity);
    let motions = &scene.moved(&scene.truth, 0.2, 7).motions;
    let cost = |range: std::ops::Range<usize>| -> f64 {
        let (motions, seconds) = (&motions[range.clone()], &SECONDS[range.clone()]);
        (0..range.len()).map(|i| chain.cost(motions, seconds, i)).sum()
    };
    assert!(cost(0..2) > 0.0 && cost(2..4) > 0.0);
    approx::assert_relative_eq!(cost(0..4), cost(0..2) + cost(2..4), epsilon = 1e-12);

    let m = Layout::new(&scene.model).motion();
    let mut model = BorderedChain::zeros(4, m, 0, chain.reach());
    for i in 0..4 {
        chain.linearize(motions, &SECONDS, i, &mut model.links);
    }
    let largest = |i: usize, k: usize| model.links[i].couplings[k].amax();
    assert!(largest(1, 0) > 0.0 && largest(3, 0) > 0.0);
    for (i, k) in [(2, 0), (2, 1), (3, 1)] {
        assert!(largest(i, k) <= 0.0, "frame {i} is coupled to {}", i - k - 1);
    }
    assert!(model.gradient().iter().all(|g| g.is_finite()));
}

/// Cameras that are turned, displaced and zoomed alike in both trials, and ahead by a time of its own in each.
fn off(cameras: usize) -> Vec<CameraOffset> {
    let offset = |camera: usize| {
        let wave = |k: usize| (1.3 * k as f64 + 2.1 * (camera % (cameras / 2)) as f64).sin();
        CameraOffset {
            turn: UnitQuaternion::from_scaled_axis(Vector3::from_fn(|k, _| 0.02 * wave(k))),
            displacement_m: Vector3::from_fn(|k, _| 0.02 * wave(k + 3)),
            log_zoom: 0.01 * wave(7),
            ahead_s: 1.0 / FPS * (0.7 * camera as f64).sin(),
        }
    };
    (0..cameras).map(offset).collect()
}

/// The derivatives of what both trials share, a camera's pose and s, add up over both; each has its own clock.
#[test]
fn a_camera_of_two_trials_is_linearized_right_with_one_pose_and_two_clocks() {
    let scene = Scene::person("human-ellipsoids", 4);
    let cameras = scene.rig.cameras.len();
    let prior = CameraPrior::freeing(
        &Free::crossed(&scene.rig, scene.truth.motions.iter(), Free { pose: true, clock: true }),
        1.0 / FPS,
    );
    let terms = scene.evidence(Measure::Ellipses).sequence_terms(scene.sequence(), prior.clone());
    let mut looks = terms.thinned;
    for look in looks[2..].iter_mut().flatten() {
        look.camera = look.camera.map(|camera| camera + cameras);
    }
    let both = [(prior.clone(), cameras), (prior, cameras)];
    let camera_prior = CameraPrior::of_trials(&both, |camera| camera.checked_sub(cameras));
    let rig = Rig { cameras: [scene.rig.cameras.clone(), scene.rig.cameras.clone()].concat() };

    let looks: Vec<Vec<_>> = looks.iter().map(|frame| frame.iter().collect()).collect();
    let problem = SequencePosterior {
        model: &scene.model,
        rig: &rig,
        camera_prior: &camera_prior,
        shape_prior: &ShapePrior::new(&scene.model),
        motion_prior: &MotionPrior::new(&scene.model, MotionModel::ConstantVelocity),
        seconds: &SECONDS,
        looks: &looks,
        weights: DataWeights::all(0.4),
        contrasts: &Contrasts::none(4),
    };
    let layout = Layout::new(&scene.model);
    let shape = layout.total() - layout.motion();
    assert_eq!(problem.empty_model().corner.nrows(), shape + (7 + 2) * cameras);

    // a law is broken if it fails at three states a hair apart; between frames the body's turn counts to first order
    let fault = |seed: u64| {
        let moved = scene.moved(&scene.truth, 0.01, seed);
        let state = SequenceState { cameras: off(2 * cameras), ..moved };
        check_linearization(&problem, &state, 1e-6, 0.02).err()
    };
    let faults: Option<Vec<_>> = (60..63).map(fault).collect();
    assert!(faults.is_none(), "{}", faults.into_iter().flatten().next().expect("three"));
}
