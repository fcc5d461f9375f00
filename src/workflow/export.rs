//! A fit in the formats of other programs.

use std::path::{Path, PathBuf};

use rayon::prelude::*;

use super::{Error, GaitStudy};
use crate::body::{Motion, Posed};
use crate::camera::UpAxis;
use crate::io::export::mesh::{MeshFormat, bytes_of};
use crate::io::export::{
    C3dInput, TableKind, bvh, c3d, coordinates, frame_table, glb, motion_text,
};
use crate::io::folder::OutFolder;
use crate::io::points::trc::{Trajectories, write_trc};
use crate::pipeline::{FittedBody, FittedPoint};
use crate::skin::{SkinOptions, ellipsoids, skin};

/// A format of another program. Every file's world is Y up; docs/formats.md says what each holds.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum ExportFormat {
    /// C3D: points with their SD and cameras, angles, foot strikes and offs.
    C3d,
    /// TRC: points.
    Trc,
    /// OpenSim's motion, degrees.
    Mot,
    /// The same as OpenSim's storage, radians.
    Sto,
    /// BVH: skeleton in T-pose and its motion.
    Bvh,
    /// glTF 2.0, binary: the body on its bones, moving.
    Glb,
    /// CSV: points, angles and their SD, frame by frame.
    Csv,
    /// The same as Parquet.
    #[cfg(feature = "parquet")]
    Parquet,
    /// The body's surface, a PLY file per frame.
    Ply,
    /// The body's surface, an OBJ file per frame.
    Obj,
}

impl GaitStudy {
    /// Writes the fit into a folder in one format, and says where.
    ///
    /// # Errors
    /// [`Error::NoFit`] of points, whatever the format lacks, and [`Error::Out`].
    pub fn export(&self, format: ExportFormat, folder: &Path) -> Result<PathBuf, Error> {
        let body = self.body(folder)?;
        let movement = &self.input.movement;
        let (model, shape, motions) = (&body.model, &body.shape, &body.motions);
        let table = || frame_table(movement, &body.points, &self.analysis);
        let (extension, bytes) = match format {
            ExportFormat::C3d => ("c3d", self.c3d(body)?),
            ExportFormat::Trc => ("trc", self.trc(body).into_bytes()),
            ExportFormat::Mot => ("mot", self.motion(TableKind::Mot, "mot")?),
            ExportFormat::Sto => ("sto", self.motion(TableKind::Sto, "sto")?),
            ExportFormat::Bvh => {
                let text = bvh(model, shape, motions, movement.rate_hz)?;
                ("bvh", text.into_bytes())
            }
            ExportFormat::Glb => ("glb", glb(model, shape, motions, movement.rate_hz)?),
            ExportFormat::Csv => ("csv", table().csv()?),
            #[cfg(feature = "parquet")]
            ExportFormat::Parquet => ("parquet", table().parquet()?),
            ExportFormat::Ply => return self.surfaces(body, MeshFormat::Ply, folder),
            ExportFormat::Obj => return self.surfaces(body, MeshFormat::Obj, folder),
        };

        let name = format!("motion.{extension}");
        OutFolder::open(folder)?.write(&name, &bytes)?;
        Ok(folder.join(name))
    }

    fn body(&self, folder: &Path) -> Result<&FittedBody, Error> {
        self.input.body.as_ref().ok_or_else(|| Error::NoFit { path: folder.into() })
    }

    fn c3d(&self, body: &FittedBody) -> Result<Vec<u8>, Error> {
        Ok(c3d(&C3dInput {
            rate_hz: self.input.movement.rate_hz,
            first_frame: self.input.movement.first_frame,
            points: &body.points,
            cameras: &body.cameras,
            angles: &self.analysis.angles,
            events: &self.analysis.events,
        })?)
    }

    fn motion(&self, kind: TableKind, format: &'static str) -> Result<Vec<u8>, Error> {
        let table = coordinates(&self.input.movement, &self.analysis);
        let table = table
            .ok_or_else(|| Error::NoCoordinates { format, body: self.input.source.clone() })?;
        Ok(motion_text(&table, kind, "Coordinates").into_bytes())
    }

    /// The points of the fit, in the order of the model.
    fn trc(&self, body: &FittedBody) -> String {
        let movement = &self.input.movement;
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

    /// Writes the skin, or the ellipsoids, of every frame in which the person was seen into a folder of its own.
    fn surfaces(
        &self,
        body: &FittedBody,
        format: MeshFormat,
        folder: &Path,
    ) -> Result<PathBuf, Error> {
        let folder = folder.join(format.extension());
        let out = OutFolder::open(&folder)?;
        let first = self.input.movement.first_frame;

        let write = |(i, motion): (usize, &Option<Motion>)| -> Result<(), Error> {
            let Some(motion) = motion else { return Ok(()) };
            let posed = Posed::new(&body.model, &body.shape, motion);
            let mesh = match body.model.metaballs.is_empty() {
                true => ellipsoids(&posed),
                false => skin(&posed, &SkinOptions::default())?,
            };
            let name = format!("frame_{:06}.{}", first + i, format.extension());
            let bytes = bytes_of(&mesh, format, UpAxis::Y);
            Ok(out.write(&name, &bytes)?)
        };
        let written = body.motions.par_iter().enumerate().map(write);
        let written: Vec<Result<(), Error>> = written.collect();
        // the first fault in the order of the frames, whichever thread met one first
        written.into_iter().collect::<Result<(), _>>()?;
        Ok(folder)
    }
}
