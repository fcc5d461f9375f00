//! Which body is fitted.

use std::path::Path;

use super::{Error, FitOptions};
use crate::body::BodyModel;
use crate::io::model::{self, ModelText};
use crate::io::recording::{InputChecksum, Recording};

/// The body when nobody names one: its contours and depths are those of a skin.
pub const DEFAULT_BODY: &str = "human-metaballs";

/// The body that was asked for, or that the recording names, and the fingerprints of all that it was read from.
pub(super) fn body(
    options: &FitOptions,
    recording: &Recording,
) -> Result<(BodyModel, Vec<InputChecksum>), Error> {
    let (name, folder) = match (options.body.as_deref(), recording.body()) {
        (Some(name), _) => (name, Path::new("")),
        (None, Some(name)) => (name, recording.folder()),
        (None, None) => (DEFAULT_BODY, Path::new("")),
    };
    let (model, texts) = model::load_with_texts(name, folder)?;
    let checksum =
        |file: &ModelText| InputChecksum::from_text(format!("body {}", file.name), &file.text);
    Ok((model, texts.iter().map(checksum).collect()))
}
