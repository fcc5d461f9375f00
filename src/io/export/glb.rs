//! glTF 2.0, binary: one skin, a bone for each part, and one animation.
//!
//! Metres, seconds, Y up: the node `body` turns our world into the file's, (X, Y, Z) to (Y, Z, X), so that who faces our X
//! faces the file's +Z; below it everything stands in our world. Bones hang on each other as the parts do, and their names are the parts'. The inverse bind matrix
//! of a bone is the inverse of its pose of binding: rest, with arms and legs apart. The skin is that of the metaballs; of a body without them
//! it is one mesh per ellipsoid, carried by its bone as it was fitted. Frames without a fit have no key, so viewers interpolate.
//!
//! # Source
//! Khronos, glTF 2.0 specification.

use nalgebra::{Isometry3, Rotation3, Translation3, UnitQuaternion, Vector3};
use serde_json::{Value, json};

use crate::body::{BodyModel, Motion, PartId, Posed, Shape};
use crate::camera::UpAxis;
use crate::skin::{BONES, SkinError, SkinnedMesh, skinned, skinned_ellipsoids};

/// Why there is no file.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum GlbError {
    /// No skin.
    #[error(transparent)]
    Skin(#[from] SkinError),
    /// No fit in any frame.
    #[error("nobody was seen in any frame")]
    Empty,
    /// More parts than an 8-bit index can name.
    #[error("the body {body} has {parts} parts: a glTF export has 255 at most")]
    Parts {
        /// The model.
        body: String,
        /// Found.
        parts: usize,
    },
    /// More than 4 GB.
    #[error("the file would have more than 4 GB: export fewer frames")]
    Size,
}

/// The bytes of a file.
///
/// # Errors
/// [`GlbError`].
pub fn glb(
    model: &BodyModel,
    shape: &Shape,
    motions: &[Option<Motion>],
    rate_hz: f64,
) -> Result<Vec<u8>, GlbError> {
    let parts = model.parts.len();
    if parts > 255 {
        let body = model.name.clone();
        return Err(GlbError::Parts { body, parts });
    }
    if motions.iter().all(Option::is_none) {
        return Err(GlbError::Empty);
    }

    let skin = match model.metaballs.is_empty() {
        true => skinned_ellipsoids(model, shape),
        false => skinned(model, shape)?,
    };
    let rest = poses(&Posed::new(model, shape, &skin.bind));
    let parents = parents(model);

    let mut data = Data::default();
    let mesh = mesh(&mut data, &skin);
    let bind = rest.iter().map(|pose| pose.inverse().to_homogeneous());
    let bind: Vec<f32> =
        bind.flat_map(|m| m.iter().map(|v| *v as f32).collect::<Vec<_>>()).collect();
    let bind = data.floats("MAT4", &bind);

    let keys: Vec<(usize, &Motion)> =
        motions.iter().enumerate().filter_map(|(i, m)| Some((i, m.as_ref()?))).collect();
    let local_poses: Vec<_> =
        keys.iter().map(|(_, m)| local(&poses(&Posed::new(model, shape, m)), &parents)).collect();
    let seconds: Vec<f32> = keys.iter().map(|(i, _)| (*i as f64 / rate_hz) as f32).collect();
    let animation = animation(&mut data, &seconds, &local_poses);

    let document = json!({
        "asset": { "version": "2.0", "generator": concat!("maquette ", env!("CARGO_PKG_VERSION")) },
        "scene": 0,
        "scenes": [{ "nodes": [parts, parts + 1] }],
        "nodes": nodes(model, &local(&rest, &parents), &parents),
        "meshes": [mesh],
        "materials": [{ "name": "skin", "pbrMetallicRoughness":
            { "baseColorFactor": [0.7, 0.48, 0.37, 1.0], "metallicFactor": 0.0, "roughnessFactor": 0.85 } }],
        "skins": [{ "joints": (0..parts).collect::<Vec<_>>(), "inverseBindMatrices": bind }],
        "animations": [animation],
        "accessors": data.accessors,
        "bufferViews": data.views,
        "buffers": [{ "byteLength": data.bytes.len() }],
    });

    container(&document, data.bytes)
}

/// A node for each part, then `body` above them, then the mesh.
fn nodes(model: &BodyModel, local: &[Isometry3<f64>], parents: &[Option<usize>]) -> Vec<Value> {
    let children =
        |of: Option<usize>| (0..parents.len()).filter(|i| parents[*i] == of).collect::<Vec<_>>();

    let part = |i: usize| {
        let mut node = json!({
            "name": model.parts[i].name,
            "translation": translation(&local[i]),
            "rotation": rotation(&local[i].rotation),
        });
        let children = children(Some(i));
        if !children.is_empty() {
            node["children"] = json!(children);
        }
        node
    };

    let mut nodes: Vec<Value> = (0..parents.len()).map(part).collect();

    // glTF has Y up
    let turn = Rotation3::from_matrix_unchecked(UpAxis::Y.export_from_world());
    let turn = rotation(&UnitQuaternion::from_rotation_matrix(&turn));
    nodes.push(json!({ "name": "body", "rotation": turn, "children": children(None) }));
    nodes.push(json!({ "name": "skin", "mesh": 0, "skin": 0 }));
    nodes
}

