//! A dressed person: a skin that bones move, with cloth tied to it.

use nalgebra::{Matrix3, Vector3};
use rand::Rng;

use super::texture::{Colour, Texture};
use crate::body::{BodyModel, Motion, PartId, Posed, Shape};
use crate::skin::{SkinError, SkinnedMesh, skinned};

/// Shirt, trousers, skin, shoes, hair.
const ZONES: usize = 5;
const SHIRT: usize = 0;
const TROUSERS: usize = 1;
const SKIN: usize = 2;
const SHOES: usize = 3;
const HAIR: usize = 4;
/// Height of the hair line over the middle of the head, metres, …
const HAIR_M: f64 = 0.03;
/// … and how much lower it lies for each metre behind the middle.
const HAIR_SLOPE: f64 = 1.1;

/// A person's skin, and what is worn where.
#[derive(Debug, Clone)]
pub(super) struct DressedPerson {
    pub(super) skin: SkinnedMesh,
    bind_poses: Vec<PartPose>,
    /// Share of each zone in each vertex.
    zones: Vec<[f32; ZONES]>,
    textures: [Texture; ZONES],
}

/// A part's axes and its origin, in the world.
type PartPose = (Matrix3<f64>, Vector3<f64>);

/// A person's skin in one frame.
#[derive(Debug, Clone)]
pub(super) struct PosedSkin {
    pub(super) vertices: Vec<Vector3<f64>>,
    pub(super) normals: Vec<Vector3<f64>>,
}

impl DressedPerson {
    /// Textures drawn for a body.
    ///
    /// # Errors
    /// [`SkinError`] if the body cannot have a skin.
    pub(super) fn random(
        model: &BodyModel,
        shape: &Shape,
        rng: &mut impl Rng,
    ) -> Result<Self, SkinError> {
        let skin = skinned(model, shape)?;
        let zones = zones(model, &skin);

        let textures = [
            Texture::printed(rng),
            Texture::printed(rng),
            Texture::plain([0.72, 0.52, 0.42], 0.15, rng),
            Texture::plain([0.22, 0.2, 0.2], 0.5, rng),
            Texture::plain([0.2, 0.14, 0.1], 0.5, rng),
        ];

        Ok(Self { bind_poses: part_poses(model, shape, &skin.bind), zones, textures, skin })
    }

    /// The skin as the parts move it: v ↦ Σₖ wₖ·(Rₖ R⁰ₖᵀ (v − o⁰ₖ) + oₖ).
    pub(super) fn posed(&self, model: &BodyModel, shape: &Shape, motion: &Motion) -> PosedSkin {
        let now = part_poses(model, shape, motion);
        let moves: Vec<PartPose> = now
            .iter()
            .zip(&self.bind_poses)
            .map(|(now, bind)| {
                let turn = now.0 * bind.0.transpose();
                (turn, now.1 - turn * bind.1)
            })
            .collect();

        // every vertex is moved by the mean of its parts' motions
        let mesh = &self.skin.mesh;
        let blended = (0..mesh.vertices.len()).map(|i| {
            let (mut turn, mut shift) = (Matrix3::zeros(), Vector3::zeros());
            for (part, weight) in self.skin.parts[i].iter().zip(self.skin.weights[i]) {
                let (own_turn, own_shift) = &moves[usize::from(*part)];
                turn += own_turn * f64::from(weight);
                shift += own_shift * f64::from(weight);
            }
            let normal = turn * mesh.normals[i];
            (turn * mesh.vertices[i] + shift, normal.try_normalize(1e-9).unwrap_or(normal))
        });

        let (vertices, normals) = blended.unzip();
        PosedSkin { vertices, normals }
    }

    /// The colour at a place on a triangle.
    pub(super) fn colour(
        &self,
        triangle: [u32; 3],
        mix: impl Fn([[f32; 8]; 3]) -> [f32; 8],
    ) -> Colour {
        let corner = |i: u32| {
            let place = self.skin.mesh.vertices[i as usize].cast::<f32>();
            let zones = self.zones[i as usize];
            std::array::from_fn(|k| if k < 3 { place[k] } else { zones[k - 3] })
        };
        let at = mix(triangle.map(corner));
        let worn = (0..ZONES).max_by(|a, b| at[3 + a].total_cmp(&at[3 + b]));
        self.textures[worn.unwrap_or(SKIN)].at([at[0], at[1], at[2]])
    }
}

fn part_poses(model: &BodyModel, shape: &Shape, motion: &Motion) -> Vec<PartPose> {
    let body = Posed::new(model, shape, motion);
    let all = (0..model.parts.len()).map(PartId);
    all.map(|part| (body.world_from_part(part), body.origin_of_part(part).coords)).collect()
}

/// Share of each zone in each vertex, from the parts that move it.
fn zones(model: &BodyModel, skin: &SkinnedMesh) -> Vec<[f32; ZONES]> {
    let zone_of_part: Vec<usize> = model.parts.iter().map(|part| zone(&part.name)).collect();
    let is_head = |i: &usize| model.parts[usize::from(skin.parts[*i][0])].name == "head";

    // the middle of the head, above which there is hair
    let vertices = &skin.mesh.vertices;
    let head: Vec<usize> = (0..vertices.len()).filter(is_head).collect();
    let middle = head.iter().map(|i| vertices[*i] / head.len() as f64).sum::<Vector3<f64>>();

    let vertex_zones = |i: usize| {
        let mut shares = [0.0; ZONES];
        for (part, weight) in skin.parts[i].iter().zip(skin.weights[i]) {
            shares[zone_of_part[usize::from(*part)]] += weight;
        }
        let above = vertices[i] - middle;
        if is_head(&i) && above.z + HAIR_SLOPE * -above.x > HAIR_M {
            shares = [0.0; ZONES];
            shares[HAIR] = 1.0;
        }
        shares
    };
    (0..vertices.len()).map(vertex_zones).collect()
}

fn zone(part: &str) -> usize {
    let begins = |names: &[&str]| names.iter().any(|name| part.starts_with(name));
    if begins(&["pelvis", "thigh", "shank"]) {
        TROUSERS
    } else if begins(&["abdomen", "thorax", "upper_arm", "forearm"]) {
        SHIRT
    } else if begins(&["foot"]) {
        SHOES
    } else {
        SKIN
    }
}
