//! `maquette gait`.

mod text;

use std::path::PathBuf;

use clap::Args;
use serde_json::json;

use crate::choice::{Choice, one_of};
use crate::error::CliError;
use crate::page::LanguageArgument;
use crate::subject::{EventArguments, SubjectArguments};
use crate::switches::{Output, Overwrite};
use maquette::gait::{GaitOptions, Surface};
use maquette::io::folder::{check_out, write_atomically};
use maquette::io::frame_rate;
use maquette::workflow::GaitSource;
use maquette::{FittedRecording, GaitStudy};
use text::Summary;

pub(super) const ABOUT: &str = "\
Analyse how a person walks: foot strikes and offs, speed, cadence, steps and phases, joint angles over the gait cycle, \
and how far they lie from those of healthy people.

Reads the folder of a finished `maquette fit`, or a .trc of joint centres or markers of any system. Writes gait.json, \
parameters.csv, curves.csv and angles.csv. docs/gait.md defines every number.";

pub(super) const EXAMPLES: &str = "\
Examples:
  maquette gait out/me
  maquette gait walk.trc --out out/walk
  maquette gait treadmill.trc --surface treadmill --normalised";

/// Arguments of `maquette gait`.
#[derive(Debug, Args)]
pub(super) struct GaitArguments {
    /// Folder of a finished fit, or a .trc file
    input: PathBuf,
    /// Where to write [default: OUT/gait of a fit, NAME_gait beside NAME.trc]
    #[arg(long, value_name = "FOLDER")]
    out: Option<PathBuf>,
    /// Which pass through the room to analyse, if the person leaves and comes back [default: the longest]
    #[arg(long, value_name = "N")]
    pass: Option<usize>,
    /// What the person walks on [default: detected]
    #[arg(long, value_parser = one_of(SURFACES))]
    surface: Option<Surface>,
    /// Frames per second, overriding the input
    #[arg(long, value_name = "HZ", value_parser = rate)]
    fps: Option<f64>,
    /// Cutoff of the low-pass filter on all points, Hz; 0 turns it off
    #[arg(long, value_name = "HZ", default_value_t = GaitOptions::default().cutoff_hz, value_parser = cutoff)]
    cutoff: f64,
    /// Norm of healthy people: a .toml file, or none [default: the shipped one of their age]
    #[arg(long, value_name = "FILE|none")]
    norm: Option<String>,
    /// Show parameters without units, scaled by leg length (Hof 1996)
    #[arg(long)]
    normalised: bool,
    #[command(flatten)]
    events: EventArguments,
    /// Body model of the fit, if it is not a shipped one
    #[arg(long, value_name = "FILE")]
    body: Option<String>,
    /// Also write report.html, for clinicians
    #[arg(long)]
    report: bool,
    #[command(flatten)]
    language: LanguageArgument,
    #[command(flatten, next_help_heading = "About the person and the report")]
    subject: SubjectArguments,
    #[command(flatten)]
    overwrite: Overwrite,
    #[command(flatten)]
    output: Output,
}

const SURFACES: &[Choice<Surface>] = &[
    ("ground", Surface::Ground, "The floor of the room"),
    ("treadmill", Surface::Treadmill, "A belt"),
];

fn rate(text: &str) -> Result<f64, String> {
    match text.parse::<f64>() {
        Ok(hz) if frame_rate::is_one(hz) => Ok(hz),
        _ => Err(format!("expected {}", frame_rate::EXPECTED)),
    }
}

fn cutoff(text: &str) -> Result<f64, String> {
    match text.parse::<f64>() {
        Ok(hz) if hz >= 0.0 && hz.is_finite() => Ok(hz),
        _ => Err("expected a cutoff of 0 Hz or above".into()),
    }
}

/// Reads, analyses, writes, prints.
pub(super) fn run(arguments: &GaitArguments) -> Result<(), CliError> {
    let source = GaitSource {
        path: &arguments.input,
        body: arguments.body.as_deref(),
        fps: arguments.fps,
        events: arguments.events.choice(),
    };
    let out = out_folder(arguments);
    check_out(&out, arguments.overwrite.existing())?;
    let study = GaitStudy::open(source, &arguments.options())?;
    let study = arguments.subject.compare(study, arguments.norm.as_deref())?;

    study.save(&out)?;
    if arguments.report {
        let (language, progress) = (arguments.language.get(), arguments.output.progress());
        let text = arguments.subject.report(&study, &arguments.input, language, &progress)?;
        write_atomically(&out.join("report.html"), text.as_bytes())?;
    }
    let text = || {
        let summary = Summary {
            input: &arguments.input,
            study: &study,
            footwear: arguments.subject.footwear(),
            is_normalised: arguments.normalised,
        };
        format!("{}\nWritten into {}\n", summary.text(), out.display())
    };
    let json = || json!({ "out": out.display().to_string(), "gait": study.file() });
    arguments.output.summarise(text, json);
    Ok(study.usable()?)
}

impl GaitArguments {
    /// How a walk is analysed.
    fn options(&self) -> GaitOptions {
        GaitOptions {
            cutoff_hz: self.cutoff,
            surface: self.surface,
            pass: self.pass,
            ..GaitOptions::default()
        }
    }

    /// A fit's walk, compared with a norm.
    pub(super) fn study(&self, fit: &FittedRecording) -> Result<GaitStudy, CliError> {
        let study = fit.gait_in(&self.input, self.events.choice(), &self.options())?;
        self.subject.compare(study, self.norm.as_deref())
    }
}

fn out_folder(arguments: &GaitArguments) -> PathBuf {
    let beside = || match arguments.input.is_dir() {
        true => arguments.input.join("gait"),
        false => {
            let stem = arguments.input.file_stem().unwrap_or_default();
            let name = format!("{}_gait", stem.to_string_lossy());
            arguments.input.with_file_name(name)
        }
    };
    arguments.out.clone().unwrap_or_else(beside)
}
