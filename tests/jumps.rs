//! A camera that is touched, or loses frames, while it records.

mod ellipsoid_person;

use std::sync::LazyLock;

use maquette::body::{BodyModel, Motion, Posed, Shape};
use maquette::camera::{CameraId, Rig};
use maquette::inference::Sequence;
use maquette::inference::camera_offset::CameraOffset;
use maquette::inference::search::{NoJournal, SearchOptions};
use maquette::inference::start::StartOptions;
use maquette::pipeline::{Cause, EstimateOptions, Fit, fit};
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
const LOST: usize = 2;

impl Scene {
    /// What the rig sees of a moment, with the number of a frame.
    fn seen(&self, rig: &Rig, moment: usize, number: usize) -> FrameObservations {
        observe(&Posed::new(&self.model, &self.shape, &self.motions[moment]), rig, number)
    }

    /// The recording; from a frame on, the camera that jumps shows another moment and stands elsewhere.
    fn recording(&self, later: usize, turn: Vector3<f64>) -> Vec<FrameObservations> {
        let offset = |id: CameraId| match id == JUMPS {
            true => CameraOffset {
                turn: UnitQuaternion::from_scaled_axis(turn),
                ..CameraOffset::none()
            },
            false => CameraOffset::none(),
        };
        let touched = CameraOffset::applied(&self.rig, self.rig.iter().map(|(id, _)| offset(id)));
        let frame = |i: usize| match i < FROM {
            true => self.seen(&self.rig, i, i),
            false => {
                let own = self.seen(&touched, i + later, i);
                self.seen(&self.rig, i, i).with(JUMPS, &own)
            }
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
        let of_frame = |(i, frame): (usize, &maquette::pipeline::FittedFrame)| {
            let truth = Posed::new(&self.model, &self.shape, &self.motions[i]).points();
            let each = truth.iter().zip(&frame.points_world).map(|(a, b)| 1e3 * (a - b).norm());
            each.sum::<f64>() / truth.len() as f64
        };
        fit.frames.iter().enumerate().map(of_frame).sum::<f64>() / fit.frames.len() as f64
    }
}

#[test]
fn a_camera_that_jumps_is_named_with_its_frame_and_costs_the_body_nothing() {
    let scene = &*SCENE;
    let none = Vector3::zeros();
    let clean = scene.fitted(&scene.recording(0, none));
    assert_eq!(clean.verdict.jumps().count(), 0, "{:?}", clean.verdict);

    // two frames are lost: all of it is used
    let frames = scene.recording(LOST, none);
    let lost = scene.fitted(&frames);
    let name = || scene.rig.cameras[JUMPS.0].name.clone();
    let frame = FrameIndex(FROM);
    let expected = Cause::LostFrames { camera: name(), frame, frames: LOST as isize };
    assert_eq!(lost.verdict.causes, [expected]);
    assert!(lost.frames[FROM].views.iter().all(|view| view.camera != name()));
    assert!(lost.frames[FRAMES - 1].views.iter().any(|view| view.camera == name()));

    // somebody runs into it: what it shows then is left out, and it is not taken to be elsewhere before
    let touched = scene.fitted(&scene.recording(0, Vector3::new(0.0, 0.01, 0.015)));
    let [Cause::TouchedWhile { camera, frame, turn_deg, left_out }] = &touched.verdict.causes[..]
    else {
        panic!("{:?}", touched.verdict);
    };
    assert_eq!((camera, frame), (&name(), &FrameIndex(FROM)));
    assert_eq!(left_out, &[FROM, FRAMES - 1].map(FrameIndex));
    assert!((turn_deg - 1.03).abs() < 0.25, "{turn_deg}°");
    let pose = touched.cameras[JUMPS.0].found.pose.expect("it is estimated");
    assert!(!pose.was_touched(), "{pose:?}");

    // the film of the camera that lost frames shows the body of the moment that it shows
    let shown = lost.shown(FPS);
    let (own, other) = (shown(FROM, JUMPS), shown(FROM, CameraId(0)));
    assert_eq!(other, lost.frames[FROM].fit.motion);
    let off_m = (own.position_world - lost.frames[FROM + LOST].fit.motion.position_world).norm();
    assert!(off_m < 0.005, "{off_m} m");

    let [best, others @ ..] = [&clean, &lost, &touched].map(|fit| scene.error_mm(fit));
    assert!(others.iter().all(|error| *error < 1.2 * best), "{others:?} mm, {best} mm without");
}
