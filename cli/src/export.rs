//! `maquette export`.

use std::path::{Path, PathBuf};

use clap::{Args, ValueEnum};
use rayon::prelude::*;

use super::analysis::{Analysed, Asked};
use super::error::CliError;
use super::print;
use maquette::body::{Motion, Posed};
use maquette::camera::UpAxis;
use maquette::gait::{GaitAnalysis, GaitOptions, Movement};
use maquette::io::export::mesh::{MeshFormat, bytes_of};
use maquette::io::export::{
    C3dInput, TableKind, bvh, c3d, coordinates, frame_table, glb, motion_text,
};
use maquette::io::folder::{OutFolder, write_atomically};
use maquette::io::gait::GaitInput;
use maquette::io::points::trc::{Trajectories, write_trc};
use maquette::pipeline::{FittedBody, FittedPoint};
use maquette::skin::{SkinOptions, ellipsoids, skin};

pub(super) const ABOUT: &str = "\
Write a fit in the formats of other programs.

Reads the folder of a finished `maquette fit` and writes motion.c3d, .trc, .mot, .sto, .bvh, .glb, .csv or .parquet into \
its folder export; ply and obj are the body's surface, a file per frame. Every file's world is Y up. docs/formats.md says what each \
holds.";

pub(super) const EXAMPLES: &str = "\
Examples:
  maquette export out/me
  maquette export out/me --format c3d --format mot";

/// Arguments of `maquette export`.
#[derive(Debug, Args)]
pub(super) struct ExportArguments {
    /// Folder of a finished fit
    out: PathBuf,
    /// A format; may be given several times [default: all that are one file]
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
    /// glTF 2.0: the body on its bones, moving
    Glb,
    /// Points, angles and their SD, frame by frame
    Csv,
    /// The same as Parquet
    Parquet,
    /// The body's surface, a PLY file per frame
    Ply,
    /// The body's surface, an OBJ file per frame
    Obj,
}

/// Reads the fit and writes each format.
pub(super) fn run(arguments: &ExportArguments) -> Result<(), CliError> {
    let asked = Asked {
        from: &arguments.out,
        body: arguments.body.as_deref(),
        fps: None,
        norm: Some("none"),
        person: (None, None),
    };
    let Analysed { input, gait, .. } = Analysed::of(&asked, &GaitOptions::default())?;
    let body = input.body.as_ref().ok_or_else(|| CliError::NoFit {
        path: arguments.out.clone(),
    })?;
    let formats: Vec<Format> = match arguments.format.as_slice() {
        [] => default_formats(),
        some => some.to_vec(),
    };
    let export = Export {
        input: &input,
        body,
        gait: &gait,
        out: &arguments.out,
        folder: arguments.out.join("export"),
    };
    OutFolder::open(&export.folder)?;
    for format in formats {
        let path = export.write(format)?;
        if !arguments.quiet {
            print(&format!("{}\n", path.display()));
        }
    }
    Ok(())
}

/// All that are one file.
fn default_formats() -> Vec<Format> {
    let is_one_file = |format: &Format| !matches!(format, Format::Ply | Format::Obj);
    let all = Format::value_variants().iter().copied();
    all.filter(is_one_file).collect()
}

/// What is exported, and where to.
struct Export<'a> {
    input: &'a GaitInput,
    body: &'a FittedBody,
    gait: &'a GaitAnalysis,
    out: &'a Path,
    folder: PathBuf,
}

impl Export<'_> {
    /// Writes one format, and says where.
    fn write(&self, format: Format) -> Result<PathBuf, CliError> {
        let (body, movement) = (self.body, &self.input.movement);
        let (model, shape, motions) = (&body.model, &body.shape, &body.motions);
        let table = || frame_table(movement, &body.points, self.gait);
        let (extension, bytes) = match format {
            Format::C3d => ("c3d", self.c3d()?),
            Format::Trc => ("trc", trc(body, movement).into_bytes()),
            Format::Mot => ("mot", self.motion(TableKind::Mot, "mot")?),
            Format::Sto => ("sto", self.motion(TableKind::Sto, "sto")?),
            Format::Bvh => {
                let text = bvh(model, shape, motions, movement.rate_hz)?;
                ("bvh", text.into_bytes())
            }
            Format::Glb => ("glb", glb(model, shape, motions, movement.rate_hz)?),
            Format::Csv => ("csv", table().csv()?),
            Format::Parquet => ("parquet", table().parquet()?),
            Format::Ply => return self.surfaces(MeshFormat::Ply),
            Format::Obj => return self.surfaces(MeshFormat::Obj),
        };
        let path = self.folder.join(format!("motion.{extension}"));
        write_atomically(&path, &bytes)?;
        Ok(path)
    }

    fn c3d(&self) -> Result<Vec<u8>, CliError> {
        Ok(c3d(&C3dInput {
            rate_hz: self.input.movement.rate_hz,
            first_frame: self.input.movement.first_frame,
            points: &self.body.points,
            cameras: &self.body.cameras,
            angles: &self.gait.angles,
            events: &self.gait.events,
        })?)
    }

    fn motion(&self, kind: TableKind, format: &'static str) -> Result<Vec<u8>, CliError> {
        let table = coordinates(&self.input.movement, self.gait);
        let table = table.ok_or_else(|| CliError::NoCoordinates {
            path: self.out.into(),
            format,
            body: self.input.source.clone(),
        })?;
        Ok(motion_text(&table, kind, "Coordinates").into_bytes())
    }

    /// Writes the skin, or the ellipsoids, of every frame in which the person was seen into a folder of its own.
    fn surfaces(&self, format: MeshFormat) -> Result<PathBuf, CliError> {
        let body = self.body;
        let folder = self.folder.join(format.extension());
        OutFolder::open(&folder)?;
        let first = self.input.movement.first_frame;
        let write = |(i, motion): (usize, &Option<Motion>)| -> Result<(), CliError> {
            let Some(motion) = motion else { return Ok(()) };
            let posed = Posed::new(&body.model, &body.shape, motion);
            let mesh = match body.model.metaballs.is_empty() {
                true => ellipsoids(&posed),
                false => skin(&posed, &SkinOptions::default())?,
            };
            let name = format!("frame_{:06}.{}", first + i, format.extension());
            Ok(write_atomically(
                &folder.join(name),
                &bytes_of(&mesh, format, UpAxis::Y),
            )?)
        };
        let written = body.motions.par_iter().enumerate().map(write);
        let written: Vec<Result<(), CliError>> = written.collect();
        // the first fault in the order of the frames, whichever thread met one first
        written.into_iter().collect::<Result<(), _>>()?;
        Ok(folder)
    }
}

/// The points of the fit, in the order of the model.
fn trc(body: &FittedBody, movement: &Movement) -> String {
    let frame = |i: usize| {
        let place = |point: &FittedPoint| {
            let known = point.track[i].iter().all(|v| v.is_finite());
            known.then(|| point.track[i].into())
        };
        body.points.iter().map(place).collect()
    };
    let trajectories = Trajectories {
        rate_hz: movement.rate_hz,
        first_frame: movement.first_frame,
        names: body.points.iter().map(|p| p.name.clone()).collect(),
        frames: (0..movement.frames).map(frame).collect(),
    };
    write_trc(&trajectories, "motion.trc")
}
