//! `linearize` says what `cost` does, and H is the Gauss–Newton matrix.
//!
//! As in `tests/laws.rs` the likelihoods are smooth piece by piece: a law is broken if it fails at three states a hair
//! apart.

use std::fmt::Display;

use maquette::body::{BodyModel, Layout, Motion, PartId, Posed, Shape};
use maquette::inference::camera_offset::CameraOffset;
use maquette::inference::camera_prior::{CameraPrior, Free, PoseErrors};
use maquette::inference::chain::{ChainPrior, ROOT_ACCELERATION, ROOT_TURN_ACCELERATION, SWING_HZ};
use maquette::inference::contrasts::{Contrasts, Leverages};
use maquette::inference::motion_prior::MotionPrior;
use maquette::inference::noise::DataWeights;
use maquette::inference::prior::{PosePrior, ShapePrior};
use maquette::inference::sequence_posterior::SequencePosterior;
use maquette::inference::step::MotionModel;
use maquette::inference::{Detail, Kind, Look, SequenceState};
use maquette::likelihood::Measure;
use maquette::math::central_differences;
use maquette::solver::{BorderedChain, Problem, QuadraticModel, check_linearization};
use nalgebra::{DMatrix, DVector, Rotation3, UnitQuaternion, Vector3};

use crate::scene::{FPS, Scene};

const MODELS: [MotionModel; 2] = [MotionModel::ConstantPosition, MotionModel::ConstantVelocity];
/// Unequal, as where frames are missing; the first is not read.
const SECONDS: [f64; 4] = [0.02, 0.1, 0.3, 0.1];
const HAIR: f64 = 1e-5;

/// The sequence posterior of a scene with weights that are not 1.
struct Posterior<'a> {
    scene: &'a Scene,
    shape_prior: ShapePrior,
    motion_prior: MotionPrior,
    looks: Vec<Vec<Look<'a>>>,
    camera_prior: CameraPrior,
    contrasts: Contrasts,
}

impl<'a> Posterior<'a> {
    fn new(scene: &'a Scene, motion_model: MotionModel, measure: Measure) -> Self {
        let evidence = scene.evidence(measure);
        let look = |f| evidence.looks_of_all(f, Detail::Coarse);
        Self {
            shape_prior: ShapePrior::new(&scene.model),
            motion_prior: MotionPrior::new(&scene.model, motion_model).beside(0.8, &[1.0; 4]),
            looks: scene.frames.iter().map(look).collect(),
            camera_prior: CameraPrior::trusting(),
            contrasts: Contrasts::none(scene.frames.len()),
            scene,
        }
    }

    /// Before cameras whose places and clocks are unknown.
    fn before_unknown_cameras(scene: &'a Scene, measure: Measure) -> Self {
        let free = Free { pose: true, clock: true };
        let camera_prior = CameraPrior::freeing(
            &Free::crossed(&scene.rig, scene.truth.motions.iter(), free),
            1.0 / FPS,
        );
        let terms = scene.evidence(measure).sequence_terms(scene.sequence(), camera_prior);
        let (looks, camera_prior) = (terms.thinned, terms.camera_prior);
        Self { looks, camera_prior, ..Self::new(scene, MODELS[1], measure) }
    }

    /// Of the priors alone.
    fn blind(scene: &'a Scene, motion_model: MotionModel) -> Self {
        let mut blind = Self::new(scene, motion_model, Measure::Metaballs);
        blind.looks.iter_mut().for_each(Vec::clear);
        blind
    }

    fn looks(&self) -> Vec<Vec<&Look<'_>>> {
        self.looks.iter().map(|frame| frame.iter().collect()).collect()
    }

    fn problem<'b>(&'b self, looks: &'b [Vec<&'b Look<'b>>]) -> SequencePosterior<'b> {
        SequencePosterior {
            model: &self.scene.model,
            rig: &self.scene.rig,
            camera_prior: &self.camera_prior,
            shape_prior: &self.shape_prior,
            motion_prior: &self.motion_prior,
            seconds: &SECONDS[..self.looks.len()],
            looks,
            weights: DataWeights { outlines: 0.4, points: 0.3, keypoints: 0.7 },
            contrasts: &self.contrasts,
        }
    }
}

