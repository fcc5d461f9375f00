//! Norms of healthy people: `data/norms/*.toml`.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use serde::Deserialize;

use crate::gait::{Angle, Band, Footwear, Norm, Parameter, SCORE_POINTS};
use crate::io::input;

/// The shipped norm: its name and text.
pub const SHIPPED_NORM: (&str, &str) =
    ("schwartz-2008-free", include_str!("../../../data/norms/schwartz-2008-free.toml"));

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
        footwear: file.footwear,
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
    fn the_shipped_norm_has_the_nine_curves_of_the_profile_score() {
        let norm = parse_norm(SHIPPED_NORM.1, Path::new(SHIPPED_NORM.0)).unwrap();
        for angle in crate::gait::VARIABLES {
            assert!(norm.curves.contains_key(&angle), "{}", angle.name());
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
