//! A camera that loses frames while it records, and one that is touched.

use std::sync::LazyLock;

use maquette::body::Motion;
use maquette::camera::CameraId;
use maquette::inference::camera_offset::CameraOffset;
use maquette::pipeline::{Cause, FittedFrame};
use maquette::silhouette::{FrameIndex, FrameObservations};
use nalgebra::{UnitQuaternion, Vector3};

use crate::ellipsoid_person::rig;
use crate::walker::{FPS, Walker};

const FRAMES: usize = 40;
const KEYFRAME_EVERY: usize = 20;
/// The camera that jumps, and its first frame then.
const JUMPS: CameraId = CameraId(1);
const FROM: usize = 23;
/// Frames that are lost before it, or by how much it is turned.
const LOST: usize = 2;
const TURN_DEG: f64 = 1.0;

/// Four cameras; as many moments are beyond the recording's end as are lost.
static WALKER: LazyLock<Walker> = LazyLock::new(|| Walker::new(rig(4), FRAMES + LOST));

/// The recording of a camera that is turned from a frame on.
fn recording_of_touched() -> Vec<FrameObservations> {
    let walker = &*WALKER;
    let turn = UnitQuaternion::from_axis_angle(&Vector3::z_axis(), TURN_DEG.to_radians());
    let still = CameraOffset::none();
    let offset = |id: CameraId| if id == JUMPS { CameraOffset { turn, ..still } } else { still };
    let turned = CameraOffset::applied(&walker.rig, walker.rig.iter().map(|(id, _)| offset(id)));
    let seen = |i: usize| walker.seen_by(&walker.rig, i, i);
    let frame = |i: usize| match i < FROM {
        true => seen(i),
        false => seen(i).with(JUMPS, &walker.seen_by(&turned, i, i)),
    };
    (0..FRAMES).map(frame).collect()
}

/// The recording; from a frame on, the camera that jumps shows so many frames later.
fn recording(later: usize) -> Vec<FrameObservations> {
    let seen = |moment: usize, number: usize| WALKER.seen_by(&WALKER.rig, moment, number);
    let frame = |i: usize| match i < FROM {
        true => seen(i, i),
        false => seen(i, i).with(JUMPS, &seen(i + later, i)),
    };
    (0..FRAMES).map(frame).collect()
}

#[test]
fn a_camera_that_loses_frames_is_named_with_the_frame_and_costs_the_body_little() {
    let walker = &*WALKER;
    let clean = walker.fitted(&recording(0), KEYFRAME_EVERY);
    assert_eq!(clean.verdict.jumps().count(), 0, "{:?}", clean.verdict);

    // two frames are lost: all of it is used
    let lost = walker.fitted(&recording(LOST), KEYFRAME_EVERY);
    let name = || walker.rig.cameras[JUMPS.0].name.clone();
    let frame = FrameIndex(FROM);
    let expected = Cause::LostFrames { camera: name(), frame, frames: LOST as isize };
    assert_eq!(lost.verdict.causes, [expected]);
    assert!(lost.frames[FROM].views.iter().all(|view| view.camera != name()));
    assert!(lost.frames[FRAMES - 1].views.iter().any(|view| view.camera == name()));

    // the film of the camera that lost frames shows the body of the moment that it shows
    let shown = lost.shown(FPS);
    let (own, other) = (shown(FROM, JUMPS), shown(FROM, CameraId(0)));
    let off_m = |shown: &Motion, frame: usize| {
        (shown.position_world - lost.frames[frame].fit.motion.position_world).norm()
    };
    let off_m = [off_m(&own, FROM + LOST), off_m(&other, FROM)];
    assert!(off_m.iter().all(|off_m| *off_m < 0.005), "{off_m:?} m");

    let [best, with] = [&clean, &lost].map(|fit| walker.error_mm(fit, 0));
    assert!(with < 1.3 * best, "{with} mm, {best} mm without");
}

#[test]
fn a_camera_that_is_touched_is_named_with_the_frame_and_what_it_shows_behind_is_left_out() {
    let walker = &*WALKER;
    let touched = walker.fitted(&recording_of_touched(), KEYFRAME_EVERY);
    let name = &walker.rig.cameras[JUMPS.0].name;
    let [Cause::TouchedWhile { camera, frame, turn_deg, left_out }] = &touched.verdict.causes[..]
    else {
        panic!("{:?}", touched.verdict);
    };
    assert_eq!((camera, *frame), (name, FrameIndex(FROM)));
    assert!((turn_deg - TURN_DEG).abs() < 0.3, "{turn_deg}°");
    assert_eq!(*left_out, [FROM, FRAMES - 1].map(FrameIndex));
    let shows = |frame: &FittedFrame| frame.views.iter().any(|view| view.camera == *name);
    assert!(touched.frames[..FROM].iter().all(shows));
    assert!(!touched.frames[FROM..].iter().any(shows));
}
