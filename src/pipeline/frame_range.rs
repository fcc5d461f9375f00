//! Which frames of a recording are meant: `FIRST:LAST`.

use std::fmt;
use std::ops::{Range, RangeInclusive};
use std::str::FromStr;

use crate::silhouette::FrameIndex;

/// Frame numbers, both included; every frame by default.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct FrameRange {
    /// Number of the first frame.
    pub first: usize,
    /// Number of the last.
    pub last: usize,
}

/// Why a range holds no frame of a recording.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum FrameRangeError {
    /// A recording of nothing.
    #[error("the recording has no frame")]
    NoFrame,
    /// No frame of the recording is in the range.
    #[error(
        "--frames {range}: no frame of the recording lies in this range: it has {first} to {last}"
    )]
    OutOfRange {
        /// The range that was asked for.
        range: FrameRange,
        /// First frame of the recording.
        first: usize,
        /// Last frame of the recording.
        last: usize,
    },
}

impl Default for FrameRange {
    fn default() -> Self {
        Self { first: 0, last: usize::MAX }
    }
}

impl FromStr for FrameRange {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let parsed = text.split_once(':').and_then(|(first, last)| {
            let (first, last) = (first.trim().parse().ok()?, last.trim().parse().ok()?);
            (first <= last).then_some(Self { first, last })
        });
        parsed.ok_or_else(|| "expected FIRST:LAST, two frame numbers in order".into())
    }
}

impl fmt::Display for FrameRange {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}:{}", self.first, self.last)
    }
}

impl FrameRange {
    /// The numbers in the range.
    pub fn numbers(self) -> RangeInclusive<usize> {
        self.first..=self.last
    }

    fn spanning(frames: &[FrameIndex]) -> Option<Self> {
        Some(Self { first: frames.first()?.0, last: frames.last()?.0 })
    }

    /// Where the frames of the range stand in a recording's frames (ascending).
    ///
    /// # Errors
    /// [`FrameRangeError`] if none of them lies in the range.
    pub fn positions(self, frames: &[FrameIndex]) -> Result<Range<usize>, FrameRangeError> {
        let first = frames.partition_point(|frame| frame.0 < self.first);
        let end = frames.partition_point(|frame| frame.0 <= self.last);
        match Self::spanning(frames) {
            None => Err(FrameRangeError::NoFrame),
            Some(_) if first < end => Ok(first..end),
            Some(all) => {
                Err(FrameRangeError::OutOfRange { range: self, first: all.first, last: all.last })
            }
        }
    }

    /// The frames of a recording (ascending) that lie in the range.
    ///
    /// # Errors
    /// As [`FrameRange::positions`].
    pub fn select(self, frames: &[FrameIndex]) -> Result<&[FrameIndex], FrameRangeError> {
        Ok(&frames[self.positions(frames)?])
    }
}

/// The numbers from the first of some frames (ascending) to the last; none without a frame.
pub fn span(frames: &[FrameIndex]) -> RangeInclusive<usize> {
    match FrameRange::spanning(frames) {
        Some(all) => all.numbers(),
        None => RangeInclusive::new(1, 0),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_range_of_frames_is_two_numbers_in_order() {
        let range = FrameRange { first: 3, last: 7 };
        assert_eq!("3:7".parse(), Ok(range));
        for text in ["7:3", "3", "3:", ":", "a:b", "-1:4"] {
            assert!(text.parse::<FrameRange>().is_err(), "{text}");
        }
    }

    #[test]
    fn a_range_takes_the_frames_that_lie_in_it_and_names_those_there_are_where_none_does() {
        let frames = [2, 4, 6, 8].map(FrameIndex);
        let select = |first, last| FrameRange { first, last }.select(&frames);
        assert_eq!(select(3, 6).unwrap(), &frames[1..3]);
        assert_eq!(select(8, 99).unwrap(), &frames[3..]);
        assert_eq!(FrameRange::default().select(&frames).unwrap(), &frames);
        let message = select(9, 12).unwrap_err().to_string();
        assert!(message.starts_with("--frames 9:12") && message.ends_with("2 to 8"), "{message}");
        let nothing = FrameRange::default().select(&[]);
        assert_eq!(nothing, Err(FrameRangeError::NoFrame));
        assert_eq!(span(&frames), 2..=8);
        assert!(span(&[]).is_empty());
    }
}
