//! `maquette skin`, and the skins of `maquette models`.

use std::path::{Path, PathBuf};

use clap::{ArgGroup, Args, ValueEnum};
use rayon::prelude::*;

use super::error::CliError;
use super::print;
use super::summary::counted;
use super::switches::Quiet;
use maquette::body::metaball::Field;
use maquette::body::{BodyModel, Motion, Posed, Shape};
use maquette::camera::UpAxis;
use maquette::io::export::mesh::{MeshFormat, bytes_of};
use maquette::io::folder::overlays::write_picture;
use maquette::io::folder::{OutFolder, write_atomically};
use maquette::io::model;
use maquette::io::result::ResultFile;
use maquette::pipeline::FrameRange;
use maquette::pipeline::Progress;
use maquette::render::{portrait_camera, shade};
use maquette::skin::{Mesh, SkinOptions, skin};

pub(super) const ABOUT: &str = "\
Make the skin of a fitted body: one closed surface of triangles for each frame.

Reads OUT/result.json of a finished `maquette fit` and writes OUT/skin/frame_<number>.ply (or .obj): metres, Z up, \
normals outwards. The body model must have metaballs; only they have a skin.";

pub(super) const EXAMPLES: &str = "\
Examples:
  maquette skin out/me
  maquette skin out/me --frame 120 --picture
  maquette skin out/me --frames 100:150 --format obj --around 96
  maquette skin out/me --rest                      (the fitted person in the pose of rest)";

/// Size of a picture, px.
const PICTURE_PX: (u32, u32) = (600, 800);

