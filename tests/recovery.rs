//! Truth in, estimate out: a walking person who is exactly the model, before four cameras.

mod ellipsoid_person;

use std::sync::LazyLock;

use maquette::body::{BodyModel, Motion, Posed, Shape, State};
use maquette::camera::Rig;
use maquette::inference::camera_offset::CameraOffset;
use maquette::inference::facing::{trial_faces_away, turned};
use maquette::inference::frame::KeyframePosterior;
use maquette::inference::hull::hull;
use maquette::inference::prior::{PosePrior, ShapePrior};
use maquette::inference::search::{NoJournal, Origin, Pruning, Search, SearchOptions, search};
use maquette::inference::start::{StartOptions, readings};
use maquette::inference::{Detail, Evidence, Sequence};
use maquette::likelihood::EllipseOptions;
use maquette::pipeline::{Cameras, Cause, Clocks, EstimateOptions, Fit, POSE, fit};
use maquette::silhouette::{FrameIndex, FrameObservations};
use maquette::solver::{NormalEquations, Options, Solution, levenberg_marquardt};
use maquette::synth::draw_shape;
use nalgebra::{DVector, Point3, Rotation3, UnitQuaternion, Vector3};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

use ellipsoid_person::{human, observe, rig, walk};

const LIMB_JOINTS: [&str; 12] = [
    "RHip",
    "RKnee",
    "RAnkle",
    "RShoulder",
    "RElbow",
    "RWrist",
    "LHip",
    "LKnee",
    "LAnkle",
    "LShoulder",
    "LElbow",
    "LWrist",
];
const FPS: f64 = 25.0;
const FRAMES: usize = 20;

/// A person drawn from p(s), twenty frames of walking.
struct Scene {
    model: BodyModel,
    rig: Rig,
    shape: Shape,
    motions: Vec<Motion>,
    frames: Vec<FrameObservations>,
}

static SCENE: LazyLock<Scene> = LazyLock::new(|| {
    let (model, rig) = (human(), rig(4));
    let shape = draw_shape(&model, &mut ChaCha8Rng::seed_from_u64(70));
    let motions = walk(&model, &shape, FPS, FRAMES);
    let bodies = motions.iter().map(|motion| Posed::new(&model, &shape, motion));
    let frames = bodies.enumerate().map(|(i, body)| observe(&body, &rig, i)).collect();
    Scene { rig, motions, frames, shape, model }
});

impl Scene {
    fn evidence(&self) -> Evidence<'_> {
        Evidence::with_ellipses(&self.model, &self.rig, EllipseOptions::default())
    }

    /// Mean distance of the limb joints from the truth in a frame, mm.
    fn error_mm(&self, points: &[Point3<f64>], frame: usize) -> f64 {
        let truth = Posed::new(&self.model, &self.shape, &self.motions[frame]).points();
        let distance = |name: &&str| {
            let index = self.model.point(name).expect("the model has the joint");
            1e3 * (points[index] - truth[index]).norm()
        };
        LIMB_JOINTS.iter().map(distance).sum::<f64>() / LIMB_JOINTS.len() as f64
    }

    /// The same of a body in its model.
    fn body_error_mm(&self, shape: &Shape, motion: &Motion, frame: usize) -> f64 {
        self.error_mm(&Posed::new(&self.model, shape, motion).points(), frame)
    }

    /// argmax p(mₖ, s | Zₖ) from a start.
    fn fit_keyframe(&self, frame: usize, start: State) -> Solution<State, NormalEquations> {
        let terms = self.evidence().terms(&self.frames[frame], Detail::Fine);
        let problem = KeyframePosterior {
            model: &self.model,
            shape_prior: &ShapePrior::new(&self.model),
            pose_prior: &PosePrior::new(&self.model),
            terms: &terms,
        };
        let options = Options { max_iterations: 60, ..Options::default() };
        levenberg_marquardt(&problem, start, &options)
    }

    /// The true motion, every angle off by up to 0.08 rad and the body by up to 3 cm; the mean shape.
    fn perturbed(&self, frame: usize, seed: u64) -> State {
        let mut rng = ChaCha8Rng::seed_from_u64(seed);
        let mut motion = self.motions[frame].clone();
        let mut draw = |size: f64| size * rng.random_range(-1.0..1.0);
        motion.angles += DVector::from_fn(motion.angles.len(), |_, _| draw(0.08));
        motion.position_world += Vector3::new(draw(0.03), draw(0.03), draw(0.03));
        State { motion, shape: ShapePrior::new(&self.model).mean() }
    }
}

