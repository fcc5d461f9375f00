//! A moving body: places over time, and what is known beyond them.

use std::collections::BTreeMap;

use nalgebra::{Point3, Vector3};
use serde::Serialize;

use super::filter;
use super::landmark::{Landmark, Paired, Side};
use super::segments::Segments;
use crate::math::stats::median;

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

/// A moving body, evenly in time. World: metres, Z up.
#[derive(Debug, Clone, PartialEq)]
pub struct Movement {
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
    /// The same of the vector from a left place to the right one in one frame.
    pub apart_sd_m: BTreeMap<Paired, Track>,
    /// Orientations of the body's parts, of a fitted body.
    pub segments: Option<Segments>,
    /// What each place was taken from.
    pub used: Vec<Used>,
}

/// Why a movement cannot be analysed.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum MovementError {
    /// A place without which nothing can be analysed.
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
    /// A place farther from the others than a body reaches.
    #[error(
        "the {place} ({from}) lies {distance_m:.1} m from the hips: expected {FARTHEST_M} m at most; is it in another unit than the other points?"
    )]
    Far {
        /// The place.
        place: String,
        /// What it was taken from.
        from: String,
        /// Median over time.
        distance_m: f64,
    },
}

/// Fewest frames that can be analysed.
const FEWEST_FRAMES: usize = 10;
/// Farthest that a place of a person lies from the middle of the hips, m.
const FARTHEST_M: f64 = 3.0;
/// Height of the hips above the ankles below which the person lies or another axis points up, in lengths of the leg.
const LOW_HIPS: f64 = 0.2;
/// Possible lengths of legs, hip to knee to ankle, m.
const LEGS_M: std::ops::Range<f64> = 0.2..1.5;

impl Movement {
    /// The movement of named points: joint centres or markers of any of the known sets.
    ///
    /// Of two names of one place the better one is used, and gaps of up to 0.1 s are bridged. A joint centre is the middle
    /// of a lateral and a medial marker where both are there. Missing hips are found from the pelvis, missing heels from
    /// the foot.
    ///
    /// # Errors
    /// [`MovementError`] where hips, knees, ankles or toes cannot be found, or the size cannot be a body's.
    pub fn from_points(
        rate_hz: f64,
        first_frame: usize,
        names: &[String],
        frames: &[Vec<Option<Point3<f64>>>],
    ) -> Result<Self, MovementError> {
        if frames.len() < FEWEST_FRAMES {
            let (frames, fewest) = (frames.len(), FEWEST_FRAMES);
            return Err(MovementError::Short { frames, fewest });
        }

        let mut movement = Self {
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
                movement.insert(landmark, bridged(&track, rate_hz), names[column].clone());
            }
        }

        movement.complete();
        movement.check(names)?;
        Ok(movement)
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
    pub fn paired_track(&self, side: Side, place: Paired) -> Option<&Track> {
        self.track(Landmark::Of(side, place))
    }

    /// Whether a marker was on the heel, as opposed to one that is fixed to the foot of a mean body.
    pub(super) fn has_heel_marker(&self, side: Side) -> bool {
        let heel = Landmark::Of(side, Paired::Heel);
        let is_made = |u: &Used| u.from.starts_with("ankle and toe");
        self.used.iter().any(|u| u.landmark == heel && !is_made(u))
    }

    fn check(&self, names: &[String]) -> Result<(), MovementError> {
        let needed = [
            (Paired::Hip, "RHip and LHip, or RASI LASI RPSI LPSI"),
            (Paired::Knee, "RKnee and LKnee"),
            (Paired::Ankle, "RAnkle and LAnkle"),
            (Paired::Toe, "RBigToe and LBigToe, or R.Toe and L.Toe"),
        ];
        for (place, example) in needed {
            for side in Side::BOTH {
                if self.paired_track(side, place).is_none() {
                    return Err(MovementError::Missing {
                        missing: Landmark::Of(side, place).name(),
                        example,
                        found: shortened(names),
                    });
                }
            }
        }

        let legs = Side::BOTH.map(|side| self.leg(side));
        let is_impossible = |length_m: &f64| !LEGS_M.contains(length_m);
        // where one leg is a leg, a single place is in another unit
        if legs.iter().flatten().any(|length| !is_impossible(length)) {
            self.check_places()?;
        }
        match legs.into_iter().flatten().find(is_impossible) {
            Some(length_m) => Err(MovementError::Size { length_m }),
            None => Ok(()),
        }
    }

