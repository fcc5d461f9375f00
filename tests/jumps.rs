//! A camera that loses frames while it records, and one that is touched.

mod ellipsoid_person;

use std::sync::LazyLock;

use maquette::body::{BodyModel, Motion, Posed, Shape};
use maquette::camera::{CameraId, Rig};
use maquette::inference::Sequence;
use maquette::inference::camera_offset::CameraOffset;
use maquette::inference::search::{NoJournal, SearchOptions};
use maquette::inference::start::StartOptions;
use maquette::pipeline::{Cause, EstimateOptions, Fit, FittedFrame, fit};
use maquette::silhouette::{FrameIndex, FrameObservations};
use maquette::synth::draw_shape;
use nalgebra::{UnitQuaternion, Vector3};
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;

use ellipsoid_person::{human, observe, rig, walk};

const FPS: f64 = 25.0;
const FRAMES: usize = 40;
/// The camera that jumps, and its first frame then.
const JUMPS: CameraId = CameraId(1);
const FROM: usize = 23;
/// Frames that are lost before it, or by how much it is turned.
const LOST: usize = 2;
const TURN_DEG: f64 = 1.0;

/// A person who walks before four cameras.
struct Scene {
    model: BodyModel,
    rig: Rig,
    shape: Shape,
    /// As many frames are beyond the recording's end as are lost.
    motions: Vec<Motion>,
}

static SCENE: LazyLock<Scene> = LazyLock::new(|| {
    let model = human();
    let shape = draw_shape(&model, &mut ChaCha8Rng::seed_from_u64(70));
    let motions = walk(&model, &shape, FPS, FRAMES + LOST);
    Scene { rig: rig(4), shape, motions, model }
});

impl Scene {
    /// What the rig sees of a moment, with the number of a frame.
    fn seen(&self, moment: usize, number: usize) -> FrameObservations {
        self.seen_by(&self.rig, moment, number)
    }

    fn seen_by(&self, rig: &Rig, moment: usize, number: usize) -> FrameObservations {
        observe(&Posed::new(&self.model, &self.shape, &self.motions[moment]), rig, number)
    }

    /// The recording of a camera that is turned from a frame on.
    fn recording_of_touched(&self) -> Vec<FrameObservations> {
        let turn = UnitQuaternion::from_axis_angle(&Vector3::z_axis(), TURN_DEG.to_radians());
        let still = CameraOffset::none();
        let offset =
            |id: CameraId| if id == JUMPS { CameraOffset { turn, ..still } } else { still };
        let turned = CameraOffset::applied(&self.rig, self.rig.iter().map(|(id, _)| offset(id)));
        let frame = |i: usize| match i < FROM {
            true => self.seen(i, i),
            false => self.seen(i, i).with(JUMPS, &self.seen_by(&turned, i, i)),
        };
        (0..FRAMES).map(frame).collect()
    }

    /// The recording; from a frame on, the camera that jumps shows so many frames later.
    fn recording(&self, later: usize) -> Vec<FrameObservations> {
        let frame = |i: usize| match i < FROM {
            true => self.seen(i, i),
            false => self.seen(i, i).with(JUMPS, &self.seen(i + later, i)),
        };
        (0..FRAMES).map(frame).collect()
    }

    fn fitted(&self, frames: &[FrameObservations]) -> Fit {
        let search = SearchOptions {
            keyframe_every: Some(20),
            start: StartOptions { headings: 4, iterations: 6, kept: 2 },
            ..SearchOptions::default()
        };
        let options = EstimateOptions { search, ..EstimateOptions::default() };
        let sequence = Sequence { frames, fps: FPS };
        fit(&self.model, &self.rig, sequence, &options, &NoJournal).expect("a fit")
    }

    /// Mean distance of all points from the truth, mm.
    fn error_mm(&self, fit: &Fit) -> f64 {
        let of_frame = |(i, frame): (usize, &FittedFrame)| {
            let truth = Posed::new(&self.model, &self.shape, &self.motions[i]).points();
            let each = truth.iter().zip(&frame.points_world).map(|(a, b)| 1e3 * (a - b).norm());
            each.sum::<f64>() / truth.len() as f64
        };
        fit.frames.iter().enumerate().map(of_frame).sum::<f64>() / fit.frames.len() as f64
    }
}

#[test]
fn a_camera_that_loses_frames_is_named_with_the_frame_and_costs_the_body_nothing() {
    let scene = &*SCENE;
    let clean = scene.fitted(&scene.recording(0));
    assert_eq!(clean.verdict.jumps().count(), 0, "{:?}", clean.verdict);

    // two frames are lost: all of it is used
    let frames = scene.recording(LOST);
    let lost = scene.fitted(&frames);
    let name = || scene.rig.cameras[JUMPS.0].name.clone();
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

    let [best, with] = [&clean, &lost].map(|fit| scene.error_mm(fit));
    assert!(with < 1.2 * best, "{with} mm, {best} mm without");
}

#[test]
fn a_camera_that_is_touched_is_named_with_the_frame_and_what_it_shows_behind_is_left_out() {
    let scene = &*SCENE;
    let touched = scene.fitted(&scene.recording_of_touched());
    let name = &scene.rig.cameras[JUMPS.0].name;
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
