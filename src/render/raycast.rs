//! Silhouettes of a metaball body and of its limbs by casting rays.

use std::ops::Range;

use nalgebra::{Matrix3, Point2, Vector2, Vector3};

use super::profile::{Bump, RayProfile};
use crate::body::metaball::{Field, Metaball, THRESHOLD};
use crate::camera::Camera;
use crate::image::{Mask, Plane};
use crate::math::quadric::{self, Ellipsoid};

/// A metaball is left out of rays on which its d is never less than this: e^(−2·6) ≈ 6·10⁻⁶ of F.
const FARTHEST: f64 = 6.0;

/// Side of the square tiles, for each of which the metaballs in reach are listed, px.
const TILE_PX: usize = 8;

/// The mask of a body in a camera: the pixels whose line of sight meets F ≥ T, F the largest of the limbs' sums.
///
/// Pixels are those of the recorded, distorted image; each is undistorted and its ray cast from its centre.
/// Rays are followed in depth, in the camera frame: x(t) = t·(u, v, 1), with t > 0 in front of the camera.
pub fn silhouette(camera: &Camera, field: &Field) -> Mask {
    let mut pixels = Plane::filled(camera.width_px as usize, camera.height_px as usize, 0u8);
    cast(camera, field, |caster, columns, y| {
        let left = columns.start;
        for (i, pixel) in pixels.row_mut(y)[columns].iter_mut().enumerate() {
            *pixel = u8::from(caster.hits(left + i, y));
        }
    });
    Mask::brighter_than(&pixels, 0)
}

/// The mask of each limb as if it were alone, by the same rays; their union is the body's [`silhouette`].
pub(super) fn limb_silhouettes(camera: &Camera, field: &Field) -> Vec<Mask> {
    let blank = Plane::filled(camera.width_px as usize, camera.height_px as usize, 0u8);
    let mut limbs = vec![blank; field.limbs.len()];
    cast(camera, field, |caster, columns, y| {
        for x in columns {
            for limb in caster.limbs_hit(x, y) {
                limbs[limb].row_mut(y)[x] = 1;
            }
        }
    });
    limbs.iter().map(|l| Mask::brighter_than(l, 0)).collect()
}

/// Calls `row` for every row of every tile that a metaball is near, with the tile's caster, the columns, and which row it is.
fn cast(camera: &Camera, field: &Field, mut row: impl FnMut(&mut Caster<'_>, Range<usize>, usize)) {
    // a metaball of several limbs comes once for each of them
    let limbs = field.limbs.iter().enumerate();
    let balls = limbs.flat_map(|(limb, balls)| balls.iter().map(move |i| (limb, *i)));
    let balls = balls.filter_map(|(limb, i)| CameraBall::new(camera, limb, &field.metaballs[i]));
    let balls: Vec<CameraBall> = balls.collect();

    let (width, height) = (camera.width_px as usize, camera.height_px as usize);
    for top in (0..height).step_by(TILE_PX) {
        for left in (0..width).step_by(TILE_PX) {
            let near = near_tile(camera, &balls, left, top);
            if near.is_empty() {
                continue;
            }

            let mut caster = Caster::new(camera, near, field.limbs.len());
            for y in top..(top + TILE_PX).min(height) {
                row(&mut caster, left..(left + TILE_PX).min(width), y);
            }
        }
    }
}

/// A rectangle of undistorted pixels.
#[derive(Debug, Clone, Copy)]
struct Frame {
    low: Vector2<f64>,
    high: Vector2<f64>,
}

impl Frame {
    fn meets(&self, other: &Self) -> bool {
        let on = |k: usize| self.low[k] < other.high[k] && other.low[k] < self.high[k];
        on(0) && on(1)
    }
}

/// A metaball in the frame of a camera.
#[derive(Debug, Clone, Copy)]
struct CameraBall {
    /// The limb within which it blends.
    limb: usize,
    /// A⁻¹ in the camera frame.
    precision: Matrix3<f64>,
    /// A⁻¹ c.
    pull: Vector3<f64>,
    /// cᵀ A⁻¹ c.
    constant: f64,
    /// Where d can be less than [`FARTHEST`]; `None` if that is around the camera.
    frame: Option<Frame>,
}

impl CameraBall {
    /// `None` if all of it, as far as it counts, is behind the camera.
    fn new(camera: &Camera, limb: usize, metaball: &Metaball) -> Option<Self> {
        let reach = Ellipsoid {
            centre: metaball.ellipsoid.centre,
            shape: metaball.ellipsoid.shape * FARTHEST,
        };
        let camera_from_world = camera.camera_from_world;
        let turn = camera_from_world.rotation.to_rotation_matrix();
        let centre = camera_from_world.transform_point(&metaball.ellipsoid.centre.into());
        let depth_radius = (turn.matrix() * reach.shape * turn.matrix().transpose())[(2, 2)].sqrt();
        if centre.z + depth_radius <= 0.0 {
            return None;
        }

        let precision = turn.matrix() * metaball.precision * turn.matrix().transpose();
        let pull = precision * centre.coords;

        let frame = quadric::project(&camera.projection(), &reach).map(|ellipse| {
            let half = Vector2::new(ellipse.shape[(0, 0)].sqrt(), ellipse.shape[(1, 1)].sqrt());
            Frame { low: ellipse.centre - half, high: ellipse.centre + half }
        });

        Some(Self { limb, precision, pull, constant: centre.coords.dot(&pull), frame })
    }

    /// How the ray t·`direction` comes near; `None` if it stays farther than [`FARTHEST`].
    fn approach(&self, direction: &Vector3<f64>) -> Option<Approach> {
        let a = direction.dot(&(self.precision * direction));
        let at = direction.dot(&self.pull) / a;
        let nearest = self.constant - a * at * at;
        (nearest < FARTHEST).then_some(Approach { limb: self.limb, nearest, at, a })
    }
}

/// How a ray comes near to a metaball of a limb: d(t) = d₀ + a (t − t₀)².
#[derive(Debug, Clone, Copy)]
struct Approach {
    limb: usize,
    /// d₀.
    nearest: f64,
    /// t₀.
    at: f64,
    a: f64,
}

impl Approach {
    fn bump(&self) -> Bump {
        Bump { peak: (-2.0 * self.nearest).exp(), at: self.at, sharpness: 4.0 * self.a }
    }
}

/// The metaballs that rays through a tile can meet.
fn near_tile(camera: &Camera, balls: &[CameraBall], left: usize, top: usize) -> Vec<CameraBall> {
    let tile = undistorted_tile(camera, left, top);
    let in_reach = balls.iter().filter(|ball| match (&tile, &ball.frame) {
        (Some(tile), Some(frame)) => tile.meets(frame),
        _ => true,
    });
    in_reach.copied().collect()
}

/// Bounds of a tile in undistorted pixels; `None` if a corner has no line of sight.
fn undistorted_tile(camera: &Camera, left: usize, top: usize) -> Option<Frame> {
    // one pixel more on each side: a lens bends the straight edges between the corners a little
    let (left, top) = (left as f64 - 1.0, top as f64 - 1.0);
    let side = TILE_PX as f64 + 1.0;
    let corners = [(0.0, 0.0), (side, 0.0), (0.0, side), (side, side)];

    let mut frame: Option<Frame> = None;
    for (x, y) in corners {
        let corner = camera.undistort(&Point2::new(left + x, top + y))?.coords;
        frame = Some(match frame {
            None => Frame { low: corner, high: corner },
            Some(f) => Frame { low: f.low.inf(&corner), high: f.high.sup(&corner) },
        });
    }
    frame
}

/// Casts the rays of one tile.
struct Caster<'a> {
    camera: &'a Camera,
    near: Vec<CameraBall>,
    /// On the present ray.
    approaches: Vec<Approach>,
    /// One for each limb.
    profiles: Vec<RayProfile>,
}