/// Arguments of `maquette skin`.
#[derive(Debug, Args)]
#[command(group = ArgGroup::new("which").args(["frames", "frame", "rest"]))]
pub(super) struct SkinArguments {
    /// Folder of a finished fit
    out: PathBuf,
    /// Only the frames of these numbers, both included [default: all]
    #[arg(long, value_name = "FIRST:LAST")]
    frames: Option<FrameRange>,
    /// Only this frame
    #[arg(long, value_name = "NUMBER")]
    frame: Option<usize>,
    /// No frame, but the pose of rest
    #[arg(long)]
    rest: bool,
    /// Format of the meshes
    #[arg(long, value_enum, default_value_t = Format::Ply)]
    format: Format,
    /// Vertices around the trunk, even; along the body there are as many as fit them
    #[arg(long, value_name = "VERTICES", default_value_t = SkinOptions::default().around)]
    around: usize,
    /// Write a shaded picture beside each mesh
    #[arg(long)]
    picture: bool,
    /// Body model of the fit, if it is not a shipped one
    #[arg(long, value_name = "FILE")]
    body: Option<String>,
    #[command(flatten)]
    quiet: Quiet,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
enum Format {
    /// PLY, binary
    Ply,
    /// PLY as text
    PlyText,
    /// Wavefront OBJ
    Obj,
}

impl From<Format> for MeshFormat {
    fn from(format: Format) -> Self {
        match format {
            Format::Ply => Self::Ply,
            Format::PlyText => Self::PlyText,
            Format::Obj => Self::Obj,
        }
    }
}

/// Makes and writes the skins.
pub(super) fn run(arguments: &SkinArguments) -> Result<(), CliError> {
    // 1. read and check everything
    let result = ResultFile::read(&arguments.out)?;
    let body = arguments.body.as_deref().unwrap_or(&result.body);
    let model = model::load(body, Path::new(""))?;
    let shape = result.shape_of(&model)?;
    let poses = poses(arguments, &result, &model)?;
    // 2. skin by skin; the first is made before anything is written, for what is wrong with one is wrong with all
    let options = SkinOptions::with_around(arguments.around);
    let skin_of = |motion: &Motion| skin(&Posed::new(&model, &shape, motion), &options);
    if let Some((_, motion)) = poses.first() {
        skin_of(motion)?;
    }
    let folder = arguments.out.join("skin");
    OutFolder::open(&folder)?;
    let progress = arguments.quiet.progress();
    progress.begin("skins", poses.len());
    let format = MeshFormat::from(arguments.format);
    let write = |(name, motion): &(String, Motion)| -> Result<(), CliError> {
        let mesh = skin_of(motion)?;
        write_mesh(
            &mesh,
            &folder.join(format!("{name}.{}", format.extension())),
            format,
        )?;
        if arguments.picture {
            let field = Field::from_body(&Posed::new(&model, &shape, motion));
            write_portrait(&field, &folder.join(format!("{name}.png")))?;
        }
        progress.step();
        Ok(())
    };
    let written: Vec<Result<(), CliError>> = poses.par_iter().map(write).collect();
    progress.end();
    // the first fault in the order of the frames, whichever thread met one first
    written.into_iter().collect::<Result<(), _>>()?;
    if !arguments.quiet.is_on() {
        let count = counted(poses.len(), "skin");
        print(&format!(
            "{}: {count} of {}\n",
            folder.display(),
            model.name
        ));
    }
    Ok(())
}

/// Names of files, and the motion that each shows.
fn poses(
    arguments: &SkinArguments,
    result: &ResultFile,
    model: &BodyModel,
) -> Result<Vec<(String, Motion)>, CliError> {
    if arguments.rest {
        return Ok(vec![("rest".into(), Motion::rest(model))]);
    }
    let (range, asked) = match (arguments.frame, arguments.frames) {
        (Some(frame), _) => (frame..=frame, format!("--frame {frame}")),
        (None, Some(range)) => (range.numbers(), format!("--frames {range}")),
        (None, None) => (0..=usize::MAX, "all frames".into()),
    };
    let frames = result.motion.frames.iter();
    let in_range = frames.filter(|frame| range.contains(&frame.frame));
    let poses: Vec<_> = in_range
        .map(|frame| (format!("frame_{:06}", frame.frame), frame.motion()))
        .collect();
    if poses.is_empty() {
        return Err(CliError::NotFitted {
            asked,
            first: result.recording.first_frame,
            last: result.recording.last_frame,
        });
    }
    Ok(poses)
}

/// Writes the skin of a model's mean body at rest, and a picture of it.
pub(super) fn of_model(
    name: &str,
    mesh: Option<&Path>,
    picture: Option<&Path>,
) -> Result<(), CliError> {
    let format = match mesh {
        Some(path) => MeshFormat::of_extension(path)
            .ok_or_else(|| CliError::MeshFormat { path: path.into() })?,
        None => MeshFormat::Ply,
    };
    let model = model::load(name, Path::new(""))?;
    let shape = Shape(model.statistics.mean.clone());
    let motion = Motion::rest(&model);
    let body = Posed::new(&model, &shape, &motion);
    let skin = skin(&body, &SkinOptions::default())?;
    if let Some(path) = mesh {
        write_mesh(&skin, path, format)?;
        let (vertices, triangles) = (skin.vertices.len(), skin.triangles.len());
        let path = path.display();
        print(&format!(
            "{path}: {vertices} vertices, {triangles} triangles\n"
        ));
    }
    if let Some(path) = picture {
        write_portrait(&Field::from_body(&body), path)?;
        print(&format!("{}\n", path.display()));
    }
    Ok(())
}

fn write_mesh(mesh: &Mesh, path: &Path, format: MeshFormat) -> Result<(), CliError> {
    Ok(write_atomically(path, &bytes_of(mesh, format, UpAxis::Z))?)
}

fn write_portrait(field: &Field, path: &Path) -> Result<(), CliError> {
    // whoever has a skin has metaballs, and so a portrait
    if let Some(camera) = portrait_camera(field, PICTURE_PX.0, PICTURE_PX.1) {
        write_picture(shade(&camera, field).pixels(), path)?;
    }
    Ok(())
}
