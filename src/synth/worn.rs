//! What is worn where.

use nalgebra::Vector3;

use crate::body::BodyModel;
use crate::skin::SkinnedMesh;

/// Shirt, trousers, skin, shoes, hair.
pub(super) const ZONES: usize = 5;
pub(super) const SHIRT: usize = 0;
pub(super) const TROUSERS: usize = 1;
pub(super) const SKIN: usize = 2;
pub(super) const SHOES: usize = 3;
pub(super) const HAIR: usize = 4;
/// Height of the hair line over the middle of the head, metres, …
const HAIR_M: f64 = 0.03;
/// … and how much lower it lies for each metre behind the middle.
const HAIR_SLOPE: f64 = 1.1;

/// Share of each zone in each vertex, from the parts that move it.
pub(super) fn zones(model: &BodyModel, skin: &SkinnedMesh) -> Vec<[f32; ZONES]> {
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
