//! Cameras side by side are held at their calibration and clock, unless they surely are off.

mod ellipsoid_person;

use maquette::body::{BodyModel, Motion, Posed, Shape};
use maquette::camera::{CameraId, Rig};
use maquette::inference::Sequence;
use maquette::inference::camera_offset::CameraOffset;
use maquette::inference::search::{NoJournal, SearchOptions};
use maquette::inference::start::StartOptions;
use maquette::pipeline::{Cause, EstimateOptions, Fit, Reason, fit};
use maquette::silhouette::FrameObservations;
use maquette::synth::draw_shape;
use nalgebra::{UnitQuaternion, Vector3};
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;

use ellipsoid_person::{human, observe, rig, walk};

const FPS: f64 = 25.0;
const FRAMES: usize = 30;
/// Between neighbouring cameras, metres.
const BASELINE_M: f64 = 0.5;
/// The camera that is off, by so many frames or so many degrees about its line of sight.
const OFF: CameraId = CameraId(2);
const LATE: usize = 2;
const ROLL_DEG: f64 = 3.0;

/// A person who walks before three cameras in a row.
struct Scene {
    model: BodyModel,
    rig: Rig,
    shape: Shape,
    motions: Vec<Motion>,
}

impl Scene {
    fn new() -> Self {
        let model = human();
        let shape = draw_shape(&model, &mut ChaCha8Rng::seed_from_u64(70));
        let motions = walk(&model, &shape, FPS, FRAMES + LATE);
        let middle = rig(1).cameras.remove(0);
        let right = middle.camera_from_world.rotation.inverse() * Vector3::x();
        let beside = |(i, name): (usize, &str)| {
            let one = Rig { cameras: vec![middle.clone()] };
            let displacement_m = right * (i as f64 - 1.0) * BASELINE_M;
            let moved = CameraOffset { displacement_m, ..CameraOffset::none() };
            let mut camera = CameraOffset::applied(&one, [moved]).cameras.remove(0);
            camera.name = name.into();
            camera
        };
        let cameras = ["left", "middle", "right"].into_iter().enumerate().map(beside).collect();
        Self { model, rig: Rig { cameras }, shape, motions }
    }

    fn seen_by(&self, rig: &Rig, moment: usize, number: usize) -> FrameObservations {
        observe(&Posed::new(&self.model, &self.shape, &self.motions[moment]), rig, number)
    }

    /// The recording, with one camera that shows what `rig` sees so many frames before.
    fn fitted(&self, rig: &Rig, late: usize) -> Fit {
        let frame = |i: usize| {
            self.seen_by(&self.rig, i + LATE, i).with(OFF, &self.seen_by(rig, i + LATE - late, i))
        };
        let frames: Vec<FrameObservations> = (0..FRAMES).map(frame).collect();
        let search = SearchOptions {
            keyframe_every: Some(15),
            start: StartOptions { headings: 4, iterations: 6, kept: 2 },
            ..SearchOptions::default()
        };
        let options = EstimateOptions { search, ..EstimateOptions::default() };
        let sequence = Sequence { frames: &frames, fps: FPS };
        fit(&self.model, &self.rig, sequence, &options, &NoJournal).expect("a fit")
    }

    /// Mean distance of all points from the truth, mm.
    fn error_mm(&self, fit: &Fit) -> f64 {
        let of_frame = |i: usize| {
            let truth = Posed::new(&self.model, &self.shape, &self.motions[i + LATE]).points();
            let found = &fit.frames[i].points_world;
            let each = truth.iter().zip(found).map(|(a, b)| 1e3 * (a - b).norm());
            each.sum::<f64>() / truth.len() as f64
        };
        (0..FRAMES).map(of_frame).sum::<f64>() / FRAMES as f64
    }
}

#[test]
fn clocks_side_by_side_are_held_if_they_are_right_and_found_if_one_is_late() {
    let scene = Scene::new();
    let right = scene.fitted(&scene.rig, 0);
    assert!(right.cameras.iter().all(|c| c.found.pose.is_none() && c.found.clock.is_none()));

    let late = scene.fitted(&scene.rig, LATE);
    let clock = late.cameras[OFF.0].found.clock.expect("an estimate");
    let (frames, sd) = clock.late_frames(FPS);
    assert!((frames - LATE as f64).abs() < 4.0 * sd.unwrap() && frames > 1.5, "{frames} ± {sd:?}");
    assert!(matches!(&late.verdict.causes[..], [Cause::Clock { camera, .. }] if camera == "right"));
    let (right, late) = (scene.error_mm(&right), scene.error_mm(&late));
    assert!(late < right + 10.0, "{late} mm for {right}");
}

#[test]
fn a_camera_side_by_side_that_was_rolled_makes_the_fit_unusable_and_is_named() {
    let scene = Scene::new();
    let sight = scene.rig.cameras[OFF.0].camera_from_world.rotation.inverse() * Vector3::z_axis();
    let turn = UnitQuaternion::from_axis_angle(&sight, ROLL_DEG.to_radians());
    let none = CameraOffset::none;
    let offsets = [none(), none(), CameraOffset { turn, ..none() }];
    let rolled = scene.fitted(&CameraOffset::applied(&scene.rig, offsets), 0);
    assert!(matches!(rolled.verdict.unusable[..], [Reason::Uncrossed { .. }]));
    let names = |cause: &Cause| matches!(cause, Cause::Touched { camera, .. } if camera == "right");
    assert!(rolled.verdict.causes.iter().any(names), "{:?}", rolled.verdict.causes);
}
