//! What gait analysis works on: places of the body over time, and what is known beyond them.

use std::collections::BTreeMap;

use nalgebra::{Point3, Vector3};
use serde::Serialize;

use super::filter;
use super::landmark::{Landmark, Paired, Side};
use super::segments::Segments;

/// A place of the body over time; NaN where it is not known.
pub type Track = Vec<Vector3<f64>>;

/// A name of the file, and what was taken for it.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Used {
    /// The place.
    pub landmark: Landmark,
    /// Its name in the file, or how it was found.
    pub from: String,
}

/// A moving body. World: metres, Z up.
#[derive(Debug, Clone, PartialEq)]
pub struct Recording {
    /// Frames per second.
    pub rate_hz: f64,
    /// Number of the first frame.
    pub first_frame: usize,
    /// Number of frames.
    pub frames: usize,
    /// Places over time.
    pub tracks: BTreeMap<Landmark, Track>,
    /// Standard deviations of the places, world axes, metres; empty if nothing is known of them.
    pub sd_m: BTreeMap<Landmark, Track>,
    /// The same of the way from a left place to the right one in the same frame.
    pub apart_sd_m: BTreeMap<Paired, Track>,
    /// Orientations of the body's parts, of a fitted body.
    pub segments: Option<Segments>,
    /// What each place was taken from.
    pub used: Vec<Used>,
}

/// Why a recording cannot be analysed.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum RecordingError {
    /// A place without which there is nothing to be said.
    #[error("no point is named as the {missing}: expected names such as {example}, found {found}")]
    Missing {
        /// The place.
        missing: String,
        /// A name that would do.
        example: &'static str,
        /// The first names that are there.
        found: String,
    },
    /// Too few frames.
    #[error("{frames} frames: expected at least {fewest}")]
    Short {
        /// Found.
        frames: usize,
        /// Needed.
        fewest: usize,
    },
    /// A body of an impossible size.
    #[error(
        "the legs would be {length_m:.4} m long (hip to knee to ankle): expected 0.2 to 1.5 m; does the file state the right unit?"
    )]
    Size {
        /// Found.
        length_m: f64,
    },
}

/// Fewest frames in which anything can be seen.
const FEWEST_FRAMES: usize = 10;

impl Recording {
    /// A recording of named points: joint centres or markers of any of the known sets.
    ///
    /// Of two names of one place the better one is taken; gaps of up to 0.1 s are bridged; joint centres are the middle
    /// of a lateral and a medial marker where both are there; hips that are not there are found from the pelvis, and
    /// heels from the foot.
    ///
    /// # Errors
    /// [`RecordingError`] where hips, knees, ankles or toes cannot be found, or the size cannot be a body's.
    pub fn of_points(
        rate_hz: f64,
        first_frame: usize,
        names: &[String],
        frames: &[Vec<Option<Point3<f64>>>],
    ) -> Result<Self, RecordingError> {
        if frames.len() < FEWEST_FRAMES {
            let (frames, fewest) = (frames.len(), FEWEST_FRAMES);
            return Err(RecordingError::Short { frames, fewest });
        }
        let mut recording = Self {
            rate_hz,
            first_frame,
            frames: frames.len(),
            tracks: BTreeMap::new(),
            sd_m: BTreeMap::new(),
            apart_sd_m: BTreeMap::new(),
            segments: None,
            used: Vec::new(),
        };
        for (landmark, column) in columns(names) {
            let place = |frame: &Vec<Option<Point3<f64>>>| match frame.get(column) {
                Some(Some(point)) => point.coords,
                _ => Vector3::repeat(f64::NAN),
            };
            let track: Track = frames.iter().map(place).collect();
            if track.iter().any(|p| p.x.is_finite()) {
                recording.insert(landmark, bridged(&track, rate_hz), names[column].clone());
            }
        }
        recording.complete();
        recording.check(names)?;
        Ok(recording)
    }

