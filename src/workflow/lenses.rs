//! A calibration from nothing but lenses: the cameras are placed by the detections of a person who moves, and then refined by the person's body.

use std::path::{Path, PathBuf};

use nalgebra::DMatrix;
use rayon::prelude::*;

use super::body::body;
use super::calibrate::{write_rig, written_files};
use super::{CalibrateError, Error, FitFolder, FitOptions};
use crate::body::{BodyModel, Shape};
use crate::camera::Rig;
use crate::io::calibration::{CalibrationOptions, CameraEstimate};
use crate::io::folder::Existing;
use crate::io::recording::{Recording, RecordingError};
use crate::pipeline::{
    Cameras, Clocks, POSE, PlaceSd, PlacedRig, Progress, Scale, Size, Walker, placed_rig,
    relative_sds, without_lenses,
};
use crate::silhouette::FramePeople;

/// A calibration that was made of lenses alone.
#[derive(Debug)]
pub struct LensRig {
    /// The cameras, in metres: z up, the floor at 0, x along the walk.
    pub rig: Rig,
    /// How well each is known, relative to the rig.
    pub sds: Vec<PlaceSd>,
    /// Where the detections alone put the cameras.
    pub placed: PlacedRig,
    /// Why the person's body did not refine that; `None` where it did.
    pub unrefined: Option<String>,
    /// What tells how large the world is.
    pub size: Size,
    /// By what the world was scaled in the end, and how well that is known.
    pub scale: Scale,
    /// Frames that were looked at.
    pub frames: usize,
    options: CalibrationOptions,
}

/// Fewer cameras are not refined.
const LEAST_CAMERAS: usize = 3;
const TWO_CAMERAS: &str = "it takes three cameras or more around a person";
const NOT_CROSSED: &str =
    "not every camera has two others that look across its line of sight by more than 20°";

impl LensRig {
    /// Calibrates the cameras of a recording; the poses in its calibration are not read.
    ///
    /// # Errors
    /// [`CalibrateError`] in words, [`Error::Lenses`] for what the motion does not tell, [`Error::Size`], [`Error::Unusable`] for a fit that
    /// cannot be used, and whatever a fit fails with.
    pub fn of(
        path: &Path,
        fps: Option<f64>,
        size: Size,
        options: &FitOptions,
        progress: &dyn Progress,
    ) -> Result<Self, Error> {
        // 1. by the detections alone
        let recording = Recording::open(path)?.with_fps(fps);
        let (model, _) = body(options, &recording)?;
        let seen = Seen::read(&recording.clone().with_lenses_alone(), options, progress)?;
        let size = match (size, recording.height_m()) {
            (Size::Usual, Some(height_m)) => Size::Height(height_m),
            (size, _) => size,
        };
        size.check(&seen.rig)?;
        let walker = Walker { model: &model, height_m: size.height_m(), fps: seen.fps };
        let placed = placed_rig(&seen.rig, &seen.people, walker)?;

        // 2. by the body, where three cameras see it from elsewhere
        let recording = recording.with_rig(placed.rig.clone());
        let by_body = match seen.rig.cameras.len() < LEAST_CAMERAS {
            true => Err(TWO_CAMERAS),
            false => ByBody::new(&recording, &placed, &model, options, progress)?,
        };

        // 3. as large as it is
        let unrefined = by_body.as_ref().err().map(ToString::to_string);
        let by_body = by_body.unwrap_or_else(|_| ByBody::none(&placed));
        let mut rig = by_body.rig;
        let scale = size.scale(&model, by_body.shape.as_ref(), &rig);
        for camera in &mut rig.cameras {
            camera.camera_from_world.translation.vector *= scale.factor;
        }
        let larger = |sd: PlaceSd| PlaceSd { place_m: scale.factor * sd.place_m, ..sd };
        Ok(Self {
            sds: by_body.sds.into_iter().map(larger).collect(),
            rig,
            placed,
            unrefined,
            size,
            scale,
            frames: seen.people.len(),
            options: recording.calibration()?.1,
        })
    }

    /// Writes the files, whose format follows from the name.
    ///
    /// # Errors
    /// [`Error::CalibrationFile`] for a name that says no format and a camera that it cannot hold, and [`Error::Out`].
    pub fn write(&self, path: &Path) -> Result<Vec<PathBuf>, Error> {
        let known = self.rig.names().zip(&self.sds).map(|(name, sd)| CameraEstimate::Placed {
            camera: name.into(),
            turn_sd_deg: sd.turn_deg,
            place_sd_m: sd.place_m,
        });
        write_rig(&self.rig, path, &self.options, &known.collect::<Vec<_>>())
    }

    /// The files that [`LensRig::write`] writes.
    ///
    /// # Errors
    /// As there.
    pub fn files(&self, path: &Path) -> Result<Vec<PathBuf>, Error> {
        written_files(&self.rig, path, &self.options)
    }
}

/// What detectors saw.
struct Seen {
    people: Vec<FramePeople>,
    rig: Rig,
    fps: f64,
}

impl Seen {
    /// The people of all frames that were asked for.
    fn read(
        lenses: &Recording,
        options: &FitOptions,
        progress: &dyn Progress,
    ) -> Result<Self, Error> {
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
        // the first fault in the order of the frames
        let people = loaded.into_iter().collect::<Result<_, _>>()?;
        Ok(Self { people, rig: files.rig, fps: files.fps })
    }
}

/// Cameras as the person's body refines them.
struct ByBody {
    rig: Rig,
    sds: Vec<PlaceSd>,
    /// The body's; `None` where there is none.
    shape: Option<Shape>,
}

impl ByBody {
    /// A fit before the cameras where the detections put them, which may err as these say; the inner error says why no camera's place was found.
    fn new(
        recording: &Recording,
        placed: &PlacedRig,
        model: &BodyModel,
        options: &FitOptions,
        progress: &dyn Progress,
    ) -> Result<Result<Self, &'static str>, Error> {
        let mut options = options.clone();
        options.estimate.cameras = Cameras::Refine;
        options.estimate.clocks = Clocks::Estimate;
        options.estimate.calibration_errors = placed.errors();
        let folder = tempfile::tempdir()?;
        let out = FitFolder { path: folder.path(), existing: Existing::Refuse, overlays: false };
        let fitted = recording.fit_into(out, &options, progress)?;
        fitted.usable()?;

        let rig = fitted.result.rig(&placed.rig);
        let rows = fitted.result.quality.poses_covariance.as_ref();
        let covariance =
            rows.map(|rows| DMatrix::from_fn(rows.len(), rows.len(), |i, j| rows[i][j]));
        let sds = covariance.filter(|c| c.nrows() == POSE * rig.cameras.len());
        let sds = sds.and_then(|covariance| relative_sds(&rig, &without_lenses(&covariance)));
        let Some(sds) = sds else {
            return Ok(Err(NOT_CROSSED));
        };
        let shape = fitted.result.shape_of(&fitted.model)?.first(model.coefficients.len());
        Ok(Ok(Self { rig, sds, shape: Some(shape) }))
    }

    /// Where the detections put them.
    fn none(placed: &PlacedRig) -> Self {
        Self { rig: placed.rig.clone(), sds: placed.sds.clone(), shape: None }
    }
}
