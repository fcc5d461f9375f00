//! The skins of a fitted body as files.

use std::path::{Path, PathBuf};

use rayon::prelude::*;

use super::{Error, FittedRecording};
use crate::body::metaball::Field;
use crate::body::{BodyModel, Motion, Posed, Shape};
use crate::camera::UpAxis;
use crate::io::export::mesh::{MeshFormat, bytes_of};
use crate::io::folder::overlays::write_picture;
use crate::io::folder::{OutFolder, write_atomically};
use crate::pipeline::{FrameRange, Progress};
use crate::render::{portrait_camera, shade};
use crate::skin::{Mesh, SkinOptions, skin};

/// Size of a picture, px.
const PICTURE_PX: (u32, u32) = (600, 800);

/// Which poses of a fitted body get a skin.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum SkinnedPoses {
    /// Those of the fitted frames of these numbers.
    Frames(FrameRange),
    /// The pose of rest.
    Rest,
}

/// How skins are written.
#[derive(Debug, Clone, Copy)]
pub struct SkinFiles<'a> {
    /// Where they are written to.
    pub folder: &'a Path,
    /// Which poses.
    pub poses: SkinnedPoses,
    /// Format of the meshes; metres, Z up.
    pub format: MeshFormat,
    /// How fine they are.
    pub options: SkinOptions,
    /// Whether a shaded picture is written beside each mesh.
    pub pictures: bool,
}

impl FittedRecording {
    /// Writes the skin of each pose, and says how many there are.
    ///
    /// # Errors
    /// [`Error::NotFitted`] if no fitted frame is in the range, [`Error::Skin`] of a body without metaballs, and
    /// [`Error::Out`]. Nothing is written before the first skin is made.
    pub fn write_skins(
        &self,
        files: &SkinFiles<'_>,
        progress: &dyn Progress,
    ) -> Result<usize, Error> {
        let poses = self.poses(files.poses)?;
        let shape = self.result.shape_of(&self.model)?;
        let posed = |motion: &Motion| Posed::new(&self.model, &shape, motion);

        // what is wrong with one is wrong with all
        if let Some((_, motion)) = poses.first() {
            skin(&posed(motion), &files.options)?;
        }
        let _out = OutFolder::open(files.folder)?;

        let write = |(name, motion): &(String, Motion)| -> Result<(), Error> {
            let body = posed(motion);
            let mesh = skin(&body, &files.options)?;
            let path = |extension| files.folder.join(format!("{name}.{extension}"));
            write_mesh(&mesh, &path(files.format.extension()), files.format)?;
            if files.pictures {
                write_portrait(&Field::from_body(&body), &path("png"))?;
            }
            progress.step();
            Ok(())
        };
        progress.begin("skins", poses.len());
        let written: Vec<Result<(), Error>> = poses.par_iter().map(write).collect();
        progress.end();
        // the first fault in the order of the frames, whichever thread met one first
        written.into_iter().collect::<Result<(), _>>()?;
        Ok(poses.len())
    }

    /// Names of files, and the motion that each shows.
    fn poses(&self, poses: SkinnedPoses) -> Result<Vec<(String, Motion)>, Error> {
        let range = match poses {
            SkinnedPoses::Rest => return Ok(vec![("rest".into(), Motion::rest(&self.model))]),
            SkinnedPoses::Frames(range) => range,
        };
        let frames = self.result.motion.frames.iter();
        let in_range = frames.filter(|frame| range.numbers().contains(&frame.frame));
        let poses: Vec<_> =
            in_range.map(|frame| (format!("frame_{:06}", frame.frame), frame.motion())).collect();
        if poses.is_empty() {
            return Err(Error::NotFitted {
                range,
                first: self.result.recording.first_frame,
                last: self.result.recording.last_frame,
            });
        }
        Ok(poses)
    }
}

/// The skin of a model's mean body at rest.
#[derive(Debug, Clone)]
pub struct RestingBody {
    /// The skin; metres, Z up.
    pub skin: Mesh,
    field: Field,
}

impl RestingBody {
    /// Poses the mean body.
    ///
    /// # Errors
    /// [`Error::Skin`] of a body without metaballs.
    pub fn new(model: &BodyModel) -> Result<Self, Error> {
        let shape = Shape(model.statistics.mean.clone());
        let motion = Motion::rest(model);
        let body = Posed::new(model, &shape, &motion);
        Ok(Self { skin: skin(&body, &SkinOptions::default())?, field: Field::from_body(&body) })
    }

    /// Writes the skin as a `.ply` or `.obj` file.
    ///
    /// # Errors
    /// [`Error::MeshFormat`] for any other name, and [`Error::Out`].
    pub fn write_mesh(&self, path: &Path) -> Result<(), Error> {
        let format = MeshFormat::from_extension(path)
            .ok_or_else(|| Error::MeshFormat { path: PathBuf::from(path) })?;
        write_mesh(&self.skin, path, format)
    }

    /// Writes a shaded picture of it as PNG.
    ///
    /// # Errors
    /// [`Error::Out`].
    pub fn write_picture(&self, path: &Path) -> Result<(), Error> {
        write_portrait(&self.field, path)
    }
}

fn write_mesh(mesh: &Mesh, path: &Path, format: MeshFormat) -> Result<(), Error> {
    Ok(write_atomically(path, &bytes_of(mesh, format, UpAxis::Z))?)
}

fn write_portrait(field: &Field, path: &Path) -> Result<(), Error> {
    // whoever has a skin has metaballs, and so a portrait
    if let Some(camera) = portrait_camera(field, PICTURE_PX.0, PICTURE_PX.1) {
        write_picture(shade(&camera, field).pixels(), path)?;
    }
    Ok(())
}
