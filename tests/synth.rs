//! Walks that are walks, and recordings that are what they say.

use std::path::Path;

use maquette::body::{BodyModel, Motion, Posed, Shape};
use maquette::camera::CameraId;
use maquette::io::model;
use maquette::silhouette::FrameIndex;
use maquette::synth::{Ground, Walk, WalkError, WalkingStyle, draw_shape, sample_walker};
use nalgebra::{Point3, Vector2};
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;

const FPS: f64 = 100.0;

fn human(name: &str) -> BodyModel {
    model::load(name, Path::new("")).expect("shipped models are right")
}

struct Trial {
    model: BodyModel,
    shape: Shape,
    walk: Walk,
    motions: Vec<Motion>,
}

/// Two strides of a person of a model: its mean for seed 0.
fn trial(name: &str, seed: u64) -> Trial {
    let model = human(name);
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    let (shape, style) = match seed {
        0 => (Shape(model.statistics.mean.clone()), WalkingStyle::normative()),
        _ => (draw_shape(&model, &mut rng), WalkingStyle::personal(&mut rng)),
    };
    let walk = Walk {
        style,
        heading: 0.0,
        middle_world: Vector2::new(0.5, -0.2),
        start_phase: 0.0,
        ground: Ground::Floor,
    };
    let frames = (2.0 * FPS / walk.style.stride_hz) as usize;
    let motions = walk.motions(&model, &shape, FPS, frames).expect("it has feet");
    Trial { model, shape, walk, motions }
}

impl Trial {
    fn path(&self, point: &str) -> Vec<Point3<f64>> {
        let index = self.model.point(point).expect("a joint centre");
        let at = |m| Posed::new(&self.model, &self.shape, m).points()[index];
        self.motions.iter().map(at).collect()
    }

    /// Frames in which the right foot alone stands flat.
    fn stance(&self) -> std::ops::Range<usize> {
        let frame = |phase: f64| (phase * FPS / self.walk.style.stride_hz) as usize;
        frame(0.12)..frame(0.3)
    }
}

fn people() -> Vec<Trial> {
    let seeds = [("walker-metaballs", 0), ("human-ellipsoids", 0)];
    let drawn = (1..6).flat_map(|s| [("walker-metaballs", s), ("human-ellipsoids", s)]);
    seeds.into_iter().chain(drawn).map(|(name, seed)| trial(name, seed)).collect()
}

#[test]
fn the_standing_foot_stays_where_it_is() {
    for trial in people() {
        for point in ["RAnkle", "RBigToe"] {
            let path = trial.path(point);
            let stance = &path[trial.stance()];
            let slid = (stance[stance.len() - 1] - stance[0]).xy().norm();
            // the ankle rocks over the sole by a few degrees: 8 cm high, 1° is 1.4 mm
            assert!(slid < 0.012, "{point} of {}: {slid} m", trial.model.name);
        }
    }
}

#[test]
fn speed_step_length_and_cadence_are_those_of_a_walk() {
    for trial in people() {
        let hip = trial.path("Hip");
        let way = hip[hip.len() - 1].x - hip[0].x;
        let speed = way / ((hip.len() - 1) as f64 / FPS);
        assert!((0.9..1.75).contains(&speed), "{speed} m/s");
        let heights: Vec<f64> = hip.iter().map(|p| p.z).collect();
        let highest = heights.iter().copied().fold(f64::MIN, f64::max);
        let lowest = heights.iter().copied().fold(f64::MAX, f64::min);
        assert!((0.015..0.09).contains(&(highest - lowest)), "{} m", highest - lowest);
        let sideways = hip.iter().map(|p| (p.y + 0.2).abs()).fold(0.0, f64::max);
        assert!(sideways < 0.12, "{sideways} m");
    }
}

#[test]
fn the_path_is_centred_where_it_was_asked_for() {
    let trial = trial("walker-metaballs", 3);
    let (first, last) = (&trial.motions[0], &trial.motions[trial.motions.len() - 1]);
    let middle = 0.5 * (first.position_world + last.position_world);
    approx::assert_relative_eq!(middle.xy(), Vector2::new(0.5, -0.2), epsilon = 1e-12);
}

