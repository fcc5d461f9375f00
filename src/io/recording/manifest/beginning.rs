//! When a camera began, in frames of the recording.

/// By how many frames a camera began after the recording: whole frames shift the numbers of its files, and what is left, half a frame at
/// most, is where the estimate of its clock starts.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct Beginning(
    /// offset_frames + start_s · fps, within 1e15 as `check_clocks` has it.
    pub(crate) f64,
);

impl Beginning {
    /// Added to the numbers of the files.
    pub(crate) fn whole(self) -> i64 {
        self.0.round() as i64
    }

    /// By how many frames the pictures are ahead of the moments that their shifted numbers say.
    pub(crate) fn ahead_frames(self) -> f64 {
        self.0 - self.0.round()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn whole_frames_and_the_rest_make_the_beginning() {
        for (frames, whole) in [(3.0, 3), (2.6, 3), (-1.7, -2), (0.3, 0), (-1e10, -10_000_000_000)]
        {
            let beginning = Beginning(frames);
            assert_eq!(beginning.whole(), whole);
            approx::assert_relative_eq!(whole as f64 + beginning.ahead_frames(), frames);
            assert!(beginning.ahead_frames().abs() <= 0.5);
        }
    }
}
