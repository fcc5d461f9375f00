//! A room full of things, some of which move.

use nalgebra::Vector3;
use rand::{Rng, RngExt};

use super::Company;
use super::texture::Texture;
use super::thing::Thing;

/// A room; the cameras stand at positive x and look along −x, the person is about the origin.
#[derive(Debug, Clone)]
pub(super) struct Room {
    /// What stands still: floor, walls, furniture.
    pub(super) still: Vec<Thing>,
    curtain: Curtain,
    cart: Option<Cart>,
    belt: Texture,
    screen: Texture,
    lamps: Lamps,
}

#[derive(Debug, Clone)]
struct Curtain {
    texture: Texture,
    /// Left edge, width.
    along_y: [f64; 2],
    /// Swings a second, and their amplitude at the hem, metres.
    sway: [f64; 2],
}

/// A box that goes to and fro behind the person.
#[derive(Debug, Clone)]
struct Cart {
    texture: Texture,
    /// Depth behind the person, width, height, metres.
    size: [f64; 3],
    /// Ways to and fro in a second, and their phase at the start.
    goes: [f64; 2],
}

/// How the brightness of the two kinds of light drifts.
#[derive(Debug, Clone, Copy)]
struct Lamps {
    phase: [f64; 2],
    hertz: [f64; 2],
}

/// The light at one time.
#[derive(Debug, Clone, Copy)]
pub(super) struct Light {
    /// From everywhere.
    pub(super) everywhere: f32,
    /// From the lamp, on what faces it.
    pub(super) lamp: f32,
}

/// The floor lies below the belt on which the person walks, metres.
const FLOOR: f64 = -0.12;
/// Depth of the back wall, metres behind the person.
const WALL: f64 = 2.3;
/// How deep a cart is, and how far it goes to either side, metres.
const CART: [f64; 2] = [0.4, 1.6];
/// Length and width of the belt, metres.
const BELT: [f64; 2] = [1.8, 1.5];

impl Room {
    /// Furniture beside the person at their own depth, out of the reach of their arms, and close behind them.
    pub(super) fn random(rng: &mut impl Rng, company: Company) -> Self {
        let mut still = shell(rng);
        for side in [-1.0, 1.0] {
            still.extend(beside(side, rng));
        }
        still.extend(behind(rng));

        let across = if rng.random_range(0.0..1.0) < 0.5 { -1.9 } else { 0.3 };

        Self {
            still,
            curtain: Curtain {
                texture: Texture::printed(rng),
                along_y: [across, 1.6],
                sway: [rng.random_range(0.25..0.45), rng.random_range(0.06..0.14)],
            },
            belt: Texture {
                stripes: (1.2, [3.0, 0.0, 0.0]),
                ..Texture::plain([0.25, 0.25, 0.27], 0.5, rng)
            },
            screen: Texture { per_m: [9.0; 3], ..Texture::printed(rng) },
            lamps: Lamps {
                phase: [0, 1].map(|_| rng.random_range(0.0..1.0)),
                hertz: [rng.random_range(0.05..0.1), rng.random_range(0.08..0.16)],
            },
            cart: (company == Company::Cart).then(|| Cart::random(rng)),
        }
    }

    /// What moves, at one time: the curtain sways, the picture on the screen shifts, the belt runs along `heading`.
    pub(super) fn moving(&self, time: f64, travelled: f64, heading: f64) -> Vec<Thing> {
        let mut all = vec![self.curtain.at(time), self.screen(time), self.belt(travelled, heading)];
        all.extend(self.cart.as_ref().map(|cart| cart.at(time)));
        all
    }

    fn screen(&self, time: f64) -> Thing {
        let at = |u: f64, v: f64| Vector3::new(-WALL + 0.3, -0.45 + 0.9 * u, 1.75 - 0.52 * v);
        let mut screen = Thing::sheet(1, 1, at, self.screen);
        for place in &mut screen.places {
            place.x = 0.35 * time;
        }
        screen
    }

    fn belt(&self, travelled: f64, heading: f64) -> Thing {
        let (sin, cos) = heading.sin_cos();
        let [length, width] = BELT;
        let flat = |u: f64, v: f64| Vector3::new(length * (u - 0.5), width * (v - 0.5), 0.0);
        let at = |u: f64, v: f64| {
            let p = flat(u, v);
            Vector3::new(cos * p.x - sin * p.y, sin * p.x + cos * p.y, 0.0)
        };
        let mut belt = Thing::sheet(1, 1, at, self.belt);
        let corners = [(0.0, 0.0), (1.0, 0.0), (0.0, 1.0), (1.0, 1.0)];
        for (place, (u, v)) in belt.places.iter_mut().zip(corners) {
            *place = flat(u, v) + Vector3::x() * travelled;
        }
        belt
    }

    /// The light at a time: both parts drift by a quarter.
    pub(super) fn light(&self, time: f64) -> Light {
        let Lamps { phase, hertz } = self.lamps;
        let drift =
            |k: usize| 1.0 + 0.25 * (std::f64::consts::TAU * (phase[k] + hertz[k] * time)).sin();
        Light { everywhere: (0.55 * drift(0)) as f32, lamp: (0.75 * drift(1)) as f32 }
    }
}

