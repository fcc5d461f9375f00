//! A person who walks along a circle, and what detectors of joints make of them.
//!
//! A detector means a place 1 cm (standard deviation along each axis) beside each joint, the same in all frames. Its errors are two processes that
//! last for .1 s and 1 s, each a quarter of what published labels scatter by; one joint of a hundred lies anywhere about the person, and now and then it takes
//! one leg for the other for .4 s. What lies outside a picture is not seen.

use maquette::body::BodyModel;
use maquette::camera::{Camera, Rig};
use maquette::likelihood::label_sigma_px;
use maquette::math::Rigid3;
use maquette::silhouette::{Detection, FrameIndex, FrameObservations, FramePeople, Keypoint};
use maquette::synth::{Recipe, Ring, Synthetic};
use nalgebra::{Point2, Point3, Rotation3, Vector2, Vector3};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, StandardNormal};

const CAMERAS: usize = 6;
const RADIUS_M: f64 = 1.2;
const MEANT_M: f64 = 0.01;
/// Seconds, and standard deviation over that of published labels.
const LASTING: [(f64, f64); 2] = [(0.1, 0.25), (1.0, 0.25)];
const LAPSES: f64 = 0.01;
const EXCHANGES_HZ: f64 = 0.1;
const EXCHANGED_S: f64 = 0.4;
const CONFIDENCE: f64 = 0.85;
/// Random stream of the detectors; the recipe's own are others.
const OWN: u64 = 7;
const NAMES: [&str; 15] = [
    "RHip",
    "RKnee",
    "RAnkle",
    "RBigToe",
    "LHip",
    "LKnee",
    "LAnkle",
    "LBigToe",
    "RShoulder",
    "RElbow",
    "RWrist",
    "LShoulder",
    "LElbow",
    "LWrist",
    "Neck",
];
/// Positions of the legs' joints, right and left.
const LEGS: [(usize, usize); 4] = [(0, 4), (1, 5), (2, 6), (3, 7)];

/// A recording and its truth.
pub(crate) struct Recorded {
    /// The person, who walks straight there.
    pub(crate) walk: Synthetic,
    /// What the detectors see.
    pub(crate) people: Vec<FramePeople>,
}

impl Recorded {
    /// Of a person drawn from a model.
    pub(crate) fn new(model: &BodyModel, seed: u64, frames: usize, fps: f64) -> Option<Self> {
        let ring = Ring { cameras: CAMERAS, ..Ring::default() };
        let recipe = Recipe { seed, frames: Some(frames), fps, ring, ..Recipe::default() };
        let walk = recipe.walker(model).ok()?;
        let mut rng = ChaCha8Rng::seed_from_u64(seed);
        rng.set_stream(OWN);

        let meant: Vec<Vector3<f64>> = NAMES.iter().map(|_| MEANT_M * normal3(&mut rng)).collect();
        let places: Vec<Vec<Point3<f64>>> =
            (0..frames).map(|i| around(&walk, i, &meant)).collect::<Option<_>>()?;
        let mut people: Vec<FramePeople> = (0..frames)
            .map(|i| FramePeople { frame: FrameIndex(i), pictures: Vec::new() })
            .collect();
        for (id, camera) in walk.rig.iter() {
            let mut detector = Detector::new(fps);
            for (frame, places) in people.iter_mut().zip(&places) {
                let seen = detector.seen(camera, places, &mut rng);
                frame.pictures.push((id, vec![seen]));
            }
        }
        Some(Self { walk, people })
    }

    /// The rig without its poses.
    pub(crate) fn lenses(&self) -> Rig {
        let mut rig = self.walk.rig.clone();
        rig.cameras.iter_mut().for_each(|camera| camera.camera_from_world = Rigid3::identity());
        rig
    }

    /// What a fit is made to.
    pub(crate) fn observed(&self) -> Vec<FrameObservations> {
        let frame = |people: &FramePeople| {
            let mut seen = FrameObservations::nothing(people.frame);
            for (id, people) in &people.pictures {
                let person = people.first().cloned().and_then(Detection::new);
                seen.detections.extend(person.map(|person| (*id, person)));
            }
            seen
        };
        self.people.iter().map(frame).collect()
    }
}

