//! The extension module `maquette._maquette`: what the Python package `maquette` calls.
//!
//! It turns words into calls of the program and results into arrays, and computes nothing. Names, units and tables are
//! made in Python, in `python/maquette/`.
//!
//! | file         | holds                                                    |
//! |--------------|----------------------------------------------------------|
//! | `fitted.rs`  | a fitted body                                            |
//! | `arrays.rs`  | its frames as NumPy's arrays                             |
//! | `study.rs`   | its gait                                                 |
//! | `session.rs` | several walks of one person, and what changed between two days |
//! | `files.rs`   | commands that write files and tell what they have found  |
//! | `watch.rs`   | work without the interpreter's lock, which can be stopped |
//! | `fault.rs`   | what went wrong, as an exception                         |

mod arrays;
mod fault;
mod files;
mod fitted;
mod session;
mod study;
mod watch;

use std::ffi::OsString;
use std::io::Write;
use std::path::PathBuf;

use image::GrayImage;
use maquette::Recording;
use maquette::io::folder::OutError;
use maquette_cli::call;
use numpy::PyReadonlyArray2;
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;

use fault::exception;
use fitted::Fitted;
use study::Study;
use watch::{Listeners, unlocked, watched};

/// What `maquette fit` with these words finds and writes.
#[pyfunction]
fn fit(py: Python<'_>, words: Vec<OsString>, listeners: Listeners) -> PyResult<Fitted> {
    watched(py, &listeners, |progress| call::fit(&words, progress)).map(Fitted::new)
}

/// Fingerprints of everything that `maquette fit` with these words reads: each input's name and BLAKE3.
#[pyfunction]
fn inputs(py: Python<'_>, words: Vec<OsString>) -> PyResult<Vec<(String, String)>> {
    let inputs = unlocked(py, || call::inputs(&words))?;
    Ok(inputs.into_iter().map(|sum| (sum.input, sum.blake3)).collect())
}

/// The body and the height that a recording names; an exception if there is no such recording.
#[pyfunction]
fn recording(path: PathBuf) -> PyResult<(Option<String>, Option<f64>)> {
    let recording =
        Recording::open(path).map_err(|fault| exception(maquette::Error::from(fault)))?;
    Ok((recording.body().map(str::to_owned), recording.height_m()))
}

/// Writes what `maquette synth` with these words writes.
#[pyfunction]
fn synth(py: Python<'_>, words: Vec<OsString>) -> PyResult<()> {
    unlocked(py, || call::synth(&words))
}

/// Writes what `maquette simulate` with these words writes.
#[pyfunction]
fn simulate(py: Python<'_>, words: Vec<OsString>) -> PyResult<()> {
    unlocked(py, || call::simulate(&words))
}

/// Where the recording is that the folder of a fit names.
#[pyfunction]
fn origin(folder: PathBuf) -> Option<PathBuf> {
    maquette::io::folder::origin::read(&folder)
}

/// Writes a mask, grey values of shape H × W, as a picture.
#[pyfunction]
fn write_mask(path: PathBuf, mask: PyReadonlyArray2<'_, u8>) -> PyResult<()> {
    let mask = mask.as_array();
    let [height, width] = [mask.nrows(), mask.ncols()].map(|side| u32::try_from(side).ok());
    let picture = width.zip(height).and_then(|(width, height)| {
        GrayImage::from_raw(width, height, mask.iter().copied().collect())
    });
    let picture = picture.ok_or_else(|| PyValueError::new_err("a mask that is too large"))?;
    picture.save(&path).map_err(|fault| {
        let source = std::io::Error::other(fault);
        exception(maquette::Error::from(OutError::Write { path, source }))
    })
}

/// Does what the words of the command line say, the program's name first, and gives the exit code.
#[pyfunction]
fn main(py: Python<'_>, words: Vec<OsString>) -> u8 {
    let code = py.detach(|| maquette_cli::run(words));
    // nobody flushes it when the interpreter ends; a reader that has closed it is no fault
    let _ = std::io::stdout().flush();
    code
}

/// The module's content.
#[pymodule]
fn _maquette(module: &Bound<'_, PyModule>) -> PyResult<()> {
    module.add("__version__", env!("CARGO_PKG_VERSION"))?;
    module.add_class::<Fitted>()?;
    module.add_class::<Study>()?;
    module.add_function(wrap_pyfunction!(fit, module)?)?;
    module.add_function(wrap_pyfunction!(inputs, module)?)?;
    module.add_function(wrap_pyfunction!(recording, module)?)?;
    module.add_function(wrap_pyfunction!(origin, module)?)?;
    module.add_function(wrap_pyfunction!(session::session, module)?)?;
    module.add_function(wrap_pyfunction!(session::session_page, module)?)?;
    module.add_function(wrap_pyfunction!(session::compare, module)?)?;
    module.add_function(wrap_pyfunction!(files::calibrate, module)?)?;
    module.add_function(wrap_pyfunction!(files::sync, module)?)?;
    module.add_function(wrap_pyfunction!(files::segment, module)?)?;
    module.add_function(wrap_pyfunction!(files::silhouettes, module)?)?;
    module.add_function(wrap_pyfunction!(files::stereo, module)?)?;
    module.add_function(wrap_pyfunction!(files::skin, module)?)?;
    module.add_function(wrap_pyfunction!(synth, module)?)?;
    module.add_function(wrap_pyfunction!(simulate, module)?)?;
    module.add_function(wrap_pyfunction!(write_mask, module)?)?;
    module.add_function(wrap_pyfunction!(main, module)?)
}
