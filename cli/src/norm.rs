//! `maquette norm`.

use std::path::PathBuf;

use clap::Args;
use maquette::gait::{Footwear, Norm};
use maquette::io::folder::write_atomically;
use maquette::io::gait::norm_text;
use maquette::workflow::NormPeople;
use serde_json::{Value, json};

use crate::camera_fit::check_free;
use crate::choice::one_of;
use crate::error::CliError;
use crate::subject::FOOTWEAR;
use crate::switches::{Output, Overwrite, print_notes};

pub(super) const ABOUT: &str = "\
Make a norm of your own laboratory from walks of healthy people: mean and standard deviation between people of every angle over the \
gait cycle, and of steps and strides.

Takes three people or more, each as the folder of a session or a fit, or a .trc file. Writes a file that --norm of gait, report and \
compare reads. docs/gait.md describes it.";

pub(super) const EXAMPLES: &str = "\
Examples:
  maquette norm out/anna out/ben out/cleo --out our-norm.toml --footwear barefoot
  maquette gait out/me --norm our-norm.toml";

/// Arguments of `maquette norm`.
#[derive(Debug, Args)]
pub(super) struct NormArguments {
    /// A session, fit or .trc file of each person
    #[arg(required = true)]
    people: Vec<PathBuf>,
    /// The file to write
    #[arg(long, value_name = "FILE")]
    out: PathBuf,
    /// What the norm is called in reports
    #[arg(long, value_name = "TEXT", default_value = "own norm")]
    name: String,
    /// What those wore whose session does not say so
    #[arg(long, value_parser = one_of(FOOTWEAR))]
    footwear: Option<Footwear>,
    /// Body model of all, if it is not a shipped one
    #[arg(long, value_name = "FILE")]
    body: Option<String>,
    #[command(flatten)]
    overwrite: Overwrite,
    #[command(flatten)]
    output: Output,
}

/// Reads everybody, writes the norm.
pub(super) fn run(arguments: &NormArguments) -> Result<(), CliError> {
    let out = &arguments.out;
    check_free(std::slice::from_ref(out), arguments.overwrite.existing())?;
    let people = NormPeople {
        paths: &arguments.people,
        body: arguments.body.as_deref(),
        footwear: arguments.footwear,
        name: &arguments.name,
    };
    let norm = people.norm()?;
    write_atomically(out, norm_text(&norm).as_bytes())?;

    print_notes(&norm.remarks);
    arguments.output.summarise(|| text(arguments, &norm), || json(arguments, &norm));
    Ok(())
}

fn json(arguments: &NormArguments, norm: &Norm) -> Value {
    let angles: Vec<&str> = norm.curves.keys().map(|angle| angle.name()).collect();
    let parameters: Vec<&str> = norm.parameters.keys().map(|p| p.name()).collect();
    json!({
        "out": arguments.out.display().to_string(),
        "people": arguments.people.len(),
        "angles": angles,
        "parameters": parameters,
        "remarks": norm.remarks,
    })
}

fn text(arguments: &NormArguments, norm: &Norm) -> String {
    format!(
        "{} people: {} angles over the cycle, {} parameters of steps and strides\nWritten to {}\n",
        arguments.people.len(),
        norm.curves.len(),
        norm.parameters.len(),
        arguments.out.display()
    )
}
