//! What the places of the joints' centres in the flesh leave open: of points, and of the angles between bones.
//!
//! What is seen is flesh; where in it a joint's centre lies is known to [`NamedPoint::sd_m`](super::NamedPoint::sd_m). Let the centres
//! lie δ from where the model has them. The bone of a part, L from its own centre to the next one, then points elsewhere: it is turned by
//!
//! ω = L × (δ_end − δ_start)/‖L‖²
//!
//! (not about itself: that, the flesh shows). An angle is that between two bones, so its joint's angle is off by
//! a·(ω_part − ω_carrier), a the joint's axis. The δ of different centres are independent; the one between both bones
//! turns both. To first order, and for axes of one joint that are nearly orthogonal.

use std::collections::BTreeMap;

use nalgebra::{DVector, Matrix3, Vector3};

use super::{FrameId, JointId, Posed};

/// A part's bone: the exported points at its two ends.
#[derive(Debug, Clone, Copy)]
struct Bone {
    start: usize,
    end: usize,
}

impl Posed<'_> {
    /// Covariance in the world of where an exported point lies in the flesh, square metres.
    pub fn point_spread(&self, index: usize) -> Matrix3<f64> {
        let point = &self.model.points[index];
        let axes = point
            .places
            .first()
            .map_or(self.frames[0], |(part, _)| *self.frame(*part));
        let axes = axes.world_from_frame;
        axes * Matrix3::from_diagonal(&point.sd_m.component_mul(&point.sd_m)) * axes.transpose()
    }

    /// Variance of each angle for where the centres at the ends of its bones lie in the flesh, square radians.
    ///
    /// By joint. A part without an exported point at its own joint and one at its far end has no bone, and adds nothing.
    pub fn angle_spread(&self) -> DVector<f64> {
        let parents = self.model.part_parents();
        let bones = self.bones(&parents);
        let places = self.points();
        let mut spread = DVector::zeros(self.model.joints.len());
        for (part, parent) in parents.iter().enumerate() {
            // how the angle turns when a point moves: by index of the point
            let mut turns: BTreeMap<usize, Matrix3<f64>> = BTreeMap::new();
            let bone_of = |part: Option<usize>| part.and_then(|p| bones[p]);
            for (bone, sign) in [(bone_of(Some(part)), 1.0), (bone_of(*parent), -1.0)] {
                let Some(bone) = bone else { continue };
                let along: Vector3<f64> = places[bone.end] - places[bone.start];
                let turned = along.cross_matrix() * (sign / along.norm_squared().max(1e-12));
                *turns.entry(bone.end).or_default() += turned;
                *turns.entry(bone.start).or_default() -= turned;
            }
            for joint in self.own_joints(part, *parent) {
                let axis = self.turns_world[FrameId::of(Some(joint)).0];
                spread[joint.0] = self.variance_along(&axis, &turns);
            }
        }
        spread
    }

    /// aᵀ(Σ B S Bᵀ)a over the points, each with its B.
    fn variance_along(&self, axis: &Vector3<f64>, turns: &BTreeMap<usize, Matrix3<f64>>) -> f64 {
        let of_point = |(point, turned): (&usize, &Matrix3<f64>)| {
            let moved = turned.tr_mul(axis);
            moved.dot(&(self.point_spread(*point) * moved))
        };
        turns.iter().map(of_point).sum()
    }

    /// By part.
    fn bones(&self, parents: &[Option<usize>]) -> Vec<Option<Bone>> {
        let of_part = |part: usize, is_centre: bool| {
            self.model
                .points
                .iter()
                .position(|point| match &point.places[..] {
                    [(owner, at)] => owner.0 == part && (at.value.norm() < 1e-9) == is_centre,
                    _ => false,
                })
        };
        let bone = |part: usize| {
            let centres = |child: usize| of_part(child, true);
            let children = (0..parents.len()).filter(|&child| parents[child] == Some(part));
            let ends: Vec<usize> = children.filter_map(centres).collect();
            let end = match ends.as_slice() {
                [] => of_part(part, false),
                [only] => Some(*only),
                _ => None,
            };
            Some(Bone {
                start: of_part(part, true)?,
                end: end?,
            })
        };
        (0..parents.len()).map(bone).collect()
    }

    /// The joints between a part and the one that carries it.
    fn own_joints(&self, part: usize, parent: Option<usize>) -> Vec<JointId> {
        let joint_of = |part: usize| self.model.parts[part].joint;
        let below = parent.and_then(joint_of);
        let mut own = self.model.chain(joint_of(part));
        let carried = own.iter().position(|&j| Some(j) == below);
        own.drain(..carried.map_or(0, |i| i + 1));
        own
    }
}
