//! The skin of the body for a program that bends it with bones (linear blend skinning).
//!
//! The skin at the pose of binding is carried along by the parts: vertex v moves to Σₖ wₖ · Tₖ · T⁰ₖ⁻¹ · v, with T and T⁰ the
//! poses of the part now and there. That pose is rest with arms and legs apart ([`bind_pose`]), so that no skin lies against
//! another. The weight wₖ is the share of part k's metaballs in the field of the limb that the vertex lies on,
//! F = Σ fᵢ; the four parts with the largest shares count. Far from joints this is the fitted skin itself. At a bent joint
//! it differs a little: a blend of two rotations is not the sum of two Gaussians.

use nalgebra::Vector3;

use super::{Mesh, SkinError, SkinOptions, skin};
use crate::body::metaball::Field;
use crate::body::{BodyModel, Motion, Posed, Shape};

/// Parts that may move one vertex.
pub const BONES: usize = 4;

/// A skin and what moves it.
#[derive(Debug, Clone, PartialEq)]
pub struct SkinnedMesh {
    /// In the pose of binding.
    pub mesh: Mesh,
    /// That pose.
    pub bind: Motion,
    /// For each vertex [`BONES`] parts.
    pub parts: Vec<[u8; BONES]>,
    /// Their weights: they sum to 1.
    pub weights: Vec<[f32; BONES]>,
}

/// The skin of a body in its pose of binding with its weights, about 5000 vertices for a person.
///
/// # Errors
/// [`SkinError`] if the body cannot have a skin.
pub fn skinned(model: &BodyModel, shape: &Shape) -> Result<SkinnedMesh, SkinError> {
    let bind = bind_pose(model, shape);
    let body = Posed::new(model, shape, &bind);
    let mesh = skin(&body, &SkinOptions::with_around(32))?;
    let field = Field::from_body(&body);
    let vertices = mesh.vertices.iter();
    let (parts, weights) = vertices.map(|v| weights(model, &field, v)).unzip();
    Ok(SkinnedMesh { mesh, bind, parts, weights })
}

/// Joints that spread the limbs, by the beginning of their names in the shipped models, and by how much, radians.
const APART: [(&str, f64); 2] = [("shoulder_abduction", 0.9), ("hip_abduction", 0.15)];

/// Rest with arms and legs apart: each joint that spreads a limb is turned to the side that makes the body wider.
pub fn bind_pose(model: &BodyModel, shape: &Shape) -> Motion {
    let mut bind = Motion::rest(model);
    for (i, joint) in model.joints.iter().enumerate() {
        let apart = APART.iter().find(|(name, _)| joint.name.starts_with(name));
        let Some((_, angle)) = apart else {
            continue;
        };

        let [one, other] = [*angle, -*angle].map(|angle| {
            let mut motion = bind.clone();
            motion.angles[i] = (joint.rest + angle).clamp(joint.limits.0, joint.limits.1);
            motion
        });
        let width = |motion: &Motion| {
            let bounds = Posed::new(model, shape, motion).bounds();
            bounds.map_or(0.0, |(low, high)| (high - low).xy().norm())
        };
        bind = match width(&one) >= width(&other) {
            true => one,
            false => other,
        };
    }
    bind
}

/// The parts that move a vertex, and the weight of each.
fn weights(model: &BodyModel, field: &Field, vertex: &Vector3<f64>) -> ([u8; BONES], [f32; BONES]) {
    // the limb that the vertex lies on
    let value = |i: &usize| (-2.0 * field.metaballs[*i].distance(vertex)).exp();
    let sum = |limb: &Vec<usize>| limb.iter().map(value).sum::<f64>();
    let own = field.limbs.iter().max_by(|a, b| sum(a).total_cmp(&sum(b)));

    // the share of each part in its field
    let mut shares = vec![0.0; model.parts.len()];
    for i in own.into_iter().flatten() {
        if let Some(source) = field.source(*i) {
            shares[model.metaballs[source].part.0] += value(i);
        }
    }

    // the largest few
    let mut order: Vec<usize> = (0..shares.len()).collect();
    order.sort_by(|a, b| shares[*b].total_cmp(&shares[*a]));
    let (mut parts, mut weights) = ([0; BONES], [0.0; BONES]);
    let total: f64 = order.iter().take(BONES).map(|k| shares[*k]).sum();
    for (slot, k) in order.into_iter().take(BONES).enumerate() {
        parts[slot] = u8::try_from(k).unwrap_or(0);
        weights[slot] = (shares[k] / total.max(f64::MIN_POSITIVE)) as f32;
    }
    (parts, weights)
}

#[cfg(test)]
mod tests {
    use std::path::Path;

    use super::*;

    #[test]
    fn every_vertex_hangs_on_its_parts_with_all_its_weight() {
        let model = crate::io::model::load("human-metaballs", Path::new("")).unwrap();
        let shape = Shape(model.statistics.mean.clone());
        let skin = skinned(&model, &shape).unwrap();
        assert_eq!(skin.weights.len(), skin.mesh.vertices.len());
        for weights in &skin.weights {
            approx::assert_relative_eq!(weights.iter().sum::<f32>(), 1.0, epsilon = 1e-5);
        }
        // a foot's lowest vertex does not hang on a hand
        let lowest = (0..skin.parts.len())
            .min_by(|a, b| skin.mesh.vertices[*a].z.total_cmp(&skin.mesh.vertices[*b].z))
            .unwrap();
        let part = &model.parts[usize::from(skin.parts[lowest][0])].name;
        assert!(part.contains("foot"), "{part}");
    }

    #[test]
    fn no_vertex_hangs_on_an_arm_and_a_leg() {
        let model = crate::io::model::load("human-metaballs", Path::new("")).unwrap();
        let shape = Shape(model.statistics.mean.clone());
        let skin = skinned(&model, &shape).unwrap();
        let share = |i: usize, names: [&str; 2]| -> f32 {
            let is_one = |k: &usize| {
                let part = &model.parts[usize::from(skin.parts[i][*k])].name;
                names.iter().any(|name| part.contains(name))
            };
            (0..BONES).filter(is_one).map(|k| skin.weights[i][k]).sum()
        };
        for i in 0..skin.parts.len() {
            let (arm, leg) = (share(i, ["forearm", "hand"]), share(i, ["thigh", "pelvis"]));
            assert!(arm.min(leg) < 0.01, "vertex {i}: {arm} {leg}");
        }
    }
}
