//! Photographs instead of masks: a person who walks and waves before clutter that is as near as they are.
//!
//! Cameras stand side by side, as for stereo. The person's clothes have textures that are tied to the skin. Around the person,
//! at the same depth and close behind, stand furniture, planks and plants with textures and edges no weaker than the clothes'.
//! Only shape, depth and motion distinguish the person from the background: there is no picture of the empty room, a curtain
//! sways, a screen changes, the belt under the person runs, and the light drifts.
//!
//! | file          | holds                                                                 |
//! |---------------|-----------------------------------------------------------------------|
//! | `texture.rs`  | colours as a function of a place                                       |
//! | `thing.rs`    | boxes, sheets, shelves and plants                                      |
//! | `room.rs`     | the room, what moves in it, and its light                              |
//! | `waving.rs`   | walking on the spot, and waving                                        |
//! | `clothes.rs`  | the person: a skin moved by bones, and what is worn where              |
//! | `lamp.rs`     | the lamp, and the person's shadow                                      |
//! | `studio.rs`   | [`Studio`]: a camera before the room; [`Shot`]: picture and true mask  |
//!
//! The person is drawn as a mesh that bones bend (see [`crate::skin::SkinnedMesh`]), not as the metaballs that are fitted.

mod clothes;
mod lamp;
mod room;
mod studio;
mod texture;
mod thing;
mod waving;

use nalgebra::{Point3, Vector2};

use super::recording::{person, stream};
use super::{Synthetic, WalkError, scene};
use crate::body::BodyModel;
use crate::camera::{Camera, CameraId, Distortion, Intrinsics, Rig};
use crate::skin::SkinError;
use clothes::DressedPerson;
use room::Room;
pub use studio::{Shot, Studio};
use waving::Waving;

/// Why a recording of photographs could not be made.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum FilmError {
    /// The walk.
    #[error(transparent)]
    Walk(#[from] WalkError),
    /// The skin.
    #[error(transparent)]
    Skin(#[from] SkinError),
}

/// What a recording of photographs is made of.
#[derive(Debug, Clone, PartialEq)]
pub struct FilmRecipe {
    /// Seed of everything that is drawn: body, walking style, waving, clothes, room, noise.
    pub seed: u64,
    /// Number of frames.
    pub frames: usize,
    /// Frames per second.
    pub fps: f64,
    /// Width of the images; they are three quarters as high.
    pub width_px: u32,
    /// Distance between neighbouring cameras, metres.
    pub baseline: f64,
    /// Distance of the cameras from the person, metres.
    pub distance: f64,
    /// Standard deviation of each pixel's noise, grey levels of 255.
    pub noise_sd: f32,
    /// What else differs from PF02's sequences (Figs. 3, 4).
    pub staging: Staging,
}

/// What the person does before the cameras, what these see of it, and what else moves.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Staging {
    /// How much of the waving and wandering there is, 0 to 1. 0: arms swing, and the person walks on the spot.
    pub waving: f64,
    /// By how much belt and person are turned further, radians.
    pub turned: f64,
    /// How far beside (along y) and above the person's middle the cameras look, metres.
    pub aimed_off: [f64; 2],
    /// Whether a cart goes to and fro behind the person.
    pub company: Company,
}

/// Who or what else is in the room and moves.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Company {
    /// Nothing but curtain, screen and belt.
    Nobody,
    /// A cart as high as a table or a person, which goes to and fro behind the person.
    Cart,
}

impl Default for Staging {
    /// PF02 Fig. 3's: the person waves and wanders, and is seen whole.
    fn default() -> Self {
        Self { waving: 1.0, turned: 0.0, aimed_off: [0.0; 2], company: Company::Nobody }
    }
}

impl Default for FilmRecipe {
    /// 300 frames at 25 Hz (PF02's sequences have 300), three cameras of 640 × 480, 20 cm apart and 3.8 m away.
    fn default() -> Self {
        Self {
            seed: 1,
            frames: 300,
            fps: 25.0,
            width_px: 640,
            baseline: 0.2,
            distance: 3.8,
            noise_sd: 2.0,
            staging: Staging::default(),
        }
    }
}

/// Names of the cameras, in the order of the rig, as one who stands behind them would call them.
const CAMERAS: [&str; 3] = ["left", "center", "right"];
/// Height over the belt of the cameras, and of the point that the middle one looks at, metres.
const HEIGHT: f64 = 1.35;
const LOOKED_AT: f64 = 0.93;

/// Random streams, after those of the person.
const WAVING: u64 = 4;
const CLOTHES: u64 = 5;
const ROOM: u64 = 6;

/// A recording of photographs, and the truth behind it.
#[derive(Debug, Clone)]
pub struct Film {
    /// Body, motion and cameras.
    pub synthetic: Synthetic,
    room: Room,
    person: DressedPerson,
    waving: Waving,
    /// How far the belt has run in each frame, metres.
    travelled: Vec<f64>,
    noise_sd: f32,
}

impl FilmRecipe {
    /// A person drawn from the model, who walks on a belt before the cameras and waves.
    ///
    /// # Errors
    /// [`FilmError`] if the model has no feet or no skin, or the frame rate is impossible.
    pub fn film(&self, model: &BodyModel) -> Result<Film, FilmError> {
        let (shape, walk) = person(model, self.seed, Vector2::zeros());
        let mut motions = walk.motions(model, &shape, self.fps, self.frames)?;
        let waving = Waving::random(&mut stream(self.seed, WAVING)).staged(&self.staging);
        let travelled = waving.apply(model, &mut motions, self.fps);

        Ok(Film {
            person: DressedPerson::random(model, &shape, &mut stream(self.seed, CLOTHES))?,
            room: Room::random(&mut stream(self.seed, ROOM), self.staging.company),
            waving,
            travelled,
            noise_sd: self.noise_sd,
            synthetic: Synthetic {
                model: model.clone(),
                skin: None,
                shape,
                motions,
                rig: self.rig(),
                fps: self.fps,
                errors: None,
                stereo: None,
                seed: self.seed,
            },
        })
    }

    /// Three parallel cameras; the one in the middle looks at the person's middle, or as far off as is staged.
    fn rig(&self) -> Rig {
        let middle = Point3::new(self.distance, 0.0, HEIGHT);
        let [beside, above] = self.staging.aimed_off;
        let looked_at = Point3::new(0.0, beside, LOOKED_AT + above);
        let pose = scene::looking_at(&middle, &looked_at, 0.0);
        let (width_px, height_px) = (self.width_px, self.width_px * 3 / 4);
        let focal_px = f64::from(width_px);

        let camera = |k: usize| {
            let mut camera_from_world = pose;
            camera_from_world.translation.x += self.baseline * (1.0 - k as f64);
            Camera {
                name: CAMERAS[k].into(),
                width_px,
                height_px,
                intrinsics: Intrinsics {
                    fx_px: focal_px,
                    fy_px: focal_px,
                    cx_px: 0.5 * (f64::from(width_px) - 1.0),
                    cy_px: 0.5 * (f64::from(height_px) - 1.0),
                    skew_px: 0.0,
                },
                distortion: Distortion::None,
                camera_from_world,
            }
        };
        Rig { cameras: (0..CAMERAS.len()).map(camera).collect() }
    }
}

impl Film {
    /// A camera before the room; `None` if there is no such camera.
    pub fn studio(&self, camera: CameraId) -> Option<Studio<'_>> {
        Studio::new(self, camera)
    }
}
