//! `maquette report`.

use std::path::PathBuf;

use clap::Args;
use serde_json::json;

use maquette::gait::GaitOptions;
use maquette::io::folder::OutFolder;
use maquette::pipeline::Progress;
use maquette::workflow::{EventChoice, GaitSource, SessionStudy};
use maquette::{FittedRecording, GaitStudy};

use super::error::CliError;
use super::page::{PageArguments, Written};
use super::subject::{EventArguments, SubjectArguments, norm_choice};
use super::switches::Output;

pub(super) const ABOUT: &str = "\
Write a report that a clinician can read: one HTML file that needs nothing else.

Reads the folder of a finished `maquette fit` and writes OUT/report.html: identity and method, quality, steps and \
strides, joint angles against a norm, shape, and the body in motion. It opens in any browser without a network and \
prints on A4. It shows what the cameras saw of the recording, which OUT names in recording.toml. docs/report.md explains every page.

Of a folder of `maquette session` it is one page of all trials, beside variation.csv; who walked stands in session.toml (docs/session.md).";

pub(super) const EXAMPLES: &str = "\
Examples:
  maquette report out/me
  maquette report out/me --recording my-recording --no-pictures
  maquette report out/me --pdf --language de
  maquette report out/me --subject 'P 017' --age 72 --sex female --date 2026-03-02 --footwear barefoot";

/// Arguments of `maquette report`.
#[derive(Debug, Args)]
pub(super) struct ReportArguments {
    /// Folder of a finished fit, or of a session
    out: PathBuf,
    #[command(flatten)]
    subject: SubjectArguments,
    /// Norm of healthy people: a .toml file, or none [default: the shipped one of their age]
    #[arg(long, value_name = "FILE|none")]
    norm: Option<String>,
    #[command(flatten)]
    events: EventArguments,
    /// Body model of the fit, if it is not a shipped one
    #[arg(long, value_name = "FILE")]
    body: Option<String>,
    #[command(flatten)]
    page: PageArguments,
    #[command(flatten)]
    output: Output,
}

/// Reads the fit, analyses it and writes the report.
pub(super) fn run(arguments: &ReportArguments) -> Result<(), CliError> {
    if SessionStudy::is_session(&arguments.out) {
        return of_session(arguments);
    }
    let source = GaitSource {
        path: &arguments.out,
        body: arguments.body.as_deref(),
        fps: None,
        events: arguments.events.choice(),
    };
    let study = GaitStudy::open(source, &GaitOptions::default())?;
    let study = arguments.subject.compare(study, arguments.norm.as_deref())?;
    let language = arguments.page.language();
    let progress = arguments.output.progress();
    let text = arguments.subject.report(&study, &arguments.out, language, &progress)?;

    arguments.write(&OutFolder::open(&arguments.out)?, &text)?;
    Ok(study.usable()?)
}

impl ReportArguments {
    /// The page of a fit, whose files are in `out`.
    pub(super) fn page(
        &self,
        fit: &FittedRecording,
        progress: &dyn Progress,
    ) -> Result<String, CliError> {
        let gait = fit.gait_in(&self.out, self.events.choice(), &GaitOptions::default())?;
        let study = self.subject.compare(gait, self.norm.as_deref())?;
        self.subject.report(&study, &self.out, self.page.language(), progress)
    }

    /// The trials of a session, whose own file says who walked.
    fn session(&self) -> Result<SessionStudy, CliError> {
        if let Some(argument) = self.subject.given() {
            let out = self.out.display();
            return Err(CliError::Arguments(format!(
                "{argument}: {out} is of a session: who walked, and which trial is the standing one, stands in its session.toml (docs/session.md)"
            )));
        }
        if !matches!(self.events.choice(), EventChoice::Beside) {
            return Err(CliError::Arguments(format!(
                "--events: {} is of a session: corrected events of a trial stand in the events.json of its own folder (docs/session.md)",
                self.out.display()
            )));
        }
        let norm = norm_choice(self.norm.as_deref());
        Ok(SessionStudy::open(&self.out, self.body.as_deref(), norm)?)
    }

    /// The page of a session.
    pub(super) fn session_page(&self) -> Result<String, CliError> {
        Ok(self.session()?.report(self.page.language())?)
    }

    /// Writes the page, prints it if that is asked for, and says where both are.
    fn write(&self, out: &OutFolder, text: &str) -> Result<(), CliError> {
        let Written { page, pdf } = self.page.write(out, "report.html", text)?;

        let named = |path: &PathBuf| path.display().to_string();
        let all = [Some(&page), pdf.as_ref()].into_iter().flatten();
        let text = || all.map(|path| named(path) + "\n").collect::<String>();
        let json = || json!({ "report": named(&page), "pdf": pdf.as_ref().map(named) });
        self.output.summarise(text, json);
        Ok(())
    }
}

/// The page of all trials, and the table of how far numbers vary.
fn of_session(arguments: &ReportArguments) -> Result<(), CliError> {
    let study = arguments.session()?;
    let out = OutFolder::open(&arguments.out)?;
    out.write("variation.csv", &study.csv()?)?;
    arguments.write(&out, &study.report(arguments.page.language())?)
}
