//! What `maquette stereo` writes: points, disparities, trajectories, pictures, and a table of the frames.

use std::fmt::Write;

use ::image::ExtendedColorType;
use serde::Serialize;

use super::overlays::write_picture;
use super::png::{self, Effort};
use super::table;
use super::{OutError, OutFolder, make_folder, write_atomically};
use crate::camera::UpAxis;
use crate::io::points::write_ply;
use crate::math::Rigid3;
use crate::pipeline::stereo::{DisparityMap, MeasuredSurface, SurfaceFrame, SurfaceTracks};
use crate::render::Canvas;
use crate::render::stereo::{cloud_from_the_side, in_colour, vector_field};
use crate::stereo::tracking::Trajectory;
use crate::stereo::{Cloud, CloudPoint, Spread};

/// Steps of a disparity's file to a pixel.
const STEPS: f32 = 256.0;

/// What is written beside points and disparities.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default)]
pub struct StereoExtras {
    /// `pictures/`: disparities in colour, the cloud from the side, the motion of the surface.
    pub pictures: bool,
    /// `trajectories.csv`.
    pub trajectories: bool,
}

/// The folder of a run.
#[derive(Debug)]
pub struct StereoFolder<'a> {
    out: &'a OutFolder,
    file_from_world: Rigid3,
    extras: StereoExtras,
    rows: Vec<FrameRow>,
    trajectories: Vec<Trajectory>,
}

/// The table of the frames; it is written last: where it stands all points do.
pub const TABLE: &str = "stereo.csv";

/// One line of the table.
#[derive(Debug, Clone, PartialEq, Serialize)]
struct FrameRow {
    frame: usize,
    points: usize,
    reason: String,
}

impl<'a> StereoFolder<'a> {
    /// Makes the folders within it, without what an older run left there; `up` is that of the recording's files.
    ///
    /// # Errors
    /// [`OutError::Write`].
    pub fn open(out: &'a OutFolder, up: UpAxis, extras: StereoExtras) -> Result<Self, OutError> {
        let older = ["points", "disparity", "pictures", "trajectories.csv"];
        out.begin(TABLE, &older)?;
        for folder in ["points", "disparity"] {
            make_folder(&out.path().join(folder))?;
        }
        Ok(Self {
            out,
            file_from_world: up.file_from_world(),
            extras,
            rows: Vec::new(),
            trajectories: Vec::new(),
        })
    }

    /// Writes what was measured in a frame.
    ///
    /// # Errors
    /// [`OutError::Write`].
    pub fn write(&mut self, measured: SurfaceFrame) -> Result<(), OutError> {
        let frame = measured.frame.0;
        self.rows.push(FrameRow {
            frame,
            points: measured.points().len(),
            reason: measured.reason,
        });

        if let Some(surface) = &measured.surface {
            self.surface(frame, surface)?;
        }

        for tracks in measured.ended_tracks {
            if self.extras.pictures {
                self.motion(&tracks)?;
            }
            self.trajectories.extend(tracks.trajectories);
        }
        Ok(())
    }

    fn surface(&mut self, frame: usize, surface: &MeasuredSurface) -> Result<(), OutError> {
        self.points(frame, &surface.points)?;
        for map in &surface.disparities {
            self.disparity(frame, map)?;
        }
        if self.extras.pictures {
            let cloud = cloud_from_the_side(&surface.template.camera, &surface.points);
            self.picture(&format!("cloud_{frame:06}"), &cloud)?;
        }
        Ok(())
    }

    /// Writes `stereo.csv`, a line for each frame: where it stands all is complete.
    ///
    /// # Errors
    /// [`OutError::Write`].
    pub fn finish(self) -> Result<(), OutError> {
        if self.extras.trajectories {
            let table = trajectory_table(&self.trajectories);
            self.out.write("trajectories.csv", table.as_bytes())?;
        }
        table::finish(self.out, TABLE, &self.rows)
    }

    /// `points/%06d.ply`: metres, in the world of the recording's files, each with its covariance.
    fn points(&self, frame: usize, points: &[CloudPoint]) -> Result<(), OutError> {
        let in_file = Cloud::from_points(points.iter().copied()).moved(&self.file_from_world);
        self.out.write(&format!("points/{frame:06}.ply"), &write_ply(&in_file.points))
    }

    /// `disparity/<name>.png`, 16 bits: 256 times the disparity in pixels of points nearer than infinity; 0 unknown.
    fn disparity(&self, frame: usize, map: &DisparityMap) -> Result<(), OutError> {
        let pair = map.pair.map_or(String::new(), |pair| format!("_{pair}"));
        let (name, disparities) = (format!("{frame:06}{pair}"), &map.disparities_px);
        let path = self.out.path().join(format!("disparity/{name}.png"));

        // 0 stands for no disparity
        let in_steps = |d: &f32| {
            if d.is_finite() { (STEPS * d).round().clamp(1.0, 65535.0) as u16 } else { 0 }
        };

        let bytes: Vec<u8> =
            disparities.values().iter().flat_map(|d| in_steps(d).to_ne_bytes()).collect();

        let (width, height) = (disparities.width(), disparities.height());
        let file = png::encode(&bytes, width, height, ExtendedColorType::L16, Effort::Quick);
        write_atomically(&path, &file.map_err(|e| OutError::write(&path, e))?)?;

        if self.extras.pictures {
            self.picture(&format!("disparity_{name}"), &in_colour(disparities))?;
        }
        Ok(())
    }

    /// How the surface moved when its tracks began.
    fn motion(&self, tracks: &SurfaceTracks) -> Result<(), OutError> {
        let (first, view) = (tracks.first_frame, &tracks.first_view);
        let points = tracks.trajectories.iter();
        let points: Vec<_> = points.filter_map(|t| t.at(first + 1).copied()).collect();
        let field = vector_field(&view.camera, &view.image, &points);
        self.picture(&format!("vectors_{first:06}"), &field)
    }

    /// `pictures/<name>.png`.
    fn picture(&self, name: &str, canvas: &Canvas) -> Result<(), OutError> {
        let folder = self.out.path().join("pictures");
        make_folder(&folder)?;
        write_picture(canvas.pixels(), &folder.join(format!("{name}.png")))
    }
}

/// `trajectories.csv`: one row for each point of each trajectory, SI units, world.
fn trajectory_table(trajectories: &[Trajectory]) -> String {
    let mut text = String::from("trajectory,frame,x,y,z,vx,vy,vz,ax,ay,az,sigma\n");
    for (id, trajectory) in trajectories.iter().enumerate() {
        for (i, point) in trajectory.points.iter().enumerate() {
            let frame = trajectory.first_frame + i;
            let (p, v, a) = (point.position_world, point.velocity, point.acceleration);
            // writing to a text cannot fail
            let _ = writeln!(
                text,
                "{id},{frame},{:.6},{:.6},{:.6},{:.5},{:.5},{:.5},{:.4},{:.4},{:.4},{:.6}",
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
    text
}

/// Standard deviation in the direction in which it is largest; NaN where it is not known.
fn widest(spread: &Spread) -> f64 {
    match spread {
        Spread::Unknown => f64::NAN,
        Spread::Isotropic(sigma) => *sigma,
        Spread::Full(covariance) => covariance.symmetric_eigenvalues().max().sqrt(),
    }
}