/// Every angle and turn 1e-8: knees and elbows at their singularity.
fn straight(state: &SequenceState) -> SequenceState {
    let mut state = state.clone();
    for motion in &mut state.motions {
        motion.world_from_root = Rotation3::from_scaled_axis(Vector3::repeat(1e-8));
        motion.angles.fill(1e-8);
    }
    state
}

/// A law is broken if it fails at three states.
fn is_kept_somewhere<F: Display>(what: &str, fault: impl Fn(u64) -> Option<F>) {
    let faults: Option<Vec<_>> = (60..63).map(fault).collect();
    if let Some(faults) = faults {
        panic!("{what}: {}", faults[0]);
    }
}

/// Checks the law in every regime with both motion models.
fn check(scene: &Scene, measure: Measure, (step, tolerance): (f64, f64)) {
    for motion_model in MODELS {
        let posterior = Posterior::new(scene, motion_model, measure);
        let looks = posterior.looks();
        for (regime, state) in [
            ("at the truth", scene.truth.clone()),
            ("straight", straight(&scene.truth)),
            ("ordinary", scene.moved(&scene.truth, 0.05, 40)),
            ("random", scene.moved(&scene.truth, 0.4, 41)),
        ] {
            let fault = |seed: Option<u64>| {
                let state = seed.map_or(state.clone(), |s| scene.moved(&state, HAIR, s));
                check_linearization(&posterior.problem(&looks), &state, step, tolerance).err()
            };
            let faults: Option<Vec<_>> =
                [None, Some(50), Some(51)].into_iter().map(fault).collect();
            if let Some(faults) = faults {
                panic!("{motion_model:?}, {regime}: {}", faults[0]);
            }
        }
    }
}

#[test]
fn the_sequence_posterior_is_linearized_right_for_a_free_root() {
    check(&Scene::person("human-metaballs", 3), Measure::Ellipses, (1e-6, 1e-4));
}

#[test]
fn the_sequence_posterior_is_linearized_right_for_a_fixed_root() {
    check(&Scene::arm(4), Measure::Metaballs, (1e-5, 1e-5));
}

/// With the joints elsewhere in the flesh, and a surface that may lie outside: all of its coefficients' derivatives where the
/// offsets themselves are 0. Where they are not, the place at which a line of sight touches an ellipsoid is held.
#[test]
fn the_sequence_posterior_is_linearized_right_for_a_detailed_body() {
    for (name, measure, tolerance) in [
        ("human-ellipsoids", Measure::Ellipses, 1e-4),
        ("human-metaballs", Measure::Metaballs, 1e-4),
    ] {
        let mut scene = Scene::person(name, 2);
        scene.model = scene.model.detailed();
        scene.truth = scene.truth.clone().detailed(&scene.model);
        let posterior = Posterior::new(&scene, MODELS[1], measure);
        let looks = posterior.looks();
        let fault = |seed: u64| {
            let mut state = scene.moved(&scene.truth, 0.03, seed);
            let offsets = scene.model.offsets.as_ref().expect("it is detailed");
            state.shape.0.rows_mut(offsets.first().0, offsets.count()).fill(0.0);
            check_linearization(&posterior.problem(&looks), &state, 1e-6, tolerance).err()
        };
        is_kept_somewhere(name, fault);
    }
}

/// A surface that lies up to a centimetre elsewhere: what the offset changes as its place slides over the part, and where parts
/// meet, is in the derivatives. What is left out is of second order: the summit of F and its slopes are taken where the surface is.
#[test]
fn the_sequence_posterior_is_linearized_right_where_the_surface_lies_outside() {
    let mut scene = Scene::person("human-metaballs", 2);
    scene.model = scene.model.detailed();
    scene.truth = scene.truth.clone().detailed(&scene.model);
    let posterior = Posterior::new(&scene, MODELS[1], Measure::Metaballs);
    let looks = posterior.looks();
    let fault = |seed: u64| {
        let mut state = scene.moved(&scene.truth, 0.03, seed);
        let offsets = scene.model.offsets.as_ref().expect("it is detailed");
        let mut outside = state.shape.0.rows_mut(offsets.first().0, offsets.count());
        outside.iter_mut().enumerate().for_each(|(k, b)| *b = 0.005 * (1.7 * k as f64).sin());
        check_linearization(&posterior.problem(&looks), &state, 1e-6, 0.02).err()
    };
    is_kept_somewhere("human-metaballs", fault);
}