/// Two keyframes, and a narrow search at each: the tests are about what comes after.
fn options(pruning: Pruning) -> SearchOptions {
    SearchOptions {
        keyframe_every: Some(10),
        start: StartOptions { headings: 4, iterations: 6, kept: 2 },
        pruning,
        ..SearchOptions::default()
    }
}

fn found(frames: usize, pruning: Pruning) -> Search {
    let sequence = Sequence { frames: &SCENE.frames[..frames], fps: FPS };
    search(&SCENE.evidence(), sequence, &options(pruning), &NoJournal)
        .expect("four cameras see the person")
}

/// The whole sequence.
static FOUND: LazyLock<Search> = LazyLock::new(|| found(FRAMES, Pruning::Exact));

/// A single keyframe leaves an arm at a near optimum now and then.
#[test]
fn keyframes_recover_the_joints_from_perturbed_starts() {
    let errors = |frame: usize| {
        let start = SCENE.perturbed(frame, 71 + frame as u64);
        let before = SCENE.body_error_mm(&start.shape, &start.motion, frame);
        let fit = SCENE.fit_keyframe(frame, start).state;
        (before, SCENE.body_error_mm(&fit.shape, &fit.motion, frame))
    };
    let (before, mut after): (Vec<f64>, Vec<f64>) = (0..FRAMES).map(errors).unzip();
    after.sort_by(f64::total_cmp);
    assert!(before.iter().all(|e| *e > 25.0), "{before:.0?} mm");
    assert!(after[FRAMES / 2] < 10.0 && after[FRAMES - 1] < 30.0, "{after:.0?} mm");
}

/// An arm may be lost before the trunk for a few frames, and is found again.
#[test]
fn the_search_finds_the_motion_without_a_start() {
    let winner = &FOUND.trials[FOUND.winner];
    let fits = winner.frames.iter().flatten().enumerate();
    let mut errors: Vec<f64> = fits
        .map(|(i, fit)| SCENE.body_error_mm(&winner.hypothesis.shape, &fit.motion, i))
        .collect();
    assert_eq!(errors.len(), FRAMES);
    let last = errors[FRAMES - 1];
    errors.sort_by(f64::total_cmp);
    let (usual, worst) = (errors[FRAMES / 2], errors[FRAMES - 1]);
    assert!(
        usual < 8.0 && last < 12.0 && worst < 25.0,
        "{errors:.0?} mm, the last frame {last:.0}"
    );
}

#[test]
fn pruning_changes_neither_the_winner_nor_a_bit_of_its_energy() {
    let all = found(FRAMES, Pruning::Off);
    assert!(all.trials.iter().all(|t| t.finished()));
    assert!(FOUND.trials.iter().any(|t| !t.finished()), "nothing was pruned");
    assert_eq!(FOUND.winner, all.winner);
    let [pruned, all] = [&*FOUND, &all].map(|s| &s.trials[s.winner]);
    assert_eq!(pruned.energy().to_bits(), all.energy().to_bits());
    assert_eq!(pruned, all);
}

#[test]
fn the_result_is_the_same_for_one_two_and_eight_threads() {
    let with = |threads| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build();
        pool.expect("threads are there").install(|| found(6, Pruning::Exact))
    };
    let one = with(1);
    assert!(one == with(2) && one == with(8));
}

#[test]
fn a_mirrored_start_costs_more_and_is_not_the_first_reading() {
    let frame = 3;
    let right = SCENE.fit_keyframe(frame, SCENE.perturbed(frame, 73));
    let mut start = SCENE.perturbed(frame, 73);
    start.motion = turned(&SCENE.model, &start.motion);
    let mirrored = SCENE.fit_keyframe(frame, start);
    assert!(mirrored.cost > 1.5 * right.cost, "{} against {}", mirrored.cost, right.cost);
    let first =
        readings(&SCENE.evidence(), &SCENE.frames[frame], &StartOptions::default()).remove(0);
    let forward = |motion: &Motion| motion.world_from_root * Vector3::x();
    let truth = forward(&SCENE.motions[frame]);
    assert!(forward(&first.state.motion).dot(&truth) > 0.9);
    assert!(forward(&mirrored.state.motion).dot(&truth) < 0.0);
}