    /// Checks that no place lies farther from the hips than a body reaches.
    fn check_places(&self) -> Result<(), MovementError> {
        let Some(hips) = self.track(Landmark::MidHip) else {
            return Ok(());
        };

        for (landmark, track) in &self.tracks {
            let rows = track.iter().zip(hips);
            let distances = rows.map(|(place, hips)| (place - hips).norm());
            let distance_m = median(&mut distances.collect::<Vec<_>>());
            let far = distance_m.filter(|d| *d > FARTHEST_M);
            if let Some(distance_m) = far {
                let used = self.used.iter().find(|u| u.landmark == *landmark);
                return Err(MovementError::Far {
                    place: landmark.name(),
                    from: used.map_or_else(String::new, |u| u.from.clone()),
                    distance_m,
                });
            }
        }
        Ok(())
    }

    /// What a person should know of the places: gaps in those of the legs, and a body that does not stand upright.
    pub(super) fn remarks(&self) -> Vec<String> {
        let mut remarks = Vec::new();
        let mut gaps = Vec::new();
        for side in Side::BOTH {
            for place in [Paired::Hip, Paired::Knee, Paired::Ankle, Paired::Toe] {
                let track = self.paired_track(side, place).map_or(&[][..], |track| track);
                let missing = track.iter().filter(|p| !p.x.is_finite()).count();
                if missing > 0 {
                    gaps.push(format!("{} {missing}", Landmark::Of(side, place).name()));
                }
            }
        }

        if !gaps.is_empty() {
            remarks.push(format!(
                "not known in some of the {} frames, and neither is what depends on them: {}",
                self.frames,
                gaps.join(", ")
            ));
        }

        let upright = self.height_of_hips().zip(self.leg_length());
        if upright.is_some_and(|(height_m, leg_m)| height_m < LOW_HIPS * leg_m) {
            remarks.push(
                "the hips are not above the ankles: is the file's Y axis up, as a TRC has it?"
                    .into(),
            );
        }
        remarks
    }

    /// How far the hips are above the ankles, median over time, metres.
    fn height_of_hips(&self) -> Option<f64> {
        let hips = self.track(Landmark::MidHip)?;
        let [left, right] = Side::BOTH.map(|side| self.paired_track(side, Paired::Ankle));
        let rows = hips.iter().zip(left?).zip(right?);
        let mut heights: Vec<f64> =
            rows.map(|((hips, left), right)| hips.z - 0.5 * (left.z + right.z)).collect();
        median(&mut heights)
    }

    /// Hip to knee to ankle, mean of both sides, median over time; metres.
    pub(super) fn leg_length(&self) -> Option<f64> {
        Some(0.5 * (self.leg(Side::Left)? + self.leg(Side::Right)?))
    }

    fn leg(&self, side: Side) -> Option<f64> {
        let (hip, knee) =
            (self.paired_track(side, Paired::Hip)?, self.paired_track(side, Paired::Knee)?);
        let ankle = self.paired_track(side, Paired::Ankle)?;
        let length = |i: usize| (hip[i] - knee[i]).norm() + (knee[i] - ankle[i]).norm();
        median(&mut (0..self.frames).map(length).collect::<Vec<_>>())
    }
}

/// The best column for each place that the names know.
fn columns(names: &[String]) -> BTreeMap<Landmark, usize> {
    let mut best: BTreeMap<Landmark, (usize, usize)> = BTreeMap::new();
    for (column, name) in names.iter().enumerate() {
        if let Some((landmark, rank)) = Landmark::from_name(name) {
            let entry = best.entry(landmark).or_insert((rank, column));
            if rank < entry.0 {
                *entry = (rank, column);
            }
        }
    }
    best.into_iter().map(|(l, (_, column))| (l, column)).collect()
}

/// The first names in one line.
fn shortened(names: &[String]) -> String {
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
    (0..track.len()).map(|i| Vector3::new(x[i], y[i], z[i])).collect()
}
