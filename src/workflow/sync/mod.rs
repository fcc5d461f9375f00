//! When each camera of a recording began, found from the person, and from sound as a check.
//!
//! | file         | holds                                                        |
//! |--------------|--------------------------------------------------------------|
//! | `windows.rs` | the frames that are looked at, and their fits                |
//! | `clocks.rs`  | what the fits say of each clock                              |
//! | `sound.rs`   | what the videos' sound says                                  |

mod clocks;
mod sound;
mod windows;

use std::path::{Path, PathBuf};

use super::fitted_source::{FittedSource, is_fit};
use super::{Error, FitOptions};
use crate::io::folder::write_atomically;
use crate::io::recording::offsets::{CameraOffsetFrames, OFFSETS, Offsets};
use crate::pipeline::{ClockLine, Clocks, Drift, Progress, clock_line};
use clocks::{clocks, found_offset, reference, why_no_drift, why_nothing};
use windows::windows_fitted;

pub use windows::WINDOW;

/// Why no camera's clock can be found.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum SyncError {
    /// A recording that tells no camera's clock.
    #[error("{}: no camera's clock can be told: {why}", path.display())]
    NothingTold {
        /// The recording.
        path: PathBuf,
        /// Why.
        why: &'static str,
    },
    /// More windows than a recording has room for.
    #[error(
        "{}: {frames} frames: expected {least} or more for {windows} windows of {WINDOW} frames that do not overlap", path.display()
    )]
    TooShort {
        /// The recording.
        path: PathBuf,
        /// Its frames.
        frames: usize,
        /// How many it needs.
        least: usize,
        /// For so many windows.
        windows: usize,
    },
}

/// How a recording's clocks are found.
#[derive(Debug, Clone, Default)]
pub struct SyncOptions {
    /// The fits.
    pub fit: FitOptions,
    /// Windows of [`WINDOW`] frames that are looked at, evenly over the recording. `None`: the whole recording up to six
    /// times as long, else three windows.
    pub windows: Option<usize>,
    /// Whether the sound of videos is listened to.
    pub sound: bool,
}

/// When the cameras of a recording began.
#[derive(Debug)]
pub struct SyncedRecording {
    /// Frames per second.
    pub fps: f64,
    /// The camera whose clock is the recording's: what all clocks have in common does not show, so it keeps its offset and the others are
    /// told against it.
    pub reference: String,
    /// First and last frame of each window.
    pub windows: Vec<[usize; 2]>,
    /// Camera by camera.
    pub cameras: Vec<SyncedCamera>,
    /// Why no drift is told; `None` where one is.
    pub no_drift: Option<String>,
    /// What should be known, each in one line.
    pub notes: Vec<String>,
    folder: PathBuf,
}

/// When a camera began.
#[derive(Debug)]
pub struct SyncedCamera {
    /// Its name.
    pub camera: String,
    /// By how many frames it was taken to begin after the recording.
    pub was_frames: f64,
    /// What was found; `Err` says why it keeps that.
    pub found: Result<FoundOffset, &'static str>,
    /// What its sound says.
    pub sound: Option<SoundCheck>,
}

/// What was found of a camera's clock.
#[derive(Debug, Clone, Copy)]
pub struct FoundOffset {
    /// By how many frames it began after the recording, in the middle of the windows.
    pub offset_frames: f64,
    /// Standard deviation.
    pub sd_frames: f64,
    /// How its clock runs against the others'; only where that is known well enough to be told.
    pub drift: Option<Drift>,
}

/// What the sound of a video says, against the first camera's that has one.
#[derive(Debug, Clone)]
pub struct SoundCheck {
    /// The camera that it is compared with.
    pub against: String,
    /// By how many frames it began after that camera.
    pub after_frames: f64,
    /// Standard deviation: sound takes its time from one camera to the other.
    pub sd_frames: f64,
    /// Whether what the pictures say agrees.
    pub agrees: bool,
}

impl SyncedRecording {
    /// Finds the clocks of a recording, or reads them from the folder of a finished fit of it.
    ///
    /// # Errors
    /// [`SyncError`] in words, [`Error::Unusable`] for a fit that cannot be used, and whatever a fit fails with.
    pub fn of(
        path: &Path,
        fps: Option<f64>,
        options: &SyncOptions,
        progress: &dyn Progress,
    ) -> Result<Self, Error> {
        let mut fit = options.fit.clone();
        fit.estimate.clocks = Clocks::Estimate;

        let fits = match is_fit(path) {
            true => vec![FittedSource::open(path, fps, &fit, progress)?],
            false => windows_fitted(path, fps, &SyncOptions { fit, ..options.clone() }, progress)?,
        };
        let reference = reference(&fits).ok_or_else(|| SyncError::NothingTold {
            path: path.into(),
            why: why_nothing(&fits[0]),
        })?;
        let mut synced = Self::from_fits(&fits, reference);
        let is_told = |(i, camera): (usize, &SyncedCamera)| i != reference && camera.found.is_ok();
        if !synced.cameras.iter().enumerate().any(is_told) {
            let why =
                "none sees the person together with another that looks across its line of sight";
            return Err(SyncError::NothingTold { path: path.into(), why }.into());
        }
        if options.sound {
            synced.listen(&fits[0].recording, progress)?;
        }
        Ok(synced)
    }

    /// What the fits of the windows say together.
    fn from_fits(fits: &[FittedSource], reference: usize) -> Self {
        let first = &fits[0].result;
        let fps = first.recording.fps;
        let camera = |i: usize| SyncedCamera {
            camera: first.quality.cameras[i].camera.clone(),
            was_frames: first.recording.offset_frames.get(i).copied().unwrap_or(0.0),
            found: found_offset(fits, i, reference),
            sound: None,
        };
        let cameras: Vec<SyncedCamera> = (0..first.quality.cameras.len()).map(camera).collect();
        let of_window = |fit: &FittedSource| {
            [fit.result.recording.first_frame, fit.result.recording.last_frame]
        };
        let lines: Vec<ClockLine> = (0..cameras.len())
            .filter(|i| *i != reference)
            .filter_map(|i| clock_line(&clocks(fits, i, reference)))
            .collect();
        Self {
            fps,
            reference: cameras[reference].camera.clone(),
            windows: fits.iter().map(of_window).collect(),
            no_drift: why_no_drift(fits, &lines),
            cameras,
            notes: Vec::new(),
            folder: fits[0].recording.folder().into(),
        }
    }

    /// The file that the recording reads when each camera began from.
    pub fn file(&self) -> PathBuf {
        self.folder.join(OFFSETS)
    }

    /// Writes when each camera began: those of which nothing was told as they were.
    ///
    /// # Errors
    /// [`Error::Out`].
    pub fn write(&self, path: &Path) -> Result<(), Error> {
        let rounded = |frames: f64| (1e4 * frames).round() / 1e4;
        let camera = |camera: &SyncedCamera| {
            let found = camera.found.ok();
            CameraOffsetFrames {
                name: camera.camera.clone(),
                offset_frames: rounded(
                    found.map_or(camera.was_frames, |found| found.offset_frames),
                ),
                sd_frames: found.map(|found| rounded(found.sd_frames)),
            }
        };
        let offsets = Offsets { fps: self.fps, cameras: self.cameras.iter().map(camera).collect() };
        Ok(write_atomically(path, offsets.text().as_bytes())?)
    }
}