impl<'a> Caster<'a> {
    fn new(camera: &'a Camera, near: Vec<CameraBall>, limbs: usize) -> Self {
        let profiles = vec![RayProfile::default(); limbs];
        Self { camera, near, approaches: Vec::new(), profiles }
    }

    /// The line of sight of a pixel.
    fn aimed(&self, x: usize, y: usize) -> Option<Vector3<f64>> {
        let pixel = Point2::new(x as f64, y as f64);
        let undistorted = self.camera.undistort(&pixel)?;
        Some(self.camera.intrinsics.normalized(&undistorted).push(1.0))
    }

    /// Whether a pixel shows the body.
    fn hits(&mut self, x: usize, y: usize) -> bool {
        let Some(direction) = self.aimed(x, y) else {
            return false;
        };
        // one metaball alone reaches T
        let alone = -0.5 * THRESHOLD.ln();
        let mut least = f64::INFINITY;
        self.approaches.clear();
        for i in 0..self.near.len() {
            let Some(approach) = self.near[i].approach(&direction) else {
                continue;
            };
            if approach.nearest <= alone && approach.at >= 0.0 {
                // the next pixel most likely meets the same metaball
                self.near.swap(0, i);
                return true;
            }
            least = least.min(approach.nearest);
            self.approaches.push(approach);
        }

        // all together do not if as many as the nearest one would not
        if self.approaches.len() as f64 * (-2.0 * least).exp() < THRESHOLD {
            return false;
        }
        self.profile();
        self.profiles.iter().any(|p| p.reaches(THRESHOLD))
    }

    /// The field of each limb along the present ray.
    fn profile(&mut self) {
        self.profiles.iter_mut().for_each(|p| p.bumps.clear());
        for approach in &self.approaches {
            self.profiles[approach.limb].bumps.push(approach.bump());
        }
    }

    /// The limbs that the line of sight of a pixel meets.
    fn limbs_hit(&mut self, x: usize, y: usize) -> impl Iterator<Item = usize> + '_ {
        self.approaches.clear();
        if let Some(direction) = self.aimed(x, y) {
            self.approaches.extend(self.near.iter().filter_map(|ball| ball.approach(&direction)));
        }
        self.profile();
        let profiles = self.profiles.iter().enumerate();
        profiles.filter(|(_, p)| p.reaches(THRESHOLD)).map(|(limb, _)| limb)
    }
}
