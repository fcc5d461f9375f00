//! Spatiotemporal norms by age and sex: `data/norms/spatiotemporal.toml`.

use std::collections::BTreeMap;
use std::path::Path;

use serde::Deserialize;

use super::norm::{NormError, ParameterPart, parameters, syntax};
use crate::gait::Norm;

/// The groups that come with the program: name of the file and text.
const SHIPPED: (&str, &str) = (
    "spatiotemporal",
    include_str!("../../../data/norms/spatiotemporal.toml"),
);

/// A sex, as tables of healthy people part them.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Deserialize)]
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
    /// Both together where it is absent.
    sex: Option<Sex>,
    source: String,
    parameter: BTreeMap<String, ParameterPart>,
}

impl GroupPart {
    fn holds(&self, age_years: u32, sex: Option<Sex>) -> bool {
        let [first, last] = self.ages;
        (first..=last).contains(&age_years) && (self.sex.is_none() || self.sex == sex)
    }
}

/// Gives a norm the parameters of healthy people of an age (completed years) and sex; as it is where no table has them.
///
/// # Errors
/// [`NormError`].
pub fn add_parameters(norm: &mut Norm, age_years: u32, sex: Option<Sex>) -> Result<(), NormError> {
    let path = Path::new(SHIPPED.0);
    let file: GroupsFile = toml::from_str(SHIPPED.1).map_err(|fault| syntax(path, fault))?;
    let group = file.group.into_iter().find(|g| g.holds(age_years, sex));
    if let Some(group) = group {
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

    fn of(age_years: u32, sex: Option<Sex>) -> Norm {
        let mut norm = Norm::default();
        add_parameters(&mut norm, age_years, sex).unwrap();
        norm
    }

    #[test]
    fn every_shipped_group_can_be_read_and_agrees_with_itself() {
        let file: GroupsFile = toml::from_str(SHIPPED.1).unwrap();
        for group in file.group {
            let name = group.name;
            let of = parameters(group.parameter, Path::new(SHIPPED.0)).unwrap();
            let mean = |parameter| of[&parameter].0;
            assert!(of.values().all(|(_, sd)| *sd > 0.0), "{name}");
            // means of different quantities are tied only as closely as their two or three digits, and as a mean of
            // quotients is a quotient of means
            let close = |found: f64, expected: f64| {
                assert!(
                    (found / expected - 1.0).abs() < 0.04,
                    "{name}: {found} {expected}"
                );
            };
            close(
                mean(Parameter::Cadence) * mean(Parameter::StrideTime),
                120.0,
            );
            close(2.0 * mean(Parameter::StepTime), mean(Parameter::StrideTime));
            close(
                2.0 * mean(Parameter::StepLength),
                mean(Parameter::StrideLength),
            );
            close(
                mean(Parameter::SingleSupport) + mean(Parameter::DoubleSupport),
                mean(Parameter::Stance),
            );
        }
    }

    #[test]
    fn a_norm_is_that_of_the_age_and_sex() {
        let (woman, man) = (of(72, Some(Sex::Female)), of(72, Some(Sex::Male)));
        assert_ne!(woman.parameters, man.parameters);
        assert!(
            man.parameters_source
                .unwrap()
                .contains("men of 70 to 74 years")
        );
        // tables of children do not ask for the sex, those of old people do, and in between there is none
        assert!(!of(13, None).parameters.is_empty());
        assert!(
            of(72, None).parameters.is_empty() && of(34, Some(Sex::Male)).parameters.is_empty()
        );
    }
}
