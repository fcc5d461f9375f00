//! The numbers that a run must reach: `experiments/expected/<name>.toml`.
//!
//! ```toml
//! [length_error_mm]        # the number's name
//! value = 12.0             # ours when it was written down, with the distance that is tolerated …
//! tolerance = 2.0
//! most = 20.0              # … or limits, or both
//! least = 0.0
//! paper = 15.0             # what the paper reports, not checked
//! ```

use std::collections::BTreeMap;
use std::fmt;

use serde::Deserialize;

/// What one number must be.
#[derive(Debug, Clone, Copy, PartialEq, Default, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct Expected {
    /// What it was.
    pub value: Option<f64>,
    /// How far from `value` it may be.
    pub tolerance: Option<f64>,
    /// Smallest value allowed.
    pub least: Option<f64>,
    /// Largest value allowed.
    pub most: Option<f64>,
    /// The paper's number.
    pub paper: Option<f64>,
}

/// Expected numbers by name.
pub type ExpectedNumbers = BTreeMap<String, Expected>;

/// A number that is not what it must be.
#[derive(Debug, Clone, PartialEq)]
pub struct Out {
    name: String,
    found: Option<f64>,
    expected: Expected,
}

impl Expected {
    /// The interval that holds the number.
    fn interval(&self) -> (f64, f64) {
        let mut interval =
            (self.least.unwrap_or(f64::NEG_INFINITY), self.most.unwrap_or(f64::INFINITY));
        if let (Some(value), Some(tolerance)) = (self.value, self.tolerance) {
            interval = (interval.0.max(value - tolerance), interval.1.min(value + tolerance));
        }
        interval
    }

    fn holds(&self, found: f64) -> bool {
        let (low, high) = self.interval();
        (low..=high).contains(&found)
    }
}

/// The expected numbers that `found` lacks or misses, in the order of their names.
pub fn out(expected: &ExpectedNumbers, found: &BTreeMap<String, f64>) -> Vec<Out> {
    let missed = expected.iter().filter_map(|(name, expected)| {
        let found = found.get(name).copied();
        let holds = found.is_some_and(|f| expected.holds(f));
        (!holds).then(|| Out { name: name.clone(), found, expected: *expected })
    });
    missed.collect()
}

impl fmt::Display for Out {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let (low, high) = self.expected.interval();
        write!(f, "out of tolerance: {} is ", self.name)?;
        match self.found {
            Some(found) => write!(f, "{found:.4}")?,
            None => write!(f, "not measured")?,
        }
        write!(f, ", expected {low:.4} to {high:.4}")
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn expected(text: &str) -> ExpectedNumbers {
        toml::from_str(text).unwrap()
    }

    fn found(numbers: &[(&str, f64)]) -> BTreeMap<String, f64> {
        numbers.iter().map(|(name, value)| ((*name).to_owned(), *value)).collect()
    }

    #[test]
    fn a_number_within_tolerance_and_limits_is_not_out() {
        let expected = expected("[a]\nvalue = 1.0\ntolerance = 0.5\n[b]\nmost = 3.0");
        assert_eq!(out(&expected, &found(&[("a", 1.4), ("b", 2.0), ("c", 9.0)])), []);
    }

    #[test]
    fn what_is_too_far_missing_or_not_a_number_is_named() {
        let expected =
            expected("[a]\nvalue = 1.0\ntolerance = 0.5\n[b]\nmost = 3.0\n[c]\nleast = 0.0");
        let out = out(&expected, &found(&[("a", 1.6), ("c", f64::NAN)]));
        let lines: Vec<String> = out.iter().map(ToString::to_string).collect();
        assert_eq!(lines[0], "out of tolerance: a is 1.6000, expected 0.5000 to 1.5000");
        assert_eq!(lines[1], "out of tolerance: b is not measured, expected -inf to 3.0000");
        assert_eq!(lines[2], "out of tolerance: c is NaN, expected 0.0000 to inf");
    }

    #[test]
    fn every_file_of_expected_numbers_can_be_read() {
        let folder = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("expected");
        for entry in std::fs::read_dir(folder).unwrap() {
            let path = entry.unwrap().path();
            let text = std::fs::read_to_string(&path).unwrap();
            let numbers = toml::from_str::<ExpectedNumbers>(&text);
            assert!(numbers.is_ok(), "{}: {numbers:?}", path.display());
        }
    }
}
