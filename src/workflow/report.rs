//! The report of a gait study; with the feature `report`.

use rayon::prelude::*;

use super::{Error, GaitStudy};
use crate::camera::CameraId;
use crate::io::recording::Recording;
use crate::report::{CameraOutlines, ReportInput, Subject, html, outline_points};
use crate::silhouette::FrameIndex;

impl GaitStudy {
    /// The report that a clinician reads: one HTML page that needs nothing else.
    ///
    /// # Errors
    /// [`Error::Json`], if the serialiser has any.
    pub fn report(&self, subject: &Subject) -> Result<String, Error> {
        self.report_of(subject, &[])
    }

    /// The same with what the cameras of the recording saw.
    ///
    /// # Errors
    /// As [`GaitStudy::report`], and [`Error::Recording`] for a mask that cannot be read.
    pub fn report_with_views(
        &self,
        subject: &Subject,
        recording: &Recording,
    ) -> Result<String, Error> {
        self.report_of(subject, &self.views(recording)?)
    }

    fn report_of(&self, subject: &Subject, views: &[CameraOutlines]) -> Result<String, Error> {
        Ok(html(&ReportInput {
            subject,
            result: self.result.as_ref(),
            body: self.input.body.as_ref(),
            movement: &self.input.movement,
            gait: &self.analysis,
            norm: self.norm.as_ref(),
            views,
        })?)
    }

    /// The outlines of all masks, camera by camera, each looking where the fit found it to look.
    fn views(&self, recording: &Recording) -> Result<Vec<CameraOutlines>, Error> {
        let movement = &self.input.movement;
        let recording = recording.clone().with_fps(movement.rate_hz);
        let mut files = recording.observations()?;
        if let Some(result) = &self.result {
            files.rig = files.rig.aimed(&result.aims_px(&files.rig));
        }
        let numbers = movement.first_frame..movement.first_frame + movement.frames;
        let frames: Vec<FrameIndex> = numbers.map(FrameIndex).collect();

        let outlines = |id: CameraId, frame: FrameIndex| -> Result<Vec<Vec<i16>>, Error> {
            let mask = files.load_mask(id, frame)?;
            let seen = mask.zip(files.rig.camera(id));
            let borders = seen.map(|(mask, camera)| outline_points(camera, &mask));
            Ok(borders.unwrap_or_default())
        };
        let mut views = Vec::new();
        for (id, camera) in files.rig.iter() {
            let all = frames.par_iter().map(|frame| outlines(id, *frame));
            let all: Vec<Result<Vec<Vec<i16>>, Error>> = all.collect();
            // the first fault in the order of the frames, whichever thread met one first
            let all = all.into_iter().collect::<Result<_, _>>()?;
            views.push(CameraOutlines::new(camera, all));
        }
        Ok(views)
    }
}
