//! Photographs of the room with the person in it.

use nalgebra::Vector3;
use rand_distr::{Distribution, StandardNormal};

use super::Film;
use super::lamp::{InLamp, Lamp, Shadow};
use super::room::Light;
use super::texture::Colour;
use super::thing::Thing;
use crate::camera::{Camera, CameraId};
use crate::image::{Mask, Picture, Plane};
use crate::render::{Fragment, Raster};
use crate::silhouette::FrameIndex;
use crate::synth::bound_skin::PosedSkin;
use crate::synth::recording::stream;

/// Samples across a pixel, and down it.
const SAMPLES: usize = 2;
/// A pixel is the mean of 4 × 4 samples with these weights: a lens that blurs by 0.4 px.
const BLUR: [f32; 4] = [0.125, 0.375, 0.375, 0.125];
/// Random streams of the noise begin here.
const FIRST_NOISE: u64 = 1 << 41;

/// One frame of one camera.
#[derive(Debug, Clone, PartialEq)]
pub struct Shot {
    /// What the camera recorded.
    pub picture: Picture,
    /// The true mask: the pixels of which the person covers more than half.
    pub mask: Mask,
}

/// What a sample shows, before light falls on it.
#[derive(Debug, Clone, Copy)]
struct UnlitSample {
    albedo: Colour,
    /// Cosine of the angle between the surface's normal and the lamp.
    facing: f32,
    depth: f32,
    in_lamp: InLamp,
}

const NOTHING: UnlitSample =
    UnlitSample { albedo: [0.0; 3], facing: 0.0, depth: f32::INFINITY, in_lamp: [-9.0; 3] };

/// What a camera sees of one frame.
struct Layers<'a> {
    /// The things that move.
    moving: Plane<UnlitSample>,
    /// The nearest triangle of the person's skin.
    person: &'a Plane<Fragment>,
    skin: PosedSkin,
    shadow: Shadow,
    light: Light,
}

/// A camera before the room; what stands still is drawn once.
#[derive(Debug)]
pub struct Studio<'a> {
    film: &'a Film,
    id: CameraId,
    camera: &'a Camera,
    lamp: Lamp,
    still: Plane<UnlitSample>,
}

impl<'a> Studio<'a> {
    pub(super) fn new(film: &'a Film, id: CameraId) -> Option<Self> {
        let camera = film.synthetic.rig.camera(id)?;
        let lamp = Lamp::new();
        let still = unlit_view(camera, &lamp, &film.room.still);
        Some(Self { film, id, camera, lamp, still })
    }

    /// A frame as this camera records it; `None` if there is no such frame.
    pub fn shot(&self, frame: FrameIndex) -> Option<Shot> {
        let Film { synthetic, room, person, .. } = self.film;
        let motion = synthetic.motions.get(frame.0)?;
        let time = frame.0 as f64 / synthetic.fps;
        let travelled = self.film.travelled.get(frame.0).copied().unwrap_or(0.0);

        // what moves in the room, and the person
        let things = room.moving(time, travelled, self.film.waving.heading);
        let skin = person.bound.posed(&synthetic.model, &synthetic.shape, motion);
        let triangles = &person.bound.skin.mesh.triangles;
        let mut raster = Raster::new(self.camera, SAMPLES);
        raster.draw(&skin.vertices, triangles, 0);

        let layers = Layers {
            moving: unlit_view(self.camera, &self.lamp, &things),
            person: raster.fragments(),
            shadow: self.lamp.shadow(&skin.vertices, triangles),
            light: room.light(time),
            skin,
        };
        Some(self.develop(&self.light_up(&layers), frame))
    }

    /// Red, green, blue and the person's share of each sample.
    fn light_up(&self, layers: &Layers<'_>) -> Plane<[f32; 4]> {
        let Layers { moving, person, skin, shadow, light } = layers;
        let lit = |sample: &UnlitSample| {
            let facing = sample.facing.max(0.0) * shadow.light_at(sample.in_lamp);
            let brightness = light.everywhere + light.lamp * facing;
            sample.albedo.map(|c| c * brightness)
        };

        // whatever is nearest
        let mut samples = Plane::filled(person.width(), person.height(), [0.0; 4]);
        for y in 0..person.height() {
            let behind = self.still.row(y).iter().zip(moving.row(y));
            let all = person.row(y).iter().zip(behind);
            for (sample, (fragment, (still, moving))) in samples.row_mut(y).iter_mut().zip(all) {
                let behind = if moving.depth < still.depth { moving } else { still };
                let is_person = fragment.depth < behind.depth;
                let [r, g, b] =
                    if is_person { lit(&self.skin_sample(fragment, skin)) } else { lit(behind) };
                *sample = [r, g, b, f32::from(u8::from(is_person))];
            }
        }
        samples
    }

