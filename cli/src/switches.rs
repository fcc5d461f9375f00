//! Switches that several commands have.

use clap::Args;
use serde_json::Value;

use super::error::{CliError, one_line};
use super::progress::Bars;
use super::{complain, print};
use maquette::io::folder::Existing;

/// `--quiet` and `--json`.
#[derive(Debug, Clone, Copy, Args)]
pub(super) struct Output {
    /// Print nothing but errors, warnings and notes
    #[arg(long)]
    quiet: bool,
    /// Print the summary as JSON, also with --quiet; `maquette schema` describes it
    #[arg(long)]
    json: bool,
}

impl Output {
    /// Whether nothing but errors, warnings and notes is printed.
    pub(super) fn is_quiet(self) -> bool {
        self.quiet
    }

    /// Prints the summary, for a person or as JSON.
    pub(super) fn summarise(self, text: impl FnOnce() -> String, json: impl FnOnce() -> Value) {
        match (self.json, self.quiet) {
            (true, _) => print(&format!("{:#}\n", json())),
            (false, false) => print(&text()),
            (false, true) => {}
        }
    }

    /// The bars of the stages.
    pub(super) fn progress(self) -> Bars {
        match self.quiet {
            true => Bars::hidden(),
            false => Bars::shown(),
        }
    }
}

/// Prints what the user should know, each in one line.
pub(super) fn print_notes(notes: &[String]) {
    for note in notes {
        complain("note", &one_line(note));
    }
}

/// `--overwrite` of what cannot be continued.
#[derive(Debug, Clone, Copy, Args)]
pub(super) struct Overwrite {
    /// Write into a folder that is not empty, and replace an older run's files
    #[arg(long)]
    overwrite: bool,
}

impl Overwrite {
    /// What to do with a folder that holds something.
    pub(super) fn existing(self) -> Existing {
        match self.overwrite {
            true => Existing::Overwrite,
            false => Existing::Refuse,
        }
    }
}

/// `--threads`.
#[derive(Debug, Clone, Copy, Args)]
pub(super) struct Threads {
    /// Threads; the result does not depend on it [default: all cores]
    #[arg(long, value_name = "N", default_value_t = 0, hide_default_value = true)]
    threads: usize,
}

impl Threads {
    /// Does some work on as many threads.
    pub(super) fn run<T: Send>(
        self,
        work: impl FnOnce() -> Result<T, CliError> + Send,
    ) -> Result<T, CliError> {
        let threads = self.threads;
        let pool = rayon::ThreadPoolBuilder::new()
            .num_threads(threads)
            .build()
            .map_err(|source| CliError::Threads { threads, source })?;
        pool.install(work)
    }
}
