//! Bones: at which joint the bone of each part ends, and how far publications disagree on where its own joint lies.

use nalgebra::Vector3;

use super::{BodyModel, JointId, PartId};

impl BodyModel {
    /// How far publications disagree on where in the flesh a part's joint lies: standard deviations along the part's axes,
    /// metres, with the spread of its pivot.
    pub fn scatter_m(&self, part: PartId) -> Vector3<f64> {
        let part = &self.parts[part.0];
        let covariance = &self.statistics.covariance;
        let mut variance = part.sd_m.component_mul(&part.sd_m);
        let pairs = part.pivot.iter().flat_map(|a| part.pivot.iter().map(move |b| (a, b)));
        for (a, b) in pairs {
            let shared = covariance[(a.coefficient.0, b.coefficient.0)];
            variance += a.direction.component_mul(&b.direction) * shared;
        }
        variance.map(f64::sqrt)
    }

    /// For each part, the part at whose joint its bone ends; the bone begins at its own joint.
    ///
    /// `None` for a part that has no joint of its own, that ends a limb, or that only branches to both sides.
    pub(crate) fn bones(&self) -> Vec<Option<PartId>> {
        let parents = self.part_parents();
        let own_joint = |part: usize| self.own_joints(part, parents[part]).first().copied();
        let is_middle = |joint: JointId| self.joints[joint.0].translation.value.y == 0.0;

        let bone = |part: usize| {
            own_joint(part)?;
            let beyond = (0..parents.len()).filter(|&child| parents[child] == Some(part));
            let beyond: Vec<(usize, JointId)> =
                beyond.filter_map(|c| Some((c, own_joint(c)?))).collect();

            // where it branches, the one branch in the middle of the body
            let mut middle = beyond.iter().filter(|(_, joint)| is_middle(*joint));
            let next = match beyond.as_slice() {
                [only] => Some(only),
                _ => middle.next().filter(|_| middle.next().is_none()),
            };
            next.map(|(child, _)| PartId(*child))
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
