//! `maquette study`: named here, done by the Python package.

use std::ffi::OsString;

use clap::Args;

use crate::error::CliError;

pub(super) const ABOUT: &str = "\
Fit all trials of a study: thousands of recordings, one dataset.

This is part of the Python package, which brings a command `maquette` that knows it: pip install \"./python[study]\" in a clone of the \
repository. docs/scale.md describes it.";

/// Arguments of `maquette study`, whatever they are.
#[derive(Debug, Args)]
pub(super) struct StudyArguments {
    #[arg(hide = true, trailing_var_arg = true, allow_hyphen_values = true)]
    words: Vec<OsString>,
}

/// Says where the command is.
pub(super) fn run(_: &StudyArguments) -> Result<(), CliError> {
    Err(CliError::Arguments(
        "study: the Python package does this: pip install \"./python[study]\" in a clone of the repository, then again"
            .into(),
    ))
}
