//! What the page's program needs: the body, its motion, its curves. Numbers in base64, little endian.

use std::collections::BTreeMap;

use base64::Engine;
use base64::prelude::BASE64_STANDARD;
use nalgebra::{Rotation3, UnitQuaternion, Vector3};
use serde::Serialize;

use super::{CameraOutlines, ReportInput, Words, label};
use crate::body::{BodyModel, Motion, PartId, Posed, Primitive, Shape};
use crate::gait::{Angle, Event, Movement, Side};
use crate::math::stats::median;
use crate::pipeline::FittedBody;
use crate::skin::{SkinnedMesh, bind_pose, skinned};

/// Everything that the page's program draws; its side of it is `web/src/scene.ts`.
#[derive(Debug, Serialize)]
pub(super) struct Scene<'a> {
    fps: f64,
    first_frame: usize,
    frames: usize,
    /// Height of the floor: the lowest place of the body, median over time.
    floor_m: f64,
    body: Option<BodyPart>,
    /// Places of named points: f32, frames × points × 3.
    points: Points,
    tracks: Vec<TrackPart<'a>>,
    events: &'a [Event],
    views: &'a [CameraOutlines],
    /// Every so many frames have pictures.
    picture_every: usize,
    /// What the program says in another language than English.
    words: &'a BTreeMap<String, String>,
}

/// The fitted body.
#[derive(Debug, Serialize)]
struct BodyPart {
    /// Of each part in each frame x, y, z and the quaternion x, y, z, w: f32; NaN where nobody was seen.
    poses: String,
    /// The same in the pose in which the skin is bound: at rest, limbs apart.
    bind: String,
    parts: usize,
    flesh: FleshPart,
}

/// Its surface.
#[derive(Debug, Serialize)]
#[serde(tag = "kind", rename_all = "lowercase")]
enum FleshPart {
    /// A skin in that pose; vertices f32, triangles u32, bones u8, weights f32.
    Skin { vertices: String, normals: String, triangles: String, bones: String, weights: String },
    /// Ellipsoids fixed to parts.
    Ellipsoids { ellipsoids: Vec<EllipsoidPart> },
}

#[derive(Debug, Serialize)]
struct EllipsoidPart {
    part: usize,
    centre: [f64; 3],
    turn: [f64; 4],
    radii: [f64; 3],
}

#[derive(Debug, Serialize)]
struct Points {
    names: Vec<String>,
    places: String,
}

/// One angle of one side over time, degrees: f32.
#[derive(Debug, Serialize)]
struct TrackPart<'a> {
    name: &'static str,
    title: &'a str,
    axis: String,
    side: Side,
    values: String,
}

impl<'a> Scene<'a> {
    pub(super) fn new(input: &ReportInput<'a>) -> Self {
        let movement = input.movement;
        let track = |((side, angle), values): (&(Side, Angle), &Vec<f64>)| {
            let label = label::angle_label(*angle, input.words);
            TrackPart {
                name: angle.name(),
                title: label.title,
                axis: label.axis(),
                side: *side,
                values: base64_of_f32(values.iter().map(|v| v.to_degrees())),
            }
        };

        Self {
            tracks: input.gait.angles.iter().map(track).collect(),
            events: &input.gait.events,
            views: &input.views.cameras,
            picture_every: input.views.every.max(1),
            ..Self::of_body(movement, input.body, input.words)
        }
    }

    /// The moving body alone.
    pub(super) fn of_body(
        movement: &Movement,
        body: Option<&FittedBody>,
        words: &'a Words,
    ) -> Self {
        Self {
            fps: movement.rate_hz,
            first_frame: movement.first_frame,
            frames: movement.frames,
            floor_m: floor_m(movement, body),
            body: body.map(body_part),
            points: points(movement),
            tracks: Vec::new(),
            events: &[],
            views: &[],
            picture_every: 1,
            words: words.program(),
        }
    }
}

fn points(movement: &Movement) -> Points {
    let tracks = &movement.tracks;
    let row = |i: usize| tracks.values().flat_map(move |track| <[f64; 3]>::from(track[i]));
    Points {
        names: tracks.keys().map(|landmark| landmark.name()).collect(),
        places: base64_of_f32((0..movement.frames).flat_map(row)),
    }
}