/// Cameras side by side, whose differences at one place cost beyond what their lines of sight do.
#[test]
fn the_sequence_posterior_is_linearized_right_before_cameras_side_by_side() {
    let mut scene = Scene::side_by_side("human-metaballs", 2);
    scene.model = scene.model.detailed();
    scene.truth = scene.truth.clone().detailed(&scene.model);
    let mut posterior = Posterior::new(&scene, MODELS[1], Measure::Metaballs);
    let cost_of_lines = posterior.problem(&posterior.looks()).cost(&scene.truth);
    let looks = posterior.looks();
    posterior.contrasts =
        Contrasts::new(&scene.model, &looks, &scene.truth, &Leverages::new(), 0.0);
    let looks = posterior.looks();
    assert!(posterior.problem(&looks).cost(&scene.truth) > cost_of_lines + 10.0);

    let fault = |seed: u64| {
        let state = scene.moved(&scene.truth, 0.01, seed);
        check_linearization(&posterior.problem(&looks), &state, 1e-6, 0.02).err()
    };
    is_kept_somewhere("human-metaballs", fault);
}

/// Cameras that are turned, displaced, zoomed and ahead by up to two frames, each by its own amount.
fn off(cameras: usize) -> Vec<CameraOffset> {
    let offset = |camera: usize| {
        let wave = |k: usize| (1.3 * k as f64 + 2.1 * camera as f64).sin();
        CameraOffset {
            turn: UnitQuaternion::from_scaled_axis(Vector3::from_fn(|k, _| 0.02 * wave(k))),
            displacement_m: Vector3::from_fn(|k, _| 0.02 * wave(k + 3)),
            log_zoom: 0.02 * wave(7),
            ahead_s: 2.0 / FPS * wave(6),
        }
    };
    (0..cameras).map(offset).collect()
}

/// The place of a camera moves the body before it, its clock moves it along its way. That is to first order in the body's turn between
/// frames, which is 4° at most here.
#[test]
fn the_sequence_posterior_is_linearized_right_before_cameras_that_are_unknown() {
    for (name, measure) in
        [("human-ellipsoids", Measure::Ellipses), ("human-metaballs", Measure::Metaballs)]
    {
        let scene = Scene::person(name, 4);
        let posterior = Posterior::before_unknown_cameras(&scene, measure);
        let looks = posterior.looks();
        let of_points = usize::from(measure == Measure::Metaballs);
        assert_eq!(looks[0].len(), scene.rig.cameras.len() + of_points);
        let fault = |seed: u64| {
            let mut state = scene.moved(&scene.truth, 0.01, seed);
            state.cameras = off(scene.rig.cameras.len());
            check_linearization(&posterior.problem(&looks), &state, 1e-6, 0.02).err()
        };
        is_kept_somewhere(name, fault);
    }
}

/// Cameras of which next to nothing is known beforehand, whose world is held instead.
#[test]
fn the_sequence_posterior_is_linearized_right_before_cameras_that_were_placed_by_detections() {
    let scene = Scene::person("human-ellipsoids", 3);
    let unknown = Posterior::before_unknown_cameras(&scene, Measure::Ellipses);
    let errors = PoseErrors { turn_deg: 2.0, displacement_m: 0.1 };
    let usual = unknown.camera_prior.clone();
    let camera_prior = usual.clone().with_errors(errors, &scene.rig);
    let posterior = Posterior { camera_prior, ..unknown };
    let looks = posterior.looks();

    // all displaced together cost what the world's own displacement does, ten standard deviations, and next to nothing each
    let count = scene.rig.cameras.len();
    let displacement_m = Vector3::new(0.03, 0.0, 0.0);
    let together = CameraOffset { displacement_m, ..CameraOffset::none() };
    let state = SequenceState { cameras: vec![together; count], ..scene.truth.clone() };
    let cost = |camera_prior: &CameraPrior| {
        SequencePosterior { camera_prior, ..posterior.problem(&looks) }.cost(&state)
    };
    let student = |square: f64| 3.5 * square.ln_1p() * count as f64;
    let expected = 50.0 + student(0.09) - student(100.0);
    let more = cost(&posterior.camera_prior) - cost(&usual);
    assert!((more - expected).abs() < 1e-6, "{more} {expected}");

    let fault = |seed: u64| {
        let mut state = scene.moved(&scene.truth, 0.01, seed);
        state.cameras = off(count);
        check_linearization(&posterior.problem(&looks), &state, 1e-6, 0.02).err()
    };
    is_kept_somewhere("placed", fault);
}

