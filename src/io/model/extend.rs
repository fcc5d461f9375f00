//! A model file that extends another: the other's skeleton, with coefficients and metaballs of its own.

use std::path::{Path, PathBuf};

use serde::Deserialize;

use super::spec::{CoefficientSpec, ModelSpec, PrimitiveSpec};
use super::{ModelFileError, ModelText, SHIPPED, build, parse_toml, text_of};

/// What every model file has, and the key that marks an extension.
#[derive(Debug, Deserialize)]
struct Head {
    name: String,
    extends: Option<String>,
}

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
struct ExtensionSpec {
    name: String,
    extends: String,
    #[serde(default)]
    factors: Vec<String>,
    #[serde(default, rename = "coefficient")]
    coefficients: Vec<CoefficientSpec>,
    #[serde(default, rename = "part")]
    parts: Vec<FleshSpec>,
}

/// What an extension may add to a part.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
struct FleshSpec {
    name: String,
    #[serde(rename = "metaball")]
    metaballs: Vec<PrimitiveSpec>,
}

/// The specification in a file, merged into that of the file which it extends, if it extends one.
///
/// `read` are the files on the way here, outermost first; this one is added.
pub(super) fn with_base(
    text: &str,
    path: &Path,
    read: &mut Vec<ModelText>,
) -> Result<ModelSpec, ModelFileError> {
    let head: Head = parse_toml(text, path)?;
    read.push(ModelText { name: head.name, path: one_name(path), text: text.to_owned() });
    if head.extends.is_none() {
        return parse_toml(text, path);
    }

    let own: ExtensionSpec = parse_toml(text, path)?;
    let base = base(&own.extends, path, read).map_err(|fault| match fault {
        ModelFileError::ExtendsItself { .. } => fault,
        fault => ModelFileError::Base { path: path.to_owned(), fault: Box::new(fault) },
    })?;

    merged(base, own, path)
}

/// The extended model, checked on its own so that errors name its file.
fn base(name: &str, path: &Path, read: &mut Vec<ModelText>) -> Result<ModelSpec, ModelFileError> {
    let folder = path.parent().unwrap_or(Path::new(""));
    let (text, base_path) = text_of(name, folder)?;
    let is_shipped = SHIPPED.iter().any(|(shipped, _)| *shipped == name);
    let own_name = one_name(&base_path);
    if !is_shipped && read.iter().any(|file| file.path == own_name) {
        return Err(ModelFileError::ExtendsItself { path: base_path });
    }
    let base = with_base(&text, &base_path, read)?;
    build::build(&base, &base_path)?;
    Ok(base)
}

/// A file's canonical path; a path that is no file's stays.
fn one_name(path: &Path) -> PathBuf {
    std::fs::canonicalize(path).unwrap_or_else(|_| path.to_owned())
}

fn merged(
    mut base: ModelSpec,
    own: ExtensionSpec,
    path: &Path,
) -> Result<ModelSpec, ModelFileError> {
    base.name = own.name;
    let new = own.factors.into_iter().filter(|f| !base.factors.contains(f));
    base.factors.extend(new.collect::<Vec<_>>());

    // a coefficient of the same name replaces the base's
    let inherited = base.coefficients.len();
    for coefficient in own.coefficients {
        let known = &mut base.coefficients[..inherited];
        match known.iter_mut().find(|c| c.name == coefficient.name) {
            Some(replaced) => *replaced = coefficient,
            None => base.coefficients.push(coefficient),
        }
    }

    // parts only gain flesh
    for flesh in own.parts {
        let part = base.parts.iter_mut().find(|p| p.name == flesh.name);
        let part = part.ok_or_else(|| ModelFileError::Missing {
            path: path.to_owned(),
            place: format!("the extension of {}", own.extends),
            kind: "part",
            name: flesh.name.clone(),
        })?;
        part.metaballs.extend(flesh.metaballs);
    }

    Ok(base)
}
