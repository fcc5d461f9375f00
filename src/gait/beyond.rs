//! Numbers beyond those of healthy people.

use std::fmt;

use serde::{Deserialize, Serialize};

/// A number is marked that lies beyond the mean of healthy people by more than so many standard deviations between them.
pub const BEYOND_SD: f64 = 2.0;

/// On which side of those of healthy people a number lies.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Beyond {
    /// Less than mean − 2 SD.
    Below,
    /// More than mean + 2 SD.
    Above,
}

impl Beyond {
    /// Where a value lies; `None` within mean ± 2 SD, and where a number is not finite.
    pub fn new(value: f64, mean: f64, sd: f64) -> Option<Self> {
        match value - mean {
            off if off > BEYOND_SD * sd => Some(Self::Above),
            off if off < -BEYOND_SD * sd => Some(Self::Below),
            _ => None,
        }
    }

    /// Its mark in tables.
    pub fn mark(self) -> &'static str {
        match self {
            Self::Below => "▼",
            Self::Above => "▲",
        }
    }

    /// In words.
    pub fn words(self) -> &'static str {
        match self {
            Self::Below => "below the norm",
            Self::Above => "above the norm",
        }
    }
}

/// What people walk in.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Footwear {
    /// Nothing.
    Barefoot,
    /// Shoes.
    Shoes,
}

impl Footwear {
    /// In words.
    pub fn words(self) -> &'static str {
        match self {
            Self::Barefoot => "barefoot",
            Self::Shoes => "in shoes",
        }
    }

    /// What to know before a person is compared with a norm, whose people walked in this or in nobody knows what; `None` where
    /// both walked alike.
    pub fn caution(norm: Option<Self>, person: Option<Self>) -> Option<FootwearCaution> {
        match (norm, person) {
            (Some(norm), Some(person)) if norm == person => None,
            (Some(norm), Some(person)) => Some(FootwearCaution::Differs { norm, person }),
            (Some(norm), None) => Some(FootwearCaution::NotStated { norm }),
            (None, _) => Some(FootwearCaution::NormUnknown),
        }
    }
}

/// What to know of footwear before a person is compared with a norm; as text one line.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum FootwearCaution {
    /// They walked in different things.
    Differs {
        /// The people of the norm.
        norm: Footwear,
        /// The person.
        person: Footwear,
    },
    /// Nobody said what the person wore.
    NotStated {
        /// The people of the norm.
        norm: Footwear,
    },
    /// What the people of the norm wore is not known.
    NormUnknown,
}

impl fmt::Display for FootwearCaution {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Differs { norm, person } => write!(
                f,
                "the people of the norm walked {}, this person {}: footwear changes steps and ankles",
                norm.words(),
                person.words()
            ),
            Self::NotStated { norm } => write!(
                f,
                "the people of the norm walked {}; what this person wore is not stated (--footwear)",
                norm.words()
            ),
            Self::NormUnknown => f.write_str("what the people of the norm wore is not known"),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn beyond_two_standard_deviations_a_number_is_marked() {
        let of = |value| Beyond::new(value, 1.0, 0.1);
        assert_eq!([0.81, 1.0, 1.19, f64::NAN].map(of), [None; 4]);
        assert_eq!([0.79, 1.21].map(of), [Some(Beyond::Below), Some(Beyond::Above)]);
    }

    #[test]
    fn only_like_footwear_is_compared_without_a_word() {
        use Footwear::{Barefoot, Shoes};
        assert_eq!(Footwear::caution(Some(Barefoot), Some(Barefoot)), None);
        let differ = Footwear::caution(Some(Shoes), Some(Barefoot)).unwrap().to_string();
        assert!(differ.contains("walked in shoes, this person barefoot"), "{differ}");
        let unstated = Footwear::caution(Some(Shoes), None).unwrap().to_string();
        assert!(unstated.contains("--footwear"), "{unstated}");
        let unknown = Footwear::caution(None, Some(Shoes)).unwrap().to_string();
        assert!(unknown.contains("not known"), "{unknown}");
    }
}
