//! Which tubes a body's skin is made of: a trunk, and limbs that grow out of it.

use crate::body::{BodyModel, PartId};

/// A chain of parts and what grows out of it.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Chain {
    /// The parts, each grown out of the one before.
    pub(super) parts: Vec<PartId>,
    /// The part of another chain that it grows out of; `None` for the trunk.
    pub(super) base: Option<PartId>,
    /// What grows out of it.
    pub(super) limbs: Vec<Chain>,
}

/// The trunk of a model with all its limbs; `None` without metaballs.
///
/// The trunk runs through the root from end to end. Where a part has several children, it goes on with the one of no
/// side (whose name does not end in `_r` or `_l`) that carries most parts, and ends where there is none such; the other
/// children are limbs. Of a trunk with exactly two limbs at one end, that end is the first.
pub(super) fn plan(model: &BodyModel) -> Option<Chain> {
    let tree = Tree::new(model);
    let root = tree.root?;

    // from the root forwards and backwards
    let mut ahead = tree.middle_children(root).into_iter();
    let forwards = ahead.next().map_or(vec![], |child| tree.descend(child));
    let backwards = ahead.next().map_or(vec![], |child| tree.descend(child));
    let mut parts: Vec<PartId> = backwards.into_iter().rev().collect();
    parts.push(root);
    parts.extend(forwards);

    // legs come first: turned around where they would come last
    let mut trunk = tree.chain(parts, None);
    if trunk.fork().is_none() {
        trunk.parts.reverse();
        if trunk.fork().is_none() {
            trunk.parts.reverse();
        }
    }
    Some(trunk)
}

impl Chain {
    /// The two limbs that grow out of its first part, as legs do; `None` if there are more or fewer.
    pub(super) fn fork(&self) -> Option<[&Self; 2]> {
        let first = self.parts.first().copied();
        let mut limbs = self.limbs.iter().filter(|limb| limb.base == first);
        match (limbs.next(), limbs.next(), limbs.next()) {
            (Some(a), Some(b), None) => Some([a, b]),
            _ => None,
        }
    }
}

/// Which part grows out of which, as far as they carry metaballs.
struct Tree<'a> {
    model: &'a BodyModel,
    root: Option<PartId>,
    children: Vec<Vec<PartId>>,
}

impl<'a> Tree<'a> {
    fn new(model: &'a BodyModel) -> Self {
        let count = model.parts.len();
        let mut children = vec![Vec::new(); count];
        let mut has_parent = vec![false; count];
        let mut tops = Vec::new();

        // a limb runs from its tip towards the root
        for limb in model.limbs() {
            tops.extend(limb.last().copied());
            for pair in limb.windows(2) {
                if !has_parent[pair[0].0] {
                    has_parent[pair[0].0] = true;
                    children[pair[1].0].push(pair[0]);
                }
            }
        }
        children.iter_mut().for_each(|parts| parts.sort());

        Self { model, root: tops.into_iter().find(|part| !has_parent[part.0]), children }
    }

    /// How many parts grow out of a part, itself included.
    fn size(&self, part: PartId) -> usize {
        let children = self.children[part.0].iter();
        1 + children.map(|c| self.size(*c)).sum::<usize>()
    }

    /// The children with which a trunk may go on, the one that carries most first.
    fn middle_children(&self, part: PartId) -> Vec<PartId> {
        let children = &self.children[part.0];
        let has_side = |part: &PartId| {
            let name = &self.model.parts[part.0].name;
            name.ends_with("_r") || name.ends_with("_l")
        };
        let is_middle = |part: &&PartId| children.len() == 1 || !has_side(part);
        let mut middle: Vec<PartId> = children.iter().filter(is_middle).copied().collect();
        middle.sort_by_key(|part| std::cmp::Reverse(self.size(*part)));
        middle
    }

    /// A part and the parts that go on from it.
    fn descend(&self, part: PartId) -> Vec<PartId> {
        let next = |part: &PartId| self.middle_children(*part).first().copied();
        std::iter::successors(Some(part), next).collect()
    }

    /// The chain of these parts, with all limbs that grow out of it.
    fn chain(&self, parts: Vec<PartId>, base: Option<PartId>) -> Chain {
        let mut limbs = Vec::new();
        for part in &parts {
            let branches = self.children[part.0].iter().filter(|c| !parts.contains(c));
            limbs.extend(branches.map(|c| self.chain(self.descend(*c), Some(*part))));
        }
        Chain { parts, base, limbs }
    }
}

#[cfg(test)]
mod tests {
    use std::path::Path;

    use super::*;

    fn names(model: &BodyModel, chain: &Chain) -> String {
        let parts = chain.parts.iter().map(|p| model.parts[p.0].name.as_str());
        parts.collect::<Vec<_>>().join(" ")
    }

    #[test]
    fn a_person_is_a_trunk_with_two_arms_and_two_legs() {
        let model = crate::io::model::load("walker-metaballs", Path::new("")).unwrap();
        let trunk = plan(&model).unwrap();
        assert_eq!(names(&model, &trunk), "pelvis abdomen thorax neck head");
        assert!(trunk.fork().is_some());
        let mut limbs: Vec<_> = trunk.limbs.iter().map(|l| names(&model, l)).collect();
        limbs.sort();
        let expected = [
            "thigh_l shank_l foot_l",
            "thigh_r shank_r foot_r",
            "upper_arm_l forearm_l hand_l",
            "upper_arm_r forearm_r hand_r",
        ];
        assert_eq!(limbs, expected);
    }

    #[test]
    fn a_model_without_metaballs_has_no_trunk() {
        let model = crate::io::model::load("arm-2d", Path::new("")).unwrap();
        assert_eq!(plan(&model), None);
    }
}
