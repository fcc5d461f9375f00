//! A calibration refined by a person who moves before its cameras.

use std::path::{Path, PathBuf};

use nalgebra::{DMatrix, DVector, UnitQuaternion, Vector3};

use super::fitted_source::FittedSource;
use super::{Error, FitOptions};
use crate::camera::{Camera, Rig};
use crate::inference::camera_offset::{CameraOffset, ZOOM};
use crate::io::calibration::{self, CalibrationOptions, CameraEstimate, Refined};
use crate::io::folder::write_atomically;
use crate::pipeline::{Cameras, Clocks, POSE, Progress, RigEstimate, RigEvidence, rig_estimate};

/// Why a calibration cannot be refined.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum CalibrateError {
    /// A recording that tells no camera's place.
    #[error("{}: no camera's place can be told: {why}", path.display())]
    NothingTold {
        /// The recording.
        path: PathBuf,
        /// Why.
        why: String,
    },
    /// Recordings of two calibrations.
    #[error(
        "camera {camera}: {} and {} have different calibrations of it: expected recordings of one calibration",
        first.display(), second.display()
    )]
    TwoCalibrations {
        /// The camera.
        camera: String,
        /// A recording.
        first: PathBuf,
        /// Another.
        second: PathBuf,
    },
    /// A recording that shows nothing that cameras can be placed by.
    #[error("{}: cameras of which the lenses alone are known are placed by detections of joints, and there are none: expected pose/<camera>_json/", path.display())]
    NoDetections {
        /// The recording.
        path: PathBuf,
    },
    /// Nothing that the motion determines.
    #[error(
        "the motion determines no camera's place: the calibration's usual errors hold all of them; let the person walk through the whole room, or give more recordings"
    )]
    NothingDetermined,
}

/// A refined calibration.
#[derive(Debug)]
pub struct RefinedRig {
    /// All cameras of the calibration, where they were found to be.
    pub rig: Rig,
    /// What became of each.
    pub cameras: Vec<RefinedCamera>,
    /// What it was refined from.
    pub recordings: Vec<UsedRecording>,
    /// What should be known, each in one line.
    pub notes: Vec<String>,
    options: CalibrationOptions,
}

/// A recording that a calibration was refined from.
#[derive(Debug)]
pub struct UsedRecording {
    /// As it was given.
    pub path: PathBuf,
    /// Frames that were fitted.
    pub frames: usize,
    /// How many cameras' places it tells.
    pub cameras: usize,
}

/// What became of a camera.
#[derive(Debug)]
pub struct RefinedCamera {
    /// Its name.
    pub camera: String,
    /// How many of its seven numbers the motion determines.
    pub determined: f64,
    /// By how much it was moved; `Err` says why it keeps its calibration.
    pub found: Result<Refined, String>,
}

/// How many numbers of a camera must be determined for it to be moved: one, or the prior has moved it.
const LEAST_DETERMINED: f64 = 1.0;
/// Numbers of a calibration that agree to this are the same.
const SAME: f64 = 1e-9;

impl RefinedRig {
    /// Refines the calibration of recordings, or of folders of finished fits of them.
    ///
    /// # Errors
    /// [`CalibrateError`] in words, [`Error::Unusable`] for a fit that cannot be used, and whatever a fit fails with.
    pub fn of(
        paths: &[PathBuf],
        fps: Option<f64>,
        options: &FitOptions,
        progress: &dyn Progress,
    ) -> Result<Self, Error> {
        let mut options = options.clone();
        options.estimate.cameras = Cameras::Refine;
        options.estimate.clocks = Clocks::Estimate;

        let mut told = Vec::new();
        for path in paths {
            let source = FittedSource::open(path, fps, &options, progress)?;
            told.push(Told::new(path, &source)?);
        }
        Ok(refined(told)?)
    }

    /// Writes the files, whose format follows from the name.
    ///
    /// # Errors
    /// [`Error::CalibrationFile`] for a name that says no format and a camera that it cannot hold, and [`Error::Out`].
    pub fn write(&self, path: &Path) -> Result<Vec<PathBuf>, Error> {
        let found = self.cameras.iter().filter_map(|camera| camera.found.clone().ok());
        let found: Vec<CameraEstimate> = found.map(CameraEstimate::Refined).collect();
        write_rig(&self.rig, path, &self.options, &found)
    }

