//! `maquette fit`: parse, fit into a folder, say what was found.

mod arguments;

use std::time::Instant;

pub(super) use arguments::{ABOUT, EXAMPLES, FitArguments};
use maquette::Recording;
use maquette::workflow::FitFolder;

use crate::complain;
use crate::error::{CliError, one_line};
use crate::summary::Summary;

/// Fits a recording and writes the result.
pub(super) fn run(arguments: &FitArguments) -> Result<(), CliError> {
    arguments.threads.run(|| fit(arguments))
}

fn fit(arguments: &FitArguments) -> Result<(), CliError> {
    let start = Instant::now();
    let folder = FitFolder {
        path: &arguments.out,
        existing: arguments.existing(),
        overlays: arguments.overlays,
    };
    let recording = Recording::open(&arguments.recording)?.with_fps(arguments.fps);
    let fit = recording.fit_into(folder, &arguments.options(), &arguments.output.progress())?;

    let summary = Summary {
        result: &fit.result,
        out: &arguments.out,
        seconds: start.elapsed().as_secs_f64(),
    };
    arguments.output.summarise(|| summary.text(), || summary.json());
    if arguments.output.is_quiet() {
        let warnings = fit.result.warnings.iter();
        warnings.for_each(|warning| complain("warning", &one_line(warning)));
    }
    Ok(fit.usable()?)
}
