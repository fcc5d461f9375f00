//! `maquette export`.

use std::path::PathBuf;

use clap::Args;
use maquette::gait::GaitOptions;
use maquette::workflow::{ExportFormat, GaitSource};
use maquette::{FittedRecording, GaitStudy};
use serde_json::json;

use super::choice::{Choice, one_of};
use super::error::CliError;
use super::subject::EventArguments;
use super::switches::Output;

pub(super) const ABOUT: &str = "\
Write a fit in the formats of other programs.

Reads the folder of a finished `maquette fit` and writes motion.c3d, .trc, .mot, .sto, .bvh, .glb, .csv or .parquet into \
its folder export; ply and obj are the body's surface, a file per frame. Every file's world is Y up. docs/formats.md says what each \
holds.";

pub(super) const EXAMPLES: &str = "\
Examples:
  maquette export out/me
  maquette export out/me --format c3d,mot";

/// Arguments of `maquette export`.
#[derive(Debug, Args)]
pub(super) struct ExportArguments {
    /// Folder of a finished fit
    out: PathBuf,
    /// Formats, with commas between them [default: all formats that are a single file]
    #[arg(long, value_parser = one_of(FORMATS), value_delimiter = ',')]
    format: Vec<ExportFormat>,
    #[command(flatten)]
    events: EventArguments,
    /// Body model of the fit, if it is not a shipped one
    #[arg(long, value_name = "FILE")]
    body: Option<String>,
    #[command(flatten)]
    output: Output,
}

const FORMATS: &[Choice<ExportFormat>] = &[
    ("c3d", ExportFormat::C3d, "Points with their SD and cameras, angles, foot strikes and offs"),
    ("trc", ExportFormat::Trc, "Points"),
    ("mot", ExportFormat::Mot, "OpenSim's motion, degrees"),
    ("sto", ExportFormat::Sto, "The same as OpenSim's storage, radians"),
    ("bvh", ExportFormat::Bvh, "Skeleton in T-pose and its motion"),
    ("glb", ExportFormat::Glb, "glTF 2.0: the body on its bones, moving"),
    ("csv", ExportFormat::Csv, "Points, angles and their SD, frame by frame"),
    ("parquet", ExportFormat::Parquet, "The same as Parquet"),
    ("ply", ExportFormat::Ply, "The body's surface, a PLY file per frame"),
    ("obj", ExportFormat::Obj, "The body's surface, an OBJ file per frame"),
];

/// Reads the fit and writes each format.
pub(super) fn run(arguments: &ExportArguments) -> Result<(), CliError> {
    if !arguments.out.is_dir() {
        let path = arguments.out.clone();
        return Err(maquette::Error::NoFit { path }.into());
    }
    let study = GaitStudy::open(
        GaitSource {
            path: &arguments.out,
            body: arguments.body.as_deref(),
            fps: None,
            events: arguments.events.choice(),
        },
        &GaitOptions::default(),
    )?;

    let formats = match arguments.format.as_slice() {
        [] => default_formats(),
        some => some.to_vec(),
    };

    let folder = arguments.out.join("export");
    let mut paths = Vec::new();
    for format in formats {
        paths.push(study.export(format, &folder)?.display().to_string());
    }
    let lines = || paths.iter().map(|path| format!("{path}\n")).collect();
    arguments.output.summarise(lines, || json!({ "files": paths }));
    Ok(study.usable()?)
}

impl ExportArguments {
    /// The fit in each format, and where it was written: into the folder.
    pub(super) fn written(&self, fit: &FittedRecording) -> Result<Vec<PathBuf>, CliError> {
        let study = fit.gait_in(&self.out, self.events.choice(), &GaitOptions::default())?;
        let mut paths = Vec::new();
        for format in &self.format {
            paths.push(study.export(*format, &self.out)?);
        }
        Ok(paths)
    }
}

/// All that are one file.
fn default_formats() -> Vec<ExportFormat> {
    let is_one_file = |f: &ExportFormat| !matches!(f, ExportFormat::Ply | ExportFormat::Obj);
    FORMATS.iter().map(|(_, format, _)| *format).filter(is_one_file).collect()
}
