//! A skin that bones move.

use nalgebra::{Matrix3, Point3, Vector3};

use crate::body::{BodyModel, Motion, PartId, Posed, Shape};
use crate::skin::{SkinError, SkinnedMesh, skinned};

/// A body's skin in its pose of binding, and where the parts are there.
#[derive(Debug, Clone, PartialEq)]
pub struct BoundSkin {
    pub(super) skin: SkinnedMesh,
    bind_poses: Vec<PartPose>,
}

/// A part's axes and its origin, in the world.
type PartPose = (Matrix3<f64>, Vector3<f64>);

/// A person's skin in one frame.
#[derive(Debug, Clone)]
pub(super) struct PosedSkin {
    pub(super) vertices: Vec<Vector3<f64>>,
    pub(super) normals: Vec<Vector3<f64>>,
}

impl BoundSkin {
    /// The skin of a body.
    ///
    /// # Errors
    /// [`SkinError`] if the body cannot have a skin.
    pub(super) fn new(model: &BodyModel, shape: &Shape) -> Result<Self, SkinError> {
        let skin = skinned(model, shape)?;
        Ok(Self { bind_poses: part_poses(model, shape, &skin.bind), skin })
    }

    /// The skin of a fitted body: b(p) outside that of the model, as its [offsets](crate::body::SurfaceOffsets) say.
    ///
    /// # Errors
    /// [`SkinError`] if the body cannot have a skin.
    pub fn fitted(model: &BodyModel, shape: &Shape) -> Result<Self, SkinError> {
        let mut bound = Self::new(model, shape)?;
        let SkinnedMesh { mesh, bind, parts, weights } = &mut bound.skin;
        let body = Posed::new(model, shape, bind);
        for (i, vertex) in mesh.vertices.iter_mut().enumerate() {
            let place: Point3<f64> = (*vertex).into();
            let offset_m = |part: &u8| {
                let part = PartId(usize::from(*part));
                body.surface_offset_at(part, &place).map_or(0.0, |b| b.value_m)
            };
            let shares = parts[i].iter().zip(weights[i]);
            let out_m: f64 = shares.map(|(part, weight)| f64::from(weight) * offset_m(part)).sum();
            *vertex += mesh.normals[i] * out_m;
        }
        Ok(bound)
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
}

fn part_poses(model: &BodyModel, shape: &Shape, motion: &Motion) -> Vec<PartPose> {
    let body = Posed::new(model, shape, motion);
    let all = (0..model.parts.len()).map(PartId);
    all.map(|part| (body.world_from_part(part), body.origin_of_part(part).coords)).collect()
}