#[test]
fn who_lies_or_goes_on_all_fours_is_found() {
    let scene = &*SCENE;
    let quarter = std::f64::consts::FRAC_PI_2;
    let on_all_fours = [
        ("hip_flexion_r", 95.0),
        ("hip_flexion_l", 80.0),
        ("knee_flexion_r", 95.0),
        ("knee_flexion_l", 85.0),
        ("shoulder_flexion_r", 80.0),
        ("shoulder_flexion_l", 95.0),
    ];
    let limbs: [(f64, &[(&str, f64)]); 3] =
        [(-quarter, &[("knee_flexion_r", 30.0)]), (quarter, &[]), (quarter, &on_all_fours)];
    for (tilt, angles_deg) in limbs {
        let mut motion = Motion::rest(&scene.model);
        for (name, angle) in angles_deg {
            motion.angles[scene.model.joint(name).expect("the joint").0] = angle.to_radians();
        }
        motion.world_from_root = Rotation3::from_axis_angle(&Vector3::z_axis(), 0.4)
            * Rotation3::from_axis_angle(&Vector3::y_axis(), tilt);
        motion.position_world = Vector3::new(0.1, -0.1, 0.5);

        let body = Posed::new(&scene.model, &scene.shape, &motion);
        let frame = observe(&body, &scene.rig, 0);
        let found = readings(&scene.evidence(), &frame, &StartOptions::default()).remove(0);
        let points = Posed::new(&scene.model, &found.state.shape, &found.state.motion).points();
        let off = points.iter().zip(body.points()).map(|(found, truth)| (found - truth).norm());
        let mean_m = off.sum::<f64>() / points.len() as f64;
        assert!(mean_m < 0.03, "{mean_m} m off at a tilt of {tilt}, {} angles", angles_deg.len());
    }
}

#[test]
fn the_other_way_of_facing_is_tried_where_no_keyframe_proposes_it() {
    let scene = &*SCENE;
    let one = StartOptions { kept: 1, ..options(Pruning::Exact).start };
    let one = SearchOptions { start: one, ..options(Pruning::Exact) };
    let sequence = Sequence { frames: &scene.frames[..6], fps: FPS };
    let found = search(&scene.evidence(), sequence, &one, &NoJournal).expect("a winner");

    let last = found.trials.last().expect("trials");
    assert_eq!(last.hypothesis.origin, Origin::Turned);
    assert!(trial_faces_away(last, &found.trials[found.winner]));
    let truth = scene.motions[0].world_from_root * Vector3::x();
    let winner = &found.trials[found.winner].hypothesis.motion;
    assert!((winner.world_from_root * Vector3::x()).dot(&truth) > 0.9);
}

#[test]
fn before_cameras_side_by_side_a_start_stands_where_their_parallax_says() {
    let scene = &*SCENE;
    let first = scene.rig.cameras[0].clone();
    let mut side_by_side = scene.rig.clone();
    side_by_side.cameras.truncate(3);
    for (camera, x) in side_by_side.cameras.iter_mut().zip([-0.2, 0.0, 0.2]) {
        camera.camera_from_world = first.camera_from_world;
        camera.camera_from_world.translation.vector.x -= x;
    }

    let body = Posed::new(&scene.model, &scene.shape, &scene.motions[0]);
    let hull = hull(&side_by_side, &observe(&body, &side_by_side, 0)).expect("a hull");
    let depth_m = |point: &Point3<f64>| (first.camera_from_world * point).z;
    let middle = body.points().iter().map(depth_m).sum::<f64>() / body.points().len() as f64;
    let off_m = depth_m(&hull.centroid_world) - middle;
    assert!(off_m.abs() < 0.1, "{off_m} m");
}

/// A fit before cameras that may be elsewhere and late, or may not.
fn fitted(rig: &Rig, frames: &[FrameObservations], cameras: Cameras, clocks: Clocks) -> Fit {
    let search = options(Pruning::Exact);
    let options = EstimateOptions { search, cameras, clocks, ..EstimateOptions::default() };
    let sequence = Sequence { frames, fps: FPS };
    fit(&SCENE.model, rig, sequence, &options, &NoJournal).expect("a fit")
}

fn mean_error_mm(fit: &Fit) -> f64 {
    let frames = fit.frames.iter().enumerate();
    let each = frames.map(|(i, f)| SCENE.error_mm(&f.points_world, i));
    each.sum::<f64>() / FRAMES as f64
}

