//! Commands that write files and tell in JSON what they have found.

use std::ffi::OsString;

use maquette::pipeline::Progress;
use maquette_cli::{CliError, call};
use pyo3::prelude::*;
use serde_json::Value;

use crate::watch::{Listeners, in_own_pool, watched};

type Call = fn(&[OsString], &dyn Progress) -> Result<Value, CliError>;

/// What a command with these words tells.
fn told(py: Python<'_>, call: Call, words: &[OsString], listeners: &Listeners) -> PyResult<String> {
    let json = watched(py, listeners, |progress| in_own_pool(|| call(words, progress)))?;
    Ok(json.to_string())
}

/// What `maquette calibrate --json` with these words prints; the calibration is written.
#[pyfunction]
pub(crate) fn calibrate(
    py: Python<'_>,
    words: Vec<OsString>,
    listeners: Listeners,
) -> PyResult<String> {
    told(py, call::calibrate, &words, &listeners)
}

/// What `maquette sync --json` with these words prints; the offsets are written.
#[pyfunction]
pub(crate) fn sync(py: Python<'_>, words: Vec<OsString>, listeners: Listeners) -> PyResult<String> {
    told(py, call::sync, &words, &listeners)
}

/// What `maquette segment --json` with these words prints; the masks are written.
#[pyfunction]
pub(crate) fn segment(
    py: Python<'_>,
    words: Vec<OsString>,
    listeners: Listeners,
) -> PyResult<String> {
    told(py, call::segment, &words, &listeners)
}

/// What `maquette silhouettes --json` with these words prints; the silhouettes are written.
#[pyfunction]
pub(crate) fn silhouettes(
    py: Python<'_>,
    words: Vec<OsString>,
    listeners: Listeners,
) -> PyResult<String> {
    told(py, call::silhouettes, &words, &listeners)
}

/// What `maquette stereo --json` with these words prints; the points are written.
#[pyfunction]
pub(crate) fn stereo(
    py: Python<'_>,
    words: Vec<OsString>,
    listeners: Listeners,
) -> PyResult<String> {
    told(py, call::stereo, &words, &listeners)
}

/// What `maquette skin --json` with these words prints; the skins are written.
#[pyfunction]
pub(crate) fn skin(py: Python<'_>, words: Vec<OsString>, listeners: Listeners) -> PyResult<String> {
    told(py, call::skin, &words, &listeners)
}
