//! Short recordings of a body that is exactly the model, with their truth.

use std::path::Path;

use maquette::body::metaball::Field;
use maquette::body::{BodyModel, Layout, Motion, Posed, Shape};
use maquette::camera::{Camera, CameraId, Rig};
use maquette::image::Mask;
use maquette::inference::SequenceState;
use maquette::inference::{Evidence, Sequence};
use maquette::io::model;
use maquette::likelihood::{LikelihoodOptions, Measure};
use maquette::math::quadric::project;
use maquette::render::silhouette;
use maquette::silhouette::{
    Detection, FrameIndex, FrameObservations, Keypoint, SilhouetteOptions, extract,
};
use maquette::stereo::{CloudPoint, Spread};
use maquette::synth::{Ground, Ring, Walk, WalkingStyle};
use nalgebra::{DVector, Point3, Rotation3, Unit, Vector2, Vector3};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

pub(crate) const FPS: f64 = 10.0;

/// A body in motion before cameras.
pub(crate) struct Scene {
    pub(crate) model: BodyModel,
    pub(crate) rig: Rig,
    pub(crate) frames: Vec<FrameObservations>,
    pub(crate) truth: SequenceState,
}

fn load(name: &str) -> BodyModel {
    model::load(name, Path::new("")).expect("a shipped model")
}

impl Scene {
    /// The arm of metaballs, its shoulder fixed, seen as silhouettes and as points.
    pub(crate) fn arm(frames: usize) -> Self {
        let model = load("arm");
        let mut shape = Shape(model.statistics.mean.clone());
        shape.0[0] += 0.03;
        shape.0[3] -= 0.03;
        let motion = |i: usize| {
            let (t, mut motion) = (i as f64 / FPS, Motion::rest(&model));
            motion.angles[0] = 0.4 + 0.5 * t;
            motion.angles[1] = 0.6 - 0.2 * t;
            motion.angles[3] = 0.7 + 0.6 * t;
            motion
        };
        let ring = Ring {
            cameras: 3,
            radius: 1.6,
            height: 0.1,
            target_world: Point3::new(0.1, -0.1, -0.2),
            focal_px: 200.0,
            width_px: 160,
            height_px: 120,
            ..Ring::default()
        };
        let truth = SequenceState::new(shape, (0..frames).map(motion).collect());
        Self::seen(model, ring.regular(), truth)
    }

    /// A walking person of ellipsoids and metaballs.
    pub(crate) fn person(name: &str, frames: usize) -> Self {
        let ring =
            Ring { cameras: 3, focal_px: 245.0, width_px: 240, height_px: 180, ..Ring::default() };
        Self::walking(name, frames, ring.regular())
    }

    /// The same before three cameras, 20 cm apart.
    pub(crate) fn side_by_side(name: &str, frames: usize) -> Self {
        let ring =
            Ring { cameras: 1, focal_px: 490.0, width_px: 480, height_px: 360, ..Ring::default() };
        let mut rig = ring.regular();
        let first = rig.cameras[0].clone();
        for (i, name) in ["b", "c"].into_iter().enumerate() {
            let mut camera = Camera { name: name.into(), ..first.clone() };
            camera.camera_from_world.translation.vector.x += 0.2 * (i + 1) as f64;
            rig.cameras.push(camera);
        }
        Self::walking(name, frames, rig)
    }

    /// A person who stands in one pose before one camera, turned by this heading; 0 faces the camera.
    pub(crate) fn standing(
        name: &str,
        heading_deg: f64,
        pose: impl Fn(&BodyModel) -> Motion,
    ) -> Self {
        let ring =
            Ring { cameras: 1, focal_px: 490.0, width_px: 480, height_px: 360, ..Ring::default() };
        let model = load(name);
        let shape = Shape(model.statistics.mean.clone());
        let mut motion = pose(&model);
        let turn = Rotation3::from_axis_angle(&Vector3::z_axis(), heading_deg.to_radians());
        motion.world_from_root = turn * motion.world_from_root;
        Self::seen(model, ring.regular(), SequenceState::new(shape, vec![motion]))
    }

    fn walking(name: &str, frames: usize, rig: Rig) -> Self {
        let model = load(name);
        let walk = Walk {
            style: WalkingStyle::normative(),
            heading: 0.2,
            middle_world: Vector2::new(0.05, -0.1),
            start_phase: 0.1,
            ground: Ground::Floor,
        };
        let shape = Shape(model.statistics.mean.clone());
        let motions = walk.motions(&model, &shape, FPS, frames).expect("feet");
        Self::seen(model, rig, SequenceState::new(shape, motions))
    }

    /// The skin's silhouettes, and a point of it from every metaball outwards.
    fn seen(model: BodyModel, rig: Rig, truth: SequenceState) -> Self {
        let frame = |(i, motion): (usize, &Motion)| {
            let body = Posed::new(&model, &truth.shape, motion);
            let field = Field::from_body(&body);
            let seen = |(id, camera)| {
                let mask = match model.metaballs.is_empty() {
                    true => ellipsoid_silhouette(camera, &body),
                    false => silhouette(camera, &field),
                };
                let options = SilhouetteOptions::default();
                (id, extract(&mask, camera, &options).expect("it is seen"))
            };
            FrameObservations {
                views: rig.iter().map(seen).collect(),
                points: surface(&field, 20, i as u64),
                ..FrameObservations::nothing(FrameIndex(i))
            }
        };
        let frames = truth.motions.iter().enumerate().map(frame).collect();
        Self { frames, model, rig, truth }
    }

