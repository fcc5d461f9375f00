//! Which cameras do not show what the others show, and why: exchanged, mirrored, late, or elsewhere.
//!
//! Each hypothesis reads the pictures in another way ([`Reading`]); the one under which the silhouettes miss each other least
//! is the cause, if it explains as much as leaving the camera out does. A camera that no other reading explains, and without
//! which the others agree, is elsewhere than its calibration says. What was found is applied, and the search goes on.

use super::coherence::{Misses, Reading, Scene};
use crate::camera::{CameraId, Rig};
use crate::math::stats::median;
use crate::silhouette::FrameObservations;

/// What is wrong with a camera or two.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum CameraFault {
    /// All pictures show left for right.
    AllMirrored,
    /// The pictures of one camera show left for right.
    Mirrored(CameraId),
    /// The pictures of two cameras are exchanged.
    Exchanged(CameraId, CameraId),
    /// A camera shows the person so many frames late; negative: early.
    Late(CameraId, isize),
    /// The focal lengths of all cameras are so many times the calibrated ones.
    AllZoomed(f64),
    /// The focal length of a camera is so many times the calibrated one.
    Zoomed(CameraId, f64),
    /// A camera shows the person elsewhere than the others do.
    Elsewhere {
        camera: CameraId,
        /// By how much its outlines miss the others', m.
        miss_m: f64,
    },
}

/// What is wrong with all cameras together.
#[derive(Debug, Clone)]
pub(in crate::pipeline) struct CameraFaults {
    /// One after the other.
    pub(super) faults: Vec<CameraFault>,
    /// How the pictures are to be read then.
    pub(super) readings: Vec<Option<Reading>>,
    /// The share of the misses that is left then.
    left: f64,
    /// The same in metres.
    pub(super) left_m: f64,
}

impl CameraFaults {
    /// Of a recording.
    pub(in crate::pipeline) fn of(rig: &Rig, frames: &[FrameObservations]) -> Self {
        camera_faults(&Scene::new(rig, frames))
    }

    /// Whether all of them are what the joint optimum finds better: cameras that are late, elsewhere or zoomed.
    pub(in crate::pipeline) fn are_of_unknowns(&self) -> bool {
        use CameraFault::{Elsewhere, Late};
        let is_such = |f: &CameraFault| f.is_of_lens() || matches!(f, Late(..) | Elsewhere { .. });
        self.faults.iter().all(is_such)
    }

    /// Whether one of them is a focal length, or there are none.
    pub(super) fn is_any_of_lenses(&self) -> bool {
        self.faults.is_empty() || self.faults.iter().any(CameraFault::is_of_lens)
    }

    /// Whether nearly all misses come from them.
    pub(super) fn explain_nearly_all(&self) -> bool {
        self.left < NEARLY_ALL
    }
}

/// A hypothesis must leave less than this share of the misses, …
const EXPLAINED: f64 = 0.6;
/// … a shift in time, which comes in all sizes, less than this, …
const EXPLAINED_BY_TIME: f64 = 0.85;
/// … and in this share of the frames less than before.
const IN_FRAMES: f64 = 0.8;
/// Faults of cameras that leave less than this share of the misses are all there is.
const NEARLY_ALL: f64 = 0.3;
/// The focal lengths that are tried, as shares of the calibrated ones.
const ZOOMS: [f64; 10] = [0.7, 0.8, 0.87, 0.91, 0.95, 1.05, 1.1, 1.15, 1.25, 1.4];
/// Rounds in which several late clocks settle at most.
const SETTLING_ROUNDS: usize = 4;
/// The shifts in time that are tried first, frames; the best is then refined.
const SHIFTS: [isize; 8] = [1, 2, 3, 5, 8, 12, 18, 25];

/// Of other ways to read the pictures, so many that a few frames speak for are looked at in all.
const RACED: usize = 3;

/// The silhouettes as they are read so far, and how they miss each other.
struct Now {
    readings: Vec<Option<Reading>>,
    misses: Misses,
    few_misses: Misses,
}

