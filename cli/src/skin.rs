//! `maquette skin`.

use std::path::PathBuf;

use clap::{ArgGroup, Args};
use maquette::FittedRecording;
use maquette::io::export::mesh::MeshFormat;
use maquette::pipeline::{FrameRange, Progress, counted};
use maquette::skin::SkinOptions;
use maquette::workflow::{SkinFiles, SkinnedPoses};
use serde_json::json;

use super::choice::{Choice, one_of};
use super::error::CliError;
use super::said::Said;
use super::switches::Output;

pub(super) const ABOUT: &str = "\
Make the skin of a fitted body: one closed surface of triangles for each frame.

Reads OUT/result.json of a finished `maquette fit` and writes OUT/skin/frame_<number>.ply (or .obj): metres, Z up, \
normals outwards. The body model must have metaballs; only they have a skin.";

pub(super) const EXAMPLES: &str = "\
Examples:
  maquette skin out/me
  maquette skin out/me --frame 120 --picture
  maquette skin out/me --frames 100:150 --format obj --around 96
  maquette skin out/me --rest                      (the fitted person in the rest pose)";

/// Arguments of `maquette skin`.
#[derive(Debug, Args)]
#[command(group = ArgGroup::new("which").args(["frames", "frame", "rest"]))]
pub(super) struct SkinArguments {
    /// Folder of a finished fit
    out: PathBuf,
    /// Only these frames, first and last included [default: all]
    #[arg(long, value_name = "FIRST:LAST")]
    frames: Option<FrameRange>,
    /// Only this frame
    #[arg(long, value_name = "NUMBER")]
    frame: Option<usize>,
    /// The rest pose instead of frames
    #[arg(long)]
    rest: bool,
    /// Format of the meshes
    #[arg(long, value_parser = one_of(FORMATS), default_value = "ply")]
    format: MeshFormat,
    /// Vertices around the trunk, an even number; their spacing along the body follows
    #[arg(long, value_name = "VERTICES", default_value_t = SkinOptions::default().around)]
    around: usize,
    /// Write a shaded picture beside each mesh
    #[arg(long)]
    picture: bool,
    /// Body model of the fit, if it is not a shipped one
    #[arg(long, value_name = "FILE")]
    body: Option<String>,
    #[command(flatten)]
    output: Output,
}

const FORMATS: &[Choice<MeshFormat>] = &[
    ("ply", MeshFormat::Ply, "PLY, binary"),
    ("ply-text", MeshFormat::PlyText, "PLY as text"),
    ("obj", MeshFormat::Obj, "Wavefront OBJ"),
];

/// Makes and writes the skins.
pub(super) fn run(arguments: &SkinArguments) -> Result<(), CliError> {
    arguments.said(&arguments.output.progress())?.print(arguments.output);
    Ok(())
}

impl SkinArguments {
    /// What there is to say of the skins, which are written.
    pub(super) fn said(&self, progress: &dyn Progress) -> Result<Said, CliError> {
        let fit = FittedRecording::read(&self.out, self.body.as_deref())?;
        let folder = self.out.join("skin");
        let files = SkinFiles {
            folder: &folder,
            poses: self.poses(),
            format: self.format,
            options: SkinOptions::with_around(self.around),
            pictures: self.picture,
        };
        let skins = fit.write_skins(&files, progress)?;
        let (folder, body) = (folder.display().to_string(), &fit.model.name);
        Ok(Said {
            text: format!("{folder}: {} of {body}\n", counted(skins, "skin")),
            json: json!({ "out": folder, "body": body, "skins": skins }),
            notes: Vec::new(),
        })
    }

    fn poses(&self) -> SkinnedPoses {
        match (self.rest, self.frame) {
            (true, _) => SkinnedPoses::Rest,
            (false, Some(frame)) => SkinnedPoses::Frames(FrameRange { first: frame, last: frame }),
            (false, None) => SkinnedPoses::Frames(self.frames.unwrap_or_default()),
        }
    }
}
