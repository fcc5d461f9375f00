//! A synthetic recording and its truth.

use nalgebra::{Point3, Vector2};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, StandardNormal};

use super::{
    BoundSkin, Ground, Make, Movement, Ring, SegmentationErrors, StereoPair, Walk, WalkError,
    WalkingStyle, draw_shape,
};
use crate::body::metaball::Field;
use crate::body::{BodyModel, Motion, Posed, Shape};
use crate::camera::{CameraId, Distortion, Rig};
use crate::image::Mask;
use crate::render;
use crate::silhouette::FrameIndex;
use crate::stereo::CloudPoint;

/// What a recording would show, and the truth behind it.
#[derive(Debug, Clone, PartialEq)]
pub struct Synthetic {
    /// The body's model.
    pub model: BodyModel,
    /// What the cameras see; `None`: the model's metaballs.
    pub skin: Option<BoundSkin>,
    /// s, the true shape.
    pub shape: Shape,
    /// m, the true motion of each frame.
    pub motions: Vec<Motion>,
    /// The cameras.
    pub rig: Rig,
    /// Frames per second.
    pub fps: f64,
    /// Errors of the segmentation; `None` for true masks.
    pub errors: Option<SegmentationErrors>,
    /// A second camera beside each, with which it sees points on the metaballs; `None` for no points.
    pub stereo: Option<StereoPair>,
    /// Seed of the errors.
    pub seed: u64,
}

impl Synthetic {
    /// Number of frames.
    pub fn frames(&self) -> usize {
        self.motions.len()
    }

    /// The body in a frame; `None` if there is no such frame.
    pub fn posed(&self, frame: FrameIndex) -> Option<Posed<'_>> {
        let motion = self.motions.get(frame.0)?;
        Some(Posed::new(&self.model, &self.shape, motion))
    }

    /// The model's points (joint centres) in a frame, in the world.
    pub fn points(&self, frame: FrameIndex) -> Option<Vec<Point3<f64>>> {
        self.posed(frame).map(|body| body.points())
    }

    /// The true silhouette; `None` if there is no such frame or camera.
    pub fn true_mask(&self, frame: FrameIndex, camera: CameraId) -> Option<Mask> {
        let camera = self.rig.camera(camera)?;
        Some(match &self.skin {
            None => render::silhouette(camera, &Field::from_body(&self.posed(frame)?)),
            Some(bound) => {
                let motion = self.motions.get(frame.0)?;
                let skin = bound.posed(&self.model, &self.shape, motion);
                render::covered(camera, &skin.vertices, &bound.skin.mesh.triangles)
            }
        })
    }

    /// The silhouette as it was segmented.
    ///
    /// Every frame of every camera has a random stream of its own: a mask does not depend on which others were made.
    pub fn mask(&self, frame: FrameIndex, camera: CameraId) -> Option<Mask> {
        let truth = self.true_mask(frame, camera)?;
        let Some(errors) = &self.errors else {
            return Some(truth);
        };
        let mut rng = stream(self.seed, FIRST_MASK + self.view_number(frame, camera));
        Some(errors.apply(&truth, &mut rng))
    }

    /// The points that one camera and its twin see; none without [`Synthetic::stereo`].
    ///
    /// `None` if there is no such frame or camera. Every frame of every camera has a random stream of its own.
    pub fn cloud(&self, frame: FrameIndex, camera: CameraId) -> Option<Vec<CloudPoint>> {
        let (body, seeing) = (self.posed(frame)?, self.rig.camera(camera)?);
        let mut rng = stream(self.seed, FIRST_CLOUD + self.view_number(frame, camera));
        let points = self.stereo.map(|pair| pair.points(seeing, &body, &mut rng));
        Some(points.unwrap_or_default())
    }

    /// The number of a view among all views of all frames.
    pub(super) fn view_number(&self, frame: FrameIndex, camera: CameraId) -> u64 {
        (frame.0 * self.rig.cameras.len() + camera.0) as u64
    }
}

/// What a synthetic recording of a walking person is made of.
#[derive(Debug, Clone, PartialEq)]
pub struct Recipe {
    /// Seed of everything that is drawn: body, walking style, places of the cameras, segmentation errors.
    pub seed: u64,
    /// Which of the person's trials: 0 is the first. Another one has the same body and cameras; the person walks a little faster or
    /// slower, with longer or shorter steps, through another place and in another direction, from another foot on.
    pub trial: u64,
    /// Number of frames; `None` for one gait cycle, or one of another movement.
    pub frames: Option<usize>,
    /// Frames per second.
    pub fps: f64,
    /// What the person does.
    pub action: Action,
    /// What the person walks on.
    pub ground: Ground,
    /// What the person is made of.
    pub make: Make,
    /// The cameras.
    pub ring: Ring,
    /// Errors of the segmentation; `None` for true masks.
    pub errors: Option<SegmentationErrors>,
    /// A second camera beside each, with which it sees points on the skin; `None` for no points.
    pub stereo: Option<StereoPair>,
}