    fn skin_sample(&self, fragment: &Fragment, skin: &PosedSkin) -> UnlitSample {
        let person = &self.film.person;
        let triangle = person.bound.skin.mesh.triangles[fragment.triangle as usize];
        let normals = triangle.map(|i| skin.normals[i as usize].cast::<f32>().into());
        let normal = Vector3::from(fragment.mix::<3>(normals));
        UnlitSample {
            albedo: person.colour(triangle, |corners| fragment.mix(corners)),
            facing: normal
                .try_normalize(f32::EPSILON)
                .map_or(0.0, |n| n.dot(&Lamp::direction().cast())),
            depth: fragment.depth,
            in_lamp: NOTHING.in_lamp,
        }
    }

    /// Samples to pixels, with the sensor's noise.
    fn develop(&self, samples: &Plane<[f32; 4]>, frame: FrameIndex) -> Shot {
        let synthetic = &self.film.synthetic;
        let (width, height) = (self.camera.width_px as usize, self.camera.height_px as usize);
        let view = synthetic.view_number(frame, self.id);
        let mut rng = stream(synthetic.seed, FIRST_NOISE + view);

        let mut picture = Plane::filled(width, height, [0u8; 3]);
        let mut covered = Plane::filled(width, height, 0.0f32);
        for y in 0..height {
            for x in 0..width {
                let [r, g, b, person] = blur(samples, x, y);
                covered.row_mut(y)[x] = person;
                picture.row_mut(y)[x] = [r, g, b].map(|c| {
                    let noise: f32 = StandardNormal.sample(&mut rng);
                    (255.0 * c + self.film.noise_sd * noise).round() as u8
                });
            }
        }

        let is_person = |x, y| covered.get(x, y).is_some_and(|share| share > 0.5);
        Shot { picture, mask: Mask::from_fn(width, height, is_person) }
    }
}

/// The weighted mean of the samples in and around a pixel; those outside the picture are the nearest within.
fn blur(samples: &Plane<[f32; 4]>, x: usize, y: usize) -> [f32; 4] {
    let within =
        |place: usize, k: usize, size: usize| (SAMPLES * place + k).saturating_sub(1).min(size - 1);
    let mut sum = [0.0; 4];
    for (j, down) in BLUR.iter().enumerate() {
        let row = samples.row(within(y, j, samples.height()));
        for (i, across) in BLUR.iter().enumerate() {
            let sample = &row[within(x, i, row.len())];
            for (sum, value) in sum.iter_mut().zip(sample) {
                *sum += down * across * value;
            }
        }
    }
    sum
}

/// What a camera sees of things, sample by sample.
fn unlit_view(camera: &Camera, lamp: &Lamp, things: &[Thing]) -> Plane<UnlitSample> {
    let mut raster = Raster::new(camera, SAMPLES);
    let mut owners: Vec<(usize, usize)> = Vec::new();
    for (owner, thing) in things.iter().enumerate() {
        raster.draw(&thing.vertices, &thing.triangles, owners.len() as u32);
        owners.extend((0..thing.triangles.len()).map(|own| (owner, own)));
    }
    let centre = camera.centre_world().coords;
    raster.fragments().map(|fragment| {
        let owner = owners.get(fragment.triangle as usize);
        owner.map_or(NOTHING, |(owner, own)| {
            surface(&things[*owner], *own, &fragment, &centre, lamp)
        })
    })
}

/// The surface of one triangle of a thing, as a camera at `centre` sees it.
fn surface(
    thing: &Thing,
    own: usize,
    fragment: &Fragment,
    centre: &Vector3<f64>,
    lamp: &Lamp,
) -> UnlitSample {
    let triangle = thing.triangles[own].map(|i| i as usize);
    let [a, b, c] = triangle.map(|i| thing.vertices[i]);
    let normal = (b - a).cross(&(c - a)).try_normalize(1e-12).unwrap_or_else(Vector3::z);
    // the side that faces the camera
    let normal = normal * normal.dot(&(centre - a)).signum();

    let places = triangle.map(|i| thing.places[i].cast::<f32>().into());
    let shares = fragment.weights.map(f64::from);
    let place = a * shares[0] + b * shares[1] + c * shares[2];
    UnlitSample {
        albedo: thing.texture.at(fragment.mix(places)),
        facing: normal.dot(&Lamp::direction()) as f32,
        depth: fragment.depth,
        in_lamp: lamp.sees(place.into()),
    }
}
