//! When each camera of a recording began, found from the person, and from sound as a check.

use std::path::{Path, PathBuf};

use super::fitted_source::{FittedSource, is_fit};
use super::{Error, FitOptions};
use crate::camera::Rig;
use crate::io::folder::write_atomically;
use crate::io::recording::Recording;
use crate::io::recording::footage::{Loudness, Source};
use crate::io::recording::offsets::{CameraOffsetFrames, OFFSETS, Offsets};
use crate::pipeline::{
    ClockLine, Clocks, Drift, FrameRange, Progress, TOLD_PPM, WindowClock, clock_line,
    sound_delay_s,
};
use crate::silhouette::FrameIndex;

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

/// Frames of a window (E): two seconds at 50 Hz, one stride and more.
pub const WINDOW: usize = 100;
/// A recording of more windows than this is looked at in [`WINDOWS`] of them only.
const MOST_WHOLE: usize = 6;
/// Its beginning, its middle and its end.
const WINDOWS: usize = 3;
/// Metres that sound travels in a second, at 20 °C.
const SOUND_M_S: f64 = 343.0;
/// The sound of a video begins within one of its steps.
const SOUND_STEP_S: f64 = 0.001;
/// Delays of sound that are looked for, seconds.
const MOST_DELAY_S: f64 = 60.0;
/// What differs by more standard deviations does not agree.
const SURE: f64 = 3.0;

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

    /// Compares the sound of the videos, if there is any.
    fn listen(&mut self, recording: &Recording, progress: &dyn Progress) -> Result<(), Error> {
        // masks alone make no sound
        let Ok(footage) = recording.footage() else {
            return Ok(());
        };
        progress.begin("sound", footage.cameras.len());
        let mut heard: Vec<(String, Loudness)> = Vec::new();
        for (name, camera) in footage.rig.names().zip(&footage.cameras) {
            if let Source::Video { path, .. } = &camera.source
                && let Some(loudness) =
                    Loudness::of(path).map_err(crate::io::recording::RecordingError::from)?
            {
                heard.push((name.into(), loudness));
            }
            progress.step();
        }
        progress.end();
        let Some(((against, first), others)) = heard.split_first() else {
            return Ok(());
        };
        for (name, loudness) in others {
            self.compare((against, first), (name, loudness), &footage.rig);
        }
        Ok(())
    }

    fn compare(
        &mut self,
        (against, a): (&String, &Loudness),
        (name, b): (&String, &Loudness),
        rig: &Rig,
    ) {
        let Some(delay_s) = sound_delay_s(&a.energy, &b.energy, MOST_DELAY_S) else {
            self.notes.push(format!(
                "camera {name}: its sound tells nothing against {against}'s: no delay is distinct"
            ));
            return;
        };
        // what is heard later in a video began earlier
        let after_frames = -(delay_s + b.start_s - a.start_s) * self.fps;
        let centre = |name: &str| rig.by_name(name).map(|(_, camera)| camera.centre_world());
        let apart_m = centre(name).zip(centre(against)).map_or(0.0, |(a, b)| (a - b).norm());
        // from wherever it comes, it is later in one of them by no more than the way between them
        let travel_s = apart_m / SOUND_M_S / 3.0_f64.sqrt();
        let sd_frames = travel_s.hypot(SOUND_STEP_S) * self.fps;

        let of = |name: &str| self.cameras.iter().find(|camera| camera.camera == name);
        let began = |name: &str| {
            let camera = of(name)?;
            let was = (camera.was_frames, 0.0);
            Some(camera.found.map_or(was, |found| (found.offset_frames, found.sd_frames)))
        };
        let Some((own, other)) = began(name).zip(began(against)) else {
            return;
        };
        let difference = own.0 - other.0 - after_frames;
        let check = SoundCheck {
            against: against.clone(),
            after_frames,
            sd_frames,
            agrees: difference.abs() <= SURE * own.1.hypot(other.1).hypot(sd_frames),
        };
        let camera = self.cameras.iter_mut().find(|camera| camera.camera == *name);
        camera.into_iter().for_each(|camera| camera.sound = Some(check.clone()));
    }
}

/// The windows of a recording, each fitted by itself; those that cannot be used are left out, if there are others.
fn windows_fitted(
    path: &Path,
    fps: Option<f64>,
    options: &SyncOptions,
    progress: &dyn Progress,
) -> Result<Vec<FittedSource>, Error> {
    let recording = Recording::open(path)?.with_fps(fps);
    let (mut fits, mut unusable) = (Vec::new(), None);
    for frames in windows(&recording, path, options)? {
        let source =
            FittedSource::fit(&recording, &FitOptions { frames, ..options.fit.clone() }, progress)?;
        match source.result.verdict.why_unusable() {
            None => fits.push(source),
            Some(why) => {
                progress.note(&format!("frames {frames}: left out: {why}"));
                unusable.get_or_insert(Error::Unusable(format!("{}: {why}", path.display())));
            }
        }
    }
    match unusable {
        Some(fault) if fits.is_empty() => Err(fault),
        _ => Ok(fits),
    }
}

/// The frames of each window.
fn windows(
    recording: &Recording,
    path: &Path,
    options: &SyncOptions,
) -> Result<Vec<FrameRange>, Error> {
    let all: Vec<FrameIndex> = match recording.observations() {
        Ok(files) => files.frames,
        Err(fault) => recording.footage().map(|footage| footage.frames()).map_err(|_| fault)?,
    };
    let wanted = options.fit.frames.select(&all)?;
    let count = match options.windows {
        None if wanted.len() <= MOST_WHOLE * WINDOW => return Ok(vec![options.fit.frames]),
        None => WINDOWS,
        Some(count) => count,
    };
    let (frames, least) = (wanted.len(), count * WINDOW);
    if frames < least {
        let path = path.into();
        return Err(SyncError::TooShort { path, frames, least, windows: count }.into());
    }
    Ok(spread(wanted, count))
}