/// Detections count apart from outlines, before cameras that are trusted and such that are unknown.
#[test]
fn the_sequence_posterior_is_linearized_right_with_detections() {
    let mut scene = Scene::person("human-ellipsoids", 3);
    scene.detect();
    let trusting =
        scene.evidence(Measure::Ellipses).sequence_terms(scene.sequence(), CameraPrior::trusting());
    let trusted = Posterior {
        looks: trusting.thinned,
        ..Posterior::new(&scene, MODELS[1], Measure::Ellipses)
    };
    let unknown = Posterior::before_unknown_cameras(&scene, Measure::Ellipses);
    // between frames the body's turn counts to first order
    for (what, posterior, cameras, tolerance) in
        [("trusted", trusted, 0, 1e-4), ("unknown", unknown, 3, 0.02)]
    {
        let looks = posterior.looks();
        assert!(looks.iter().flatten().any(|look| look.kind == Kind::Keypoints), "{what}");
        let fault = |seed: u64| {
            let moved = scene.moved(&scene.truth, 0.01, seed);
            let state = SequenceState { cameras: off(cameras), ..moved };
            check_linearization(&posterior.problem(&looks), &state, 1e-6, tolerance).err()
        };
        is_kept_somewhere(what, fault);
    }
}

/// What a camera shows of a body is the same whether the camera was moved or the body: its picture of the moved one is the one by which
/// it is compared. Of another focal length the root is where it is shown, and the rest to first order: it is relinearized there.
#[test]
fn a_camera_that_is_off_shows_what_a_camera_at_its_place_shows() {
    let scene = Scene::person("human-metaballs", 1);
    let offsets = off(scene.rig.cameras.len());
    let zoomed = CameraOffset::applied(&scene.rig, offsets.clone());
    let offsets: Vec<CameraOffset> =
        offsets.into_iter().map(|offset| CameraOffset { log_zoom: 0.0, ..offset }).collect();
    let there = CameraOffset::applied(&scene.rig, offsets.clone());
    let motion = &scene.truth.motions[0];
    for ((camera, moved), offset) in scene.rig.cameras.iter().zip(&there.cameras).zip(offsets) {
        let seen = offset.seen(camera, motion);
        let points = |motion| Posed::new(&scene.model, &scene.truth.shape, motion).points();
        for (point, seen) in points(motion).iter().zip(points(&seen)) {
            let (a, b) = (moved.project(point), camera.project(&seen));
            assert!((a.unwrap() - b.unwrap()).norm() < 1e-9);
        }
    }

    let root = motion.position_world.into();
    for ((camera, moved), offset) in
        scene.rig.cameras.iter().zip(&zoomed.cameras).zip(off(scene.rig.cameras.len()))
    {
        let seen = offset.seen(camera, motion).position_world.into();
        let (a, b) = (moved.project(&root), camera.project(&seen));
        assert!((a.expect("in view") - b.expect("in view")).norm() < 1e-9);
    }
}

