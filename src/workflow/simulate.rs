//! The recording that the cameras of a fit would have made of the fitted body: a parametric bootstrap.

use std::path::Path;

use super::fitted_files::fitted_files;
use super::{Error, FittedRecording};
use crate::body::Motion;
use crate::io::recording::Recording;
use crate::synth::{BoundSkin, SegmentationErrors, Synthetic};

/// How a fit is simulated.
#[derive(Debug, Clone, Copy)]
pub struct Simulation<'a> {
    /// The recording that was fitted, which has the cameras.
    pub recording: &'a Recording,
    /// The folder of the fit, which holds the masks that were made of the recording's pictures.
    pub out: &'a Path,
    /// Errors of the segmentation; `None` for true masks.
    pub errors: Option<SegmentationErrors>,
    /// Seed of the errors.
    pub seed: u64,
}

impl FittedRecording {
    /// What the cameras of the recording, each where the fit found it and all at once, would have seen of the fitted body.
    ///
    /// Shape and motion are the fit's, the surface is its skin with what clothes and flesh add, moved by shares
    /// ([`BoundSkin`]). Frame 0 is the first that was fitted.
    ///
    /// # Errors
    /// [`Error::Unusable`], [`Error::FrameGap`], [`Error::Skin`] of a body without metaballs, and [`Error::Recording`] of
    /// another recording.
    pub fn simulated(&self, simulation: &Simulation<'_>) -> Result<Synthetic, Error> {
        self.usable()?;
        let fps = self.result.recording.fps;
        let recording = simulation.recording.clone().with_fps(fps);
        let (files, _) = fitted_files(Some(&self.result), &recording, simulation.out)?;
        files.check(&self.result.inputs)?;

        let shape = self.result.shape_of(&self.model)?;
        Ok(Synthetic {
            skin: Some(BoundSkin::fitted(&self.model, &shape)?),
            model: self.model.clone(),
            shape,
            motions: self.motions()?,
            rig: self.result.rig(&files.rig),
            fps,
            errors: simulation.errors,
            stereo: None,
            seed: simulation.seed,
        })
    }

    /// The motion of every frame from the first to the last.
    fn motions(&self) -> Result<Vec<Motion>, Error> {
        let frames = &self.result.motion.frames;
        let gap = frames.windows(2).find(|pair| pair[1].frame != pair[0].frame + 1);
        match gap {
            Some(pair) => Err(Error::FrameGap { frame: pair[0].frame + 1 }),
            None => Ok(frames.iter().map(|frame| frame.motion()).collect()),
        }
    }
}
