//! Limbs: the chains of parts within which metaballs blend.
//!
//! A sum over all metaballs would melt an arm that hangs beside the trunk into the trunk, and the thighs into each
//! other, which no silhouette shows. So metaballs belong to limbs (PFD99 § 3.3): the skin is that of the limb whose
//! sum is largest. **Differs** from PF02 eq. 3, which sums over the whole body. A body that is one chain, such as an
//! arm, has one limb, and there the sum is the paper's.

use super::{BodyModel, PartId};

impl BodyModel {
    /// The limbs in the order of their tips, each from its tip towards the root.
    ///
    /// Each leaf part is the tip of a limb, and so is each branching part but the root. A limb ends with the next part
    /// that branches, or with the root: so the trunk is a limb, and the pelvis belongs to it and to both legs. Parts are
    /// left out if neither they nor any part beyond them carries a metaball.
    pub fn limbs(&self) -> Vec<Vec<PartId>> {
        let parents = self.part_parents();
        let mut carries = vec![false; self.parts.len()];
        for ball in &self.metaballs {
            for part in towards_root(&parents, ball.part.0) {
                carries[part] = true;
            }
        }

        let carrying = || (0..self.parts.len()).filter(|&part| carries[part]);
        let mut children = vec![0_usize; self.parts.len()];
        for parent in carrying().filter_map(|part| parents[part]) {
            children[parent] += 1;
        }

        let is_tip = |&part: &usize| match children[part] {
            0 => true,
            1 => false,
            _ => parents[part].is_some(),
        };

        let limb = |tip: usize| {
            let mut limb = vec![PartId(tip)];
            for part in towards_root(&parents, tip).skip(1) {
                limb.push(PartId(part));
                if children[part] > 1 {
                    break;
                }
            }
            limb
        };

        carrying().filter(is_tip).map(limb).collect()
    }

    /// The two parts of each joint at which the skin folds.
    pub(crate) fn folds(&self) -> Vec<(PartId, PartId)> {
        let parents = self.part_parents();
        let folding = (0..self.parts.len()).filter(|&part| self.parts[part].folds);
        folding.filter_map(|part| Some((PartId(parents[part]?), PartId(part)))).collect()
    }

    /// The part on which each part sits.
    pub(crate) fn part_parents(&self) -> Vec<Option<usize>> {
        let first_at = |joint| self.parts.iter().position(|p| p.joint == joint);
        let parent = |part: usize| {
            let mut joint = self.parts[part].joint;
            loop {
                // several parts may share a frame: the first of them carries the others
                if let Some(other) =
                    first_at(joint).filter(|&other| other < part || joint != self.parts[part].joint)
                {
                    return Some(other);
                }
                joint = self.joints[joint?.0].parent;
            }
        };
        (0..self.parts.len()).map(parent).collect()
    }
}

/// A part and the parts that carry it, towards the root.
pub(crate) fn towards_root(parents: &[Option<usize>], part: usize) -> impl Iterator<Item = usize> {
    std::iter::successors(Some(part), |&p| parents[p])
}

#[cfg(test)]
mod tests {
    use nalgebra::{DMatrix, DVector, Rotation3, Vector3};

    use super::*;
    use crate::body::{
        FrameId, Joint, JointId, Part, Primitive, Root, ScaledVector, ShapeStatistics,
    };

    fn fixed(value: [f64; 3]) -> ScaledVector {
        ScaledVector::fixed(Vector3::from(value))
    }

    /// A tree of parts, one joint each but the root; all but those named `bare…` carry a ball.
    fn tree(parts: &[(&str, Option<usize>)]) -> BodyModel {
        // part i > 0 sits at joint i − 1
        let joint_of = |part: usize| part.checked_sub(1).map(JointId);
        let joint = |(name, parent): &(&str, Option<usize>)| Joint {
            name: (*name).to_owned(),
            parent: parent.and_then(joint_of),
            parent_from_joint: Rotation3::identity(),
            translation: fixed([0.3, 0.0, 0.0]),
            axis: Vector3::y_axis(),
            limits: (-1.0, 1.0),
            rest: 0.0,
            spread: 1.0,
            speed: 1.0,
        };
        let ball = |part: usize| Primitive {
            part: PartId(part),
            frame: FrameId::from_joint(joint_of(part)),
            centre: fixed([0.1, 0.0, 0.0]),
            home: Vector3::zeros(),
            radii: fixed([0.1; 3]),
            part_from_primitive: Rotation3::identity(),
        };
        let carrying = (0..parts.len()).filter(|&i| !parts[i].0.starts_with("bare"));
        BodyModel {
            name: "tree".into(),
            coefficients: Vec::new(),
            statistics: ShapeStatistics {
                mean: DVector::zeros(0),
                covariance: DMatrix::zeros(0, 0),
            },
            root: Root::Fixed,
            joints: parts[1..].iter().map(joint).collect(),
            followers: Vec::new(),
            offsets: None,
            parts: (0..parts.len())
                .map(|i| Part {
                    name: parts[i].0.into(),
                    joint: joint_of(i),
                    pivot: Vec::new(),
                    sd_m: Vector3::zeros(),
                    folds: false,
                })
                .collect(),
            ellipsoids: Vec::new(),
            metaballs: carrying.map(ball).collect(),
            points: Vec::new(),
            keypoints: Vec::new(),
            poses: Vec::new(),
            lengths: Vec::new(),
        }
    }

    fn names(model: &BodyModel) -> Vec<String> {
        let name = |limb: &Vec<PartId>| {
            let names: Vec<_> = limb.iter().map(|p| model.parts[p.0].name.as_str()).collect();
            names.join(" ")
        };
        model.limbs().iter().map(name).collect()
    }

    #[test]
    fn a_chain_is_one_limb() {
        let arm = tree(&[("shoulder", None), ("upper", Some(0)), ("lower", Some(1))]);
        assert_eq!(names(&arm), ["lower upper shoulder"]);
    }

    #[test]
    fn the_trunk_is_a_limb_and_its_ends_belong_to_those_beyond() {
        let person = tree(&[
            ("pelvis", None),
            ("abdomen", Some(0)),
            ("thorax", Some(1)),
            ("head", Some(2)),
            ("arm", Some(2)),
            ("hand", Some(4)),
            ("leg_l", Some(0)),
            ("leg_r", Some(0)),
        ]);
        let expected = [
            "thorax abdomen pelvis",
            "head thorax",
            "hand arm thorax",
            "leg_l pelvis",
            "leg_r pelvis",
        ];
        assert_eq!(names(&person), expected);
    }

    #[test]
    fn a_part_without_metaballs_makes_no_branch() {
        let arm = tree(&[("upper", None), ("bare_marker", Some(0)), ("lower", Some(0))]);
        assert_eq!(names(&arm), ["lower upper"]);
    }
}
