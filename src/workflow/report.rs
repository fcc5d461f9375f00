//! The report of a gait study; with the feature `report`.

use std::path::Path;

use nalgebra::{Point2, Point3};
use rayon::prelude::*;

use super::fitted_files::fitted_files;
use super::{Error, FittedRecording, GaitStudy};
use crate::camera::{Camera, CameraId};
use crate::image::Picture;
use crate::io::gait::from_result;
use crate::io::recording::footage::Footage;
use crate::io::recording::{ObservationFiles, Recording};
use crate::math::stats::median;
use crate::pipeline::Progress;
use crate::report::{
    CameraOutlines, FramePicture, Language, PictureBudget, ReportInput, Subject, ViewerInput,
    Views, Words, html, joint_marks, outline_points, viewer_html,
};
use crate::silhouette::{FrameIndex, Keypoint, distances_px};

/// The recording that a report shows.
#[derive(Clone, Copy)]
pub struct ReportedRecording<'a> {
    /// The recording that was fitted.
    pub recording: &'a Recording,
    /// The folder of the fit, which holds the masks and points that were made of the recording's pictures.
    pub out: &'a Path,
    /// Whether the recorded pictures are shown under the outlines, where there are any.
    pub pictures: bool,
    /// Is told how far it is.
    pub progress: &'a dyn Progress,
}

impl std::fmt::Debug for ReportedRecording<'_> {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "ReportedRecording({:?} fitted into {:?})", self.recording.path(), self.out)
    }
}

impl FittedRecording {
    /// A page that shows the fitted body as it moves: one HTML text that needs nothing else.
    ///
    /// # Errors
    /// [`Error::GaitInput`] of fewer than 10 frames and of a body that has no legs, and [`Error::Json`], if the serialiser has any.
    pub fn viewer(&self) -> Result<String, Error> {
        let input = from_result(&self.result, self.model.clone(), None)?;
        Ok(viewer_html(&ViewerInput {
            body: input.body.as_ref(),
            movement: &input.movement,
            verdict: &self.result.verdict,
        })?)
    }
}

impl GaitStudy {
    /// The report that a clinician reads: one HTML page that needs nothing else.
    ///
    /// # Errors
    /// [`Error::Json`], if the serialiser has any.
    pub fn report(&self, subject: &Subject, language: Language) -> Result<String, Error> {
        self.report_of(subject, &Views::default(), language)
    }

    /// The same with what the cameras of the recording saw.
    ///
    /// # Errors
    /// As [`GaitStudy::report`], and [`Error::Recording`] for another recording than the one that was fitted, and for a
    /// mask that cannot be read.
    pub fn report_with_views(
        &self,
        subject: &Subject,
        shown: ReportedRecording<'_>,
        language: Language,
    ) -> Result<String, Error> {
        self.report_of(subject, &self.views(shown)?, language)
    }

    fn report_of(
        &self,
        subject: &Subject,
        views: &Views,
        language: Language,
    ) -> Result<String, Error> {
        Ok(html(&ReportInput {
            subject,
            result: self.result.as_ref(),
            body: self.input.body.as_ref(),
            movement: &self.input.movement,
            gait: &self.analysis,
            norm: self.norm.as_ref(),
            views,
            words: &Words::new(language),
        })?)
    }

    /// The outlines of all masks, camera by camera, each looking where the fit found it to look, and the pictures.
    fn views(&self, shown: ReportedRecording<'_>) -> Result<Views, Error> {
        let recording = shown.recording.clone().with_fps(self.input.movement.rate_hz);
        let (mut files, footage) = fitted_files(self.result.as_ref(), &recording, shown.out)?;
        if let Some(result) = &self.result {
            files.check(&result.inputs)?;
            files.rig = result.rig(&files.rig);
        }

        let cameras = self.outlines(&files, shown.progress)?;
        let mut views = Views { cameras, ..Views::default() };
        if shown.pictures {
            // without pictures the outlines are shown alone
            let footage = footage.or_else(|| recording.footage().ok());
            if let Some(footage) = footage {
                self.add_pictures(&mut views, &files, &footage, shown.progress);
            }
        }
        Ok(views)
    }

