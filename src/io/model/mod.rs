//! Body model files (`data/models/*.toml`): TOML to [`BodyModel`].
//!
//! `spec` is the file as it is written, `extend` adds what the file that it extends says, `build` makes the
//! model of it: sides are doubled, parents sorted first (`order`), names resolved, degrees turned to radians. Field by
//! field: docs/formats.md.

mod build;
mod extend;
mod flesh;
mod lengths;
mod order;
mod side;
mod spec;

use std::path::{Path, PathBuf};

use crate::body::{BodyModel, ModelError};
use crate::io::input;

/// The models that come with the program: name and text.
pub const SHIPPED: [(&str, &str); 6] = [
    ("human-ellipsoids", include_str!("../../../data/models/human-ellipsoids.toml")),
    ("human-metaballs", include_str!("../../../data/models/human-metaballs.toml")),
    ("walker-metaballs", include_str!("../../../data/models/walker-metaballs.toml")),
    ("arm", include_str!("../../../data/models/arm.toml")),
    ("arm-ellipsoids", include_str!("../../../data/models/arm-ellipsoids.toml")),
    ("arm-2d", include_str!("../../../data/models/arm-2d.toml")),
];

/// Why a model file could not be used.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum ModelFileError {
    /// Neither a shipped model nor a file.
    #[error("no body model {name:?}: shipped are {shipped}; anything else must be a .toml file")]
    Unknown {
        /// What was asked for.
        name: String,
        /// What there is.
        shipped: String,
    },
    /// The file cannot be read.
    #[error("cannot read body model {path}: {source}")]
    Read {
        /// File.
        path: PathBuf,
        /// Why.
        source: std::io::Error,
    },
    /// Not TOML, or not the keys that a model has.
    #[error("{path}:{line}: {message}")]
    Syntax {
        /// File.
        path: PathBuf,
        /// Line, from 1.
        line: usize,
        /// The parser's words.
        message: String,
    },
    /// A name that nothing defines.
    #[error("{path}: {place} names the {kind} {name:?}, which the file does not define")]
    Missing {
        /// File.
        path: PathBuf,
        /// Where.
        place: String,
        /// part, coefficient, factor or point.
        kind: &'static str,
        /// The name.
        name: String,
    },
    /// Two things of one name.
    #[error("{path}: two {kind}s are named {name:?}")]
    Duplicate {
        /// File.
        path: PathBuf,
        /// part, joint, coefficient or point.
        kind: &'static str,
        /// The name.
        name: String,
    },
    /// A part is its own ancestor.
    #[error("{path}: part {part:?} is its own ancestor: break the cycle of `parent`")]
    Cycle {
        /// File.
        path: PathBuf,
        /// One part of the cycle.
        part: String,
    },
    /// An axis that is neither ±x, ±y, ±z nor three numbers of positive length.
    #[error(
        "{path}: joint {joint}: the axis {found} is no direction: give \"x\", \"-y\" or three numbers"
    )]
    Axis {
        /// File.
        path: PathBuf,
        /// Joint.
        joint: String,
        /// What stands there.
        found: String,
    },
    /// A part without joints that states where its first joint is.
    #[error(
        "{path}: part {part}: `{key}` says where its first joint is, and it has none: give it a joint or leave `{key}` out"
    )]
    NoJoint {
        /// File.
        path: PathBuf,
        /// Part.
        part: String,
        /// The key that has no effect.
        key: &'static str,
    },
    /// Two keys in one place that say the same thing, or none of them.
    #[error("{path}: {place}: expected one of `{keys}`, found {found}", keys = keys.join("`, `"))]
    OneOf {
        /// File.
        path: PathBuf,
        /// Where.
        place: String,
        /// The keys.
        keys: [&'static str; 2],
        /// How many of them are there.
        found: usize,
    },
    /// No part without a parent, or more than one.
    #[error("{path}: expected one part without a parent, found {found}")]
    Roots {
        /// File.
        path: PathBuf,
        /// How many.
        found: usize,
    },
    /// The model that is extended cannot be used.
    #[error("{path}: what it extends: {fault}")]
    Base {
        /// File.
        path: PathBuf,
        /// What is wrong with the other.
        fault: Box<ModelFileError>,
    },
    /// A file extends itself, by way of others or not.
    #[error("{path} extends itself: break the cycle of `extends`")]
    ExtendsItself {
        /// File.
        path: PathBuf,
    },
    /// The model itself is faulty.
    #[error("{path}: {fault}")]
    Model {
        /// File.
        path: PathBuf,
        /// What is wrong.
        fault: ModelError,
    },
}

/// A file that a model is made of.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct ModelText {
    /// The model's name in it.
    pub name: String,
    /// Where it is; of a shipped model its name.
    pub path: PathBuf,
    /// The whole text.
    pub text: String,
}

/// Loads a shipped model by name, or a file by path (relative to `folder`).
///
/// # Errors
/// [`ModelFileError`] names the file, the place and what was expected.
pub fn load(name: &str, folder: &Path) -> Result<BodyModel, ModelFileError> {
    Ok(load_with_texts(name, folder)?.0)
}

/// As [`load`], with every file that was read: the model's own, the one that it extends, and so on.
///
/// # Errors
/// As [`load`].
pub fn load_with_texts(
    name: &str,
    folder: &Path,
) -> Result<(BodyModel, Vec<ModelText>), ModelFileError> {
    let (text, path) = text_of(name, folder)?;
    let mut read = Vec::new();
    let spec = extend::with_base(&text, &path, &mut read)?;
    Ok((build::build(&spec, &path)?, read))
}

/// The text of a shipped model by name, or of a file by path (relative to `folder`), and what errors call it.
fn text_of(name: &str, folder: &Path) -> Result<(String, PathBuf), ModelFileError> {
    if let Some((_, text)) = SHIPPED.iter().find(|(shipped, _)| *shipped == name) {
        return Ok(((*text).to_owned(), PathBuf::from(format!("{name}.toml"))));
    }
    if Path::new(name).extension().is_none_or(|e| e != "toml") {
        let shipped = SHIPPED.map(|(n, _)| n).join(", ");
        return Err(ModelFileError::Unknown { name: name.to_owned(), shipped });
    }
    let path = folder.join(name);
    match input::read_text(&path) {
        Ok(text) => Ok((text, path)),
        Err(source) => Err(ModelFileError::Read { path, source }),
    }
}

/// Parses the text of a model file; `path` is what errors name.
///
/// # Errors
/// As [`load`].
pub fn parse(text: &str, path: &Path) -> Result<BodyModel, ModelFileError> {
    let spec = extend::with_base(text, path, &mut Vec::new())?;
    build::build(&spec, path)
}

fn parse_toml<T: serde::de::DeserializeOwned>(
    text: &str,
    path: &Path,
) -> Result<T, ModelFileError> {
    toml::from_str(text).map_err(|e| ModelFileError::Syntax {
        path: path.to_owned(),
        line: e.span().map_or(0, |s| text[..s.start].matches('\n').count() + 1),
        message: e.message().to_owned(),
    })
}
