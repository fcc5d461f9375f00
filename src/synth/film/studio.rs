//! Photographs of the room with the person in it.

use nalgebra::Vector3;
use rand_distr::{Distribution, StandardNormal};

use super::Filmed;
use super::clothes::Worn;
use super::lamp::{InLamp, Lamp, Shadow};
use super::room::Light;
use super::texture::Colour;
use super::thing::Thing;
use crate::camera::{Camera, CameraId};
use crate::image::{Mask, Picture, Plane};
use crate::render::{Fragment, Raster};
use crate::silhouette::FrameIndex;
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
    /// Where the person is, exactly: pixels that they cover by more than half.
    pub mask: Mask,
}

/// What a sample sees, before there is light on it.
#[derive(Debug, Clone, Copy)]
struct Seen {
    albedo: Colour,
    /// Cosine of the angle between the surface's normal and the lamp.
    facing: f32,
    depth: f32,
    in_lamp: InLamp,
}

const NOTHING: Seen = Seen {
    albedo: [0.0; 3],
    facing: 0.0,
    depth: f32::INFINITY,
    in_lamp: [-9.0; 3],
};

/// A camera before the room: what stands still is drawn once.
#[derive(Debug)]
pub struct Studio<'a> {
    film: &'a Filmed,
    id: CameraId,
    camera: &'a Camera,
    lamp: Lamp,
    still: Plane<Seen>,
}

impl<'a> Studio<'a> {
    pub(super) fn new(film: &'a Filmed, id: CameraId) -> Option<Self> {
        let camera = film.synthetic.rig.camera(id)?;
        let lamp = Lamp::new();
        let still = seen(camera, &lamp, &film.room.still);
        Some(Self {
            film,
            id,
            camera,
            lamp,
            still,
        })
    }

    /// A frame as this camera records it; `None` if there is no such frame.
    pub fn shot(&self, frame: FrameIndex) -> Option<Shot> {
        let Filmed {
            synthetic,
            room,
            clothes,
            ..
        } = self.film;
        let motion = synthetic.motions.get(frame.0)?;
        let time = frame.0 as f64 / synthetic.fps;
        let travelled = self.film.travelled.get(frame.0).copied().unwrap_or(0.0);
        let worn = clothes.posed(&synthetic.model, &synthetic.shape, motion);
        let moving = seen(
            self.camera,
            &self.lamp,
            &room.moving(time, travelled, self.film.waving.heading),
        );
        let mut raster = Raster::new(self.camera, SAMPLES);
        raster.draw(&worn.vertices, &clothes.skin.mesh.triangles, 0);
        let shadow = self
            .lamp
            .shadow(&worn.vertices, &clothes.skin.mesh.triangles);
        let light = room.light(time);
        let sampled = self.light_up(&raster, &moving, (&worn, light, &shadow));
        Some(self.developed(&sampled, frame))
    }

    /// Red, green, blue and the person's share of each sample.
    fn light_up(
        &self,
        raster: &Raster<'_>,
        moving: &Plane<Seen>,
        (worn, light, shadow): (&Worn, Light, &Shadow),
    ) -> Plane<[f32; 4]> {
        let lit = |seen: &Seen| {
            let facing = seen.facing.max(0.0) * shadow.light_at(seen.in_lamp);
            let brightness = light.everywhere + light.lamp * facing;
            seen.albedo.map(|c| c * brightness)
        };
        let person = raster.fragments();
        let mut samples = Plane::filled(person.width(), person.height(), [0.0; 4]);
        for y in 0..person.height() {
            let behind = self.still.row(y).iter().zip(moving.row(y));
            let all = person.row(y).iter().zip(behind);
            for (sample, (fragment, (still, moving))) in samples.row_mut(y).iter_mut().zip(all) {
                let behind = if moving.depth < still.depth {
                    moving
                } else {
                    still
                };
                let is_person = fragment.depth < behind.depth;
                let [r, g, b] = if is_person {
                    lit(&self.skin(fragment, worn))
                } else {
                    lit(behind)
                };
                *sample = [r, g, b, f32::from(u8::from(is_person))];
            }
        }
        samples
    }

    fn skin(&self, fragment: &Fragment, worn: &Worn) -> Seen {
        let clothes = &self.film.clothes;
        let triangle = clothes.skin.mesh.triangles[fragment.triangle as usize];
        let normals = triangle.map(|i| worn.normals[i as usize].cast::<f32>().into());
        let normal = Vector3::from(fragment.mix::<3>(normals));
        Seen {
            albedo: clothes.colour(triangle, |corners| fragment.mix(corners)),
            facing: normal
                .try_normalize(f32::EPSILON)
                .map_or(0.0, |n| n.dot(&Lamp::direction().cast())),
            depth: fragment.depth,
            in_lamp: NOTHING.in_lamp,
        }
    }

    /// Samples to pixels, with the sensor's noise.
    fn developed(&self, samples: &Plane<[f32; 4]>, frame: FrameIndex) -> Shot {
        let synthetic = &self.film.synthetic;
        let (width, height) = (
            self.camera.width_px as usize,
            self.camera.height_px as usize,
        );
        let view = synthetic.number(frame, self.id);
        let mut rng = stream(synthetic.seed, FIRST_NOISE + view);
        let mut picture = Plane::filled(width, height, [0u8; 3]);
        let mut covered = Plane::filled(width, height, 0.0f32);
        for y in 0..height {
            for x in 0..width {
                let [r, g, b, person] = blurred(samples, x, y);
                covered.row_mut(y)[x] = person;
                picture.row_mut(y)[x] = [r, g, b].map(|c| {
                    let noise: f32 = StandardNormal.sample(&mut rng);
                    (255.0 * c + self.film.noise_sd * noise).round() as u8
                });
            }
        }
        let is_person = |x, y| covered.get(x, y).is_some_and(|share| share > 0.5);
        Shot {
            picture,
            mask: Mask::from_fn(width, height, is_person),
        }
    }
}

/// The weighted mean of the samples in and around a pixel; those outside the picture are the nearest within.
fn blurred(samples: &Plane<[f32; 4]>, x: usize, y: usize) -> [f32; 4] {
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

/// What a camera sees of things.
fn seen(camera: &Camera, lamp: &Lamp, things: &[Thing]) -> Plane<Seen> {
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
            surface(&things[*owner], *own, (&fragment, &centre, lamp))
        })
    })
}

fn surface(
    thing: &Thing,
    own: usize,
    (fragment, centre, lamp): (&Fragment, &Vector3<f64>, &Lamp),
) -> Seen {
    let triangle = thing.triangles[own].map(|i| i as usize);
    let [a, b, c] = triangle.map(|i| thing.vertices[i]);
    let normal = (b - a)
        .cross(&(c - a))
        .try_normalize(1e-12)
        .unwrap_or_else(Vector3::z);
    // the side that is seen
    let normal = normal * normal.dot(&(centre - a)).signum();
    let places = triangle.map(|i| thing.places[i].cast::<f32>().into());
    let shares = fragment.weights.map(f64::from);
    let place = a * shares[0] + b * shares[1] + c * shares[2];
    Seen {
        albedo: thing.texture.at(fragment.mix(places)),
        facing: normal.dot(&Lamp::direction()) as f32,
        depth: fragment.depth,
        in_lamp: lamp.sees(place.into()),
    }
}
