//! A synthetic recording as a folder, with its truth.
//!
//! | file                        | content                                                              |
//! |-----------------------------|----------------------------------------------------------------------|
//! | `sequence.toml`             | manifest                                                             |
//! | `calibration.toml`          | cameras, as Pose2Sim writes them                                     |
//! | `masks/<camera>/%06d.png`   | masks, 0 and 255                                                     |
//! | `points/%06d.ply`           | points on the skin, where the recording has a [`crate::synth::StereoPair`] |
//! | `truth.trc`                 | joint centres of every frame                                         |
//! | `truth.json`                | [`Truth`]: lengths, coefficients, pelvis and angles of every frame   |

use std::collections::BTreeMap;
use std::fs;
use std::path::{Path, PathBuf};

use rayon::prelude::*;
use serde::Serialize;

use crate::body::Posed;
use crate::camera::{Camera, CameraId};
use crate::io::calibration;
use crate::io::folder::parent_of;
use crate::io::folder::png::{self, Effort};
use crate::io::points::trc::{Trajectories, write_trc};
use crate::io::points::write_ply;
use crate::silhouette::FrameIndex;
use crate::synth::Synthetic;

/// Why a synthetic recording could not be written.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum SyntheticError {
    /// The folder holds something already.
    #[error("{}: this folder is not empty: nothing was written", path.display())]
    NotEmpty {
        /// Folder.
        path: PathBuf,
    },
    /// A file or folder that cannot be written.
    #[error("{}: cannot be written: {source}", path.display())]
    Write {
        /// File or folder.
        path: PathBuf,
        /// Why.
        source: std::io::Error,
    },
    /// Truth that is no JSON, because a number in it is not finite.
    #[error("{}: the truth cannot be written: {source}", path.display())]
    Truth {
        /// File.
        path: PathBuf,
        /// Why.
        source: serde_json::Error,
    },
}

/// The truth of a synthetic recording; `truth.json`.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Truth {
    /// Frames per second.
    pub fps: f64,
    /// Number of frames.
    pub frames: usize,
    /// Name of the body model.
    pub model: String,
    /// Seed of the segmentation errors.
    pub seed: u64,
    /// Shape coefficients s, logarithms.
    pub coefficients: BTreeMap<String, f64>,
    /// The model's lengths, metres.
    pub lengths_m: BTreeMap<String, f64>,
    /// The root's origin in each frame, world, metres.
    pub root_position_m: Vec<[f64; 3]>,
    /// The root's orientation in each frame, world from root, as a rotation vector, radians.
    pub root_rotation_rad: Vec<[f64; 3]>,
    /// Each joint's angle in each frame, degrees.
    pub angles_deg: BTreeMap<String, Vec<f64>>,
}

impl Truth {
    /// The truth of a recording.
    pub fn new(synthetic: &Synthetic) -> Self {
        let Synthetic { model, shape, motions, .. } = synthetic;

        let named = |names: &[String], values: &[f64]| {
            names.iter().cloned().zip(values.iter().copied()).collect()
        };
        let angles = model.joints.iter().enumerate().map(|(j, joint)| {
            let over_time = motions.iter().map(|m| m.angles[j].to_degrees());
            (joint.name.clone(), over_time.collect())
        });

        Self {
            fps: synthetic.fps,
            frames: motions.len(),
            model: model.name.clone(),
            seed: synthetic.seed,
            coefficients: named(&model.coefficients, shape.0.as_slice()),
            lengths_m: lengths(synthetic),
            root_position_m: motions.iter().map(|m| m.position_world.into()).collect(),
            root_rotation_rad: motions
                .iter()
                .map(|m| m.world_from_root.scaled_axis().into())
                .collect(),
            angles_deg: angles.collect(),
        }
    }
}

/// The model's lengths in the first frame. Those within a limb are the same in all.
fn lengths(synthetic: &Synthetic) -> BTreeMap<String, f64> {
    let Some(points) = synthetic.points(FrameIndex(0)) else {
        return BTreeMap::new();
    };
    let length = |(name, from, to): &(String, usize, usize)| {
        (name.clone(), (points[*to] - points[*from]).norm())
    };
    synthetic.model.lengths.iter().map(length).collect()
}

/// Writes a recording into a folder that is empty or does not exist.
///
/// Everything is written beside it first and moved there at the end, so a failure leaves nothing.
///
/// # Errors
/// [`SyntheticError`] names the file and why.
pub fn write(synthetic: &Synthetic, folder: &Path) -> Result<(), SyntheticError> {
    write_at_once(folder, |whole| fill(synthetic, whole))
}

/// Lets `fill` write a folder beside the wanted one, and moves it there when all is written.
pub(super) fn write_at_once(
    folder: &Path,
    fill: impl FnOnce(&Path) -> Result<(), SyntheticError>,
) -> Result<(), SyntheticError> {
    if fs::read_dir(folder).is_ok_and(|mut entries| entries.next().is_some()) {
        let path = folder.to_owned();
        return Err(SyntheticError::NotEmpty { path });
    }

    let parent = parent_of(folder);
    fs::create_dir_all(parent).map_err(failed(parent))?;

    let scratch = tempfile::Builder::new()
        .prefix(".maquette-synth-")
        .tempdir_in(parent)
        .map_err(failed(parent))?;
    let whole = scratch.path().join("recording");
    fs::create_dir_all(&whole).map_err(failed(&whole))?;
    fill(&whole)?;

    if folder.is_dir() {
        fs::remove_dir(folder).map_err(failed(folder))?;
    }
    fs::rename(&whole, folder).map_err(failed(folder))
}

