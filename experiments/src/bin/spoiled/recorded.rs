//! A recording in memory: what is spoiled.

use std::error::Error;
use std::path::Path;

use maquette::camera::Rig;
use maquette::image::Mask;
use maquette::io::points::trc::{Trajectories, read_trc};
use maquette::io::recording::Recording;
use maquette::silhouette::{FrameIndex, FrameObservations, SilhouetteOptions, extract};
use rayon::prelude::*;

/// Cameras and masks of a recording, and the truth.
#[derive(Debug, Clone)]
pub(crate) struct Recorded {
    pub(crate) rig: Rig,
    pub(crate) fps: f64,
    /// The numbers of the frames.
    pub(crate) numbers: Vec<FrameIndex>,
    /// Frame by frame a place for each camera.
    pub(crate) masks: Vec<Vec<Option<Mask>>>,
    pub(crate) truth: Trajectories,
}

impl Recorded {
    /// Reads a recording with its masks, and the truth beside it.
    pub(crate) fn read(folder: &Path, fps: f64, truth: &str) -> Result<Self, Box<dyn Error>> {
        let files = Recording::open(folder)?.with_fps(fps).masks()?;
        let cameras: Vec<_> = files.rig.iter().map(|(id, _)| id).collect();
        let read = |frame: &FrameIndex| {
            let masks = cameras.iter().map(|id| files.load_mask(*id, *frame));
            masks.collect::<Result<Vec<_>, _>>()
        };
        let masks: Result<Vec<_>, _> = files.frames.par_iter().map(read).collect();

        let path = folder.join(truth);
        Ok(Self {
            masks: masks?,
            numbers: files.frames.clone(),
            fps,
            truth: read_trc(&std::fs::read_to_string(&path)?, &path)?,
            rig: files.rig,
        })
    }

    /// The silhouettes of every frame.
    pub(crate) fn observations(&self) -> Vec<FrameObservations> {
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
    pub(crate) fn with_masks(
        &self,
        change: impl Fn(usize, usize, &Mask) -> Option<Mask> + Sync,
    ) -> Self {
        let of_frame = |(frame, masks): (usize, &Vec<Option<Mask>>)| {
            let masks = masks.iter().enumerate();
            masks.map(|(camera, mask)| change(frame, camera, mask.as_ref()?)).collect()
        };
        Self { masks: self.masks.par_iter().enumerate().map(of_frame).collect(), ..self.clone() }
    }

    /// Only some of the cameras.
    pub(crate) fn with_cameras(&self, kept: &[usize]) -> Self {
        let masks = self.masks.iter();
        Self {
            rig: Rig { cameras: kept.iter().map(|i| self.rig.cameras[*i].clone()).collect() },
            masks: masks.map(|m| kept.iter().map(|i| m[*i].clone()).collect()).collect(),
            ..self.clone()
        }
    }
}