    /// Films another body in the same motion: its ellipsoids.
    pub(crate) fn film(&mut self, model: &BodyModel) {
        for (frame, motion) in self.frames.iter_mut().zip(&self.truth.motions) {
            let body = Posed::new(model, &self.truth.shape, motion);
            let seen = |(id, camera)| {
                let mask = ellipsoid_silhouette(camera, &body);
                let options = SilhouetteOptions::default();
                (id, extract(&mask, camera, &options).expect("it is seen"))
            };
            frame.views = self.rig.iter().map(seen).collect();
        }
    }

    /// Detectors see some joints of the body, three pixels off, and have unknowns for what they mean.
    pub(crate) fn detect(&mut self) {
        const NAMES: [&str; 6] = ["RHip", "LHip", "RKnee", "LKnee", "RWrist", "LWrist"];
        self.model = self.model.with_keypoints(&NAMES);
        self.truth = self.truth.clone().detailed(&self.model);
        for (frame, motion) in self.frames.iter_mut().zip(&self.truth.motions) {
            let body = Posed::new(&self.model, &self.truth.shape, motion);
            let points = body.points();
            let seen = |(id, camera): (CameraId, &Camera)| {
                let keypoint = |name: &'static str| {
                    let at = points[self.model.point(name)?];
                    let pixel = camera.project_undistorted(&at)? + Vector2::new(3.0, -3.0);
                    Some(Keypoint { name, pixel, confidence: 0.9 })
                };
                let keypoints = NAMES.into_iter().filter_map(keypoint).collect();
                (id, Detection { keypoints, size_px: 50.0 })
            };
            frame.detections = self.rig.iter().map(seen).collect();
        }
    }

    pub(crate) fn evidence(&self, measure: Measure) -> Evidence<'_> {
        Evidence::new(&self.model, &self.rig, LikelihoodOptions::default(), measure)
    }

    pub(crate) fn sequence(&self) -> Sequence<'_> {
        Sequence { frames: &self.frames, fps: FPS }
    }

    /// Every component of every motion and of the shape moved by up to this: metres, radians, coefficients.
    pub(crate) fn moved(&self, state: &SequenceState, size: f64, seed: u64) -> SequenceState {
        let mut rng = ChaCha8Rng::seed_from_u64(seed);
        let layout = Layout::new(&self.model);
        let mut draw = |n| DVector::from_fn(n, |_, _| size * rng.random_range(-1.0..1.0));
        SequenceState {
            motions: state
                .motions
                .iter()
                .map(|motion| layout.retract_motion(motion, &draw(layout.motion())))
                .collect(),
            shape: Shape(&state.shape.0 + draw(state.shape.0.len())),
            cameras: state.cameras.clone(),
        }
    }

    /// Mean distance of the exported points from the truth, mm.
    pub(crate) fn error_mm(&self, shape: &Shape, motions: &[Motion]) -> f64 {
        let points = |shape, motion| Posed::new(&self.model, shape, motion).points();
        let pairs = motions.iter().zip(&self.truth.motions);
        let errors: Vec<f64> = pairs
            .flat_map(|(fit, truth)| {
                let fit = points(shape, fit).into_iter();
                let distance = |(a, b): (Point3<f64>, Point3<f64>)| 1e3 * (a - b).norm();
                fit.zip(points(&self.truth.shape, truth)).map(distance).collect::<Vec<_>>()
            })
            .collect();
        errors.iter().sum::<f64>() / errors.len() as f64
    }
}

/// Points of the skin: `each` from the centre of every metaball outwards.
pub(crate) fn surface(field: &Field, each: usize, seed: u64) -> Vec<CloudPoint> {
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    let mut points = Vec::new();
    for ball in &field.metaballs {
        for _ in 0..each {
            let out = Vector3::from_fn(|_, _| rng.random_range(-1.0..1.0));
            let out = Unit::new_normalize(out).into_inner();
            let steps = (0..300).map(|i| ball.ellipsoid.centre + out * (1e-3 * f64::from(i)));
            let mut outside = steps.skip_while(|x| field.value(x) > 0.5);
            points.extend(outside.next().map(|x| CloudPoint {
                position_world: Point3::from(x),
                spread: Spread::Isotropic(0.002),
            }));
        }
    }
    points
}

/// The pixels that any ellipsoid of a body covers.
fn ellipsoid_silhouette(camera: &Camera, body: &Posed<'_>) -> Mask {
    let projection = camera.projection();
    let ellipses: Vec<_> =
        body.ellipsoids().iter().filter_map(|e| project(&projection, e)).collect();
    let inverses: Vec<_> =
        ellipses.iter().filter_map(|e| Some((e.centre, e.shape.cholesky()?.inverse()))).collect();
    let covers = |x: usize, y: usize| {
        let pixel = Vector2::new(x as f64, y as f64);
        inverses.iter().any(|(centre, inverse)| {
            let offset = pixel - centre;
            offset.dot(&(inverse * offset)) <= 1.0
        })
    };
    Mask::from_fn(camera.width_px as usize, camera.height_px as usize, covers)
}