impl Now {
    fn new(scene: &Scene<'_>, readings: Vec<Option<Reading>>) -> Self {
        let (misses, few_misses) = (scene.misses(&readings), scene.few_misses(&readings));
        Self { readings, misses, few_misses }
    }

    /// The readings with another one of a camera that is there.
    fn with(&self, camera: usize, change: impl Fn(&mut Reading)) -> Vec<Option<Reading>> {
        let mut readings = self.readings.clone();
        readings[camera].iter_mut().for_each(change);
        readings
    }
}

/// Another way to read the pictures.
struct Hypothesis {
    fault: CameraFault,
    readings: Vec<Option<Reading>>,
}

impl Hypothesis {
    /// The share of the misses that it leaves in a few frames; `None` where that is more than there was, or too few frames can be
    /// compared.
    fn few_left(&self, scene: &Scene<'_>, now: &Now) -> Option<f64> {
        let (left, _) = scene.few_misses(&self.readings).share_of(&now.few_misses)?;
        (left <= 1.0).then_some(left)
    }

    /// What it leaves in all frames that are looked at; `None` where too few can be compared.
    fn tried(self, scene: &Scene<'_>, now: &Now) -> Option<Trial> {
        let (left, fewer_in) = scene.misses(&self.readings).share_of(&now.misses)?;
        Some(Trial { fault: self.fault, readings: self.readings, left, fewer_in })
    }
}

/// Those that leave the least: all are looked at in a few frames, and in all frames only the first of them.
fn raced(scene: &Scene<'_>, now: &Now, hypotheses: Vec<Hypothesis>) -> Vec<Trial> {
    let few = |hypothesis: Hypothesis| Some((hypothesis.few_left(scene, now)?, hypothesis));
    let mut sorted: Vec<(f64, Hypothesis)> = hypotheses.into_iter().filter_map(few).collect();
    sorted.sort_by(|a, b| a.0.total_cmp(&b.0));
    let first = sorted.into_iter().take(RACED);
    first.filter_map(|(_, hypothesis)| hypothesis.tried(scene, now)).collect()
}

/// A hypothesis and what it leaves.
struct Trial {
    fault: CameraFault,
    readings: Vec<Option<Reading>>,
    /// The share of the misses that is left.
    left: f64,
    /// The share of the frames that miss less.
    fewer_in: f64,
}

impl Trial {
    /// Whether the hypothesis leaves much less than there was, and in nearly every frame.
    fn explains(&self) -> bool {
        let share = match self.fault {
            CameraFault::Late(..) => EXPLAINED_BY_TIME,
            _ => EXPLAINED,
        };
        self.left < share && self.fewer_in >= IN_FRAMES
    }

    fn order(a: &Self, b: &Self) -> std::cmp::Ordering {
        a.left.total_cmp(&b.left)
    }
}

/// What is wrong with the cameras, the greatest first; nothing where the silhouettes agree.
fn camera_faults(scene: &Scene<'_>) -> CameraFaults {
    let mut now = Now::new(scene, scene.plain());
    let first_m = now.misses.mean_m();
    let mut faults: Vec<CameraFault> = Vec::new();
    let mut left = 1.0;
    while faults.len() < now.readings.len() {
        let Some(found) = next_fault(scene, &now) else {
            break;
        };
        faults.push(found.fault);
        left *= found.left;
        now = Now::new(scene, found.readings);
        left *= settle_clocks(scene, &mut now, &mut faults);
    }
    CameraFaults { faults, readings: now.readings, left, left_m: left * first_m }
}