/// Three cameras side by side see a person whose surface lies 5 mm outside the model's, and one who stands 10 cm farther away.
#[test]
fn cameras_side_by_side_differ_by_how_far_a_person_is_and_not_by_how_fat() {
    let mut scene = Scene::side_by_side("human-metaballs", 1);
    scene.model = scene.model.detailed();
    let truth = scene.truth.clone().detailed(&scene.model);
    let posterior = Posterior::new(&scene, MODELS[1], Measure::Metaballs);
    let looks = posterior.looks();
    let contrasts = Contrasts::new(&scene.model, &looks, &truth, &Leverages::new(), 0.0);
    let cost = |state: &SequenceState| {
        contrasts.cost(0, &Posed::new(&scene.model, &state.shape, &state.motions[0]))
    };

    let mut fatter = truth.clone();
    let offsets = scene.model.offsets.as_ref().expect("it is detailed");
    fatter.shape.0.rows_mut(offsets.first().0, offsets.count()).fill(0.005);
    let mut farther = truth.clone();
    let away = truth.motions[0].position_world - scene.rig.cameras[1].centre_world().coords;
    farther.motions[0].position_world += away * (0.1 / away.norm());
    assert!(cost(&fatter) < 1.2 * cost(&truth), "{} {}", cost(&fatter), cost(&truth));
    assert!(cost(&farther) > 5.0 * cost(&truth), "{} {}", cost(&farther), cost(&truth));
}

#[test]
fn cameras_around_a_person_have_no_places_to_compare() {
    let scene = Scene::person("human-metaballs", 1);
    let evidence = scene.evidence(Measure::Metaballs);
    let body = Posed::new(&scene.model, &scene.truth.shape, &scene.truth.motions[0]);
    let terms = evidence.terms(&scene.frames[0], Detail::Fine);
    assert!(terms.iter().all(|term| term.parallax(&body).is_none()));
}

/// An arm whose surface lies 3 cm further out than the trunk's, past which it moves: chosen by the field alone, the limb that a line
/// of sight touches changes where the residuals differ by those 3 cm.
#[test]
fn no_residual_jumps_where_a_line_of_sight_comes_to_touch_another_limb() {
    let mut scene = Scene::person("human-metaballs", 1);
    scene.model = scene.model.detailed();
    scene.truth = scene.truth.clone().detailed(&scene.model);
    let model = &scene.model;
    let offsets = model.offsets.as_ref().expect("it is detailed");
    for k in 0..offsets.count() {
        let is_of_arm = model.parts[offsets.owners()[k].0].name.contains("arm");
        let outside_m = if is_of_arm { 0.015 } else { -0.015 };
        scene.truth.shape.0[offsets.first().0 + k] = outside_m;
    }

    let evidence = scene.evidence(Measure::Metaballs);
    let terms = evidence.terms(&scene.frames[0], Detail::Fine);
    let joint = model.joint("shoulder_abduction_r").expect("a person has shoulders");
    let residuals = |step: i32| {
        let mut motion = scene.truth.motions[0].clone();
        motion.angles[joint.0] += 0.002 * f64::from(step);
        let body = Posed::new(model, &scene.truth.shape, &motion);
        terms[0].placed_residuals(&body)
    };

    let limbs = model.limbs();
    let is_apart =
        |a: PartId, b: PartId| !limbs.iter().any(|limb| limb.contains(&a) && limb.contains(&b));
    let (mut changed, mut largest) = (0, 0.0_f64);
    let all: Vec<_> = (-150..150).map(residuals).collect();
    for neighbours in all.windows(2) {
        for (a, b) in neighbours[0].iter().zip(&neighbours[1]) {
            if is_apart(a.part, b.part) && a.value.min(b.value) < 3.0 {
                changed += 1;
                largest = largest.max((a.value - b.value).abs());
            }
        }
    }
    assert!(changed > 50, "{changed}");
    // a limb may have two summits, between which it still jumps
    assert!(largest < 1.5, "{largest} standard deviations");
}

/// Ellipses, lines of sight and points at once.
#[test]
fn the_sequence_posterior_is_linearized_right_with_all_terms_together() {
    let scene = Scene::arm(2);
    let looks = Posterior::new(&scene, MODELS[0], Measure::Both).looks;
    assert_eq!(looks[0].iter().map(|look| look.terms.len()).sum::<usize>(), 3);
    check(&scene, Measure::Both, (1e-6, 1e-4));
}

#[test]
fn one_frame_alone_is_a_sequence() {
    check(&Scene::arm(1), Measure::Metaballs, (1e-5, 1e-5));
}

