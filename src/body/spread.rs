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

use super::{BodyModel, FrameId, JointId, Posed};

/// A part's bone: the exported points at its two ends.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Bone {
    pub(crate) start: usize,
    pub(crate) end: usize,
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
        let bones = self.model.bones();
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
            for joint in self.model.own_joints(part, *parent) {
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
}

impl BodyModel {
    /// The exported point at a part's own joint.
    pub(crate) fn centre_of_part(&self, part: usize) -> Option<usize> {
        self.point_of_part(part, |at| at.norm() < 1e-9)
    }

    fn point_of_part(&self, part: usize, is_it: impl Fn(&Vector3<f64>) -> bool) -> Option<usize> {
        self.points
            .iter()
            .position(|point| match &point.places[..] {
                [(owner, at)] => owner.0 == part && is_it(&at.value),
                _ => false,
            })
    }

    /// By part.
    pub(crate) fn bones(&self) -> Vec<Option<Bone>> {
        let parents = self.part_parents();
        let bone = |part: usize| {
            let children = (0..parents.len()).filter(|&child| parents[child] == Some(part));
            let ends: Vec<usize> = children.filter_map(|c| self.centre_of_part(c)).collect();
            let end = match ends.as_slice() {
                [] => self.point_of_part(part, |at| at.norm() >= 1e-9),
                [only] => Some(*only),
                _ => None,
            };
            Some(Bone {
                start: self.centre_of_part(part)?,
                end: end?,
            })
        };
        (0..parents.len()).map(bone).collect()
    }

    /// The joints between a part and the one that carries it.
    pub(crate) fn own_joints(&self, part: usize, parent: Option<usize>) -> Vec<JointId> {
        let joint_of = |part: usize| self.parts[part].joint;
        let below = parent.and_then(joint_of);
        let mut own = self.chain(joint_of(part));
        let carried = own.iter().position(|&j| Some(j) == below);
        own.drain(..carried.map_or(0, |i| i + 1));
        own
    }
}
