//! `maquette schema`.

use clap::{Args, ValueEnum};

use super::print;

pub(super) const ABOUT: &str = "\
Print the JSON Schema (draft 2020-12) of what a command prints with --json.";

/// Arguments of `maquette schema`.
#[derive(Debug, Args)]
pub(super) struct SchemaArguments {
    /// The command
    #[arg(value_enum)]
    command: Verb,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
enum Verb {
    Fit,
    Session,
    Compare,
    Segment,
    Silhouettes,
    Skin,
    Stereo,
    Calibrate,
    Sync,
    Gait,
    Report,
    Norm,
    Export,
    Models,
    Synth,
    Simulate,
}

/// Prints a schema.
pub(super) fn run(arguments: &SchemaArguments) {
    print(match arguments.command {
        Verb::Fit => include_str!("../schemas/fit.json"),
        Verb::Session => include_str!("../schemas/session.json"),
        Verb::Compare => include_str!("../schemas/compare.json"),
        Verb::Segment => include_str!("../schemas/segment.json"),
        Verb::Silhouettes => include_str!("../schemas/silhouettes.json"),
        Verb::Skin => include_str!("../schemas/skin.json"),
        Verb::Stereo => include_str!("../schemas/stereo.json"),
        Verb::Calibrate => include_str!("../schemas/calibrate.json"),
        Verb::Sync => include_str!("../schemas/sync.json"),
        Verb::Gait => include_str!("../schemas/gait.json"),
        Verb::Report => include_str!("../schemas/report.json"),
        Verb::Norm => include_str!("../schemas/norm.json"),
        Verb::Export => include_str!("../schemas/export.json"),
        Verb::Models => include_str!("../schemas/models.json"),
        Verb::Synth => include_str!("../schemas/synth.json"),
        Verb::Simulate => include_str!("../schemas/simulate.json"),
    });
}