#[test]
fn a_camera_that_was_touched_is_found_and_costs_the_body_nothing() {
    let scene = &*SCENE;
    let touched = CameraOffset {
        turn: UnitQuaternion::from_scaled_axis(Vector3::new(0.006, -0.005, 0.007)),
        displacement_m: Vector3::new(-0.006, 0.008, 0.01),
        ..CameraOffset::none()
    };
    // the second camera of the calibration stands where it was before it was touched
    let mut calibrated = scene.rig.clone();
    let back = CameraOffset {
        turn: touched.turn.inverse(),
        displacement_m: -touched.displacement_m,
        ..CameraOffset::none()
    };
    let rig = CameraOffset::applied(&scene.rig, std::iter::repeat_n(back, 4));
    calibrated.cameras[1] = rig.cameras[1].clone();

    let of = |rig: &Rig, cameras| fitted(rig, &scene.frames, cameras, Clocks::Trust);
    let untouched = of(&scene.rig, Cameras::Refine);
    let (found, trusting) = (of(&calibrated, Cameras::Refine), of(&calibrated, Cameras::Trust));

    for (camera, fit) in [0, 2, 3].map(|c| (c, &found)).into_iter().chain([(1, &untouched)]) {
        let pose = fit.cameras[camera].found.pose.expect("it is estimated");
        assert!(!pose.was_touched(), "{camera} {pose:?}");
    }
    let pose = found.cameras[1].found.pose.expect("it is estimated");
    assert!(pose.was_touched(), "{pose:?}");
    let off = found.cameras[1].found.offset().turn.angle_to(&touched.turn).to_degrees();
    assert!(off < 0.25, "{off}° of {}°", touched.turn.angle().to_degrees());
    let [best, with, without] = [&untouched, &found, &trusting].map(mean_error_mm);
    assert!(with < 1.3 * best && with < 0.7 * without, "{best} {with} {without} mm");

    // a check finds the camera as well, and leaves the body where it is with the cameras as calibrated
    let checked = of(&calibrated, Cameras::Check);
    let told = checked.cameras[1].found.pose.expect("it is estimated");
    assert!(told.was_touched() && !told.used && pose.used, "{told:?}");
    assert_eq!(checked.rig, calibrated);
    assert_eq!(checked.shape, trusting.shape);
    for (checked, trusting) in checked.frames.iter().zip(&trusting.frames) {
        assert_eq!(checked.fit.motion, trusting.fit.motion);
    }

    // how sure the poses are together, with the standard deviations that are stated
    let covariance = found.camera_covariances.poses.as_ref().expect("it is known");
    assert_eq!(covariance.nrows(), 4 * POSE);
    assert!(covariance.clone().cholesky().is_some(), "it is positive definite");
    for (camera, quality) in found.cameras.iter().enumerate() {
        let sd = quality.found.pose.and_then(|pose| pose.displacement_sd_m).expect("it is known");
        let stated = covariance[(POSE * camera + 3, POSE * camera + 3)].sqrt();
        approx::assert_relative_eq!(stated, sd[0], max_relative = 1e-9);
    }
    assert!(trusting.camera_covariances.poses.is_none());
}

/// A lens that was calibrated 4 % too long, and all lenses.
#[test]
fn a_focal_length_that_is_wrong_is_found_and_named_and_the_others_are_not() {
    let scene = &*SCENE;
    let mut one = scene.rig.clone();
    one.cameras[1] = one.cameras[1].zoomed(1.04);
    let found = fitted(&one, &scene.frames, Cameras::Refine, Clocks::Trust);
    let trusting = fitted(&one, &scene.frames, Cameras::Trust, Clocks::Trust);
    let best = fitted(&scene.rig, &scene.frames, Cameras::Refine, Clocks::Trust);

    let zoom = |fit: &Fit, camera: usize| {
        let pose = fit.cameras[camera].found.pose.expect("it is estimated");
        (pose.zoom, pose.zoom_sd.expect("it is known"))
    };
    let (of_one, sd) = zoom(&found, 1);
    assert!((of_one - 1.0 / 1.04).abs() < 3.0 * sd && sd < 0.005, "{of_one} ± {sd}");
    for camera in [0, 2, 3] {
        let (zoom, sd) = zoom(&found, camera);
        assert!((zoom - 1.0).abs() < 3.0 * sd, "camera {camera}: {zoom} ± {sd}");
    }
    let [best, with, without] = [&best, &found, &trusting].map(mean_error_mm);
    assert!(with < 1.2 * best && with < without, "{best} {with} {without} mm");
    assert_eq!(found.rig.cameras[1].intrinsics, one.cameras[1].zoomed(of_one).intrinsics);
    let name = &scene.rig.cameras[1].name;
    let is_named = |cause: &Cause| matches!(cause, Cause::FocalLength { camera, lens } if camera == name && lens.sd.is_some() && lens.used);
    let causes = &found.verdict.causes;
    assert!(matches!(&causes[..], [cause] if is_named(cause)), "{causes:?}");
}

