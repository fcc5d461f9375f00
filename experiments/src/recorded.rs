//! A recording in memory, with its truth.

use std::error::Error;
use std::path::Path;

use maquette::camera::Rig;
use maquette::image::Mask;
use maquette::inference::Sequence;
use maquette::inference::search::NoJournal;
use maquette::io::calibration::{self, CalibrationOptions};
use maquette::io::model;
use maquette::io::points::trc::{Trajectories, read_trc};
use maquette::io::recording::Recording;
use maquette::pipeline::{EstimateOptions, Fit, FitError, fit};
use maquette::silhouette::{FrameIndex, FrameObservations, SilhouetteOptions, extract};
use maquette::workflow::DEFAULT_BODY;
use rayon::prelude::*;

use crate::figures::Figures;

/// The trajectories of a TRC file.
///
/// # Errors
/// If it is missing, or cannot be read.
pub fn read_trajectories(path: &Path) -> Result<Trajectories, Box<dyn Error>> {
    Ok(read_trc(&std::fs::read_to_string(path)?, path)?)
}

/// Cameras and masks of a recording, and the truth.
#[derive(Debug, Clone)]
pub struct Recorded {
    /// The cameras as they are calibrated.
    pub rig: Rig,
    /// The cameras where they were, if that is known to differ.
    pub true_rig: Rig,
    /// Frames per second.
    pub fps: f64,
    /// The numbers of the frames.
    pub numbers: Vec<FrameIndex>,
    /// Frame by frame a place for each camera.
    pub masks: Vec<Vec<Option<Mask>>>,
    /// Where the joint centres were.
    pub truth: Trajectories,
    /// The person's height, where it is known, metres.
    pub stature_m: Option<f64>,
    /// The height that a fit is given.
    pub given_m: Option<f64>,
}

impl Recorded {
    /// Reads a recording with its masks, and the truth beside it.
    ///
    /// # Errors
    /// If a file is missing, or cannot be read.
    pub fn read(folder: &Path, fps: f64, truth: &str) -> Result<Self, Box<dyn Error>> {
        let files = Recording::open(folder)?.with_fps(fps).masks()?;
        let cameras: Vec<_> = files.rig.iter().map(|(id, _)| id).collect();
        let read = |frame: &FrameIndex| {
            let masks = cameras.iter().map(|id| files.load_mask(*id, *frame));
            masks.collect::<Result<Vec<_>, _>>()
        };
        let masks: Result<Vec<_>, _> = files.frames.par_iter().map(read).collect();

        Ok(Self {
            stature_m: stature_m(&folder.join("truth.json"))?,
            given_m: None,
            masks: masks?,
            numbers: files.frames.clone(),
            fps,
            truth: read_trajectories(&folder.join(truth))?,
            true_rig: true_rig(folder)?.unwrap_or_else(|| files.rig.clone()),
            rig: files.rig,
        })
    }

    /// The default body's fit, or why there is none.
    ///
    /// # Errors
    /// As [`model::load`].
    pub fn fit(&self) -> Result<Result<Fit, FitError>, Box<dyn Error>> {
        self.fit_with(EstimateOptions::default())
    }

    /// The same with other options.
    ///
    /// # Errors
    /// As [`model::load`].
    pub fn fit_with(
        &self,
        options: EstimateOptions,
    ) -> Result<Result<Fit, FitError>, Box<dyn Error>> {
        let body = model::load(DEFAULT_BODY, Path::new(""))?;
        let frames = self.observations();
        let sequence = Sequence { frames: &frames, fps: self.fps };
        let options = EstimateOptions { height_m: self.given_m, ..options };
        Ok(fit(&body, &self.rig, sequence, &options, &NoJournal))
    }

    /// How far a fit is from the truth.
    pub fn figures(&self, fit: &Fit) -> Figures {
        Figures::new(&self.truth, fit, self.fps)
    }

    /// The silhouettes of every frame.
    pub fn observations(&self) -> Vec<FrameObservations> {
        let of_frame = |(number, masks): (&FrameIndex, &Vec<Option<Mask>>)| {
            let mut seen = FrameObservations::nothing(*number);
            for ((id, camera), mask) in self.rig.iter().zip(masks) {
                let Some(mask) = mask else { continue };
                match extract(mask, camera, &SilhouetteOptions::default()) {
                    Ok(silhouette) => seen.views.push((id, silhouette)),
                    Err(reason) => seen.rejected.push((id, reason)),
                }
            }
            seen
        };
        self.numbers.par_iter().zip(&self.masks).map(of_frame).collect()
    }

    /// The same with every mask changed; `change` is given frame, camera and mask.
    pub fn with_masks(&self, change: impl Fn(usize, usize, &Mask) -> Option<Mask> + Sync) -> Self {
        let of_frame = |(frame, masks): (usize, &Vec<Option<Mask>>)| {
            let masks = masks.iter().enumerate();
            masks.map(|(camera, mask)| change(frame, camera, mask.as_ref()?)).collect()
        };
        Self { masks: self.masks.par_iter().enumerate().map(of_frame).collect(), ..self.clone() }
    }

    /// Every so many frames.
    pub fn with_every(&self, step: usize) -> Self {
        let every = |frames: &[Vec<_>]| frames.iter().step_by(step).cloned().collect();
        let frames = self.truth.frames.iter().step_by(step).cloned().collect();
        Self {
            fps: self.fps / step as f64,
            numbers: (0..self.numbers.len().div_ceil(step)).map(FrameIndex).collect(),
            masks: every(&self.masks),
            truth: Trajectories { frames, ..self.truth.clone() },
            ..self.clone()
        }
    }

    /// Only some of the cameras.
    pub fn with_cameras(&self, kept: &[usize]) -> Self {
        let masks = self.masks.iter();
        Self {
            rig: Rig { cameras: kept.iter().map(|i| self.rig.cameras[*i].clone()).collect() },
            masks: masks.map(|m| kept.iter().map(|i| m[*i].clone()).collect()).collect(),
            ..self.clone()
        }
    }
}

fn true_rig(folder: &Path) -> Result<Option<Rig>, Box<dyn Error>> {
    let path = folder.join("calibration-true.toml");
    if !path.is_file() {
        return Ok(None);
    }
    Ok(Some(calibration::read(&path, &CalibrationOptions::default())?))
}

/// `segment_lengths_m.stature` of a file of truths; `None` without the file or the number.
fn stature_m(path: &Path) -> Result<Option<f64>, Box<dyn Error>> {
    if !path.is_file() {
        return Ok(None);
    }
    let truth: serde_json::Value = serde_json::from_str(&std::fs::read_to_string(path)?)?;
    Ok(truth["segment_lengths_m"]["stature"].as_f64())
}
