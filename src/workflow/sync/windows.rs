//! The frames of a recording that are looked at, and their fits.

use std::path::Path;

use super::{SyncError, SyncOptions};
use crate::io::recording::Recording;
use crate::pipeline::{FrameRange, Progress};
use crate::silhouette::FrameIndex;
use crate::workflow::fitted_source::FittedSource;
use crate::workflow::{Error, FitOptions};

/// Frames of a window (E): two seconds at 50 Hz, one stride and more.
pub const WINDOW: usize = 100;
/// A recording of more windows than this is looked at in [`WINDOWS`] of them only.
const MOST_WHOLE: usize = 6;
/// Its beginning, its middle and its end.
const WINDOWS: usize = 3;

/// The windows of a recording, each fitted by itself; those that cannot be used are left out, if there are others.
pub(super) fn windows_fitted(
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