#[test]
fn a_clock_that_is_off_is_found_and_costs_the_body_nothing() {
    // one camera shows each moment two frames early
    let scene = &*SCENE;
    let mut frames = scene.frames.clone();
    for (i, frame) in frames.iter_mut().enumerate() {
        frame.views.retain(|(id, _)| id.0 != 1);
        if let Some(later) = scene.frames.get(i + 2) {
            frame.views.extend(later.views.iter().filter(|(id, _)| id.0 == 1).cloned());
        }
        frame.views.sort_by_key(|(id, _)| *id);
    }

    let of = |clocks| fitted(&scene.rig, &frames, Cameras::Trust, clocks);
    let (found, trusting) = (of(Clocks::Estimate), of(Clocks::Trust));
    for (camera, quality) in found.cameras.iter().enumerate() {
        let clock = quality.found.clock.expect("it is estimated");
        let off = FPS * clock.ahead_s - if camera == 1 { 2.0 } else { 0.0 };
        assert!(off.abs() < 0.3, "camera {camera}: {off} frames, {clock:?}");
        assert_eq!(clock.is_off(FPS), camera == 1, "camera {camera}: {clock:?}");
    }
    // how far one clock is ahead of another is known better than how far either is
    let covariance = found.camera_covariances.clocks.as_ref().expect("it is known");
    assert_eq!(covariance.nrows(), 4);
    let sd = found.cameras[1].found.clock.and_then(|clock| clock.sd_s).expect("it is known");
    approx::assert_relative_eq!(covariance[(1, 1)].sqrt(), sd, max_relative = 1e-9);
    let apart = covariance[(0, 0)] + covariance[(1, 1)] - 2.0 * covariance[(0, 1)];
    assert!(apart > 0.0 && apart < covariance[(0, 0)] + covariance[(1, 1)], "{covariance}");

    let best = mean_error_mm(&fitted(&scene.rig, &scene.frames, Cameras::Trust, Clocks::Trust));
    let [with, without] = [&found, &trusting].map(mean_error_mm);
    assert!(with < 1.3 * best && with < 0.7 * without, "{best} {with} {without} mm");
}

#[test]
fn a_person_who_leaves_and_comes_back_elsewhere_facing_the_other_way_is_found_again() {
    // twenty frames, twenty without anybody, and ten of the same walk turned about
    let scene = &*SCENE;
    let turn = Rotation3::from_axis_angle(&Vector3::z_axis(), std::f64::consts::PI);
    let returned = |i: usize| {
        let motion = &scene.motions[i];
        Motion {
            position_world: turn * motion.position_world,
            world_from_root: turn * motion.world_from_root,
            ..motion.clone()
        }
    };
    let mut motions: Vec<Option<Motion>> = scene.motions.iter().cloned().map(Some).collect();
    motions.extend((0..FRAMES).map(|_| None));
    motions.extend((0..10).map(|i| Some(returned(i))));
    let frames: Vec<FrameObservations> = motions
        .iter()
        .enumerate()
        .map(|(i, motion)| match motion {
            Some(m) => observe(&Posed::new(&scene.model, &scene.shape, m), &scene.rig, i),
            None => FrameObservations::nothing(FrameIndex(i)),
        })
        .collect();

    let options = EstimateOptions { joint: None, ..EstimateOptions::default() };
    let sequence = Sequence { frames: &frames, fps: FPS };
    let found = fit(&scene.model, &scene.rig, sequence, &options, &NoJournal).unwrap();
    for (i, truth) in motions.iter().enumerate() {
        let Some(truth) = truth else { continue };
        let off = (found.frames[i].fit.motion.position_world - truth.position_world).norm();
        assert!(off < 0.05, "frame {i} is {off:.2} m off");
        assert!(found.frames[i].mean_iou().is_some_and(|iou| iou > 0.8), "frame {i}");
    }
}