    /// The files that [`RefinedRig::write`] writes.
    ///
    /// # Errors
    /// As there.
    pub fn files(&self, path: &Path) -> Result<Vec<PathBuf>, Error> {
        written_files(&self.rig, path, &self.options)
    }
}

/// Writes the files of a rig, whose format follows from the name.
pub(super) fn write_rig(
    rig: &Rig,
    path: &Path,
    options: &CalibrationOptions,
    known: &[CameraEstimate],
) -> Result<Vec<PathBuf>, Error> {
    let files = calibration::write(rig, path, options, known)?;
    for file in &files {
        write_atomically(&file.path, file.text.as_bytes())?;
    }
    Ok(files.into_iter().map(|file| file.path).collect())
}

/// The files that [`write_rig`] writes.
pub(super) fn written_files(
    rig: &Rig,
    path: &Path,
    options: &CalibrationOptions,
) -> Result<Vec<PathBuf>, Error> {
    let files = calibration::write(rig, path, options, &[])?;
    Ok(files.into_iter().map(|file| file.path).collect())
}

/// What one recording tells.
struct Told {
    path: PathBuf,
    frames: usize,
    rig: Rig,
    options: CalibrationOptions,
    /// Names of the cameras whose poses it estimated.
    names: Vec<String>,
    found: DVector<f64>,
    covariance: DMatrix<f64>,
    /// Names of cameras that show somebody.
    seeing: Vec<String>,
}

impl Told {
    fn new(path: &Path, source: &FittedSource) -> Result<Self, Error> {
        let result = &source.result;
        let with_pose = result.quality.cameras.iter().filter_map(|c| Some((c, c.found.pose?)));
        let (mut names, mut found) = (Vec::new(), Vec::new());
        for (camera, pose) in with_pose {
            names.push(camera.camera.clone());
            found.extend(pose.turn_deg.map(f64::to_radians));
            found.extend(pose.displacement_m);
            found.push(pose.zoom.ln());
        }
        let rows = result.quality.poses_covariance.as_ref().filter(|rows| !rows.is_empty());
        let Some(rows) = rows else {
            let why = why_nothing(source);
            return Err(CalibrateError::NothingTold { path: path.into(), why }.into());
        };

        let (rig, options) = source.recording.calibration()?;
        let seeing = result.quality.cameras.iter().filter(|camera| camera.frames > 0);
        Ok(Self {
            path: path.into(),
            frames: result.recording.frames,
            covariance: DMatrix::from_fn(found.len(), found.len(), |i, j| rows[i][j]),
            found: DVector::from_vec(found),
            seeing: seeing.map(|camera| camera.camera.clone()).collect(),
            names,
            rig,
            options,
        })
    }
}

/// Why a fit says nothing of its cameras' places.
fn why_nothing(source: &FittedSource) -> String {
    let result = &source.result;
    let cameras = result.recording.cameras.len();
    let found = result.quality.cameras.iter().any(|camera| camera.found.pose.is_some());
    if !source.asks_for_poses() {
        "it was fitted with --cameras trust or --joint off: give the recording, or fit it with --cameras refine".into()
    } else if found {
        "its standard deviations are not known".into()
    } else if !result.quality.points.is_empty() {
        "its points were measured with this calibration: give a recording of masks or videos".into()
    } else if cameras < 3 {
        format!(
            "it has {cameras} cameras, and how far away a person stands is told by those that look from elsewhere: expected three or more around the person"
        )
    } else {
        "no camera has two others that look across its line of sight by more than 20°, or the body is held: expected three or more cameras around a person who moves".into()
    }
}