/// Moves the clocks that were found late by single frames until the silhouettes agree best, for the first was found when the
/// others were still wrong. Gives the share of the misses that is left.
fn settle_clocks(scene: &Scene<'_>, now: &mut Now, faults: &mut [CameraFault]) -> f64 {
    let is_late = |fault: &&CameraFault| matches!(fault, CameraFault::Late(..));
    if faults.iter().filter(is_late).count() < 2 {
        return 1.0;
    }

    let mut left = 1.0;
    for _ in 0..SETTLING_ROUNDS {
        let before = left;
        for fault in faults.iter_mut() {
            if let Some(better) = moved_clock(scene, now, *fault) {
                left *= better.left;
                *fault = better.fault;
                *now = Now::new(scene, better.readings);
            }
        }
        if left >= before {
            break;
        }
    }
    left
}

/// A late clock moved by a frame, if the silhouettes agree better so.
fn moved_clock(scene: &Scene<'_>, now: &Now, fault: CameraFault) -> Option<Trial> {
    let CameraFault::Late(id, late) = fault else {
        return None;
    };
    let moved = |by: isize| {
        let readings = now.with(id.0, |r| r.late = late + by);
        Hypothesis { fault: CameraFault::Late(id, late + by), readings }.tried(scene, now)
    };
    let best = [-1, 1].into_iter().filter_map(moved).min_by(Trial::order)?;
    (best.left < 1.0).then_some(best)
}

/// The hypothesis that explains most of the misses that there are `now`.
fn next_fault(scene: &Scene<'_>, now: &Now) -> Option<Trial> {
    if now.misses.mean_m() < scene.quiet_m() {
        return None;
    }

    // without each camera in turn
    let mut without: Vec<Trial> = left_out(scene, now);
    without.sort_by(Trial::order);
    let suspects: Vec<usize> = match without.as_slice() {
        [] => present(now).collect(),
        sorted => sorted.iter().take(2).filter_map(|t| t.fault.camera()).collect(),
    };

    // other ways to read the pictures
    let mut hypotheses = rearranged(now);
    hypotheses.extend(zoomed(now, &suspects));
    let mut trials = raced(scene, now, hypotheses);
    trials.extend(suspects.iter().filter_map(|camera| shifted(scene, now, *camera)));
    let best = trials.into_iter().filter(Trial::explains).min_by(Trial::order);

    // the cause is what explains as much as leaving the camera out does
    let odd = odd_one(scene, without, now);
    match (best, odd) {
        (Some(best), Some(odd)) => {
            // one camera less leaves less to miss, with four by far
            let looser = if present(now).count() > 4 { 1.5 } else { 3.5 };
            let floor = looser * odd.left.max(0.25 * scene.quiet_m() / now.misses.mean_m());
            Some(if best.left <= floor { best } else { odd })
        }
        (best, odd) => best.or(odd),
    }
}

fn present(now: &Now) -> impl Iterator<Item = usize> {
    now.readings.iter().enumerate().filter(|(_, r)| r.is_some()).map(|(i, _)| i)
}

/// Leaves out each camera; nothing with fewer than four, for the two that are left agree about nearly anything.
fn left_out(scene: &Scene<'_>, now: &Now) -> Vec<Trial> {
    if present(now).count() < 4 {
        return Vec::new();
    }
    let without = |camera: usize| {
        let mut readings = now.readings.clone();
        readings[camera] = None;
        let miss_m = now.misses.cameras[camera].unwrap_or(0.0);
        let fault = CameraFault::Elsewhere { camera: CameraId(camera), miss_m };
        let trial = Hypothesis { fault, readings }.tried(scene, now)?;
        (trial.left <= scene.most_left()).then_some(trial)
    };
    present(now).filter_map(without).collect()
}

/// The first of the sorted trials, if the others agree much better without its camera than without another.
fn odd_one(scene: &Scene<'_>, without: Vec<Trial>, now: &Now) -> Option<Trial> {
    let mut sorted = without.into_iter();
    let first = sorted.next()?;
    let usual = median(&mut sorted.map(|t| t.left).collect())?;
    let is_odd = first.left < EXPLAINED * usual && usual * now.misses.mean_m() > scene.quiet_m();
    is_odd.then_some(first)
}

