//! Spatiotemporal norms by age and sex: `data/norms/spatiotemporal.toml`.

use std::collections::BTreeMap;
use std::path::Path;

use serde::{Deserialize, Serialize};

use super::norm::{NormError, ParameterPart, parameters, syntax};
use crate::gait::{Footwear, Norm};

/// The shipped groups: name of the file and text.
const SHIPPED: (&str, &str) =
    ("spatiotemporal", include_str!("../../../data/norms/spatiotemporal.toml"));

/// A sex, as tables of healthy people distinguish it.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Sex {
    /// Female.
    Female,
    /// Male.
    Male,
}

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
struct GroupsFile {
    group: Vec<GroupPart>,
}

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
struct GroupPart {
    name: String,
    people: String,
    /// First and last year of life.
    ages: [u32; 2],
    /// Absent: both sexes together.
    sex: Option<Sex>,
    /// What they wore, if the source says so.
    footwear: Option<Footwear>,
    source: String,
    parameter: BTreeMap<String, ParameterPart>,
}

impl GroupPart {
    fn holds(&self, age_years: u32, sex: Option<Sex>) -> bool {
        let [first, last] = self.ages;
        (first..=last).contains(&age_years) && (self.sex.is_none() || self.sex == sex)
    }
}

/// Adds the parameters of healthy people of an age (completed years) and sex; without a table for them the norm stays.
///
/// # Errors
/// [`NormError`].
pub fn add_parameters(norm: &mut Norm, age_years: u32, sex: Option<Sex>) -> Result<(), NormError> {
    let path = Path::new(SHIPPED.0);
    let file: GroupsFile = toml::from_str(SHIPPED.1).map_err(|fault| syntax(path, fault))?;
    let group = file.group.into_iter().find(|g| g.holds(age_years, sex));
    if let Some(group) = group {
        norm.parameters_footwear = group.footwear;
        norm.parameters = parameters(group.parameter, path)?;
        let (name, people, source) = (group.name, group.people, group.source);
        norm.parameters_source = Some(format!("{name}: {source}, {people}"));
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::gait::Parameter;

    fn norm(age_years: u32, sex: Option<Sex>) -> Norm {
        let mut norm = Norm::default();
        add_parameters(&mut norm, age_years, sex).unwrap();
        norm
    }

    #[test]
    fn every_shipped_group_can_be_read_and_agrees_with_itself() {
        let file: GroupsFile = toml::from_str(SHIPPED.1).unwrap();
        for group in file.group {
            let name = group.name;
            let parameters = parameters(group.parameter, Path::new(SHIPPED.0)).unwrap();
            let mean = |parameter| parameters[&parameter].0;
            assert!(parameters.values().all(|(_, sd)| *sd > 0.0), "{name}");
            // means of different quantities are tied only as closely as their two or three digits, and as a mean of
            // quotients is a quotient of means
            let close = |found: f64, expected: f64| {
                assert!((found / expected - 1.0).abs() < 0.04, "{name}: {found} {expected}");
            };
            close(mean(Parameter::Cadence) * mean(Parameter::StrideTime), 120.0);
            close(2.0 * mean(Parameter::StepTime), mean(Parameter::StrideTime));
            close(2.0 * mean(Parameter::StepLength), mean(Parameter::StrideLength));
            if parameters.contains_key(&Parameter::Stance) {
                let supports = mean(Parameter::SingleSupport) + mean(Parameter::DoubleSupport);
                close(supports, mean(Parameter::Stance));
            }
            if let Some((speed, _)) = parameters.get(&Parameter::Speed) {
                close(mean(Parameter::StrideLength) / mean(Parameter::StrideTime), *speed);
            }
        }
    }

    #[test]
    fn a_norm_is_that_of_the_age_and_sex() {
        let (woman, man) = (norm(72, Some(Sex::Female)), norm(72, Some(Sex::Male)));
        assert_ne!(woman.parameters, man.parameters);
        assert_eq!(norm(9, None).parameters_footwear, Some(Footwear::Shoes));
        assert_eq!(man.parameters_footwear, None, "the transcription does not say");
        assert!(man.parameters_source.unwrap().contains("men of 70 to 74 years"));
        // tables of children and adults hold for both sexes, those of old people for one, and some ages have none
        for age in [13, 21, 37, 50, 69] {
            assert!(!norm(age, None).parameters.is_empty(), "{age}");
        }
        assert_eq!(norm(34, None).parameters_footwear, Some(Footwear::Barefoot));
        for age in [14, 20, 38, 49, 72] {
            assert!(norm(age, None).parameters.is_empty(), "{age}");
        }
    }
}