/// What a person does.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Action {
    /// Walks.
    #[default]
    Walk,
    /// Stands still, every joint at rest.
    Stand,
    /// Moves otherwise, on the spot.
    Move(Movement),
}

impl Default for Recipe {
    /// The sample recording: one gait cycle at 50 Hz, six cameras with a little distortion, mild errors.
    fn default() -> Self {
        let coefficients = [-0.12, 0.06, 0.0004, -0.0003];
        Self {
            seed: 1,
            trial: 0,
            frames: None,
            fps: 50.0,
            action: Action::Walk,
            ground: Ground::Floor,
            make: Make::Metaballs,
            ring: Ring {
                distortion: Distortion::brown_conrady(&coefficients).unwrap_or(Distortion::None),
                ..Ring::default()
            },
            errors: Some(SegmentationErrors::MILD),
            stereo: None,
        }
    }
}

/// Random streams of [`Recipe::walker`]; those of masks and points follow.
const BODY: u64 = 1;
const STYLE: u64 = 2;
const SCENE: u64 = 3;
const SKIN: u64 = 5;
const FIRST_MASK: u64 = 16;
const FIRST_CLOUD: u64 = 1 << 40;
const FIRST_TRIAL: u64 = 1 << 50;
const FIRST_MOVEMENT: u64 = 1 << 51;
/// Standard deviations of a trial's place, m, and direction.
const PLACE_SD_M: f64 = 0.1;
const HEADING_SD: f64 = 0.05;

/// One of a seed's random streams.
pub(super) fn stream(seed: u64, number: u64) -> ChaCha8Rng {
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    rng.set_stream(number);
    rng
}

/// A body drawn from a model, and how this person walks along x through a place of the floor.
pub(super) fn person(model: &BodyModel, seed: u64, middle_world: Vector2<f64>) -> (Shape, Walk) {
    let walk = Walk {
        style: WalkingStyle::personal(&mut stream(seed, STYLE)),
        heading: 0.0,
        middle_world,
        start_phase: 0.0,
        ground: Ground::Floor,
    };
    (draw_shape(model, &mut stream(seed, BODY)), walk)
}

impl Recipe {
    /// The walk of this trial.
    fn of_trial(&self, first: Walk) -> Walk {
        if self.trial == 0 {
            return first;
        }
        let mut rng = stream(self.seed, FIRST_TRIAL + self.trial);
        let style = first.style.again(&mut rng);
        let mut draw = || -> f64 { StandardNormal.sample(&mut rng) };
        let heading = first.heading + HEADING_SD * draw();
        let middle_world = first.middle_world + PLACE_SD_M * Vector2::new(draw(), draw());
        Walk { style, heading, middle_world, start_phase: rng.random(), ..first }
    }

    /// What the person does.
    fn motions(
        &self,
        model: &BodyModel,
        shape: &Shape,
        walk: Walk,
    ) -> Result<Vec<Motion>, WalkError> {
        let mut walk = Walk { ground: self.ground, ..self.of_trial(walk) };
        match self.action {
            Action::Walk => {}
            Action::Stand => walk.style = WalkingStyle::standing(),
            Action::Move(movement) => {
                let frames =
                    self.frames.unwrap_or((self.fps * movement.period_s()).ceil() as usize);
                let mut rng = stream(self.seed, FIRST_MOVEMENT + self.trial);
                return movement.motions(
                    model,
                    shape,
                    (self.fps, frames),
                    walk.middle_world,
                    &mut rng,
                );
            }
        }
        let cycle = (self.fps / walk.style.stride_hz).ceil() as usize;
        walk.motions(model, shape, self.fps, self.frames.unwrap_or(cycle))
    }

    /// A person drawn from the model, who walks in a style of their own along x through the middle of the ring, or does something else there.
    ///
    /// # Errors
    /// [`WalkError`] if the model has no feet or cannot have the skin of its make, or if the frame rate is impossible.
    pub fn walker(&self, model: &BodyModel) -> Result<Synthetic, WalkError> {
        let middle_world = self.ring.target_world.coords.xy();
        let (shape, walk) = person(model, self.seed, middle_world);
        let mut motions = self.motions(model, &shape, walk)?;
        let skin = self.make.skin(model, &shape, &mut stream(self.seed, SKIN))?;
        if let Some((_, sole_m)) = &skin {
            motions.iter_mut().for_each(|motion| motion.position_world.z += sole_m);
        }
        Ok(Synthetic {
            model: model.clone(),
            skin: skin.map(|(skin, _)| skin),
            motions,
            shape,
            rig: self.ring.irregular(&mut stream(self.seed, SCENE)),
            fps: self.fps,
            errors: self.errors,
            stereo: self.stereo,
            seed: self.seed.wrapping_add(self.trial << 32),
        })
    }
}

/// The sample recording of a model: the default [`Recipe`] with a seed.
///
/// # Errors
/// [`WalkError`] if the model has no feet.
pub fn sample_walker(model: &BodyModel, seed: u64) -> Result<Synthetic, WalkError> {
    let recipe = Recipe { seed, ..Recipe::default() };
    recipe.walker(model)
}
