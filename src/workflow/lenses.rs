//! A calibration from nothing but lenses: the cameras are placed by the detections of a person who moves, and then refined by the person's body.

use std::path::Path;

use rayon::prelude::*;

use super::calibrate::{Told, refined};
use super::fitted_source::FittedSource;
use super::{CalibrateError, Error, FitFolder, FitOptions, RefinedRig, input};
use crate::body::{BodyModel, Shape};
use crate::camera::Rig;
use crate::io::folder::Existing;
use crate::io::recording::{Recording, RecordingError};
use crate::pipeline::{Cameras, Clocks, PlacedRig, Progress, Scale, Size, Walker, placed_rig};
use crate::silhouette::FramePeople;

/// What was found of cameras of which the lenses alone were known.
#[derive(Debug, Clone)]
pub struct FoundByLenses {
    /// Where the detections alone put the cameras.
    pub placed: PlacedRig,
    /// By what the world was scaled in the end, and how well that is known.
    pub scale: Scale,
    /// The size that was given, or none.
    pub size: Size,
    /// Why the person's body did not refine it; `None` where it did.
    pub unrefined: Option<String>,
}

/// Fewer cameras are not refined: how far away a person stands is told by those that look from elsewhere.
const LEAST_CAMERAS: usize = 3;
const TWO_CAMERAS: &str = "it takes three cameras or more around a person";

impl RefinedRig {
    /// Calibrates the cameras of a recording of which the lenses alone are known: the poses in its calibration are not read.
    ///
    /// # Errors
    /// [`CalibrateError`] in words, [`Error::Lenses`] for what the motion does not tell, [`Error::Unusable`] for a fit that cannot be used, and
    /// whatever a fit fails with.
    pub fn from_lenses(
        path: &Path,
        fps: Option<f64>,
        size: Size,
        options: &FitOptions,
        progress: &dyn Progress,
    ) -> Result<Self, Error> {
        let mut options = options.clone();
        options.estimate.cameras = Cameras::Refine;
        options.estimate.clocks = Clocks::Estimate;

        // 1. by the detections alone
        let recording = Recording::open(path)?.with_fps(fps);
        let (model, _) = input::body(&options, &recording)?;
        let lenses = recording.clone().with_lenses_alone();
        let (people, rig, fps) = people(&lenses, &options, progress)?;
        let size = match (size, recording.height_m()) {
            (Size::Usual, Some(height_m)) => Size::Height(height_m),
            (size, _) => size,
        };
        size.check(&rig)?;
        let walker = Walker { model: &model, height_m: size.height_m(), fps };
        let placed = placed_rig(&rig, &people, walker)?;

        // 2. by the body, where three cameras see it from elsewhere
        let mean = Shape(model.statistics.mean.clone());
        let recording = recording.with_rig(placed.rig.clone());
        let (refined, shape, unrefined) = match rig.cameras.len() < LEAST_CAMERAS {
            true => (None, mean, Some(TWO_CAMERAS.into())),
            false => by_body(path, &recording, &model, &options, progress)?,
        };

        // 3. as large as it is
        let refined = match refined {
            Some(refined) => refined,
            None => Self::unrefined(&placed.rig, recording.calibration()?.1),
        };
        let scale = match (&size, &unrefined) {
            // the detections' own scale is by the height or the mean already
            (Size::Height(_) | Size::Usual, Some(_)) => Scale { factor: 1.0, sd: None },
            _ => size.scale(&model, &shape, &refined.rig),
        };
        Ok(refined.from(FoundByLenses { placed, scale, size, unrefined }))
    }
}

/// The cameras as the body of the person refines them, its shape, or why it does not.
type ByBody = (Option<RefinedRig>, Shape, Option<String>);

fn by_body(
    path: &Path,
    recording: &Recording,
    model: &BodyModel,
    options: &FitOptions,
    progress: &dyn Progress,
) -> Result<ByBody, Error> {
    let folder = tempfile::tempdir()?;
    let out = FitFolder { path: folder.path(), existing: Existing::Refuse, overlays: false };
    let fitted = recording.fit_into(out, options, progress)?;
    fitted.usable()?;
    let shape = fitted.result.shape_of(&fitted.model)?.first(model.coefficients.len());
    let source = FittedSource { recording: recording.clone(), result: fitted.result };
    match Told::new(path, &source).and_then(|told| Ok(refined(vec![told])?)) {
        Ok(refined) => Ok((Some(refined), shape, None)),
        Err(Error::Calibrate(why)) => Ok((None, shape, Some(why.to_string()))),
        Err(fault) => Err(fault),
    }
}

/// The people of all frames that were asked for, the cameras, and the frame rate.
fn people(
    lenses: &Recording,
    options: &FitOptions,
    progress: &dyn Progress,
) -> Result<(Vec<FramePeople>, Rig, f64), Error> {
    let files = lenses.observations()?;
    if !files.has_detections() {
        return Err(CalibrateError::NoDetections { path: lenses.path().into() }.into());
    }
    let positions = options.frames.positions(&files.frames)?;
    progress.begin("reading detections", positions.len());
    let load = |position: usize| {
        let people = files.load_people(position);
        progress.step();
        people
    };
    let loaded: Vec<Result<FramePeople, RecordingError>> =
        positions.into_par_iter().map(load).collect();
    progress.end();
    let people = loaded.into_iter().collect::<Result<_, _>>()?;
    Ok((people, files.rig, files.fps))
}
