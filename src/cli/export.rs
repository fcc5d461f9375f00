//! `maquette export`.

use std::path::PathBuf;

use clap::{Args, ValueEnum};

use super::analysis::{Analysed, Asked};
use super::error::CliError;
use super::print;
use crate::gait::{Gait, GaitOptions, Recording};
use crate::io::export::{C3dInput, TableKind, bvh, c3d, coordinates, glb, motion_text};
use crate::io::gait::{FittedBody, FittedPoint, GaitInput, angles_csv};
use crate::io::out_folder::{OutFolder, write_atomically};
use crate::io::trc::{Trajectories, write_trc};

pub(super) const ABOUT: &str = "\
Write a fit in the formats of other programs.

Reads the folder of a finished `maquette fit` and writes NAME.c3d, .trc, .mot, .sto, .bvh, .glb or .csv into its folder \
export. Every file's world is Y up. docs/formats.md says what each holds.";

pub(super) const EXAMPLES: &str = "\
Examples:
  maquette export out/me
  maquette export out/me --format c3d --format mot";

/// Arguments of `maquette export`.
#[derive(Debug, Args)]
pub(super) struct ExportArguments {
    /// Folder of a finished fit
    out: PathBuf,
    /// A format; may be given several times [default: all]
    #[arg(long, value_enum)]
    format: Vec<Format>,
    /// Body model of the fit, if it is not a shipped one
    #[arg(long, value_name = "FILE")]
    body: Option<String>,
    /// Print nothing but errors
    #[arg(long)]
    quiet: bool,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
enum Format {
    /// Points with their SD and cameras, angles, foot strikes and offs
    C3d,
    /// Points
    Trc,
    /// OpenSim's motion, degrees
    Mot,
    /// The same as OpenSim's storage, radians
    Sto,
    /// Skeleton in T-pose and its motion
    Bvh,
    /// glTF 2.0: the skin on its bones, moving (bodies with metaballs)
    Glb,
    /// Angles, frame by frame
    Csv,
}

/// Reads the fit and writes each format.
pub(super) fn run(arguments: &ExportArguments) -> Result<(), CliError> {
    let asked = Asked {
        from: &arguments.out,
        body: arguments.body.as_deref(),
        fps: None,
        norm: Some("none"),
    };
    let Analysed { input, gait, .. } = Analysed::of(&asked, &GaitOptions::default())?;
    let body = input.body.as_ref().ok_or_else(|| CliError::NoFit {
        path: arguments.out.clone(),
    })?;
    let has_skin = !body.model.metaballs.is_empty();
    let is_possible = |format: &&Format| has_skin || **format != Format::Glb;
    let formats: Vec<&Format> = match arguments.format.as_slice() {
        [] => Format::value_variants()
            .iter()
            .filter(is_possible)
            .collect(),
        some => some.iter().collect(),
    };
    let folder = arguments.out.join("export");
    OutFolder::open(&folder)?;
    for format in formats {
        let bytes = bytes_of(*format, (&input, body), &gait, arguments)?;
        let path = folder.join(format!("motion.{}", format.extension()));
        write_atomically(&path, &bytes)?;
        if !arguments.quiet {
            print(&format!("{}\n", path.display()));
        }
    }
    Ok(())
}

impl Format {
    fn extension(self) -> &'static str {
        match self {
            Self::C3d => "c3d",
            Self::Trc => "trc",
            Self::Mot => "mot",
            Self::Sto => "sto",
            Self::Bvh => "bvh",
            Self::Glb => "glb",
            Self::Csv => "csv",
        }
    }
}

fn bytes_of(
    format: Format,
    (input, body): (&GaitInput, &FittedBody),
    gait: &Gait,
    arguments: &ExportArguments,
) -> Result<Vec<u8>, CliError> {
    let recording = &input.recording;
    let table = |kind, format| {
        let table = coordinates(recording, gait).ok_or_else(|| CliError::NoCoordinates {
            path: arguments.out.clone(),
            format,
            body: input.source.clone(),
        })?;
        Ok::<_, CliError>(motion_text(&table, kind, "Coordinates"))
    };
    let text = match format {
        Format::C3d => {
            return Ok(c3d(&C3dInput {
                rate_hz: recording.rate_hz,
                first_frame: recording.first_frame,
                points: &body.points,
                cameras: &body.cameras,
                angles: &gait.angles,
                events: &gait.events,
            })?);
        }
        Format::Glb => {
            return Ok(glb(
                &body.model,
                &body.shape,
                &body.motions,
                recording.rate_hz,
            )?);
        }
        Format::Csv => return Ok(angles_csv(gait, recording)?),
        Format::Trc => trc(body, recording),
        Format::Mot => table(TableKind::Mot, "mot")?,
        Format::Sto => table(TableKind::Sto, "sto")?,
        Format::Bvh => bvh(&body.model, &body.shape, &body.motions, recording.rate_hz)?,
    };
    Ok(text.into_bytes())
}

/// The points of the fit, in the order of the model.
fn trc(body: &FittedBody, recording: &Recording) -> String {
    let frame = |i: usize| {
        let place = |point: &FittedPoint| {
            let known = point.track[i].iter().all(|v| v.is_finite());
            known.then(|| point.track[i].into())
        };
        body.points.iter().map(place).collect()
    };
    let trajectories = Trajectories {
        rate_hz: recording.rate_hz,
        first_frame: recording.first_frame,
        names: body.points.iter().map(|p| p.name.clone()).collect(),
        frames: (0..recording.frames).map(frame).collect(),
    };
    write_trc(&trajectories, "motion.trc")
}
