//! Norms of healthy people: `data/norms/*.toml`.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use serde::Deserialize;

use crate::gait::{Angle, Band, Footwear, Norm, Parameter, SCORE_POINTS, Zero};
use crate::io::input;

/// The shipped norms, name and text; an age takes the first whose ages hold it.
const SHIPPED: [(&str, &str); 4] = [
    ("schwartz-2008-free", include_str!("../../../data/norms/schwartz-2008-free.toml")),
    ("fukuchi-2018-young", include_str!("../../../data/norms/fukuchi-2018-young.toml")),
    ("fukuchi-2018-older", include_str!("../../../data/norms/fukuchi-2018-older.toml")),
    ("fukuchi-2018-adults", include_str!("../../../data/norms/fukuchi-2018-adults.toml")),
];

/// Why a norm cannot be used.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum NormError {
    /// A file that cannot be read.
    #[error("{}: cannot be read: {source}", path.display())]
    Read {
        /// The file.
        path: PathBuf,
        /// Why.
        source: std::io::Error,
    },
    /// Not TOML, or with other keys.
    #[error("{}: {}", path.display(), source.message())]
    Syntax {
        /// The file.
        path: PathBuf,
        /// What is wrong.
        source: Box<toml::de::Error>,
    },
    /// A name of no angle or parameter.
    #[error("{}: {kind} {name:?} is not known", path.display())]
    Name {
        /// The file.
        path: PathBuf,
        /// angle or parameter.
        kind: &'static str,
        /// Found.
        name: String,
    },
    /// A curve of another length.
    #[error("{}: curve {name}: expected {SCORE_POINTS} finite means and as many SD above 0", path.display())]
    Points {
        /// The file.
        path: PathBuf,
        /// Which curve.
        name: String,
    },
}

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
struct NormFile {
    name: String,
    source: String,
    /// What its people wore.
    footwear: Option<Footwear>,
    /// What its angles are counted from.
    #[serde(default)]
    zero: Zero,
    /// First and last year of life of its people.
    ages: Option<[u32; 2]>,
    /// What to know before a person is compared with it.
    #[serde(default)]
    remarks: Vec<String>,
    #[serde(default)]
    curve: BTreeMap<String, CurvePart>,
    #[serde(default)]
    parameter: BTreeMap<String, ParameterPart>,
}

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
struct CurvePart {
    mean_deg: Vec<f64>,
    sd_deg: Vec<f64>,
}

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct ParameterPart {
    mean: f64,
    sd: f64,
}

/// The shipped norm of people of this age, in completed years.
///
/// Without an age it is that of children, whose nine curves are of the conventional model, and a remark says so. An age of which
/// no shipped norm has people has one without curves.
///
/// # Errors
/// [`NormError`].
pub fn shipped_norm(age_years: Option<u32>) -> Result<Norm, NormError> {
    for (name, text) in SHIPPED {
        let mut norm = parse_norm(text, Path::new(name))?;
        let Some(age) = age_years else {
            let line = "no age is stated, so angles are compared with children (--age, or the session's birth date, chooses)";
            norm.remarks.push(line.into());
            return Ok(norm);
        };
        if norm.ages.is_some_and(|[first, last]| (first..=last).contains(&age)) {
            return Ok(norm);
        }
    }

    let (name, source) = ("none".into(), "no shipped norm has angles of people of this age".into());
    let remarks = vec![
        "no norm that comes with the program has angles of people of this age (--norm takes yours)"
            .into(),
    ];
    Ok(Norm { name, source, remarks, ..Norm::default() })
}

/// The norm of a file.
///
/// # Errors
/// [`NormError`].
pub fn load_norm(path: &Path) -> Result<Norm, NormError> {
    let text =
        input::read_text(path).map_err(|source| NormError::Read { path: path.into(), source })?;
    parse_norm(&text, path)
}

/// The norm of a text; `path` is what errors name.
///
/// # Errors
/// [`NormError`].
pub fn parse_norm(text: &str, path: &Path) -> Result<Norm, NormError> {
    let file: NormFile = toml::from_str(text).map_err(|fault| syntax(path, fault))?;
    let mut norm = Norm {
        name: file.name,
        source: file.source,
        ages: file.ages,
        remarks: file.remarks,
        footwear: file.footwear,
        zero: file.zero,
        parameters_footwear: file.footwear,
        parameters: parameters(file.parameter, path)?,
        ..Norm::default()
    };
    for (name, part) in file.curve {
        let angle = Angle::ALL.into_iter().find(|a| a.name() == name);
        let angle = angle.ok_or_else(|| unknown(path, "angle", &name))?;

        let is_whole =
            |values: &[f64]| values.len() == SCORE_POINTS && values.iter().all(|v| v.is_finite());
        let is_positive = part.sd_deg.iter().all(|sd| *sd > 0.0);
        if !is_whole(&part.mean_deg) || !is_whole(&part.sd_deg) || !is_positive {
            let path = path.into();
            return Err(NormError::Points { path, name });
        }

        let radians = |values: Vec<f64>| values.into_iter().map(f64::to_radians).collect();
        let band = Band { mean: radians(part.mean_deg), sd: radians(part.sd_deg) };
        norm.curves.insert(angle, band);
    }
    Ok(norm)
}