/// Height of the lowest place, median over the frames in which one is known.
fn floor_m(movement: &Movement, body: Option<&FittedBody>) -> f64 {
    let mut lowest: Vec<f64> = match body {
        Some(body) => {
            let motions = body.motions.iter().flatten();
            let bounds = motions.filter_map(|m| Posed::new(&body.model, &body.shape, m).bounds());
            bounds.map(|(least, _)| least.z).collect()
        }

        None => {
            let lowest = |i: usize| {
                let heights = movement.tracks.values().map(|track| track[i].z);
                heights.fold(f64::INFINITY, f64::min)
            };
            let all = (0..movement.frames).map(lowest);
            all.filter(|z| z.is_finite()).collect()
        }
    };
    median(&mut lowest).unwrap_or(0.0)
}

fn body_part(body: &FittedBody) -> BodyPart {
    let (model, shape) = (&body.model, &body.shape);
    let unseen = || vec![f64::NAN; 7 * model.parts.len()];
    let pose =
        |motion: &Option<Motion>| motion.as_ref().map_or_else(unseen, |m| poses(model, shape, m));
    BodyPart {
        poses: base64_of_f32(body.motions.iter().flat_map(pose)),
        bind: base64_of_f32(poses(model, shape, &bind_pose(model, shape))),
        parts: model.parts.len(),
        flesh: flesh(model, shape),
    }
}

fn poses(model: &BodyModel, shape: &Shape, motion: &Motion) -> Vec<f64> {
    let body = Posed::new(model, shape, motion);
    let pose = |i: usize| {
        let place = body.origin_of_part(PartId(i));
        let [x, y, z, w] =
            quaternion(&Rotation3::from_matrix_unchecked(body.world_from_part(PartId(i))));
        [place.x, place.y, place.z, x, y, z, w]
    };
    (0..model.parts.len()).flat_map(pose).collect()
}

fn quaternion(rotation: &Rotation3<f64>) -> [f64; 4] {
    let q = UnitQuaternion::from_rotation_matrix(rotation);
    [q.i, q.j, q.k, q.w]
}

/// The skin, or the ellipsoids of a body without metaballs.
fn flesh(model: &BodyModel, shape: &Shape) -> FleshPart {
    let skin = skinned(model, shape).ok().filter(|_| model.parts.len() <= 255);
    let Some(SkinnedMesh { mesh, parts, weights, .. }) = skin else {
        return FleshPart::Ellipsoids { ellipsoids: ellipsoids(model, shape) };
    };

    let rows =
        |vectors: &[Vector3<f64>]| base64_of_f32(vectors.iter().flat_map(|v| [v.x, v.y, v.z]));
    let corners = mesh.triangles.iter().flatten();
    FleshPart::Skin {
        vertices: rows(&mesh.vertices),
        normals: rows(&mesh.normals),
        triangles: base64(corners.flat_map(|i| i.to_le_bytes())),
        bones: base64(parts.into_iter().flatten()),
        weights: base64(weights.into_iter().flatten().flat_map(f32::to_le_bytes)),
    }
}

fn ellipsoids(model: &BodyModel, shape: &Shape) -> Vec<EllipsoidPart> {
    let rest = Motion::rest(model);
    let body = Posed::new(model, shape, &rest);
    // the skin of a metaball alone: its ellipsoid, smaller
    let alone = (0.5 * 2_f64.ln()).sqrt();
    let (primitives, size) = match model.ellipsoids.as_slice() {
        [] => (&model.metaballs, alone),
        _ => (&model.ellipsoids, 1.0),
    };
    let part = |primitive: &Primitive| {
        let centre = body.primitive(primitive).centre;
        let radii = body.primitive_radii(primitive) * size;
        EllipsoidPart {
            part: primitive.part.0,
            centre: body.in_part(primitive.part, &centre.into()).into(),
            turn: quaternion(&primitive.part_from_primitive),
            radii: radii.into(),
        }
    };
    primitives.iter().map(part).collect()
}

fn base64(bytes: impl Iterator<Item = u8>) -> String {
    BASE64_STANDARD.encode(bytes.collect::<Vec<_>>())
}

fn base64_of_f32(values: impl IntoIterator<Item = f64>) -> String {
    base64(values.into_iter().flat_map(|v| (v as f32).to_le_bytes()))
}

pub(super) fn base64_of_i16(values: &[i16]) -> String {
    base64(values.iter().flat_map(|v| v.to_le_bytes()))
}
