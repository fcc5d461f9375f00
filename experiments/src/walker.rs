//! A walking person of metaballs, seen by seven cameras: ZS06's real sequence, made anew with its truth.

use std::path::Path;

use maquette::camera::Rig;
use maquette::io::model::{self, ModelFileError};
use maquette::io::points::trc::Trajectories;
use maquette::silhouette::{FrameIndex, FrameObservations, SilhouetteOptions, extract};
use maquette::synth::{Make, Recipe, Ring, SegmentationErrors, Synthetic, WalkError};
use rayon::prelude::*;

use crate::metrics::trajectories;

/// Why a walker could not be made.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum WalkerError {
    /// The body's model.
    #[error(transparent)]
    Model(#[from] ModelFileError),
    /// The walk.
    #[error(transparent)]
    Walk(#[from] WalkError),
}

/// Seven cameras, wide enough for four seconds of walking; a good background subtraction.
///
/// The person (model `walker-metaballs`, drawn by the seed) has other proportions than the model that is
/// fitted, and is rendered by ray casting, not by the code that is tested.
///
/// # Errors
/// [`WalkerError`]; the shipped model has none.
pub fn recording(frames: usize, seed: u64) -> Result<Synthetic, WalkerError> {
    seen_by(7, Some(frames), seed)
}

/// The same, seen by another number of cameras; one gait cycle if no number of frames is given.
///
/// # Errors
/// [`WalkerError`]; the shipped model has none.
pub fn seen_by(cameras: usize, frames: Option<usize>, seed: u64) -> Result<Synthetic, WalkerError> {
    let body = model::load("walker-metaballs", Path::new(""))?;
    let recipe = Recipe {
        seed,
        make: Make::Metaballs,
        frames,
        fps: 50.0,
        ring: wide_ring(cameras),
        errors: Some(SegmentationErrors::MILD),
        stereo: None,
        ..Recipe::default()
    };
    Ok(recipe.walker(&body)?)
}

/// Cameras so far away that the whole walk is seen.
pub fn wide_ring(cameras: usize) -> Ring {
    Ring {
        cameras,
        radius: 6.0,
        height: 2.2,
        focal_px: 560.0,
        width_px: 800,
        height_px: 600,
        ..Ring::default()
    }
}

/// The silhouettes of every frame.
pub fn observe(recording: &Synthetic) -> Vec<FrameObservations> {
    let frames: Vec<usize> = (0..recording.frames()).collect();
    frames
        .into_par_iter()
        .map(|index| observe_frame(recording, &recording.rig, FrameIndex(index)))
        .collect()
}

fn observe_frame(recording: &Synthetic, rig: &Rig, frame: FrameIndex) -> FrameObservations {
    let mut observations = FrameObservations::nothing(frame);
    for (id, camera) in rig.iter() {
        let Some(mask) = recording.mask(frame, id) else {
            continue;
        };
        match extract(&mask, camera, &SilhouetteOptions::default()) {
            Ok(silhouette) => observations.views.push((id, silhouette)),
            Err(reason) => observations.rejected.push((id, reason)),
        }
    }
    observations
}

/// The true joint centres.
pub fn truth(recording: &Synthetic) -> Trajectories {
    trajectories(&recording.model, &recording.shape, &recording.motions, recording.fps)
}
