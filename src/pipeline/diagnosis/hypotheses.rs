//! Other ways to read the pictures of a recording, and what each leaves of the silhouettes' misses.

use super::coherence::{Misses, Scene};
use super::fault::CameraFault;
use super::reading::{Flip, Reading};
use crate::camera::CameraId;

/// A hypothesis must leave less than this share of the misses, …
pub(super) const EXPLAINED: f64 = 0.6;
/// … a shift in time, which comes in all sizes, less than this, …
const EXPLAINED_BY_TIME: f64 = 0.85;
/// … and in this share of the frames less than before.
const IN_FRAMES: f64 = 0.8;
/// With fewer cameras a picture of another place may look flipped, and the two that are left without one agree about nearly anything.
pub(super) const ENOUGH: usize = 4;
/// The focal lengths that are tried, as shares of the calibrated ones.
const ZOOMS: [f64; 10] = [0.7, 0.8, 0.87, 0.91, 0.95, 1.05, 1.1, 1.15, 1.25, 1.4];
/// The shifts in time that are tried first, frames; the best is then refined.
const SHIFTS: [isize; 8] = [1, 2, 3, 5, 8, 12, 18, 25];

/// Of other ways to read the pictures, so many that a few frames speak for are looked at in all.
const RACED: usize = 3;

/// The silhouettes as they are read so far, and how they miss each other.
pub(super) struct Now {
    pub(super) readings: Vec<Option<Reading>>,
    pub(super) misses: Misses,
    few_misses: Misses,
}

impl Now {
    pub(super) fn new(scene: &Scene<'_>, readings: Vec<Option<Reading>>) -> Self {
        let (misses, few_misses) = (scene.misses(&readings), scene.few_misses(&readings));
        Self { readings, misses, few_misses }
    }

    /// The readings with another one of a camera that is there.
    pub(super) fn with(
        &self,
        camera: usize,
        change: impl Fn(&mut Reading),
    ) -> Vec<Option<Reading>> {
        let mut readings = self.readings.clone();
        readings[camera].iter_mut().for_each(change);
        readings
    }
}

/// Another way to read the pictures.
pub(super) struct Hypothesis {
    pub(super) fault: CameraFault,
    pub(super) readings: Vec<Option<Reading>>,
}

impl Hypothesis {
    /// The share of the misses that it leaves in a few frames; `None` where that is more than there was, or too few frames can be
    /// compared.
    pub(super) fn few_left(&self, scene: &Scene<'_>, now: &Now) -> Option<f64> {
        let (left, _) = scene.few_misses(&self.readings).share_of(&now.few_misses)?;
        (left <= 1.0).then_some(left)
    }

    /// What it leaves in all frames that are looked at; `None` where too few can be compared.
    pub(super) fn tried(self, scene: &Scene<'_>, now: &Now) -> Option<Trial> {
        let (left, fewer_in) = scene.misses(&self.readings).share_of(&now.misses)?;
        Some(Trial { fault: self.fault, readings: self.readings, left, fewer_in })
    }
}

/// Those that leave the least: all are looked at in a few frames, and in all frames only the first of them.
pub(super) fn raced(scene: &Scene<'_>, now: &Now, hypotheses: Vec<Hypothesis>) -> Vec<Trial> {
    let few = |hypothesis: Hypothesis| Some((hypothesis.few_left(scene, now)?, hypothesis));
    let mut sorted: Vec<(f64, Hypothesis)> = hypotheses.into_iter().filter_map(few).collect();
    sorted.sort_by(|a, b| a.0.total_cmp(&b.0));
    let first = sorted.into_iter().take(RACED);
    first.filter_map(|(_, hypothesis)| hypothesis.tried(scene, now)).collect()
}

/// A hypothesis and what it leaves.
pub(super) struct Trial {
    pub(super) fault: CameraFault,
    pub(super) readings: Vec<Option<Reading>>,
    /// The share of the misses that is left.
    pub(super) left: f64,
    /// The share of the frames that miss less.
    pub(super) fewer_in: f64,
}