/// Within the limits of angles and sizes, of a fixed root, priors and steps are quadratic: there the model is exact.
#[test]
fn where_all_residuals_are_linear_the_model_is_the_cost() {
    let scene = Scene::arm(4);
    let state = scene.truth.clone();
    for motion_model in MODELS {
        let posterior = Posterior::blind(&scene, motion_model);
        let looks = posterior.looks();
        let problem = posterior.problem(&looks);
        let mut model = problem.empty_model();
        let cost = problem.linearize(&state, &mut model);
        for seed in 0..5 {
            let size = model.gradient().len();
            let step =
                DVector::from_fn(size, |i, _| 0.01 * ((i as f64 + 1.7) * (seed + 1) as f64).sin());
            let decrease = cost - problem.cost(&problem.retract(&state, &step));
            approx::assert_relative_eq!(
                model.predicted_decrease(&step),
                decrease,
                max_relative = 1e-9
            );
        }
        // and one step of Newton's is the minimum
        let step = model.minimizer(0.0).expect("the priors hold every angle");
        let least = problem.retract(&state, &step);
        let mut there = problem.empty_model();
        problem.linearize(&least, &mut there);
        assert!(there.gradient().amax() < 1e-8 * model.gradient().amax());
    }
}

/// JᵀWJ of numerically differentiated residuals: velocities, and their differences.
fn dense(model: &BodyModel, motions: &[Motion], motion_model: MotionModel) -> DMatrix<f64> {
    let layout = Layout::new(model);
    let m = layout.motion();
    let (per_velocity, per_acceleration) = densities(model);
    let rows = |delta: &DVector<f64>| {
        let moved =
            |i: usize| layout.retract_motion(&motions[i], &delta.rows(i * m, m).into_owned());
        let moved: Vec<Motion> = (0..motions.len()).map(moved).collect();
        let velocity = |i: usize| layout.motion_difference(&moved[i - 1], &moved[i]) / SECONDS[i];
        let mut rows = Vec::new();
        for i in 1..motions.len() {
            let weight = per_velocity.map(|density| (density * SECONDS[i]).sqrt());
            rows.extend(velocity(i).component_mul(&weight).iter());
            if motion_model == MotionModel::ConstantVelocity && i > 1 {
                let between = 0.5 * (SECONDS[i] + SECONDS[i - 1]);
                let weight = per_acceleration.map(|density| (density / between).sqrt());
                let change = velocity(i) - velocity(i - 1);
                rows.extend(change.component_mul(&weight).iter());
            }
        }
        DVector::from_vec(rows)
    };
    let jacobian = central_differences(motions.len() * m, 1e-5, rows);
    jacobian.tr_mul(&jacobian)
}

/// What a square of each velocity and acceleration counts for each second: 1/2Sv and S/4v³ of an angle of spread S and speed v, 2πf/2v² and πf/a² of
/// the root.
fn densities(model: &BodyModel) -> (DVector<f64>, DVector<f64>) {
    let of_root = |(v, a): (f64, f64)| {
        let half_turns = std::f64::consts::PI * SWING_HZ;
        (half_turns / (v * v), half_turns / (a * a))
    };
    let root = match model.root {
        maquette::body::Root::Free { speed, turn } => {
            [[(speed, ROOT_ACCELERATION); 3], [(turn, ROOT_TURN_ACCELERATION); 3]].concat()
        }
        maquette::body::Root::Fixed => Vec::new(),
    };
    let of_joint = |j: &maquette::body::Joint| {
        (0.5 / (j.spread * j.speed), j.spread / (4.0 * j.speed.powi(3)))
    };
    let all = root.into_iter().map(of_root).chain(model.joints.iter().map(of_joint));
    let (velocity, acceleration): (Vec<f64>, Vec<f64>) = all.unzip();
    (DVector::from_vec(velocity), DVector::from_vec(acceleration))
}

fn assembled(chain: &BorderedChain) -> DMatrix<f64> {
    let (n, m) = (chain.links.len(), chain.links[0].gradient.len());
    let mut all = DMatrix::zeros(n * m, n * m);
    for (i, link) in chain.links.iter().enumerate() {
        let mut put = |before: usize, block: &DMatrix<f64>| {
            let place = (i * m, (i - before) * m);
            all.view_mut(place, (m, m)).copy_from(block);
        };
        put(0, &link.diagonal);
        for (k, coupling) in link.couplings.iter().enumerate() {
            put(k + 1, coupling);
        }
    }
    all.fill_upper_triangle_with_lower_triangle();
    all
}