impl Cart {
    fn random(rng: &mut impl Rng) -> Self {
        Self {
            texture: Texture::printed(rng),
            size: [
                rng.random_range(1.25..1.45),
                rng.random_range(0.4..0.7),
                rng.random_range(0.7..1.7),
            ],
            goes: [rng.random_range(0.08..0.16), rng.random_range(0.0..1.0)],
        }
    }

    fn at(&self, time: f64) -> Thing {
        let ([behind, width, height], [hertz, phase]) = (self.size, self.goes);
        let [deep, most] = CART;
        let y = most * (std::f64::consts::TAU * (hertz * time + phase)).sin();
        let low = Vector3::new(-behind - deep, -0.5 * width, FLOOR);
        let high = Vector3::new(-behind, 0.5 * width, FLOOR + height);
        let mut cart = Thing::cuboid(low, high, 0.0, self.texture);
        cart.vertices.iter_mut().for_each(|vertex| vertex.y += y);
        cart
    }
}

impl Curtain {
    fn at(&self, time: f64) -> Thing {
        let [left, width] = self.along_y;
        let [hertz, swing] = self.sway;
        let hanging = |u: f64, v: f64| Vector3::new(-WALL + 0.55, left + width * u, 2.4 - 2.3 * v);
        let at = |u: f64, v: f64| {
            let phase = std::f64::consts::TAU * (hertz * time + 0.8 * u);
            let fold = 0.05 * (std::f64::consts::TAU * 7.0 * u + 1.5 * phase.sin()).sin();
            hanging(u, v)
                + Vector3::new(fold + swing * v * phase.sin(), 0.6 * swing * v * phase.cos(), 0.0)
        };
        let mut thing = Thing::sheet(56, 12, at, self.texture);
        thing.places = Thing::sheet(56, 12, hanging, self.texture).vertices;
        thing
    }
}

/// Floor, walls and the deck below the belt.
fn shell(rng: &mut impl Rng) -> Vec<Thing> {
    let floor = |u: f64, v: f64| Vector3::new(2.6 - (2.6 + WALL) * v, 4.0 * (2.0 * u - 1.0), FLOOR);
    let wall = |u: f64, v: f64| Vector3::new(-WALL, 4.0 * (2.0 * u - 1.0), 3.2 - 3.4 * v);
    let paper = Texture { grain: 0.15, ..Texture::plain([0.62, 0.6, 0.55], 0.25, rng) };
    vec![Thing::sheet(1, 1, floor, Texture::wooden(rng)), Thing::sheet(1, 1, wall, paper)]
}

/// A cabinet, a plank and perhaps a plant at the person's own depth.
fn beside(side: f64, rng: &mut impl Rng) -> Vec<Thing> {
    let mut all = Vec::new();
    let from_floor = |x: f64, y: f64| Vector3::new(x, y, FLOOR);

    // a cabinet
    let (depth, width) = (rng.random_range(0.25..0.4), rng.random_range(0.3..0.5));
    let low = from_floor(rng.random_range(-0.35..0.05), side * rng.random_range(1.3..1.4));
    let high = low + Vector3::new(depth, side * width, rng.random_range(0.9..1.7));
    let turn = rng.random_range(-0.15..0.15);
    all.push(Thing::cuboid(low.inf(&high), low.sup(&high), turn, Texture::printed(rng)));

    // a plank as thick as an arm, upright close behind
    let plank = from_floor(rng.random_range(-0.75..-0.55), side * rng.random_range(0.45..0.75));
    let size = Vector3::new(0.05, rng.random_range(0.08..0.14), rng.random_range(1.6..2.1));
    all.push(Thing::cuboid(plank, plank + size, turn, Texture::wooden(rng)));

    // a plant, or none
    let height = rng.random_range(1.0..1.6);
    let foot = from_floor(rng.random_range(-0.7..-0.45), side * rng.random_range(0.9..1.2));
    if rng.random_range(0.0..1.0) < 0.7 {
        all.extend(Thing::plant(foot, height, rng));
    }
    all
}

/// A table with boxes on it, and a shelf against the wall.
fn behind(rng: &mut impl Rng) -> Vec<Thing> {
    // the table: a top and four legs
    let y = rng.random_range(-0.9..0.1);
    let corner = Vector3::new(-1.15, y, 0.0);
    let top = rng.random_range(0.62..0.78);
    let wood = Texture::wooden(rng);
    let piece = |low: [f64; 3], high: [f64; 3]| {
        Thing::cuboid(corner + Vector3::from(low), corner + Vector3::from(high), 0.0, wood)
    };
    let mut all = vec![piece([0.0, 0.0, top - 0.04], [0.6, 1.0, top])];
    for (x, y) in [(0.02, 0.02), (0.52, 0.02), (0.02, 0.92), (0.52, 0.92)] {
        all.push(piece([x, y, FLOOR], [x + 0.06, y + 0.06, top]));
    }

    // boxes on it
    for k in 0..3 {
        let low = corner + Vector3::new(rng.random_range(0.05..0.3), 0.05 + 0.32 * k as f64, top);
        let size = Vector3::new(0.22, rng.random_range(0.12..0.28), rng.random_range(0.12..0.5));
        all.push(Thing::cuboid(
            low,
            low + size,
            rng.random_range(-0.5..0.5),
            Texture::printed(rng),
        ));
    }

    // the shelf
    let left = rng.random_range(-1.6..0.4);
    let height = rng.random_range(1.5..2.0);
    all.extend(Thing::shelf(Vector3::new(-1.7, left, FLOOR), 0.9, height, rng));
    all
}
