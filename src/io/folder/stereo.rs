//! What `maquette stereo` writes: points, disparities, trajectories, pictures, and a table of the frames.

use std::fmt::Write;
use std::path::{Path, PathBuf};

use ::image::ExtendedColorType;
use serde::Serialize;

use super::overlays::write_picture;
use super::png::{self, Effort};
use super::table;
use super::{OutError, OutFolder, write_atomically};
use crate::camera::UpAxis;
use crate::image::Plane;
use crate::io::points::write_ply;
use crate::math::Rigid3;
use crate::render::Canvas;
use crate::stereo::tracking::Trajectory;
use crate::stereo::{Cloud, CloudPoint, Spread};

/// Steps of a disparity's file to a pixel.
const STEPS: f32 = 256.0;

/// The folder of a run.
#[derive(Debug)]
pub struct StereoFolder {
    path: PathBuf,
    out: OutFolder,
    file_from_world: Rigid3,
}

/// The table of the frames; it is written last: where it stands all points do.
pub const TABLE: &str = "stereo.csv";

/// One line of the table.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct MeasuredFrame {
    /// Number of the frame.
    pub frame: usize,
    /// Points that were measured in it.
    pub points: usize,
    /// Why there are none; empty where there are.
    pub reason: String,
}

impl StereoFolder {
    /// Makes the folder and those within it, without what an older run left there; `up` is that of the recording's files.
    ///
    /// # Errors
    /// [`OutError::Write`].
    pub fn open(path: &Path, up: UpAxis) -> Result<Self, OutError> {
        let older = ["points", "disparity", "pictures", "trajectories.csv"];
        let out = OutFolder::open(path)?;
        out.begin(TABLE, &older)?;
        for folder in ["points", "disparity"] {
            OutFolder::open(&path.join(folder))?;
        }
        Ok(Self {
            path: path.into(),
            out,
            file_from_world: up.file_from_world(),
        })
    }

    /// Writes `stereo.csv`, a line for each frame.
    ///
    /// # Errors
    /// [`OutError::Write`].
    pub fn table(&self, frames: &[MeasuredFrame]) -> Result<(), OutError> {
        table::finish(&self.out, TABLE, frames)
    }

    /// Writes `points/%06d.ply`: metres, in the world of the recording's files, each with its covariance.
    ///
    /// # Errors
    /// [`OutError::Write`].
    pub fn points(&self, frame: usize, points: &[CloudPoint]) -> Result<(), OutError> {
        let path = self.path.join(format!("points/{frame:06}.ply"));
        let in_file = Cloud::from_points(points.iter().copied()).moved(&self.file_from_world);
        write_atomically(&path, &write_ply(&in_file.points))
    }

    /// Writes `disparity/<name>.png`, 16 bits: 256 times the disparity in pixels of points nearer than infinity; 0 unknown.
    ///
    /// # Errors
    /// [`OutError::Write`].
    pub fn disparity(&self, name: &str, disparities: &Plane<f32>) -> Result<(), OutError> {
        let path = self.path.join(format!("disparity/{name}.png"));
        let steps = |d: &f32| {
            if d.is_finite() {
                (STEPS * d).round().clamp(1.0, 65535.0) as u16
            } else {
                0
            }
        };
        let bytes: Vec<u8> = disparities
            .values()
            .iter()
            .flat_map(|d| steps(d).to_ne_bytes())
            .collect();
        let size = (disparities.width(), disparities.height());
        let file = png::encode(&bytes, size, ExtendedColorType::L16, Effort::Quick);
        write_atomically(&path, &file.map_err(|e| OutError::write(&path, e))?)
    }

    /// Writes `pictures/<name>.png`.
    ///
    /// # Errors
    /// [`OutError::Write`].
    pub fn picture(&self, name: &str, canvas: &Canvas) -> Result<(), OutError> {
        let folder = self.path.join("pictures");
        OutFolder::open(&folder)?;
        write_picture(canvas.pixels(), &folder.join(format!("{name}.png")))
    }

    /// Writes `trajectories.csv`: one row for each point of each trajectory, SI units, world.
    ///
    /// # Errors
    /// [`OutError::Write`].
    pub fn trajectories(&self, trajectories: &[Trajectory]) -> Result<(), OutError> {
        let mut text = String::from("trajectory,frame,x,y,z,vx,vy,vz,ax,ay,az,sigma\n");
        for (id, trajectory) in trajectories.iter().enumerate() {
            for (i, point) in trajectory.points.iter().enumerate() {
                let p = point.position_world;
                let (v, a) = (point.velocity, point.acceleration);
                // writing to a text cannot fail
                let _ = writeln!(
                    text,
                    "{id},{},{:.6},{:.6},{:.6},{:.5},{:.5},{:.5},{:.4},{:.4},{:.4},{:.6}",
                    trajectory.first_frame + i,
                    p.x,
                    p.y,
                    p.z,
                    v.x,
                    v.y,
                    v.z,
                    a.x,
                    a.y,
                    a.z,
                    widest(&point.spread)
                );
            }
        }
        write_atomically(&self.path.join("trajectories.csv"), text.as_bytes())
    }
}

/// Standard deviation in the direction in which it is largest; NaN where it is not known.
fn widest(spread: &Spread) -> f64 {
    match spread {
        Spread::Unknown => f64::NAN,
        Spread::Isotropic(sigma) => *sigma,
        Spread::Full(covariance) => covariance.symmetric_eigenvalues().max().sqrt(),
    }
}