/// Mean and SD of each named parameter.
pub(super) fn parameters(
    parts: BTreeMap<String, ParameterPart>,
    path: &Path,
) -> Result<BTreeMap<Parameter, (f64, f64)>, NormError> {
    let mean_and_sd = |(name, part): (String, ParameterPart)| {
        let parameter = Parameter::ALL.into_iter().find(|p| p.name() == name);
        let parameter = parameter.ok_or_else(|| unknown(path, "parameter", &name))?;
        Ok((parameter, (part.mean, part.sd)))
    };
    parts.into_iter().map(mean_and_sd).collect()
}

fn unknown(path: &Path, kind: &'static str, name: &str) -> NormError {
    NormError::Name { path: path.into(), kind, name: name.to_owned() }
}

pub(super) fn syntax(path: &Path, source: toml::de::Error) -> NormError {
    NormError::Syntax { path: path.into(), source: Box::new(source) }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_shipped_norm_has_the_nine_curves_of_the_profile_score_and_its_own_name() {
        for (name, text) in SHIPPED {
            let norm = parse_norm(text, Path::new(name)).unwrap();
            assert_eq!(norm.name, name);
            assert!(norm.ages.is_some_and(|[first, last]| first < last), "{name}");
            for angle in crate::gait::VARIABLES {
                assert!(norm.curves.contains_key(&angle), "{name}: {}", angle.name());
            }
        }
    }

    #[test]
    fn the_norm_of_angles_is_that_of_the_age() {
        let name = |age| shipped_norm(age).unwrap().name;
        for (age, expected) in [
            (9, "schwartz-2008-free"),
            (17, "schwartz-2008-free"),
            (21, "fukuchi-2018-young"),
            (37, "fukuchi-2018-young"),
            (44, "fukuchi-2018-adults"),
            (72, "fukuchi-2018-older"),
            (19, "none"),
            (90, "none"),
        ] {
            assert_eq!(name(Some(age)), expected, "{age}");
        }
        let nobody = shipped_norm(Some(19)).unwrap();
        assert!(nobody.curves.is_empty() && nobody.cautions(None).len() == 1);

        // without an age it is that of children, and says so
        let unknown = shipped_norm(None).unwrap();
        assert_eq!(unknown.name, "schwartz-2008-free");
        assert!(unknown.cautions(None).iter().any(|line| line.contains("--age")));
        assert!(shipped_norm(Some(9)).unwrap().remarks.is_empty());
    }

    /// What every healthy walk has, in degrees and percent of the cycle: a wrong sign, axis or time breaks one of them.
    #[test]
    fn every_shipped_norm_walks_as_people_do() {
        for (name, text) in SHIPPED {
            let norm = parse_norm(text, Path::new(name)).unwrap();
            let at =
                |angle: Angle, percent: usize| norm.curves[&angle].mean[percent / 2].to_degrees();
            let top = |angle: Angle, percents: std::ops::Range<usize>| {
                let places = percents.step_by(2).map(|percent| (at(angle, percent), percent));
                places.max_by(|a, b| a.0.total_cmp(&b.0)).unwrap()
            };
            let holds = |what: &str, found: f64, range: std::ops::RangeInclusive<f64>| {
                assert!(range.contains(&found), "{name}: {what}: {found}");
            };
            let (knee, when) = top(Angle::KneeFlexion, 0..101);
            holds("knee in swing", knee, 55.0..=70.0);
            holds("its time", when as f64, 68.0..=76.0);
            holds("hip at strike", at(Angle::HipFlexion, 0), 25.0..=40.0);
            holds("hip before foot off", at(Angle::HipFlexion, 52), -15.0..=0.0);
            holds("dorsiflexion in stance", top(Angle::AnkleDorsiflexion, 30..56).0, 8.0..=15.0);
            holds("push-off", at(Angle::AnkleDorsiflexion, 64), -25.0..=-8.0);
            holds("anterior tilt", at(Angle::PelvisTilt, 0), 5.0..=15.0);
            holds("own side up in loading", at(Angle::PelvisObliquity, 14), 2.0..=7.0);
            holds("own side forwards at strike", at(Angle::PelvisRotation, 0), 2.0..=8.0);
            holds("hip adduction in stance", top(Angle::HipAdduction, 10..30).0, 3.0..=9.0);
            holds("toes outwards in stance", at(Angle::FootProgression, 26), -15.0..=-2.0);
        }
    }

    #[test]
    fn a_norm_that_cannot_be_used_says_why() {
        let parse = |text: &str| parse_norm(text, Path::new("n.toml")).unwrap_err().to_string();
        let head = "name = \"a\"\nsource = \"b\"\n";
        let unknown = parse(&format!("{head}[parameter.sped]\nmean = 1\nsd = 1"));
        assert_eq!(unknown, "n.toml: parameter \"sped\" is not known");
        let short = parse(&format!("{head}[curve.knee_flexion]\nmean_deg = [1.0]\nsd_deg = [1.0]"));
        assert!(short.contains("knee_flexion: expected 51"), "{short}");
    }
}