/// Motions with the body turned by up to nearly half a turn from one to the next.
fn tumbling(scene: &Scene, turn: f64) -> Vec<Motion> {
    let axes =
        [Vector3::new(1.0, -2.0, 0.5), Vector3::new(0.2, 0.3, 1.0), Vector3::new(-1.0, 0.1, 0.4)];
    let mut motions = scene.moved(&scene.truth, 0.3, 42).motions;
    for i in 1..motions.len() {
        let by = Rotation3::from_scaled_axis(axes[i - 1] * (turn / axes[i - 1].norm()));
        motions[i].world_from_root = motions[i - 1].world_from_root * by;
    }
    motions
}

#[test]
fn the_chain_is_the_gauss_newton_matrix_of_its_residuals_for_turns_up_to_nearly_half() {
    let scene = Scene::person("walker-metaballs", 4);
    let layout = Layout::new(&scene.model);
    for motion_model in MODELS {
        let prior = ChainPrior::new(&scene.model, motion_model);
        for turn in [1e-8, 0.3, 1.5, 2.9] {
            let motions = tumbling(&scene, turn);
            let mut chain = BorderedChain::zeros(4, layout.motion(), 0, prior.reach());
            let each = |i| prior.linearize(&motions, &SECONDS, i, &mut chain.links);
            let cost: f64 = (0..4).map(each).sum();
            let alone: f64 = (0..4).map(|i| prior.cost(&motions, &SECONDS, i)).sum();
            approx::assert_relative_eq!(cost, alone, max_relative = 1e-12);
            let expected = dense(&scene.model, &motions, motion_model);
            let difference = (assembled(&chain) - &expected).amax();
            assert!(difference < 1e-6 * expected.amax(), "{motion_model:?}, {turn}: {difference}");
        }
    }
}

/// A chain prior by itself.
struct Steps<'a> {
    model: &'a BodyModel,
    prior: ChainPrior,
}

impl Problem for Steps<'_> {
    type State = Vec<Motion>;
    type Model = BorderedChain;
    fn empty_model(&self) -> BorderedChain {
        BorderedChain::zeros(4, Layout::new(self.model).motion(), 0, self.prior.reach())
    }
    fn cost(&self, x: &Vec<Motion>) -> f64 {
        (0..4).map(|i| self.prior.cost(x, &SECONDS, i)).sum()
    }
    fn linearize(&self, x: &Vec<Motion>, chain: &mut BorderedChain) -> f64 {
        let each = |i| self.prior.linearize(x, &SECONDS, i, &mut chain.links);
        (0..4).map(each).sum()
    }
    fn retract(&self, x: &Vec<Motion>, delta: &DVector<f64>) -> Vec<Motion> {
        let layout = Layout::new(self.model);
        let m = layout.motion();
        let moved = |(i, motion): (usize, &Motion)| {
            layout.retract_motion(motion, &delta.rows(i * m, m).into_owned())
        };
        x.iter().enumerate().map(moved).collect()
    }
}

#[test]
fn the_chain_prior_is_linearized_right_for_turns_up_to_nearly_half() {
    let scene = Scene::person("walker-metaballs", 4);
    for motion_model in MODELS {
        let steps =
            Steps { model: &scene.model, prior: ChainPrior::new(&scene.model, motion_model) };
        for turn in [1e-8, 0.3, 1.5, 2.9] {
            let motions = tumbling(&scene, turn);
            check_linearization(&steps, &motions, 1e-5, 1e-6)
                .unwrap_or_else(|fault| panic!("{motion_model:?}, {turn}: {fault}"));
        }
    }
}

#[test]
fn the_mean_shape_has_no_cost() {
    let scene = Scene::arm(2);
    let posterior = Posterior::blind(&scene, MODELS[0]);
    let looks = posterior.looks();
    let cost =
        |shape| posterior.problem(&looks).cost(&SequenceState { shape, ..scene.truth.clone() });
    let mean = Shape(scene.model.statistics.mean.clone());
    let own = cost(scene.truth.shape.clone()) - cost(mean);
    approx::assert_relative_eq!(
        own,
        posterior.shape_prior.cost(&scene.truth.shape),
        epsilon = 1e-9
    );
    assert!(own > 0.1);
}

