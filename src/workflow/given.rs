//! What a recording has before anything is made of its pictures, and what a fit of it reads.

use super::body::body;
use super::{Error, FitOptions, SilhouetteSource};
use crate::io::recording::footage::FootageError;
use crate::io::recording::{InputChecksum, ObservationFiles, Recording, RecordingError};
use crate::pipeline::FitTo;

/// Masks, detections and points that a recording has, or that it has none.
pub(super) struct Given(pub(super) Result<ObservationFiles, RecordingError>);

impl Given {
    pub(super) fn of(recording: &Recording, options: &FitOptions) -> Result<Self, Error> {
        let given = match options.stereo {
            // its points are what is to be measured
            Some(_) => recording.masks(),
            None => recording.observations(),
        };
        match given {
            Err(fault @ RecordingError::NoMasks { .. }) => Ok(Self(Err(fault))),
            given => Ok(Self(Ok(given?))),
        }
    }

    /// Whether a fit needs no pictures.
    pub(super) fn is_enough(&self, options: &FitOptions) -> bool {
        let fit_to = options.observations.fit_to;
        let is_enough = |files: &ObservationFiles| {
            files.has_masks()
                || fit_to == FitTo::Points && files.has_points()
                || fit_to == FitTo::Detections && files.has_detections()
        };
        let is_free =
            options.stereo.is_none() && options.silhouettes != Some(SilhouetteSource::Joint);
        is_free && self.0.as_ref().is_ok_and(is_enough)
    }
}

impl Recording {
    /// Fingerprints of everything that a fit with these options reads: two fits of the same inputs, options and version
    /// give the same result. No picture is decoded.
    ///
    /// # Errors
    /// [`Error`] if something is missing or cannot be read.
    pub fn inputs(&self, options: &FitOptions) -> Result<Vec<InputChecksum>, Error> {
        let given = Given::of(self, options)?;
        let footage = match given.is_enough(options) {
            true => None,
            false => match self.footage() {
                Err(RecordingError::Footage(FootageError::NoPictures { .. })) => None,
                footage => Some(footage?),
            },
        };
        let mut inputs = match (given, &footage) {
            (Given(Err(_)), Some(_)) => Vec::new(),
            (Given(files), _) => files?.checksums()?,
        };
        if let Some(footage) = &footage {
            inputs.extend(self.picture_checksums(footage)?);
        }
        let (_, body) = body(options, self)?;
        inputs.extend(body);
        Ok(inputs)
    }
}