fn mesh(data: &mut Data, skin: &SkinnedMesh) -> Value {
    let numbers = |of: &[Vector3<f64>]| {
        of.iter().flat_map(|v| [v.x as f32, v.y as f32, v.z as f32]).collect::<Vec<_>>()
    };
    let position = data.floats("VEC3", &numbers(&skin.mesh.vertices));
    let normal = data.floats("VEC3", &numbers(&skin.mesh.normals));
    let weights = data.floats("VEC4", &skin.weights.concat());
    // what has no weight names no bone
    let joint = |(parts, weights): (&[u8; BONES], &[f32; BONES])| -> Vec<u8> {
        let pairs = parts.iter().zip(weights);
        pairs.map(|(part, weight)| if *weight > 0.0 { *part } else { 0 }).collect()
    };
    let joints: Vec<u8> = skin.parts.iter().zip(&skin.weights).flat_map(joint).collect();
    let joints = data.push("VEC4", UNSIGNED_BYTE, joints.len() / 4, &joints, json!({}));

    let corners = skin.mesh.triangles.iter().flatten();
    let count = 3 * skin.mesh.triangles.len();
    let corners: Vec<u8> = corners.flat_map(|i| i.to_le_bytes()).collect();
    let indices = data.push("SCALAR", UNSIGNED_INT, count, &corners, json!({}));
    json!({ "name": "skin", "primitives": [{
        "attributes": { "POSITION": position, "NORMAL": normal, "JOINTS_0": joints, "WEIGHTS_0": weights },
        "indices": indices,
        "material": 0,
    }] })
}

/// Translations and rotations of every part at every key.
fn animation(data: &mut Data, seconds: &[f32], keys: &[Vec<Isometry3<f64>>]) -> Value {
    let input = data.floats("SCALAR", seconds);
    let (mut samplers, mut channels) = (Vec::new(), Vec::new());
    let parts = keys.first().map_or(0, Vec::len);
    for part in 0..parts {
        let places: Vec<f32> =
            keys.iter().flat_map(|k| translation(&k[part]).map(|v| v as f32)).collect();
        let mut last = UnitQuaternion::identity();
        let mut turns: Vec<f32> = Vec::new();
        for key in keys {
            // of the two quaternions of a rotation the one that is nearer to the last
            let turn = key[part].rotation;
            last = if last.coords.dot(&turn.coords) < 0.0 {
                UnitQuaternion::new_unchecked(-turn.into_inner())
            } else {
                turn
            };
            turns.extend(rotation(&last));
        }
        let outputs = [
            ("translation", data.floats("VEC3", &places)),
            ("rotation", data.floats("VEC4", &turns)),
        ];
        for (path, output) in outputs {
            channels.push(
                json!({ "sampler": samplers.len(), "target": { "node": part, "path": path } }),
            );
            samplers.push(json!({ "input": input, "output": output, "interpolation": "LINEAR" }));
        }
    }
    json!({ "name": "motion", "samplers": samplers, "channels": channels })
}

/// The parent of each part: the part of the nearest joint before its own.
fn parents(model: &BodyModel) -> Vec<Option<usize>> {
    let parent = |i: usize| {
        let mut joint = model.parts[i].joint?;
        loop {
            let before = model.joints[joint.0].parent;
            let part = model.parts.iter().position(|p| p.joint == before);
            match (part, before) {
                (Some(part), _) => return Some(part),
                (None, Some(before)) => joint = before,
                (None, None) => return None,
            }
        }
    };
    (0..model.parts.len()).map(parent).collect()
}

fn poses(body: &Posed<'_>) -> Vec<Isometry3<f64>> {
    let pose = |i: usize| {
        let turn = Rotation3::from_matrix_unchecked(body.world_from_part(PartId(i)));
        let place = body.origin_of_part(PartId(i)).coords;
        Isometry3::from_parts(
            Translation3::from(place),
            UnitQuaternion::from_rotation_matrix(&turn),
        )
    };
    (0..body.model.parts.len()).map(pose).collect()
}

fn local(poses: &[Isometry3<f64>], parents: &[Option<usize>]) -> Vec<Isometry3<f64>> {
    let own = poses.iter().zip(parents);
    own.map(|(pose, parent)| parent.map_or(*pose, |p| poses[p].inverse() * pose)).collect()
}

fn translation(pose: &Isometry3<f64>) -> [f64; 3] {
    pose.translation.vector.into()
}

/// In the file's precision, with a unit quaternion's numbers within ±1.
fn rotation(turn: &UnitQuaternion<f64>) -> [f32; 4] {
    [turn.i, turn.j, turn.k, turn.w].map(|v| (v as f32).clamp(-1.0, 1.0))
}

