//! `maquette fit`: parse, fit into a folder, say what was found.

mod arguments;

use std::time::Instant;

pub(super) use arguments::{ABOUT, EXAMPLES, FitArguments};
use maquette::io::recording::InputChecksum;
use maquette::pipeline::Progress;
use maquette::workflow::FitFolder;
use maquette::{FittedRecording, Recording};

use crate::complain;
use crate::error::{CliError, one_line};
use crate::summary::Summary;

/// Fits a recording and writes the result.
pub(super) fn run(arguments: &FitArguments) -> Result<(), CliError> {
    arguments.threads.run(|| fit(arguments))
}

impl FitArguments {
    fn recording(&self) -> Result<Recording, CliError> {
        Ok(Recording::open(&self.recording)?.with_fps(self.fps))
    }

    /// Fingerprints of everything that the fit reads.
    pub(super) fn inputs(&self) -> Result<Vec<InputChecksum>, CliError> {
        Ok(self.recording()?.inputs(&self.options())?)
    }

    /// The fit, which is written into a folder.
    fn fitted(&self, progress: &dyn Progress) -> Result<FittedRecording, CliError> {
        let folder =
            FitFolder { path: &self.out, existing: self.existing(), overlays: self.overlays };
        Ok(self.recording()?.fit_into(folder, &self.options(), progress)?)
    }

    /// The same on as many threads as were asked for.
    pub(super) fn call(&self, progress: &dyn Progress) -> Result<FittedRecording, CliError> {
        self.threads.run(|| self.fitted(progress))
    }
}

fn fit(arguments: &FitArguments) -> Result<(), CliError> {
    let start = Instant::now();
    let fit = arguments.fitted(&arguments.output.progress())?;

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
