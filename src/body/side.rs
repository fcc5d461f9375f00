//! Left and right: their names, and the one colour of each.

use serde::Serialize;

/// A side of the body.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Side {
    /// Left.
    Left,
    /// Right.
    Right,
}

impl Side {
    /// Left, then right.
    pub const BOTH: [Self; 2] = [Self::Left, Self::Right];

    /// The other one.
    pub fn other(self) -> Self {
        match self {
            Self::Left => Self::Right,
            Self::Right => Self::Left,
        }
    }

    /// `left` or `right`.
    pub fn name(self) -> &'static str {
        match self {
            Self::Left => "left",
            Self::Right => "right",
        }
    }

    /// Its colour in every chart and picture, as red, green and blue: left is red and right is blue, as in gait laboratories.
    pub fn colour(self) -> [u8; 3] {
        match self {
            Self::Left => [0xc8, 0x10, 0x2e],
            Self::Right => [0x00, 0x57, 0xb8],
        }
    }

    /// The side that the name of a joint centre begins with, as in `RKnee`; `None` of one in the middle.
    pub fn from_initial(name: &str) -> Option<Self> {
        let mut letters = name.chars();
        let (first, second) = (letters.next(), letters.next());
        match (first, second.is_some_and(char::is_uppercase)) {
            (Some('L'), true) => Some(Self::Left),
            (Some('R'), true) => Some(Self::Right),
            _ => None,
        }
    }

    /// The name of a joint centre's mirror image: `LKnee` for `RKnee`; `None` of one in the middle.
    pub fn mirrored(name: &str) -> Option<String> {
        let other = match Self::from_initial(name)? {
            Self::Left => 'R',
            Self::Right => 'L',
        };
        Some(format!("{other}{}", &name[1..]))
    }

    /// +1 for right, −1 for left: what points to the body's right points outwards on the right side, inwards on the left.
    pub(crate) fn sign(self) -> f64 {
        match self {
            Self::Left => -1.0,
            Self::Right => 1.0,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn left_is_red_and_right_is_blue() {
        let [left, right] = Side::BOTH.map(Side::colour);
        assert!(left[0] > 3 * left[2].max(left[1]), "{left:?}");
        assert!(right[2] > 2 * right[0].max(right[1]), "{right:?}");
    }

    #[test]
    fn the_side_is_read_from_the_name_of_a_joint_centre() {
        let sides = ["RKnee", "LHip", "Hip", "Rib"].map(Side::from_initial);
        assert_eq!(sides, [Some(Side::Right), Some(Side::Left), None, None]);
        let mirrored = ["RKnee", "LHip", "Hip"].map(Side::mirrored);
        assert_eq!(mirrored, [Some("LKnee".to_owned()), Some("RHip".to_owned()), None]);
    }
}