const UNSIGNED_BYTE: u32 = 5121;
const UNSIGNED_INT: u32 = 5125;
const FLOAT: u32 = 5126;

/// The binary part, and what describes it.
#[derive(Debug, Default)]
struct Data {
    bytes: Vec<u8>,
    views: Vec<Value>,
    accessors: Vec<Value>,
}

impl Data {
    /// Appends numbers; the number of their accessor.
    fn floats(&mut self, kind: &'static str, values: &[f32]) -> usize {
        let width = match kind {
            "SCALAR" => 1,
            "VEC3" => 3,
            "VEC4" => 4,
            _ => 16,
        };
        let of = |k: usize| values.iter().skip(k).step_by(width).copied();
        let least: Vec<f32> = (0..width).map(|k| of(k).fold(f32::INFINITY, f32::min)).collect();
        let most: Vec<f32> = (0..width).map(|k| of(k).fold(f32::NEG_INFINITY, f32::max)).collect();
        let bytes: Vec<u8> = values.iter().flat_map(|v| v.to_le_bytes()).collect();
        let bounds = json!({ "min": least, "max": most });
        self.push(kind, FLOAT, values.len() / width, &bytes, bounds)
    }

    fn push(
        &mut self,
        kind: &str,
        component: u32,
        count: usize,
        bytes: &[u8],
        mut accessor: Value,
    ) -> usize {
        self.views.push(
            json!({ "buffer": 0, "byteOffset": self.bytes.len(), "byteLength": bytes.len() }),
        );

        accessor["bufferView"] = json!(self.views.len() - 1);
        accessor["componentType"] = json!(component);
        accessor["count"] = json!(count);
        accessor["type"] = json!(kind);
        self.accessors.push(accessor);
        self.bytes.extend_from_slice(bytes);
        self.bytes.resize(self.bytes.len().next_multiple_of(4), 0);
        self.accessors.len() - 1
    }
}

/// Header and two chunks, each of whole fours of bytes.
fn container(document: &Value, binary: Vec<u8>) -> Result<Vec<u8>, GlbError> {
    let mut text = document.to_string().into_bytes();
    text.resize(text.len().next_multiple_of(4), b' ');
    let size = |n: usize| u32::try_from(n).map_err(|_| GlbError::Size);
    let mut file = b"glTF".to_vec();
    file.extend(2_u32.to_le_bytes());
    file.extend(size(12 + 8 + text.len() + 8 + binary.len())?.to_le_bytes());
    for (kind, chunk) in [(b"JSON", text), (b"BIN\0", binary)] {
        file.extend(size(chunk.len())?.to_le_bytes());
        file.extend(kind);
        file.extend(chunk);
    }
    Ok(file)
}

#[cfg(test)]
mod tests {
    use std::path::Path;

    use super::*;

    #[test]
    fn a_file_says_its_own_length_and_its_bones() {
        let model = crate::io::model::load("human-metaballs", Path::new("")).unwrap();
        let shape = Shape(model.statistics.mean.clone());
        let motions = [Some(Motion::rest(&model)), None, Some(Motion::rest(&model))];
        let file = glb(&model, &shape, &motions, 50.0).unwrap();
        let number = |at: usize| u32::from_le_bytes(file[at..at + 4].try_into().unwrap()) as usize;
        assert_eq!((&file[..4], number(8)), (&b"glTF"[..], file.len()));
        let json: Value = serde_json::from_slice(&file[20..20 + number(12)]).unwrap();
        assert_eq!(json["nodes"].as_array().unwrap().len(), model.parts.len() + 2);
        let times = json["animations"][0]["samplers"][0]["input"].as_u64().unwrap() as usize;
        assert_eq!(json["accessors"][times]["count"], 2);
        approx::assert_relative_eq!(
            json["accessors"][times]["max"][0].as_f64().unwrap(),
            0.04,
            epsilon = 1e-6
        );
        assert_eq!(glb(&model, &shape, &[None], 50.0), Err(GlbError::Empty));
    }

    #[test]
    fn a_body_of_ellipsoids_has_a_mesh_of_each() {
        let model = crate::io::model::load("human-ellipsoids", Path::new("")).unwrap();
        let shape = Shape(model.statistics.mean.clone());
        let file = glb(&model, &shape, &[Some(Motion::rest(&model))], 50.0).unwrap();
        let length = u32::from_le_bytes(file[12..16].try_into().unwrap()) as usize;
        let json: Value = serde_json::from_slice(&file[20..20 + length]).unwrap();
        let position = &json["meshes"][0]["primitives"][0]["attributes"]["POSITION"];
        let corners = json["accessors"][position.as_u64().unwrap() as usize]["count"].as_u64();
        let of_each =
            skinned_ellipsoids(&model, &shape).mesh.vertices.len() / model.ellipsoids.len();
        assert_eq!(corners.unwrap() as usize, of_each * model.ellipsoids.len());
    }
}
