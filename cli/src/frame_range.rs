//! `--frames FIRST:LAST`.

use std::fmt;
use std::ops::{Range, RangeInclusive};
use std::str::FromStr;

use super::error::CliError;
use maquette::silhouette::FrameIndex;

/// Frame numbers, both included.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct FrameRange {
    first: usize,
    last: usize,
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
    /// The numbers that are asked for.
    pub(super) fn numbers(self) -> RangeInclusive<usize> {
        self.first..=self.last
    }

    /// Where in a recording's frames (ascending) those lie that are asked for; all where nothing is.
    ///
    /// # Errors
    /// [`CliError::NoFrames`] if a range is asked for in which none lies, [`CliError::NoFrame`] if there is none at all.
    pub(super) fn positions(
        asked: Option<Self>,
        frames: &[FrameIndex],
    ) -> Result<Range<usize>, CliError> {
        let numbers = asked.map_or(0..=usize::MAX, Self::numbers);
        let first = frames.partition_point(|frame| frame.0 < *numbers.start());
        let end = frames.partition_point(|frame| frame.0 <= *numbers.end());
        match (frames, asked) {
            _ if first < end => Ok(first..end),
            ([all_first, ..], Some(range)) => Err(CliError::NoFrames {
                range: range.to_string(),
                first: all_first.0,
                last: frames.last().map_or(all_first.0, |frame| frame.0),
            }),
            _ => Err(CliError::NoFrame),
        }
    }

    /// The frames of a recording (ascending) that are asked for; all where nothing is.
    ///
    /// # Errors
    /// As [`FrameRange::positions`].
    pub(super) fn of(
        asked: Option<Self>,
        frames: &[FrameIndex],
    ) -> Result<&[FrameIndex], CliError> {
        Ok(&frames[Self::positions(asked, frames)?])
    }
}

/// The numbers from the first of some frames (ascending) to the last.
pub(super) fn span(frames: &[FrameIndex]) -> RangeInclusive<usize> {
    match (frames.first(), frames.last()) {
        (Some(first), Some(last)) => first.0..=last.0,
        // holds nothing
        _ => RangeInclusive::new(1, 0),
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
        let of = |first, last| FrameRange::of(Some(FrameRange { first, last }), &frames);
        assert_eq!(of(3, 6).unwrap(), &frames[1..3]);
        assert_eq!(of(8, 99).unwrap(), &frames[3..]);
        assert_eq!(FrameRange::of(None, &frames).unwrap(), &frames);
        let message = of(9, 12).unwrap_err().to_string();
        assert!(
            message.starts_with("--frames 9:12") && message.ends_with("2 to 8"),
            "{message}"
        );
        assert!(matches!(FrameRange::of(None, &[]), Err(CliError::NoFrame)));
        assert_eq!(span(&frames), 2..=8);
    }
}