/// The same path of four seconds at 25, 50 and 100 frames a second costs the same, but for the ends.
#[test]
fn a_second_of_motion_costs_the_same_at_any_frame_rate() {
    let scene = Scene::arm(1);
    let (chain, pose) = (
        ChainPrior::new(&scene.model, MotionModel::ConstantVelocity),
        PosePrior::new(&scene.model),
    );
    let cost = |fps: f64| {
        let motion = |i: usize| {
            let mut motion = Motion::rest(&scene.model);
            let t = i as f64 / fps;
            let swing = |(k, a): (usize, &mut f64)| *a += 0.4 * (3.0 * t + k as f64).sin();
            motion.angles.iter_mut().enumerate().for_each(swing);
            motion
        };
        let motions: Vec<Motion> = (0..(4.0 * fps) as usize).map(motion).collect();
        let seconds = vec![1.0 / fps; motions.len()];
        let one = |i: usize| {
            chain.cost(&motions, &seconds, i) + pose.cost_lasting(&motions[i], 1.0 / fps)
        };
        (1..motions.len()).map(one).sum::<f64>()
    };
    let [slow, usual, fast] = [25.0, 50.0, 100.0].map(cost);
    approx::assert_relative_eq!(slow, usual, max_relative = 0.03);
    approx::assert_relative_eq!(usual, fast, max_relative = 0.03);
    assert!(usual > 1.0, "{usual}");
}

/// ω: what stays from frame to frame counts as in two seconds, what passes as in all.
#[test]
fn a_motion_counts_beside_data_that_repeat_as_it_does_in_two_seconds() {
    let scene = Scene::arm(4);
    let motions = &scene.moved(&scene.truth, 0.2, 7).motions;
    // without accelerations, which count otherwise
    let once = MotionPrior::new(&scene.model, MotionModel::ConstantPosition);
    let counts = |staying_share: f64, seconds: &[f64]| {
        let prior = once.beside(staying_share, seconds);
        prior.cost(motions, &SECONDS) / once.cost(motions, &SECONDS)
    };
    let five: Vec<f64> = std::iter::once(f64::INFINITY).chain([0.5; 10]).collect();
    approx::assert_relative_eq!(counts(1.0, &five), 0.4, max_relative = 1e-12);
    approx::assert_relative_eq!(counts(0.5, &five), 0.7, max_relative = 1e-12);
    approx::assert_relative_eq!(counts(0.0, &five), 1.0, max_relative = 1e-12);
    approx::assert_relative_eq!(counts(1.0, &five[..5]), 1.0, max_relative = 1e-12);
    // a second trial of five seconds, and a pause of a minute
    let two = [&five[..], &five[..]].concat();
    approx::assert_relative_eq!(counts(1.0, &two), 0.2, max_relative = 1e-12);
    let paused = [&five[..], &[60.0, 0.5, 0.5, 0.5, 0.5, 0.5, 0.5]].concat();
    approx::assert_relative_eq!(counts(1.0, &paused), 0.2, max_relative = 1e-12);
}

/// τ₁/τ: accelerations count as what passes, however long the recording is.
#[test]
fn accelerations_count_as_often_as_what_passes() {
    let scene = Scene::arm(4);
    let motions = &scene.moved(&scene.truth, 0.2, 7).motions;
    let chains = MODELS.map(|model| MotionPrior::new(&scene.model, model));
    // of priors that differ in accelerations alone
    let of_accelerations = |staying_share: f64, seconds: &[f64]| {
        let costs = chains
            .clone()
            .map(|prior| prior.beside(staying_share, seconds).cost(motions, &SECONDS));
        (costs[0] - costs[1]).abs()
    };
    let five: Vec<f64> = std::iter::once(f64::INFINITY).chain([0.5; 10]).collect();
    let once = of_accelerations(0.0, &five);
    assert!(once > 0.0);
    for seconds in [&five[..], &five[..3]] {
        let found = of_accelerations(0.8, seconds) / once;
        approx::assert_relative_eq!(found, 0.2, max_relative = 1e-9);
    }
}
