//! What `maquette stereo` writes: points, disparities, trajectories, pictures.

use std::fmt::Write;
use std::path::{Path, PathBuf};

use ::image::ExtendedColorType;

use super::cloud::write_ply;
use super::out_folder::{OutError, OutFolder, write_atomically};
use super::overlays::{OverlayError, write_picture};
use super::png::{self, Effort};
use crate::image::Plane;
use crate::render::Canvas;
use crate::stereo::tracking::Trajectory;
use crate::stereo::{CloudPoint, Spread};

/// Steps of a disparity's file to a pixel.
const STEPS: f32 = 256.0;

/// Why something cannot be written.
#[derive(Debug, thiserror::Error)]
pub enum StereoOutError {
    /// A file or folder.
    #[error(transparent)]
    Out(#[from] OutError),
    /// A picture.
    #[error(transparent)]
    Picture(#[from] OverlayError),
}

/// The folder of a run.
#[derive(Debug)]
pub struct StereoFolder {
    path: PathBuf,
}

impl StereoFolder {
    /// Makes the folder and those within it.
    ///
    /// # Errors
    /// [`StereoOutError::Out`].
    pub fn open(path: &Path) -> Result<Self, StereoOutError> {
        for folder in ["points", "disparity"] {
            OutFolder::open(&path.join(folder))?;
        }
        Ok(Self { path: path.into() })
    }

    /// Writes `points/%06d.ply`: metres, world, each with its covariance.
    ///
    /// # Errors
    /// [`StereoOutError::Out`].
    pub fn points(&self, frame: usize, points: &[CloudPoint]) -> Result<(), StereoOutError> {
        let path = self.path.join(format!("points/{frame:06}.ply"));
        Ok(write_atomically(&path, &write_ply(points))?)
    }

    /// Writes `disparity/<name>.png`, 16 bits: 256 times the disparity in pixels of points nearer than infinity; 0 unknown.
    ///
    /// # Errors
    /// [`StereoOutError`].
    pub fn disparity(&self, name: &str, disparities: &Plane<f32>) -> Result<(), StereoOutError> {
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
        match png::encode(&bytes, size, ExtendedColorType::L16, Effort::Quick) {
            Ok(file) => Ok(write_atomically(&path, &file)?),
            Err(source) => Err(OverlayError::Encode { path, source }.into()),
        }
    }

    /// Writes `pictures/<name>.png`.
    ///
    /// # Errors
    /// [`StereoOutError`].
    pub fn picture(&self, name: &str, canvas: &Canvas) -> Result<(), StereoOutError> {
        let folder = self.path.join("pictures");
        OutFolder::open(&folder)?;
        Ok(write_picture(canvas, folder.join(format!("{name}.png")))?)
    }

    /// Writes `trajectories.csv`: one row for each point of each trajectory, SI units, world.
    ///
    /// # Errors
    /// [`StereoOutError::Out`].
    pub fn trajectories(&self, trajectories: &[Trajectory]) -> Result<(), StereoOutError> {
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
        Ok(write_atomically(
            &self.path.join("trajectories.csv"),
            text.as_bytes(),
        )?)
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