#[test]
fn a_belt_carries_the_person_back_evenly() {
    let floor = trial("walker-metaballs", 2);
    let belt = Walk { ground: Ground::Treadmill, ..floor.walk.clone() };
    let motions =
        belt.motions(&floor.model, &floor.shape, FPS, floor.motions.len()).expect("it has feet");
    let (first, last) = (&motions[0], &motions[motions.len() - 1]);
    approx::assert_relative_eq!(
        first.position_world.xy(),
        last.position_world.xy(),
        epsilon = 1e-12
    );

    // the same poses, and one velocity between them and the floor's
    let run = |i: usize| floor.motions[i].position_world - motions[i].position_world;
    let velocity = run(1) - run(0);
    assert!((0.9..1.75).contains(&(velocity.norm() * FPS)), "{velocity}");
    for (i, (on_floor, on_belt)) in floor.motions.iter().zip(&motions).enumerate() {
        assert_eq!(on_floor.angles, on_belt.angles);
        approx::assert_relative_eq!(run(i), run(0) + velocity * i as f64, epsilon = 1e-9);
    }
}

#[test]
fn a_heading_turns_the_whole_walk() {
    let straight = trial("walker-metaballs", 2);
    let turned = Walk { heading: 1.0, ..straight.walk.clone() };
    let motions = turned
        .motions(&straight.model, &straight.shape, FPS, straight.motions.len())
        .expect("it has feet");
    let turn = nalgebra::Rotation2::new(1.0);
    for (a, b) in straight.motions.iter().zip(&motions) {
        let from = turn * (a.position_world.xy() - straight.walk.middle_world);
        approx::assert_relative_eq!(
            from,
            b.position_world.xy() - turned.middle_world,
            epsilon = 1e-9
        );
        assert_eq!(a.angles, b.angles);
    }
}

#[test]
fn angles_are_within_the_joints_limits_and_motion_is_smooth() {
    for trial in people() {
        for motion in &trial.motions {
            for (angle, joint) in motion.angles.iter().zip(&trial.model.joints) {
                assert!((joint.limits.0..joint.limits.1).contains(angle), "{}", joint.name);
            }
        }
        let hip = trial.path("Hip");
        let acceleration = |w: &[Point3<f64>]| ((w[0] - w[1]) + (w[2] - w[1])) * FPS * FPS;
        for a in hip.windows(3).map(acceleration) {
            assert!(a.xy().norm() < 12.0 && a.z.abs() < 30.0, "{a} m/s²");
        }
    }
}

#[test]
fn a_model_without_feet_cannot_walk() {
    let arm = human("arm-2d");
    let walk = trial("walker-metaballs", 0).walk;
    let shape = Shape(arm.statistics.mean.clone());
    let error = walk.motions(&arm, &shape, 50.0, 3).unwrap_err();
    assert!(matches!(error, WalkError::NoFoot { point: "RBigToe", .. }));
    let model = human("walker-metaballs");
    let shape = Shape(model.statistics.mean.clone());
    let error = walk.motions(&model, &shape, 0.0, 3).unwrap_err();
    assert_eq!(error, WalkError::Rate { fps: 0.0 });
}

#[test]
fn a_mask_does_not_depend_on_which_were_made_before_it() {
    let model = human("walker-metaballs");
    let sample = |seed| sample_walker(&model, seed).expect("it has feet");
    let (one, other) = (sample(1), sample(1));
    assert_eq!(one, other);
    let _ = one.mask(FrameIndex(0), CameraId(0));
    let mask = one.mask(FrameIndex(7), CameraId(2));
    assert!(mask.is_some());
    assert_eq!(mask, other.mask(FrameIndex(7), CameraId(2)));
    assert_ne!(mask, one.true_mask(FrameIndex(7), CameraId(2)));
    assert_ne!(mask, sample(2).mask(FrameIndex(7), CameraId(2)));
    assert_eq!(one.mask(FrameIndex(one.frames()), CameraId(0)), None);
    assert_eq!(one.mask(FrameIndex(0), CameraId(6)), None);
}

#[test]
fn joint_centres_lie_inside_the_silhouette_of_every_camera() {
    let model = human("walker-metaballs");
    let sample = sample_walker(&model, 1).expect("it has feet");
    for frame in [0, 25].map(FrameIndex) {
        let points = sample.points(frame).expect("such a frame");
        for (id, camera) in sample.rig.iter() {
            let mask = sample.true_mask(frame, id).expect("such a camera");
            // `Head` is the crown: on the border, not inside
            let named = points.iter().zip(&model.points);
            for (point, named) in named.filter(|(_, n)| n.name != "Head") {
                let pixel = camera.project(point).expect("in view");
                let (x, y) = (pixel.x.round() as usize, pixel.y.round() as usize);
                assert!(mask.is_foreground(x, y), "{} in {} of {id}", named.name, frame);
            }
        }
    }
}
