//! Who walked.

use std::fmt;
use std::str::FromStr;

use serde::{Deserialize, Serialize};

use crate::gait::{Footwear, Side};
use crate::io::gait::Sex;

/// A person, as `session.toml` names them; nothing has to be stated.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Person {
    /// Name or number.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub id: Option<String>,
    /// Day of birth; with the date of the session it gives the age.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub birth_date: Option<Date>,
    /// Age in completed years, in the place of the day of birth.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub age_years: Option<u32>,
    /// Sex.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub sex: Option<Sex>,
    /// Height without shoes, metres.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub height_m: Option<f64>,
    /// Mass, kg.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub mass_kg: Option<f64>,
    /// The side that is affected.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub affected_side: Option<AffectedSide>,
    /// In words.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub diagnosis: Option<String>,
    /// What they wore on their feet.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub footwear: Option<Footwear>,
}

/// Which side is affected.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum AffectedSide {
    /// Left.
    Left,
    /// Right.
    Right,
    /// Both.
    Both,
}

impl AffectedSide {
    /// In words.
    pub fn words(self) -> &'static str {
        match self {
            Self::Left => Side::Left.name(),
            Self::Right => Side::Right.name(),
            Self::Both => "both sides",
        }
    }
}

/// A day of the calendar.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
#[serde(try_from = "String", into = "String")]
pub struct Date {
    year: u32,
    month: u32,
    day: u32,
}

impl FromStr for Date {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let number =
            |part: &str| part.bytes().all(|b| b.is_ascii_digit()).then(|| part.parse().ok())?;
        let parts: Vec<Option<u32>> = text.split('-').map(number).collect();
        match parts.as_slice() {
            [Some(year @ 1850..=9999), Some(month @ 1..=12), Some(day @ 1..=31)] => {
                Ok(Self { year: *year, month: *month, day: *day })
            }
            _ => Err(format!("expected a day as 1953-04-12, found {text:?}")),
        }
    }
}

impl TryFrom<String> for Date {
    type Error = String;

    fn try_from(text: String) -> Result<Self, String> {
        text.parse()
    }
}

impl From<Date> for String {
    fn from(date: Date) -> Self {
        date.to_string()
    }
}

impl fmt::Display for Date {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{:04}-{:02}-{:02}", self.year, self.month, self.day)
    }
}

impl Person {
    /// Their age on a day in completed years: as stated, or by the day of birth; `None` where neither is known.
    pub fn age_on(&self, date: Option<Date>) -> Option<u32> {
        let by_birth = || {
            let (born, on) = (self.birth_date?, date?);
            let is_before = (on.month, on.day) < (born.month, born.day);
            on.year.checked_sub(born.year)?.checked_sub(u32::from(is_before))
        };
        self.age_years.or_else(by_birth)
    }

    /// Why their steps are not compared with people of their age, in one line; `None` where they are.
    pub fn lacks_age(&self, date: Option<Date>) -> Option<&'static str> {
        match (self.age_on(date), self.birth_date, date) {
            (Some(_), _, _) => None,
            (None, None, _) => Some(
                "no birth date and no age: steps and strides are not compared with people of an age",
            ),
            (None, Some(_), None) => Some(
                "no date of the session: the age is not known, and steps and strides are not compared with people of an age",
            ),
            (None, Some(_), Some(_)) => Some("the date of the session is before the birth date"),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn born(day: &str) -> Person {
        Person { birth_date: Some(day.parse().unwrap()), ..Person::default() }
    }

    #[test]
    fn the_age_grows_on_the_birthday() {
        let date = |text: &str| Some(text.parse::<Date>().unwrap());
        assert_eq!(born("1953-04-12").age_on(date("2026-04-11")), Some(72));
        assert_eq!(born("1953-04-12").age_on(date("2026-04-12")), Some(73));
        assert_eq!(born("1953-04-12").age_on(date("1950-01-01")), None);
        assert!(born("1953-04-12").lacks_age(None).unwrap().contains("no date"));
        assert!(Person::default().lacks_age(date("2026-04-12")).unwrap().contains("no birth date"));
        let stated = Person { age_years: Some(9), ..Person::default() };
        assert_eq!((stated.age_on(None), stated.lacks_age(None)), (Some(9), None));
    }

    #[test]
    fn a_day_that_is_none_is_refused_with_what_was_expected() {
        for text in ["12.4.1953", "1953-4", "1953-13-01", "1953-04-+1", ""] {
            let fault = text.parse::<Date>().unwrap_err();
            assert!(fault.contains("1953-04-12"), "{fault}");
        }
        assert_eq!("1953-04-12".parse::<Date>().unwrap().to_string(), "1953-04-12");
    }
}
