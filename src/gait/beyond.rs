//! Numbers beyond those of healthy people.

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
    pub fn caution(norm: Option<Self>, person: Option<Self>) -> Option<String> {
        Some(match (norm, person) {
            (Some(norm), Some(person)) if norm == person => return None,
            (Some(norm), Some(person)) => format!(
                "the people of the norm walked {}, this person {}: footwear changes steps and ankles",
                norm.words(),
                person.words()
            ),
            (Some(norm), None) => format!(
                "the people of the norm walked {}; what this person wore is not stated (--footwear)",
                norm.words()
            ),
            (None, _) => "what the people of the norm wore is not known".into(),
        })
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
        let differ = Footwear::caution(Some(Shoes), Some(Barefoot)).unwrap();
        assert!(differ.contains("walked in shoes, this person barefoot"), "{differ}");
        assert!(Footwear::caution(Some(Shoes), None).unwrap().contains("--footwear"));
        assert!(Footwear::caution(None, Some(Shoes)).unwrap().contains("not known"));
    }
}
