//! Several walks of one person with one body, and what changed between two days.

use std::ffi::OsString;

use maquette_cli::call;
use pyo3::prelude::*;

use crate::watch::{Listeners, unlocked, watched};

/// Writes what `maquette session` with these words writes, and gives the verdict of one that cannot be used.
#[pyfunction]
pub(crate) fn session(
    py: Python<'_>,
    words: Vec<OsString>,
    listeners: Listeners,
) -> PyResult<Option<String>> {
    let fitted = watched(py, &listeners, |progress| call::session(&words, progress))?;
    Ok(fitted.usable().err().map(|verdict| verdict.to_string()))
}

/// The page of all trials that `maquette report` with these words writes.
#[pyfunction]
pub(crate) fn session_page(py: Python<'_>, words: Vec<OsString>) -> PyResult<String> {
    unlocked(py, || call::session_page(&words))
}

/// What `maquette compare --json` with these words prints, and its page.
#[pyfunction]
pub(crate) fn compare(py: Python<'_>, words: Vec<OsString>) -> PyResult<(String, String)> {
    let (json, page) = unlocked(py, || call::compare(&words))?;
    Ok((json.to_string(), page))
}