impl Trial {
    /// Whether the hypothesis leaves much less than there was, and in nearly every frame.
    pub(super) fn explains(&self) -> bool {
        let share = match self.fault {
            CameraFault::Late(..) => EXPLAINED_BY_TIME,
            _ => EXPLAINED,
        };
        self.left < share && self.fewer_in >= IN_FRAMES
    }

    pub(super) fn order(a: &Self, b: &Self) -> std::cmp::Ordering {
        a.left.total_cmp(&b.left)
    }
}

/// The cameras that are read.
pub(super) fn present(readings: &[Option<Reading>]) -> impl Iterator<Item = usize> {
    readings.iter().enumerate().filter(|(_, r)| r.is_some()).map(|(i, _)| i)
}

/// Exchanged pictures of two cameras.
pub(super) fn exchanged(now: &Now) -> Vec<Hypothesis> {
    let pairs = present(&now.readings)
        .flat_map(|i| present(&now.readings).take_while(move |j| *j < i).map(move |j| (i, j)));
    let hypothesis = |(i, j): (usize, usize)| {
        let mut readings = now.readings.clone();
        readings.swap(i, j);
        Hypothesis { fault: CameraFault::Exchanged(CameraId(j), CameraId(i)), readings }
    };
    pairs.map(hypothesis).collect()
}

/// Flipped pictures, of all cameras and of each.
pub(super) fn flipped(now: &Now) -> Vec<Hypothesis> {
    let all = |flip: Flip| {
        let mut readings = now.readings.clone();
        readings.iter_mut().flatten().for_each(|r| r.flip = Some(flip));
        Hypothesis { fault: CameraFault::AllFlipped(flip), readings }
    };
    let one = |camera: usize, flip: Flip| Hypothesis {
        fault: CameraFault::Flipped(CameraId(camera), flip),
        readings: now.with(camera, |r| r.flip = Some(flip)),
    };
    let flips = if present(&now.readings).count() < ENOUGH {
        &[Flip::Mirrored][..]
    } else {
        &Flip::ALL[..]
    };
    let each =
        present(&now.readings).flat_map(|camera| flips.iter().map(move |flip| one(camera, *flip)));
    Flip::ALL.into_iter().map(all).chain(each).collect()
}

/// Other focal lengths, of all cameras and of each that is suspected.
pub(super) fn zoomed(now: &Now, suspects: &[usize]) -> Vec<Hypothesis> {
    let all = |by: &f64| {
        let mut readings = now.readings.clone();
        readings.iter_mut().flatten().for_each(|r| r.zoom *= by);
        Hypothesis { fault: CameraFault::AllZoomed(*by), readings }
    };
    let one = |camera: usize, by: f64| Hypothesis {
        fault: CameraFault::Zoomed(CameraId(camera), by),
        readings: now.with(camera, |r| r.zoom *= by),
    };
    let each = suspects.iter().flat_map(|camera| ZOOMS.map(|by| one(*camera, by)));
    ZOOMS.iter().map(all).chain(each).collect()
}

/// The shift of a camera's clock under which it agrees best with the others.
pub(super) fn shifted(scene: &Scene<'_>, now: &Now, camera: usize) -> Option<Trial> {
    let own = now.readings[camera]?;
    let at = |by: isize| Hypothesis {
        fault: CameraFault::Late(CameraId(camera), own.late + by),
        readings: now.with(camera, |r| r.late += by),
    };
    let few_left = |by: isize| Some((by, at(by).few_left(scene, now)?));
    let order = |a: &(isize, f64), b: &(isize, f64)| a.1.total_cmp(&b.1);

    let coarse = SHIFTS.iter().flat_map(|by| [*by, -by]).filter_map(few_left).min_by(order)?;
    let around = (coarse.0 - 3..=coarse.0 + 3).filter(|by| *by != 0);
    raced(scene, now, around.map(at).collect()).into_iter().min_by(Trial::order)
}