    fn outlines(
        &self,
        files: &ObservationFiles,
        progress: &dyn Progress,
    ) -> Result<Vec<CameraOutlines>, Error> {
        let movement = &self.input.movement;
        let numbers = movement.first_frame..movement.first_frame + movement.frames;
        let frames: Vec<FrameIndex> = numbers.map(FrameIndex).collect();
        let outlines = |id: CameraId, frame: FrameIndex| -> Result<Vec<Vec<i16>>, Error> {
            progress.step();
            let Some(camera) = files.rig.camera(id) else { return Ok(Vec::new()) };
            if !files.has_masks() {
                let joints = self.joints_px(camera, &files.people(id, frame)?, frame);
                return Ok(joint_marks(camera, &joints));
            }
            let mask = files.load_mask(id, frame)?;
            Ok(mask.map(|mask| outline_points(camera, &mask)).unwrap_or_default())
        };

        progress.begin("outlines", frames.len() * files.rig.cameras.len());
        let mut cameras = Vec::new();
        for (id, camera) in files.rig.iter() {
            let all = frames.par_iter().map(|frame| outlines(id, *frame));
            let all: Vec<Result<Vec<Vec<i16>>, Error>> = all.collect();
            // the first fault in the order of the frames, whichever thread met one first
            let all = all.into_iter().collect::<Result<_, _>>()?;
            cameras.push(CameraOutlines::new(camera, all));
        }
        progress.end();
        Ok(cameras)
    }

    /// The joints of the one of several people in a picture whom the fitted body is nearest to.
    fn joints_px(
        &self,
        camera: &Camera,
        people: &[Vec<Keypoint>],
        frame: FrameIndex,
    ) -> Vec<Point2<f64>> {
        let Some(motion) = self.result.as_ref().map(|result| &result.motion) else {
            return Vec::new();
        };
        let fitted = motion.frames.iter().find(|part| part.frame == frame.0);
        let place = |point: &str| {
            let index = motion.points.iter().position(|name| name == point)?;
            Some(Point3::from(fitted?.points_m[index]))
        };
        let miss = |person: &&Vec<Keypoint>| {
            median(&mut distances_px(person, camera, place)).unwrap_or(f64::INFINITY)
        };
        let own = people.iter().min_by(|a, b| miss(a).total_cmp(&miss(b)));
        own.into_iter().flatten().map(|keypoint| keypoint.pixel).collect()
    }

    /// Adds the pictures of as many frames as the report has room for.
    fn add_pictures(
        &self,
        views: &mut Views,
        files: &ObservationFiles,
        footage: &Footage,
        progress: &dyn Progress,
    ) {
        let movement = &self.input.movement;
        let (first, last) = (movement.first_frame, movement.first_frame + movement.frames - 1);
        let budget = PictureBudget::new(views.cameras.len(), movement.frames);
        views.every = budget.every;
        let known: Vec<(&Camera, Option<CameraId>)> = files
            .rig
            .cameras
            .iter()
            .map(|camera| (camera, footage.rig.by_name(&camera.name).map(|(id, _)| id)))
            .collect();

        progress.begin("pictures", movement.frames);
        for (frame, pictures) in footage.frame_sets(first..=last) {
            progress.step();
            let at = frame.0 - first;
            if at % budget.every != 0 {
                continue;
            }
            let of = |id: CameraId| pictures.get(id.0).and_then(Option::as_ref);
            let cameras = views.cameras.par_iter_mut().zip(&known);
            cameras.for_each(|(view, (camera, id))| add(view, camera, at, id.and_then(of), budget));
        }
        progress.end();
    }
}

/// Adds the part of a picture around the person to a view; nothing where either is not there.
fn add(
    view: &mut CameraOutlines,
    camera: &Camera,
    at: usize,
    picture: Option<&Picture>,
    budget: PictureBudget,
) {
    if let (Some(picture), Some(part)) = (picture, view.part(at)) {
        view.pictures.extend(FramePicture::new(camera, picture, (at, part), budget));
    }
}