fn refined(told: Vec<Told>) -> Result<RefinedRig, CalibrateError> {
    let rig = united(&told)?;
    let position = |name: &String| rig.by_name(name).map_or(0, |(id, _)| id.0);
    let evidence = |told: &Told| RigEvidence {
        cameras: told.names.iter().map(position).collect(),
        found: told.found.clone(),
        covariance: told.covariance.clone(),
    };
    let evidence: Vec<RigEvidence> = told.iter().map(evidence).collect();
    let estimate = rig_estimate(rig.cameras.len(), &evidence).map_err(|singular| {
        let why = "its covariance has no inverse".into();
        CalibrateError::NothingTold { path: told[singular.0].path.clone(), why }
    })?;

    let of_camera = |(i, camera): (usize, &Camera)| RefinedCamera {
        camera: camera.name.clone(),
        determined: estimate.determined[i].max(0.0),
        found: match why_kept(&camera.name, estimate.determined[i], &told) {
            Some(why) => Err(why),
            None => Ok(found(&camera.name, i, &estimate)),
        },
    };
    let cameras: Vec<RefinedCamera> = rig.cameras.iter().enumerate().map(of_camera).collect();
    if cameras.iter().all(|camera| camera.found.is_err()) {
        return Err(CalibrateError::NothingDetermined);
    }

    let note = |(recording, camera): &(usize, usize)| {
        format!(
            "{}: says surely something else of {} than the recordings together: was it touched between them?",
            told[*recording].path.display(),
            rig.cameras[*camera].name
        )
    };
    let used = |told: &Told| UsedRecording {
        path: told.path.clone(),
        frames: told.frames,
        cameras: told.names.len(),
    };
    Ok(RefinedRig {
        notes: estimate.disagreeing.iter().map(note).collect(),
        recordings: told.iter().map(used).collect(),
        rig: moved(&rig, &cameras),
        options: told[0].options.clone(),
        cameras,
    })
}

/// The cameras of all recordings, which must have the same calibration.
fn united(told: &[Told]) -> Result<Rig, CalibrateError> {
    let mut rig = Rig::default();
    let mut from: Vec<&Path> = Vec::new();
    for recording in told {
        for camera in &recording.rig.cameras {
            match rig.by_name(&camera.name) {
                None => {
                    rig.cameras.push(camera.clone());
                    from.push(&recording.path);
                }
                Some((id, known)) if !is_same(known, camera) => {
                    return Err(CalibrateError::TwoCalibrations {
                        camera: camera.name.clone(),
                        first: from[id.0].into(),
                        second: recording.path.clone(),
                    });
                }
                Some(_) => {}
            }
        }
    }
    Ok(rig)
}

fn is_same(a: &Camera, b: &Camera) -> bool {
    let turned = a.camera_from_world.rotation.angle_to(&b.camera_from_world.rotation);
    let moved =
        (a.camera_from_world.translation.vector - b.camera_from_world.translation.vector).norm();
    // the angle of two rotations is no surer than the root of rounding
    moved < SAME
        && turned < 10.0 * SAME.sqrt() * SAME.sqrt().sqrt()
        && a.intrinsics == b.intrinsics
        && a.distortion == b.distortion
}

/// Why a camera keeps its calibration, if it does.
fn why_kept(name: &String, determined: f64, told: &[Told]) -> Option<String> {
    if !told.iter().any(|told| told.seeing.contains(name)) {
        return Some("it sees nobody".into());
    }
    if !told.iter().any(|told| told.names.contains(name)) {
        return Some("no two others look across its line of sight".into());
    }
    (determined < LEAST_DETERMINED).then(|| {
        format!(
            "the motion determines {determined:.1} of its {POSE} numbers, the calibration the rest"
        )
    })
}

/// By how much a camera was found to be off.
fn found(name: &str, i: usize, estimate: &RigEstimate) -> Refined {
    let three = |first: usize| {
        let first = POSE * i + first;
        [0, 1, 2].map(|k| estimate.found[first + k])
    };
    let sd = |first: usize| {
        let first = POSE * i + first;
        [0, 1, 2].map(|k| estimate.covariance[(first + k, first + k)].max(0.0).sqrt())
    };
    let zoom = estimate.found[POSE * i + ZOOM].exp();
    let variance = estimate.covariance[(POSE * i + ZOOM, POSE * i + ZOOM)];
    Refined {
        camera: name.into(),
        turn_deg: three(0).map(f64::to_degrees),
        turn_sd_deg: sd(0).map(f64::to_degrees),
        displacement_m: three(3),
        displacement_sd_m: sd(3),
        zoom,
        zoom_sd: zoom * variance.max(0.0).sqrt(),
    }
}

/// The cameras where they were found to be.
fn moved(rig: &Rig, cameras: &[RefinedCamera]) -> Rig {
    let offset = |camera: &RefinedCamera| match &camera.found {
        Err(_) => CameraOffset::none(),
        Ok(found) => CameraOffset {
            turn: UnitQuaternion::from_scaled_axis(
                Vector3::from(found.turn_deg).map(f64::to_radians),
            ),
            displacement_m: found.displacement_m.into(),
            log_zoom: found.zoom.ln(),
            ..CameraOffset::none()
        },
    };
    CameraOffset::applied(rig, cameras.iter().map(offset))
}
