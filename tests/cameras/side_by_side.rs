//! Cameras side by side are held at their calibration and clock, unless they surely are off.

use std::sync::LazyLock;

use maquette::camera::{CameraId, Rig};
use maquette::inference::camera_offset::CameraOffset;
use maquette::pipeline::{Cause, Fit, Reason};
use maquette::silhouette::FrameObservations;
use nalgebra::{UnitQuaternion, Vector3};

use crate::ellipsoid_person::rig;
use crate::walker::{FPS, Walker};

const FRAMES: usize = 30;
const KEYFRAME_EVERY: usize = 15;
/// Between neighbouring cameras, metres.
const BASELINE_M: f64 = 0.5;
/// The camera that is off, by so many frames or so many degrees about its line of sight.
const OFF: CameraId = CameraId(2);
const LATE: usize = 2;
const ROLL_DEG: f64 = 3.0;

static WALKER: LazyLock<Walker> = LazyLock::new(|| Walker::new(in_a_row(), FRAMES + LATE));

/// Three cameras, the middle one that of a ring.
fn in_a_row() -> Rig {
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
    Rig { cameras: ["left", "middle", "right"].into_iter().enumerate().map(beside).collect() }
}

/// The fit to a recording in which one camera shows what `rig` sees so many frames before.
fn fitted(rig: &Rig, late: usize) -> Fit {
    let seen = |i: usize| WALKER.seen_by(&WALKER.rig, i + LATE, i);
    let frame = |i: usize| seen(i).with(OFF, &WALKER.seen_by(rig, i + LATE - late, i));
    let frames: Vec<FrameObservations> = (0..FRAMES).map(frame).collect();
    WALKER.fitted(&frames, KEYFRAME_EVERY)
}

#[test]
fn clocks_side_by_side_are_held_if_they_are_right_and_found_if_one_is_late() {
    let walker = &*WALKER;
    let right = fitted(&walker.rig, 0);
    assert!(right.cameras.iter().all(|c| c.found.pose.is_none() && c.found.clock.is_none()));

    let late = fitted(&walker.rig, LATE);
    let clock = late.cameras[OFF.0].found.clock.expect("an estimate");
    let (frames, sd) = clock.late_frames(FPS);
    assert!((frames - LATE as f64).abs() < 4.0 * sd.unwrap() && frames > 1.5, "{frames} ± {sd:?}");
    assert!(matches!(&late.verdict.causes[..], [Cause::Clock { camera, .. }] if camera == "right"));
    let [right, late] = [right, late].map(|fit| walker.error_mm(&fit, LATE));
    assert!(late < right + 10.0, "{late} mm for {right}");
}

#[test]
fn a_camera_side_by_side_that_was_rolled_makes_the_fit_unusable_and_is_named() {
    let rig = &WALKER.rig;
    let sight = rig.cameras[OFF.0].camera_from_world.rotation.inverse() * Vector3::z_axis();
    let turn = UnitQuaternion::from_axis_angle(&sight, ROLL_DEG.to_radians());
    let none = CameraOffset::none;
    let offsets = [none(), none(), CameraOffset { turn, ..none() }];
    let rolled = fitted(&CameraOffset::applied(rig, offsets), 0);
    assert!(matches!(rolled.verdict.unusable[..], [Reason::Uncrossed { .. }]));
    let names = |cause: &Cause| matches!(cause, Cause::Touched { camera, .. } if camera == "right");
    assert!(rolled.verdict.causes.iter().any(names), "{:?}", rolled.verdict.causes);
}
