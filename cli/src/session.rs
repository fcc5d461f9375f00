//! `maquette session`.

use std::path::PathBuf;
use std::time::Instant;

use clap::Args;
use maquette::FitOptions;
use maquette::io::folder::Existing;
use maquette::io::session::SessionFile;
use maquette::pipeline::Progress;
use maquette::workflow::{FittedSession, Session, SessionFolder};
use serde_json::{Value, json};

use crate::complain;
use crate::error::{CliError, one_line};
use crate::switches::{Output, Threads};
use crate::table::Table;

pub(super) const ABOUT: &str = "\
Fit several trials of one person with one body.

Give the folders of the recordings, or one folder that holds them, or a session.toml that names the person and the trials. Several \
folders of recordings are conditions of one session, which `maquette compare` compares. Every trial is fitted \
alone first, as `maquette fit` does it. Then all get one body: the lengths, the clothes and the places of the \
cameras are the same in all trials, and each trial has its own motion. A trial whose lengths are not those of the others is named. The \
result goes into OUT: session.json, trials/NAME with the files of a fit, and alone/NAME with each trial by itself.";

pub(super) const EXAMPLES: &str = "\
Examples:
  maquette session walks --out out/before                 (a folder of walks)
  maquette session walk1 walk2 walk3 --fps 50 --out out/before
  maquette session before after --out out/both            (two folders of walks: two conditions)
  maquette session before.session/session.toml --out out/before
  maquette session walks --out out/before --resume --without walk3
  maquette report out/before
  maquette compare out/before out/after --out out/change";

/// Arguments of `maquette session`.
#[derive(Debug, Args)]
pub(super) struct SessionArguments {
    /// Recordings, a folder of recordings, or a session.toml
    #[arg(required = true)]
    trials: Vec<PathBuf>,
    /// Folder for the result; it must be empty or new
    #[arg(long)]
    out: PathBuf,
    /// Leave out a trial, by its name; may be given again
    #[arg(long, value_name = "NAME")]
    without: Vec<String>,
    /// Frames per second, where neither a video nor a file states them
    #[arg(long, allow_negative_numbers = true)]
    fps: Option<f64>,
    /// Body model: a shipped one (see `maquette models`) or a .toml file [default: that of the recordings, or human-metaballs]
    #[arg(long, value_name = "NAME|FILE")]
    body: Option<String>,
    #[command(flatten)]
    threads: Threads,
    /// Go on in OUT: trials that were fitted before are taken up
    #[arg(long, conflicts_with = "overwrite")]
    resume: bool,
    /// Replace the session in OUT
    #[arg(long)]
    overwrite: bool,
    #[command(flatten)]
    output: Output,
}

impl SessionArguments {
    fn existing(&self) -> Existing {
        match (self.resume, self.overwrite) {
            (true, _) => Existing::Resume,
            (false, true) => Existing::Overwrite,
            (false, false) => Existing::Refuse,
        }
    }
}

impl SessionArguments {
    /// The session, which is written into a folder.
    fn fitted(&self, progress: &dyn Progress) -> Result<FittedSession, CliError> {
        let session = Session::open(&self.trials)?.without(&self.without)?;
        let session = Session { fps: self.fps, ..session };
        let folder = SessionFolder { path: &self.out, existing: self.existing() };
        let options = FitOptions { body: self.body.clone(), ..FitOptions::default() };
        Ok(session.fit_into(folder, &options, progress)?)
    }

    /// The same on as many threads as were asked for.
    pub(super) fn call(&self, progress: &dyn Progress) -> Result<FittedSession, CliError> {
        self.threads.run(|| self.fitted(progress))
    }
}

/// Fits all trials and writes the session.
pub(super) fn run(arguments: &SessionArguments) -> Result<(), CliError> {
    arguments.threads.run(|| fit(arguments))
}

fn fit(arguments: &SessionArguments) -> Result<(), CliError> {
    let start = Instant::now();
    let fitted = arguments.fitted(&arguments.output.progress())?;

    let seconds = start.elapsed().as_secs_f64();
    let file = &fitted.file;
    arguments
        .output
        .summarise(|| text(arguments, file, seconds), || json(arguments, file, seconds));
    if arguments.output.is_quiet() {
        warnings(&fitted).for_each(|line| complain("warning", &one_line(&line)));
    }
    Ok(fitted.usable()?)
}

/// What a person should know of the session and of its trials.
fn warnings(session: &FittedSession) -> impl Iterator<Item = String> {
    let file = &session.file;
    let of_trial = file.trials.iter().filter_map(|trial| {
        trial.verdict.as_ref().map(|verdict| format!("trial {}: {verdict}", trial.name))
    });
    file.notes.iter().cloned().chain(of_trial)
}

fn json(arguments: &SessionArguments, file: &SessionFile, seconds: f64) -> Value {
    json!({ "out": arguments.out.display().to_string(), "seconds": seconds, "session": file })
}

/// Tables for a person.
fn text(arguments: &SessionArguments, file: &SessionFile, seconds: f64) -> String {
    let mut trials = Table::new(&["trial", "frames", ""]);
    for trial in &file.trials {
        let verdict = trial.verdict.clone().unwrap_or_default();
        trials.row(vec![trial.name.clone(), trial.frames.to_string(), verdict]);
    }

    let cm = |metres: f64| format!("{:.1}", 100.0 * metres);
    let sd = |sd_m: Option<f64>| sd_m.map_or(String::new(), |sd| format!("± {}", cm(sd)));
    let mut lengths = Table::new(&["length", "cm", "± SD", "alone, from", "to"]);
    for length in &file.lengths {
        let (least, most) = length
            .alone_m
            .iter()
            .fold((f64::INFINITY, 0.0_f64), |(a, b), m| (a.min(*m), b.max(*m)));
        let name = length.name.replace('_', " ");
        lengths.row(vec![name, cm(length.length_m), sd(length.sd_m), cm(least), cm(most)]);
    }

    let odd = file.disagreements.iter().map(|odd| format!("!! {}\n", odd.line));
    let notes = file.notes.iter().map(|note| format!("{note}\n"));
    let head = format!(
        "{} fitted to {} trials with one body in {seconds:.1} s\n",
        file.body,
        file.trials.len()
    );
    let end = format!("Written into {}\n", arguments.out.display());
    let sections = odd.chain([head, trials.text(), lengths.text()]).chain(notes).chain([end]);
    sections.collect::<Vec<_>>().join("\n")
}
