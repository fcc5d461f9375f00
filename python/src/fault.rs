//! What went wrong, as an exception of Python with the program's line.

use maquette::Error;
use maquette_cli::CliError;
use pyo3::prelude::*;

/// The exception of a fault: a class of `maquette.errors`, and the line that the program prints.
pub(crate) fn exception(fault: impl Into<CliError>) -> PyErr {
    let fault = fault.into();
    let made = Python::attach(|py| {
        let class = py.import("maquette.errors")?.getattr(class(&fault))?;
        Ok(PyErr::from_value(class.call1((fault.line(),))?))
    });
    made.unwrap_or_else(|odd: PyErr| odd)
}

/// The name of the class.
fn class(fault: &CliError) -> &'static str {
    match fault {
        CliError::Arguments(_) | CliError::Threads { .. } => "OptionError",
        CliError::Library(fault) => class_of(fault),
        _ => "MaquetteError",
    }
}

fn class_of(fault: &Error) -> &'static str {
    match fault {
        Error::Size(_) => "OptionError",
        Error::Recording(_) | Error::FrameRange(_) | Error::OneInstant => "RecordingError",
        Error::Model(_) => "BodyError",
        Error::Fit(_)
        | Error::Stereo(_)
        | Error::Silhouettes(_)
        | Error::Calibrate(_)
        | Error::Lenses(_)
        | Error::Sync(_) => "FitError",
        Error::Out(_) | Error::Journal(_) | Error::Overlay(_) | Error::Pdf(_) => "OutputError",
        Error::Result(_) | Error::Session(_) | Error::SessionFile(_) => "ResultError",
        Error::GaitInput(_)
        | Error::Movement(_)
        | Error::Gait(_)
        | Error::Events(_)
        | Error::Norm(_)
        | Error::OwnNorm(_) => "GaitError",
        Error::Unusable(_) => "UnusableError",
        _ => "MaquetteError",
    }
}
