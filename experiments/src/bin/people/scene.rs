//! Two people in one room.

use experiments::metrics::{mpjpe_mm, offset_mm, trajectories};
use maquette::body::{BodyModel, Motion};
use maquette::camera::CameraId;
use maquette::image::Mask;
use maquette::inference::Sequence;
use maquette::inference::search::NoJournal;
use maquette::io::points::trc::Trajectories;
use maquette::pipeline::{EstimateOptions, NoProgress, fit, people};
use maquette::silhouette::{FrameIndex, FrameObservations, SilhouetteOptions, extract};
use maquette::synth::{Make, Recipe, Ring, SegmentationErrors, Synthetic};
use nalgebra::{Rotation3, Vector3};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

const FRAMES: usize = 45;
const FPS: f64 = 30.0;
/// Who is farther off than this was not found.
pub(crate) const LOST_MM: f64 = 60.0;
/// Random streams of the second person's way and of the errors of masks.
const WAY: u64 = 7;
const ERRORS: u64 = 8;
/// Seeds of the second people.
const SECOND: u64 = 1000;

/// What the second person does.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Company {
    Nobody,
    Beside,
    Against,
    Behind,
    Stands,
    Across,
}

impl Company {
    pub(crate) const ALL: [Self; 6] =
        [Self::Nobody, Self::Beside, Self::Against, Self::Behind, Self::Stands, Self::Across];

    pub(crate) fn name(self) -> &'static str {
        match self {
            Self::Nobody => "is not there",
            Self::Beside => "walks beside",
            Self::Against => "comes the other way",
            Self::Behind => "follows",
            Self::Stands => "stands by",
            Self::Across => "walks across",
        }
    }

    /// Heading, radians, and place beside the first person's path, metres ahead and to the left.
    fn way(self, rng: &mut ChaCha8Rng) -> (f64, Vector3<f64>) {
        let side = if rng.random_bool(0.5) { 1.0 } else { -1.0 };
        let aside = side * rng.random_range(0.6..0.9);
        match self {
            Self::Nobody | Self::Beside => (0.0, Vector3::new(0.0, aside, 0.0)),
            Self::Against => (std::f64::consts::PI, Vector3::new(0.0, aside, 0.0)),
            Self::Behind => (0.0, Vector3::new(-rng.random_range(0.9..1.3), 0.3 * aside, 0.0)),
            Self::Stands => (rng.random_range(-1.0..1.0), Vector3::new(0.0, aside, 0.0)),
            Self::Across => (
                side * std::f64::consts::FRAC_PI_2,
                Vector3::new(rng.random_range(1.0..1.4), 0.0, 0.0),
            ),
        }
    }
}

/// The people, and what the cameras show of them.
pub(crate) struct Scene {
    people: Vec<Synthetic>,
    frames: Vec<FrameObservations>,
}

/// How many people were found, and how well each is fitted.
pub(crate) struct Outcome {
    pub(crate) people: usize,
    pub(crate) found: usize,
    pub(crate) joints_mm: Vec<f64>,
    pub(crate) offset_mm: Vec<f64>,
}

impl Scene {
    pub(crate) fn new(
        walker: &BodyModel,
        company: Company,
        cameras: usize,
        seed: u64,
    ) -> Option<Self> {
        let recipe = |seed: u64, make: Make| Recipe {
            seed,
            make,
            frames: Some(FRAMES),
            fps: FPS,
            ring: Ring { cameras, radius: 5.0, focal_px: 500.0, ..Ring::default() },
            errors: None,
            stereo: None,
            ..Recipe::default()
        };
        let first = recipe(seed, Make::Flesh).walker(walker).ok()?;
        let mut people = vec![first];
        if company != Company::Nobody {
            let mut second = recipe(SECOND + seed, Make::Dressed).walker(walker).ok()?;
            let mut rng = ChaCha8Rng::seed_from_u64(seed);
            rng.set_stream(WAY);
            let way = company.way(&mut rng);
            let motions = second.motions.clone();
            let standing = motions.get(FRAMES / 2)?;
            let middle = standing.position_world.xy().push(0.0);
            second.motions = motions
                .iter()
                .map(|motion| if company == Company::Stands { standing } else { motion })
                .map(|motion| moved(motion, middle, way))
                .collect();
            second.rig = people[0].rig.clone();
            people.push(second);
        }
        let frames = (0..FRAMES).map(|i| observed(&people, FrameIndex(i), seed)).collect();
        Some(Self { people, frames })
    }

    /// What is found and fitted; `None` if nothing could be.
    pub(crate) fn fitted(&self, body: &BodyModel) -> Option<Outcome> {
        let rig = &self.people[0].rig;
        let sequence = Sequence { frames: &self.frames, fps: FPS };
        let options = EstimateOptions::default();
        let shares = people(body, rig, sequence, &options, None, &NoProgress).ok()?;
        let shares = if shares.is_empty() { vec![self.frames.clone()] } else { shares };

        let mut outcome = Outcome {
            people: self.people.len(),
            found: shares.len(),
            joints_mm: Vec::new(),
            offset_mm: Vec::new(),
        };
        for frames in &shares {
            let own = Sequence { frames, ..sequence };
            let found = fit(body, rig, own, &options, &NoJournal).ok()?;
            let motions: Vec<Motion> = found.frames.iter().map(|f| f.fit.motion.clone()).collect();
            let found = trajectories(&found.model, &found.shape, &motions, FPS);
            let truths =
                self.people.iter().map(|p| trajectories(&p.model, &p.shape, &p.motions, FPS));
            let off = |truth: &Trajectories| mpjpe_mm(truth, &found).unwrap_or(f64::INFINITY);
            let truth = truths.min_by(|a, b| off(a).total_cmp(&off(b)))?;
            outcome.joints_mm.push(off(&truth));
            outcome.offset_mm.push(offset_mm(&truth, &found)?);
        }
        Some(outcome)
    }
}

/// Turned about the middle of the path and put aside.
fn moved(motion: &Motion, middle: Vector3<f64>, (heading, aside): (f64, Vector3<f64>)) -> Motion {
    let turn = Rotation3::from_axis_angle(&Vector3::z_axis(), heading);
    Motion {
        position_world: turn * (motion.position_world - middle) + middle + aside,
        world_from_root: turn * motion.world_from_root,
        ..motion.clone()
    }
}

/// What the cameras show of everybody, as it was segmented.
fn observed(people: &[Synthetic], frame: FrameIndex, seed: u64) -> FrameObservations {
    let rig = &people[0].rig;
    let mut seen = FrameObservations::nothing(frame);
    for (id, camera) in rig.iter() {
        let masks: Vec<Mask> = people.iter().filter_map(|p| p.true_mask(frame, id)).collect();
        let (width, height) = (camera.width_px as usize, camera.height_px as usize);
        let all = Mask::from_fn(width, height, |x, y| masks.iter().any(|m| m.is_foreground(x, y)));
        let mask = SegmentationErrors::MILD.apply(&all, &mut errors(seed, frame, id));
        let silhouette = extract(&mask, camera, &SilhouetteOptions::default()).ok();
        seen.views.extend(silhouette.map(|silhouette| (id, silhouette)));
    }
    seen
}

fn errors(seed: u64, frame: FrameIndex, camera: CameraId) -> ChaCha8Rng {
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    rng.set_stream(ERRORS + (100 * frame.0 + camera.0) as u64);
    rng
}
