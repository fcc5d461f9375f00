//! Points of the body that gait analysis knows, and their names in marker sets and trackers.

use serde::{Serialize, Serializer};

pub use crate::body::Side;

/// A place that the body has on both sides.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Paired {
    /// Hip joint centre.
    Hip,
    /// Knee joint centre, or a marker on the lateral epicondyle.
    Knee,
    /// Marker on the medial epicondyle.
    KneeMedial,
    /// Ankle joint centre, or a marker on the lateral malleolus.
    Ankle,
    /// Marker on the medial malleolus.
    AnkleMedial,
    /// Back of the heel.
    Heel,
    /// Front of the foot: big toe, or a marker on the toes.
    Toe,
    /// Anterior superior iliac spine.
    Asis,
    /// Posterior superior iliac spine.
    Psis,
    /// Shoulder joint centre, or a marker on the acromion.
    Shoulder,
    /// Elbow joint centre, or a marker.
    Elbow,
    /// Wrist joint centre, or a marker.
    Wrist,
}

/// A place of the body.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Landmark {
    /// Middle of the hip joint centres.
    MidHip,
    /// Marker over the sacrum.
    Sacrum,
    /// Neck, or C7.
    Neck,
    /// A place of one side.
    Of(Side, Paired),
}

/// Names without their side; lower case, letters and digits only; the best first.
const PAIRED: [(Paired, &[&str]); 12] = [
    (Paired::Hip, &["hjc", "hipjointcentre", "hipjointcenter", "hip"]),
    (Paired::Knee, &["kjc", "knee", "kneelat", "lfc", "kne"]),
    (Paired::KneeMedial, &["mknee", "kneemed", "mfc"]),
    (Paired::Ankle, &["ajc", "ankle", "anklelat", "lmal", "ank"]),
    (Paired::AnkleMedial, &["mankle", "anklemed", "mmal"]),
    (Paired::Heel, &["heel", "calc", "cal", "hee"]),
    (Paired::Toe, &["bigtoe", "toe", "toetip", "hallux", "footindex", "toemed"]),
    (Paired::Asis, &["asis", "asi"]),
    (Paired::Psis, &["psis", "psi"]),
    (Paired::Shoulder, &["sjc", "shoulder", "acr", "acromium", "acromion", "sho"]),
    (Paired::Elbow, &["ejc", "elbow", "elbowlat", "lel", "elb"]),
    (Paired::Wrist, &["wjc", "wrist", "wristlat", "wra"]),
];

/// Names of the places in the middle, the best first.
const SINGLE: [(Landmark, &[&str]); 3] = [
    (Landmark::MidHip, &["hip", "midhip", "pelvis"]),
    (Landmark::Sacrum, &["sacrum", "sacr", "vsacral", "s2"]),
    (Landmark::Neck, &["neck", "c7"]),
];

impl Landmark {
    /// The place that a name means, and the rank of the name among those of that place, 0 the best; `None` if unknown.
    ///
    /// Case, dots, underscores, spaces and a closing `_study` do not matter, and the side stands before or after:
    /// `RHeel`, `R.Heel`, `right heel`, `heel_r` and `r_calc_study` all mean the right heel.
    pub fn from_name(name: &str) -> Option<(Self, usize)> {
        let lower = name.to_lowercase();
        let plain: String = lower.chars().filter(|c| c.is_alphanumeric()).collect();
        let plain = plain.strip_suffix("study").unwrap_or(&plain);
        let single = SINGLE.iter().find_map(|(landmark, names)| {
            let rank = names.iter().position(|n| *n == plain)?;
            Some((*landmark, rank))
        });
        single.or_else(|| Side::BOTH.iter().find_map(|side| Self::paired_from_name(plain, *side)))
    }

    fn paired_from_name(plain: &str, side: Side) -> Option<(Self, usize)> {
        let (letter, word) = match side {
            Side::Left => ("l", "left"),
            Side::Right => ("r", "right"),
        };
        let bare = [
            plain.strip_prefix(word),
            plain.strip_suffix(word),
            plain.strip_prefix(letter),
            plain.strip_suffix(letter),
        ];
        PAIRED.iter().find_map(|(place, names)| {
            let rank = |bare: &str| names.iter().position(|n| *n == bare);
            let rank = bare.iter().flatten().find_map(|bare| rank(bare))?;
            Some((Self::Of(side, *place), rank))
        })
    }

    /// In words: `right heel`.
    pub fn name(self) -> String {
        match self {
            Self::MidHip => "middle of the hips".into(),
            Self::Sacrum => "sacrum".into(),
            Self::Neck => "neck".into(),
            Self::Of(side, place) => format!("{} {}", side.name(), place.name()),
        }
    }
}

impl Paired {
    fn name(self) -> &'static str {
        match self {
            Self::Hip => "hip",
            Self::Knee => "knee",
            Self::KneeMedial => "medial knee",
            Self::Ankle => "ankle",
            Self::AnkleMedial => "medial ankle",
            Self::Heel => "heel",
            Self::Toe => "toe",
            Self::Asis => "ASIS",
            Self::Psis => "PSIS",
            Self::Shoulder => "shoulder",
            Self::Elbow => "elbow",
            Self::Wrist => "wrist",
        }
    }
}

impl Serialize for Landmark {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.serialize_str(&self.name())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_of_five_marker_sets_mean_the_same_place() {
        let heel = Landmark::Of(Side::Right, Paired::Heel);
        for name in ["RHeel", "R.Heel", "r_calc_study", "RCAL", "right heel", "heel_r"] {
            assert_eq!(Landmark::from_name(name).unwrap().0, heel, "{name}");
        }
    }

    #[test]
    fn a_malleolus_is_not_mistaken_for_the_left_side() {
        let of = |name: &str| Landmark::from_name(name).unwrap().0;
        assert_eq!(of("RLMAL"), Landmark::Of(Side::Right, Paired::Ankle));
        assert_eq!(of("LMMAL"), Landmark::Of(Side::Left, Paired::AnkleMedial));
        assert_eq!(of("Hip"), Landmark::MidHip);
        assert_eq!(of("LHip"), Landmark::Of(Side::Left, Paired::Hip));
        assert_eq!(Landmark::from_name("R.TH1"), None);
    }
}
