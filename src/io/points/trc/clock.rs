//! The columns Frame# and Time, which say when a row was recorded.

use std::path::Path;

use super::TrcError;
use crate::io::input::shortened;
use crate::math::stats::median;

/// How many numbers between the first row and the last may have no row.
const MOST_MISSING: usize = 100_000;

/// What a row says of itself.
#[derive(Debug, Clone, Copy)]
pub(super) struct Stamp {
    /// Line of the file, from 1.
    line: usize,
    /// Under Frame#.
    pub(super) number: usize,
    /// Under Time; `None` where that is empty.
    time_s: Option<f64>,
    /// The last decimal place of the time, s.
    resolution_s: f64,
}

impl Stamp {
    /// Reads the first two cells of a row.
    pub(super) fn read(cells: &[&str], line: usize, path: &Path) -> Result<Self, TrcError> {
        let cell = |i: usize| cells.get(i).copied().unwrap_or_default();
        let fault = |column, i| TrcError::Stamp {
            path: path.to_owned(),
            line,
            column,
            found: shortened(cell(i)),
        };

        // some programs write 1.0
        let number = cell(0).parse::<f64>().ok().filter(|n| n.fract() == 0.0 && *n >= 0.0);
        let number = number.ok_or_else(|| fault("Frame#", 0))? as usize;
        let time_s = match cell(1) {
            "" => None,
            text => Some(text.parse().ok().filter(|t: &f64| t.is_finite())),
        };
        if time_s == Some(None) {
            return Err(fault("Time", 1));
        }

        let decimals = cell(1).split_once('.').map_or("", |(_, decimals)| decimals);
        let decimals = decimals.chars().take_while(char::is_ascii_digit).count();
        let resolution_s = 0.1_f64.powi(decimals as i32);
        Ok(Self { line, number, time_s: time_s.flatten(), resolution_s })
    }

    /// Frames and seconds from another row to this.
    fn since(&self, other: &Self) -> (f64, Option<f64>) {
        let seconds = self.time_s.zip(other.time_s).map(|(now, then)| now - then);
        (self.number as f64 - other.number as f64, seconds)
    }
}

/// Checks that frame numbers and times grow together, and says how many frames a second has by the times.
///
/// A number that is left out with its time is a frame without points. `None` without times, or where all are one.
pub(super) fn check(stamps: &[Stamp], path: &Path) -> Result<Option<f64>, TrcError> {
    let pairs = || stamps.iter().zip(stamps.iter().skip(1));

    // numbers ascend, and most by one
    for (before, row) in pairs() {
        if row.number <= before.number {
            let (path, line) = (path.to_owned(), row.line);
            let (number, before) = (row.number, before.number);
            return Err(TrcError::Order { path, line, number, before });
        }
    }
    let usual = median(&mut pairs().map(|(before, row)| row.since(before).0).collect());
    let missing: usize = pairs().map(|(before, row)| row.number - before.number - 1).sum();
    let is_thinned = stamps.len() > 2 && usual.is_some_and(|usual| usual > 1.0);
    if is_thinned || missing > MOST_MISSING {
        return Err(TrcError::Missing { path: path.to_owned(), rows: stamps.len(), missing });
    }

    // times grow with them
    let steps = pairs().map(|(before, row)| row.since(before));
    let mut per_frame: Vec<f64> = steps.filter_map(|(n, seconds)| Some(seconds? / n)).collect();
    let Some(step_s) = median(&mut per_frame).filter(|_| per_frame.iter().any(|s| *s != 0.0))
    else {
        return Ok(None);
    };
    for (before, row) in pairs() {
        let (frames, seconds) = row.since(before);
        let error = seconds.map_or(0.0, |seconds| (seconds / step_s - frames).abs());
        // rounded times err by one in their last place
        let is_right = step_s > 0.0 && error <= 0.5_f64.max(row.resolution_s / step_s);
        if !is_right {
            return Err(TrcError::Time {
                path: path.to_owned(),
                line: row.line,
                number: row.number,
                before: before.number,
                found_s: seconds.unwrap_or(0.0),
                expected_s: step_s.max(0.0) * frames,
            });
        }
    }
    Ok(rate(stamps, step_s))
}

/// Times of three decimals err by up to half a millisecond in a step: the whole span does not.
fn rate(stamps: &[Stamp], step_s: f64) -> Option<f64> {
    let (frames, seconds) = stamps.last()?.since(stamps.first()?);
    let span_s = seconds.map(|seconds| seconds / frames);
    let is_close = |span_s: &f64| (span_s / step_s - 1.0).abs() < 0.1;
    Some(1.0 / span_s.filter(is_close).unwrap_or(step_s))
}