pub(super) fn failed(path: &Path) -> impl FnOnce(std::io::Error) -> SyntheticError {
    let path = path.to_owned();
    |source| SyntheticError::Write { path, source }
}

fn fill(synthetic: &Synthetic, folder: &Path) -> Result<(), SyntheticError> {
    for (_, camera) in synthetic.rig.iter() {
        let path = masks_of(folder, camera);
        fs::create_dir_all(&path).map_err(failed(&path))?;
    }
    let rig = &synthetic.rig;
    let all = rig.iter().flat_map(|(id, camera)| {
        (0..synthetic.frames()).map(move |frame| (FrameIndex(frame), id, camera))
    });
    let all: Vec<_> = all.collect();
    all.into_par_iter().try_for_each(|(frame, id, camera)| {
        let path = masks_of(folder, camera).join(format!("{:06}.png", frame.0));
        write_mask(synthetic, frame, id, &path)
    })?;
    write_clouds(synthetic, folder)?;
    write_texts(synthetic, folder, &manifest(synthetic))
}

/// Cameras, manifest and truth.
pub(super) fn write_texts(
    synthetic: &Synthetic,
    folder: &Path,
    manifest: &str,
) -> Result<(), SyntheticError> {
    let text_file = |name: &str, text: &str| {
        let path = folder.join(name);
        fs::write(&path, text).map_err(failed(&path))
    };
    let trajectories = write_trc(&trajectories(synthetic), "truth.trc");
    text_file("calibration.toml", &calibration::write_toml(&synthetic.rig))?;
    text_file("sequence.toml", manifest)?;
    text_file("truth.trc", &trajectories)?;
    text_file("truth.json", &truth_text(synthetic, folder)?)
}

fn masks_of(folder: &Path, camera: &Camera) -> PathBuf {
    folder.join("masks").join(&camera.name)
}

fn write_mask(
    synthetic: &Synthetic,
    frame: FrameIndex,
    camera: CameraId,
    path: &Path,
) -> Result<(), SyntheticError> {
    let Some(mask) = synthetic.mask(frame, camera) else {
        return Ok(());
    };
    png::encode_mask(&mask, Effort::Small)
        .and_then(|bytes| fs::write(path, bytes))
        .map_err(failed(path))
}

/// The points of all cameras together, a file for each frame.
fn write_clouds(synthetic: &Synthetic, folder: &Path) -> Result<(), SyntheticError> {
    if synthetic.stereo.is_none() {
        return Ok(());
    }
    let folder = folder.join("points");
    fs::create_dir_all(&folder).map_err(failed(&folder))?;
    let frames: Vec<usize> = (0..synthetic.frames()).collect();
    frames.into_par_iter().try_for_each(|frame| {
        let of_cameras = synthetic.rig.iter();
        let of_cameras = of_cameras.filter_map(|(id, _)| synthetic.cloud(FrameIndex(frame), id));
        let points: Vec<_> = of_cameras.flatten().collect();
        let path = folder.join(format!("{frame:06}.ply"));
        fs::write(&path, write_ply(&points)).map_err(failed(&path))
    })
}

fn manifest(synthetic: &Synthetic) -> String {
    let Synthetic { fps, seed, model, .. } = synthetic;
    let mut text = format!(
        "# Synthetic: model {}, seed {seed}. The truth is in truth.trc and truth.json.\n\
         fps = {fps:?}\ncalibration = \"calibration.toml\"\nunit = \"m\"\nup = \"z\"\n",
        model.name.escape_debug()
    );
    if synthetic.stereo.is_some() {
        text.push_str("points = \"points/%06d.ply\"\npoints_unit = \"m\"\n");
    }
    for name in synthetic.rig.names() {
        text.push_str(&format!(
            "\n[[camera]]\nname = {name:?}\nmasks = \"masks/{name}/%06d.png\"\n"
        ));
    }
    text
}

/// The joint centres of every frame.
pub fn trajectories(synthetic: &Synthetic) -> Trajectories {
    let Synthetic { model, shape, .. } = synthetic;
    let points = |m| Posed::new(model, shape, m).points().into_iter().map(Some).collect();
    Trajectories {
        rate_hz: synthetic.fps,
        first_frame: 0,
        names: model.points.iter().map(|p| p.name.clone()).collect(),
        frames: synthetic.motions.iter().map(points).collect(),
    }
}

fn truth_text(synthetic: &Synthetic, folder: &Path) -> Result<String, SyntheticError> {
    let text = serde_json::to_string(&Truth::new(synthetic));
    text.map_err(|source| SyntheticError::Truth { path: folder.join("truth.json"), source })
}