/// So many windows, evenly from the first frame to the last; one is in the middle. There are enough frames.
fn spread(frames: &[FrameIndex], count: usize) -> Vec<FrameRange> {
    let room = frames.len() - WINDOW;
    let first = |w: usize| match count {
        1 => room / 2,
        _ => w * room / (count - 1),
    };
    let window =
        |w: usize| FrameRange { first: frames[first(w)].0, last: frames[first(w) + WINDOW - 1].0 };
    (0..count).map(window).collect()
}

/// The first camera whose clock some window tells, with its standard deviation, and that sees somebody.
fn reference(fits: &[FittedSource]) -> Option<usize> {
    let cameras = 0..fits[0].result.quality.cameras.len();
    let is_told = |fit: &FittedSource, i: usize| {
        let camera = &fit.result.quality.cameras[i];
        let has_covariance = fit.result.quality.clocks_covariance.is_some();
        has_covariance && camera.frames > 0 && camera.found.clock.is_some()
    };
    cameras.into_iter().find(|i| fits.iter().any(|fit| is_told(fit, *i)))
}

/// By how much a camera's clock is ahead of the reference's in each window: of a difference the variance is Σ_cc + Σ_rr − 2Σ_cr.
fn clocks(fits: &[FittedSource], camera: usize, reference: usize) -> Vec<WindowClock> {
    let clock = |fit: &FittedSource| {
        let (recording, quality) = (&fit.result.recording, &fit.result.quality);
        let ahead_s = |i: usize| Some(quality.cameras.get(i)?.found.clock?.ahead_s);
        let row = |i: usize| {
            let before = quality.cameras[..i].iter();
            before.filter(|camera| camera.found.clock.is_some()).count()
        };
        let covariance = quality.clocks_covariance.as_ref()?;
        let (c, r) = (row(camera), row(reference));
        let off_s = ahead_s(camera)? - ahead_s(reference)?;
        let variance = covariance[c][c] + covariance[r][r] - 2.0 * covariance[c][r];
        let middle = 0.5 * (recording.first_frame + recording.last_frame) as f64;
        let sd_s = variance.max(0.0).sqrt();
        (sd_s > 0.0).then_some(WindowClock { middle_s: middle / recording.fps, off_s, sd_s })
    };
    fits.iter().filter_map(clock).collect()
}

/// When a camera began, or why that is not told.
fn found_offset(
    fits: &[FittedSource],
    camera: usize,
    reference: usize,
) -> Result<FoundOffset, &'static str> {
    let result = &fits[0].result;
    let was = |i: usize| result.recording.offset_frames.get(i).copied().unwrap_or(0.0);
    if camera == reference {
        return Ok(FoundOffset { offset_frames: was(camera), sd_frames: 0.0, drift: None });
    }
    if fits.iter().all(|fit| fit.result.quality.cameras[camera].frames == 0) {
        return Err("it sees nobody");
    }
    let line = clock_line(&clocks(fits, camera, reference));
    let line = line.ok_or("no other camera looks across its line of sight")?;
    let fps = result.recording.fps;
    // the files were moved by whole frames, and the estimate holds the rest
    let of_reference = was(reference) - was(reference).round();
    Ok(FoundOffset {
        offset_frames: was(camera).round() + line.off_s * fps + of_reference,
        sd_frames: line.sd_s * fps,
        drift: line.drift.filter(Drift::is_told),
    })
}

/// Why nothing is told of drift, if nothing is.
fn why_no_drift(fits: &[FittedSource], lines: &[ClockLine]) -> Option<String> {
    let drifts: Vec<&Drift> = lines.iter().filter_map(|line| line.drift.as_ref()).collect();
    if fits.len() < 2 || drifts.is_empty() {
        return Some(format!(
            "too short to tell drift: it takes two windows of {WINDOW} frames or more, far apart (--windows 2)"
        ));
    }
    if drifts.iter().any(|drift| drift.is_told()) {
        return None;
    }
    let best = drifts.iter().map(|drift| drift.sd_ppm).fold(f64::INFINITY, f64::min);
    let (first, last) = (&fits[0].result.recording, &fits[fits.len() - 1].result.recording);
    let span_s = (last.last_frame - first.first_frame) as f64 / first.fps;
    Some(format!(
        "too short to tell drift: {span_s:.0} s tell it within {best:.0} ppm, and clocks of cameras drift by {TOLD_PPM:.0} ppm or less; it takes about {:.0} s",
        span_s * best / TOLD_PPM
    ))
}

/// Why a fit says nothing of its cameras' clocks.
fn why_nothing(source: &FittedSource) -> &'static str {
    let result = &source.result;
    if !source.asks_for_clocks() {
        "it was fitted with --clocks trust or --joint off: give the recording, or fit it with --clocks estimate"
    } else if !result.quality.points.is_empty() {
        "its points were measured by pictures of one moment: give a recording of masks or videos"
    } else {
        "no camera has another that looks across its line of sight by more than 20°, or the body is held: expected cameras around a person who moves"
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn windows_reach_from_the_first_frame_to_the_last_and_do_not_overlap() {
        let frames: Vec<FrameIndex> = (7..707).map(FrameIndex).collect();
        let range = |first, last| FrameRange { first, last };
        assert_eq!(spread(&frames, 1), [range(307, 406)]);
        assert_eq!(spread(&frames, 3), [range(7, 106), range(307, 406), range(607, 706)]);
        let seven = spread(&frames, 7);
        assert!(seven.windows(2).all(|pair| pair[0].last < pair[1].first), "{seven:?}");
    }
}
