//! What the fits of the windows say of each camera's clock.

use super::{FoundOffset, WINDOW};
use crate::pipeline::{ClockLine, Drift, TOLD_PPM, WindowClock, clock_line};
use crate::workflow::fitted_source::FittedSource;

/// The first camera whose clock some window tells, with its standard deviation, and that sees somebody.
pub(super) fn reference(fits: &[FittedSource]) -> Option<usize> {
    let cameras = 0..fits[0].result.quality.cameras.len();
    let is_told = |fit: &FittedSource, i: usize| {
        let camera = &fit.result.quality.cameras[i];
        let has_covariance = fit.result.quality.clocks_covariance.is_some();
        has_covariance && camera.frames > 0 && camera.found.clock.is_some()
    };
    cameras.into_iter().find(|i| fits.iter().any(|fit| is_told(fit, *i)))
}

/// By how much a camera's clock is ahead of the reference's in each window: of a difference the variance is Σ_cc + Σ_rr − 2Σ_cr.
pub(super) fn clocks(fits: &[FittedSource], camera: usize, reference: usize) -> Vec<WindowClock> {
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
pub(super) fn found_offset(
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
pub(super) fn why_no_drift(fits: &[FittedSource], lines: &[ClockLine]) -> Option<String> {
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
pub(super) fn why_nothing(source: &FittedSource) -> &'static str {
    let result = &source.result;
    if !source.asks_for_clocks() {
        "it was fitted with --clocks trust or --joint off: give the recording, or fit it with --clocks estimate"
    } else if !result.quality.points.is_empty() {
        "its points were measured by pictures of one moment: give a recording of masks or videos"
    } else {
        "no camera has another that looks across its line of sight by more than 20°, or the body is held: expected cameras around a person who moves"
    }
}