/// Where the detectors mean the joints of a frame to be, of the person on a circle.
fn around(walk: &Synthetic, frame: usize, meant: &[Vector3<f64>]) -> Option<Vec<Point3<f64>>> {
    let root = walk.motions.get(frame)?.position_world;
    let begun = walk.motions.first()?.position_world;
    let points = walk.points(FrameIndex(frame))?;
    let turn = (root.x - begun.x) / RADIUS_M;
    let rotation = Rotation3::from_axis_angle(&Vector3::z_axis(), turn);
    let place = Vector3::new(turn.sin(), -turn.cos(), 0.0) * RADIUS_M;
    let at = |(name, meant): (&&str, &Vector3<f64>)| {
        let straight = points[walk.model.point(name)?].coords + meant;
        let own = straight - Vector3::new(root.x, 0.0, 0.0);
        Some(Point3::from(rotation * own + place))
    };
    NAMES.iter().zip(meant).map(at).collect()
}

/// A detector before one camera.
struct Detector {
    interval_s: f64,
    /// By joint, of each process, over its standard deviation.
    errors: Vec<[Vector2<f64>; 2]>,
    /// For how many frames it takes one leg for the other.
    exchanged: usize,
}

impl Detector {
    fn new(fps: f64) -> Self {
        let errors = vec![[Vector2::zeros(); 2]; NAMES.len()];
        Self { interval_s: 1.0 / fps, errors, exchanged: 0 }
    }

    /// What it sees in the next frame.
    fn seen(
        &mut self,
        camera: &Camera,
        places: &[Point3<f64>],
        rng: &mut ChaCha8Rng,
    ) -> Vec<Keypoint> {
        let pixels: Vec<Option<Point2<f64>>> =
            places.iter().map(|place| camera.project(place)).collect();
        let clean = pixels.iter().flatten().map(|pixel| keypoint("Neck", *pixel)).collect();
        let size_px = Detection::new(clean).map_or(0.0, |person| person.size_px);
        if self.exchanged == 0 && rng.random_bool(EXCHANGES_HZ * self.interval_s) {
            self.exchanged = (EXCHANGED_S / self.interval_s) as usize;
        }
        self.exchanged = self.exchanged.saturating_sub(1);

        let mut seen = Vec::new();
        for (joint, pixel) in pixels.into_iter().enumerate() {
            let name = NAMES[self.named(joint)];
            let off = self.error(joint, size_px, rng);
            let pixel = pixel.map(|pixel| pixel + off).filter(|pixel| camera.contains(pixel));
            let pixel = pixel.and_then(|pixel| camera.undistort(&pixel));
            seen.extend(pixel.map(|pixel| keypoint(name, pixel)));
        }
        seen
    }

    /// Which joint it calls this one.
    fn named(&self, joint: usize) -> usize {
        let other = LEGS.iter().find_map(|(a, b)| match joint {
            _ if joint == *a => Some(*b),
            _ if joint == *b => Some(*a),
            _ => None,
        });
        if self.exchanged > 0 { other.unwrap_or(joint) } else { joint }
    }

    fn error(&mut self, joint: usize, size_px: f64, rng: &mut ChaCha8Rng) -> Vector2<f64> {
        let sigma_px = label_sigma_px(NAMES[joint], size_px, 1.0);
        let mut off = Vector2::zeros();
        for (error, (lasting_s, share)) in self.errors[joint].iter_mut().zip(LASTING) {
            let kept = (-self.interval_s / lasting_s).exp();
            *error = *error * kept + normal3(rng).xy() * (1.0 - kept * kept).sqrt();
            off += *error * share * sigma_px;
        }
        if rng.random_bool(LAPSES) {
            off = Vector2::from_fn(|_, _| size_px * rng.random_range(-1.0..1.0));
        }
        off
    }
}

fn keypoint(name: &'static str, pixel: Point2<f64>) -> Keypoint {
    Keypoint { name, pixel, confidence: CONFIDENCE }
}

fn normal3(rng: &mut ChaCha8Rng) -> Vector3<f64> {
    Vector3::from_fn(|_, _| Distribution::<f64>::sample(&StandardNormal, rng))
}