    pub(super) fn insert(&mut self, landmark: Landmark, track: Track, from: String) {
        self.tracks.insert(landmark, track);
        self.used.push(Used { landmark, from });
    }

    /// A place over time.
    pub fn track(&self, landmark: Landmark) -> Option<&Track> {
        self.tracks.get(&landmark)
    }

    /// A place of one side over time.
    pub fn of(&self, side: Side, place: Paired) -> Option<&Track> {
        self.track(Landmark::Of(side, place))
    }

    /// Whether a marker was on the heel, as opposed to one that is fixed to the foot of a mean body.
    pub(super) fn has_heel_marker(&self, side: Side) -> bool {
        let heel = Landmark::Of(side, Paired::Heel);
        let is_made = |u: &Used| u.from.starts_with("ankle and toe");
        self.used.iter().any(|u| u.landmark == heel && !is_made(u))
    }

    fn check(&self, names: &[String]) -> Result<(), RecordingError> {
        let needed = [
            (Paired::Hip, "RHip and LHip, or RASI LASI RPSI LPSI"),
            (Paired::Knee, "RKnee and LKnee"),
            (Paired::Ankle, "RAnkle and LAnkle"),
            (Paired::Toe, "RBigToe and LBigToe, or R.Toe and L.Toe"),
        ];
        for (place, example) in needed {
            for side in Side::BOTH {
                if self.of(side, place).is_none() {
                    return Err(RecordingError::Missing {
                        missing: Landmark::Of(side, place).name(),
                        example,
                        found: first_of(names),
                    });
                }
            }
        }
        match self.leg_length() {
            Some(length_m) if !(0.2..1.5).contains(&length_m) => {
                Err(RecordingError::Size { length_m })
            }
            _ => Ok(()),
        }
    }

    /// Hip to knee to ankle, mean of both sides, median over time; metres.
    pub fn leg_length(&self) -> Option<f64> {
        let mut lengths = Vec::new();
        for side in Side::BOTH {
            let (hip, knee) = (self.of(side, Paired::Hip)?, self.of(side, Paired::Knee)?);
            let ankle = self.of(side, Paired::Ankle)?;
            let length = |i: usize| (hip[i] - knee[i]).norm() + (knee[i] - ankle[i]).norm();
            let mut all: Vec<f64> = (0..self.frames).map(length).collect();
            lengths.push(crate::math::stats::median(&mut all)?);
        }
        Some(0.5 * (lengths[0] + lengths[1]))
    }
}

/// The best column for each place that the names know.
fn columns(names: &[String]) -> BTreeMap<Landmark, usize> {
    let mut best: BTreeMap<Landmark, (usize, usize)> = BTreeMap::new();
    for (column, name) in names.iter().enumerate() {
        if let Some((landmark, rank)) = Landmark::of_name(name) {
            let entry = best.entry(landmark).or_insert((rank, column));
            if rank < entry.0 {
                *entry = (rank, column);
            }
        }
    }
    best.into_iter()
        .map(|(l, (_, column))| (l, column))
        .collect()
}

fn first_of(names: &[String]) -> String {
    match names {
        [] => "no names".into(),
        [first @ .., _] if names.len() > 6 => format!("{} …", first[..6].join(" ")),
        _ => names.join(" "),
    }
}

/// Short gaps bridged, axis by axis.
fn bridged(track: &Track, rate_hz: f64) -> Track {
    by_axis(track, |values| {
        let mut values = values.to_vec();
        filter::bridge(&mut values, rate_hz);
        values
    })
}

/// A track after something was done to each of its coordinates.
pub(super) fn by_axis(track: &Track, act: impl Fn(&[f64]) -> Vec<f64>) -> Track {
    let axis = |a: usize| act(&track.iter().map(|p| p[a]).collect::<Vec<_>>());
    let (x, y, z) = (axis(0), axis(1), axis(2));
    (0..track.len())
        .map(|i| Vector3::new(x[i], y[i], z[i]))
        .collect()
}