/// Mirrored and exchanged pictures.
fn rearranged(now: &Now) -> Vec<Hypothesis> {
    let mirror = |r: &mut Reading| r.mirrored = !r.mirrored;
    let mut all = now.readings.clone();
    all.iter_mut().flatten().for_each(mirror);

    let mut hypotheses = vec![Hypothesis { fault: CameraFault::AllMirrored, readings: all }];
    for i in present(now) {
        let fault = CameraFault::Mirrored(CameraId(i));
        hypotheses.push(Hypothesis { fault, readings: now.with(i, mirror) });
        for j in present(now).take_while(|j| *j < i) {
            let mut readings = now.readings.clone();
            readings.swap(i, j);
            let fault = CameraFault::Exchanged(CameraId(j), CameraId(i));
            hypotheses.push(Hypothesis { fault, readings });
        }
    }
    hypotheses
}

/// Other focal lengths, of all cameras and of each that is suspected.
fn zoomed(now: &Now, suspects: &[usize]) -> Vec<Hypothesis> {
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
fn shifted(scene: &Scene<'_>, now: &Now, camera: usize) -> Option<Trial> {
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

impl CameraFault {
    fn is_of_lens(&self) -> bool {
        matches!(self, Self::AllZoomed(_) | Self::Zoomed(..))
    }

    /// The camera, of faults of one.
    pub(super) fn camera(self) -> Option<usize> {
        match self {
            Self::Mirrored(id)
            | Self::Late(id, _)
            | Self::Zoomed(id, _)
            | Self::Elsewhere { camera: id, .. } => Some(id.0),
            Self::AllMirrored | Self::AllZoomed(_) | Self::Exchanged(..) => None,
        }
    }
}

#[cfg(test)]
mod tests {
    use nalgebra::Vector3;

    use super::*;
    use crate::math::Rigid3;
    use crate::pipeline::diagnosis::figures::{late, walker as recording};

    fn faults(rig: &Rig, frames: &[FrameObservations]) -> Vec<CameraFault> {
        camera_faults(&Scene::new(rig, frames)).faults
    }

    #[test]
    fn each_fault_of_a_camera_is_named_and_none_where_there_is_none() {
        let (rig, frames) = recording();
        assert!(rig.cameras.len() >= 4, "leaving one out must leave three");
        assert_eq!(faults(&rig, &frames), []);

        // two cameras exchanged
        let mut exchanged = rig.clone();
        let (a, b) = (rig.cameras[0].clone(), rig.cameras[1].clone());
        exchanged.cameras[0] = b;
        exchanged.cameras[1] = a;
        let found = faults(&exchanged, &frames);
        assert_eq!(found, [CameraFault::Exchanged(CameraId(0), CameraId(1))]);

        // one turned by three degrees after its calibration
        let mut turned = rig.clone();
        let turn = Rigid3::rotation(Vector3::y() * 3f64.to_radians());
        turned.cameras[1].camera_from_world = turn * turned.cameras[1].camera_from_world;
        let found = faults(&turned, &frames);
        let is_elsewhere =
            |f: &CameraFault| matches!(f, CameraFault::Elsewhere { camera: CameraId(1), .. });
        assert!(found.len() == 1 && is_elsewhere(&found[0]), "{found:?}");

        // one late by three frames
        assert_eq!(faults(&rig, &late(&frames, 1, 3)), [CameraFault::Late(CameraId(1), 3)]);
    }

    #[test]
    fn clocks_of_several_cameras_settle_at_what_each_is_late_by() {
        let (rig, frames) = recording();
        let spoiled = [(1, 2), (3, -2)];
        let shown = spoiled.iter().fold(frames, |frames, (id, by)| late(&frames, *id, *by));
        let mut found = faults(&rig, &shown);
        found.sort_by_key(|fault| fault.camera());
        assert_eq!(found, spoiled.map(|(id, by)| CameraFault::Late(CameraId(id), by)));
    }
}
