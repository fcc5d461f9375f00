//! Which frame each picture of a video is.

/// Largest relative difference between an interval and the usual one in a video of steady rate.
const STEADY: f64 = 0.5;
/// Largest distance of a picture's time from a promised one, as a fraction of the interval between pictures.
const NEAR: f64 = 0.5;

/// How the time stamp of a picture becomes its number.
///
/// The decoder leaves out what it cannot decode, so pictures are not counted but known by their time: what is lost in
/// the middle does not shift what follows.
#[derive(Clone, Debug, PartialEq)]
pub(crate) enum Numbering {
    /// A steady rate, and every picture's time known: the k-th time is number k.
    Steady {
        /// Ascending, seconds.
        times_s: Vec<f64>,
    },
    /// A rate that varies: the number is (time − first)·rate, rounded, so that numbers keep to the clock of the recording.
    Clock {
        /// Ascending, seconds.
        times_s: Vec<f64>,
        /// Frames per second of the recording.
        rate_hz: f64,
    },
    /// Times unknown before decoding: the same as [`Numbering::Clock`], counted from the first picture that is decoded.
    Count {
        /// How many pictures are promised.
        pictures: usize,
        /// Pictures per second of the video.
        rate_hz: f64,
    },
}

impl Numbering {
    /// The numbering of pictures at these times; `rate_hz` is that of the recording.
    pub(super) fn from_times(mut times_s: Vec<f64>, rate_hz: f64) -> Self {
        times_s.sort_by(f64::total_cmp);
        let mut intervals: Vec<f64> = times_s.windows(2).map(|w| w[1] - w[0]).collect();
        intervals.sort_by(f64::total_cmp);
        let usual = intervals.get(intervals.len() / 2).copied().unwrap_or(0.0);
        let is_steady = |interval: &f64| (interval - usual).abs() <= STEADY * usual;
        if intervals.iter().all(is_steady) {
            Self::Steady { times_s }
        } else {
            Self::Clock { times_s, rate_hz }
        }
    }

    /// Numbers of the pictures that are promised, ascending, each once.
    pub(super) fn numbers(&self) -> Vec<u64> {
        let mut numbers: Vec<u64> = match self {
            Self::Steady { times_s } => (0..times_s.len() as u64).collect(),
            Self::Clock { times_s, .. } => {
                times_s.iter().filter_map(|t| self.number(*t, 0.0)).collect()
            }
            Self::Count { pictures, .. } => (0..*pictures as u64).collect(),
        };
        numbers.dedup();
        numbers
    }

    /// Number of the picture at a time, `first_s` being the time of the first picture that was decoded.
    ///
    /// `None` for one that is before the first or at no time that was promised.
    pub(super) fn number(&self, time_s: f64, first_s: f64) -> Option<u64> {
        match self {
            Self::Steady { times_s } => {
                let after = times_s.partition_point(|t| *t < time_s);
                let nearest = [after.checked_sub(1), Some(after)].into_iter().flatten();
                let distance =
                    |i: &usize| times_s.get(*i).map_or(f64::INFINITY, |t| (t - time_s).abs());
                let nearest = nearest.min_by(|a, b| distance(a).total_cmp(&distance(b)))?;
                let interval =
                    (times_s.last()? - times_s.first()?) / (times_s.len().max(2) - 1) as f64;
                (distance(&nearest) <= NEAR * interval.max(1e-3)).then_some(nearest as u64)
            }
            Self::Clock { times_s, rate_hz } => rounded((time_s - times_s.first()?) * rate_hz),
            Self::Count { rate_hz, .. } => rounded((time_s - first_s) * rate_hz),
        }
    }
}

fn rounded(number: f64) -> Option<u64> {
    let number = number.round();
    // beyond 2^53 no video reaches
    (0.0..9e15).contains(&number).then_some(number as u64)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_steady_video_is_numbered_by_its_order_however_its_times_are_rounded() {
        let times: Vec<f64> =
            (0..200).map(|k| (f64::from(k) * 1000.0 / 60.0).round() / 1000.0).collect();
        let numbering = Numbering::from_times(times.clone(), 60.0);
        assert!(matches!(numbering, Numbering::Steady { .. }));
        for (k, time) in times.iter().enumerate() {
            assert_eq!(numbering.number(*time, 0.0), Some(k as u64));
        }
        assert_eq!(numbering.number(-1.0, 0.0), None);
        assert_eq!(numbering.number(99.0, 0.0), None);
    }

    #[test]
    fn a_video_of_varying_rate_keeps_to_the_clock() {
        let numbering = Numbering::from_times(vec![1.0, 1.04, 1.08, 1.2, 1.205, 1.24], 25.0);
        assert_eq!(numbering.numbers(), [0, 1, 2, 5, 6]);
        assert_eq!(numbering.number(1.2, 0.0), Some(5));
    }

    #[test]
    fn pictures_without_known_times_are_numbered_from_the_first() {
        let numbering = Numbering::Count { pictures: 3, rate_hz: 50.0 };
        assert_eq!(numbering.numbers(), [0, 1, 2]);
        assert_eq!(numbering.number(0.1, 0.06), Some(2));
    }

    #[test]
    fn one_picture_or_none_is_no_fault() {
        assert_eq!(Numbering::from_times(vec![], 25.0).numbers(), [0; 0]);
        let one = Numbering::from_times(vec![3.0], 25.0);
        assert_eq!(one.number(3.0, 3.0), Some(0));
    }
}
