//! Which cameras do not show what the others show, and why: exchanged, mirrored, late, or elsewhere.
//!
//! Each hypothesis reads the pictures in another way ([`Reading`]); the one under which the silhouettes miss each other least
//! is the cause, if it explains as much as leaving the camera out does. A camera that no other reading explains, and without
//! which the others agree, is elsewhere than its calibration says. What was found is applied, and the search goes on.

use super::coherence::{Misses, Reading, Scene};
use crate::camera::CameraId;
use crate::math::stats::median;

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
pub(super) struct CameraFaults {
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
    /// Whether nearly all misses come from them.
    pub(super) fn explain_nearly_all(&self) -> bool {
        self.left < NEARLY_ALL
    }
}

/// Silhouettes that miss each other by less than this agree, metres: the step in which lines of sight are followed hides less.
const QUIET_M: f64 = 0.001;
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
/// The shifts in time that are tried first, frames; the best is then refined.
const SHIFTS: [isize; 8] = [1, 2, 3, 5, 8, 12, 18, 25];

/// A hypothesis and what it leaves.
struct Trial {
    fault: CameraFault,
    readings: Vec<Option<Reading>>,
    misses: Misses,
    /// The share of the misses that is left.
    left: f64,
    /// The share of the frames that miss less.
    fewer_in: f64,
}

impl Trial {
    /// `None` where it leaves more than there was, or too few frames can be compared.
    fn new(
        scene: &Scene<'_>,
        now: &Misses,
        fault: CameraFault,
        readings: Vec<Option<Reading>>,
    ) -> Option<Self> {
        let (few_left, _) = scene.few_misses(&readings).share_of(&now.few())?;
        if few_left > 1.0 {
            return None;
        }
        let misses = scene.misses(&readings);
        let (left, fewer_in) = misses.share_of(now)?;
        Some(Self { fault, readings, misses, left, fewer_in })
    }

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
pub(super) fn camera_faults(scene: &Scene<'_>) -> CameraFaults {
    let mut readings = scene.plain();
    let mut misses = scene.misses(&readings);
    let first_m = misses.mean_m();
    let mut faults: Vec<CameraFault> = Vec::new();
    let mut left = 1.0;
    while faults.len() < readings.len() {
        let Some(found) = next_fault(scene, &readings, &misses) else {
            break;
        };
        faults.push(found.fault);
        left *= found.left;
        (readings, misses) = (found.readings, found.misses);
    }
    CameraFaults { faults, readings, left, left_m: left * first_m }
}

/// The hypothesis that explains most of the misses that there are `now`.
fn next_fault(scene: &Scene<'_>, readings: &[Option<Reading>], now: &Misses) -> Option<Trial> {
    if now.mean_m() < QUIET_M {
        return None;
    }

    // without each camera in turn
    let mut without: Vec<Trial> = left_out(scene, readings, now);
    without.sort_by(Trial::order);
    let suspects: Vec<usize> = match without.as_slice() {
        [] => present(readings).collect(),
        sorted => sorted.iter().take(2).filter_map(|t| t.fault.camera()).collect(),
    };

    // other ways to read the pictures
    let mut trials = rearranged(scene, readings, now);
    trials.extend(zoomed(scene, readings, now, &suspects));
    trials.extend(suspects.iter().filter_map(|camera| shifted(scene, readings, now, *camera)));
    let best = trials.into_iter().filter(Trial::explains).min_by(Trial::order);

    // the cause is what explains as much as leaving the camera out does
    let odd = odd_one(without, now);
    match (best, odd) {
        (Some(best), Some(odd)) => {
            // one camera less leaves less to miss, with four by far
            let looser = if present(readings).count() > 4 { 1.5 } else { 3.5 };
            let floor = looser * odd.left.max(0.25 * QUIET_M / now.mean_m());
            Some(if best.left <= floor { best } else { odd })
        }
        (best, odd) => best.or(odd),
    }
}

fn present(readings: &[Option<Reading>]) -> impl Iterator<Item = usize> {
    readings.iter().enumerate().filter(|(_, r)| r.is_some()).map(|(i, _)| i)
}

/// Leaves out each camera; nothing with fewer than four, for the two that are left agree about nearly anything.
fn left_out(scene: &Scene<'_>, readings: &[Option<Reading>], now: &Misses) -> Vec<Trial> {
    if present(readings).count() < 4 {
        return Vec::new();
    }
    let without = |camera: usize| {
        let mut left = readings.to_vec();
        left[camera] = None;
        let miss_m = now.cameras[camera].unwrap_or(0.0);
        let fault = CameraFault::Elsewhere { camera: CameraId(camera), miss_m };
        Trial::new(scene, now, fault, left)
    };
    present(readings).filter_map(without).collect()
}

/// The first of the sorted trials, if the others agree much better without its camera than without another.
fn odd_one(without: Vec<Trial>, now: &Misses) -> Option<Trial> {
    let mut sorted = without.into_iter();
    let first = sorted.next()?;
    let usual = median(&mut sorted.map(|t| t.left).collect())?;
    (first.left < EXPLAINED * usual && usual * now.mean_m() > QUIET_M).then_some(first)
}

/// Mirrored and exchanged pictures.
fn rearranged(scene: &Scene<'_>, readings: &[Option<Reading>], now: &Misses) -> Vec<Trial> {
    let mut hypotheses = Vec::new();
    let mirrored = |r: &mut Option<Reading>| {
        if let Some(r) = r {
            r.mirrored = !r.mirrored;
        }
    };
    let mut all = readings.to_vec();
    all.iter_mut().for_each(mirrored);
    hypotheses.push((CameraFault::AllMirrored, all));
    for i in present(readings) {
        let mut one = readings.to_vec();
        mirrored(&mut one[i]);
        hypotheses.push((CameraFault::Mirrored(CameraId(i)), one));
        for j in present(readings).take_while(|j| *j < i) {
            let mut pair = readings.to_vec();
            pair.swap(i, j);
            hypotheses.push((CameraFault::Exchanged(CameraId(j), CameraId(i)), pair));
        }
    }

    let trial = |(fault, readings)| Trial::new(scene, now, fault, readings);
    hypotheses.into_iter().filter_map(trial).collect()
}

/// Other focal lengths, of all cameras and of each that is suspected.
fn zoomed(
    scene: &Scene<'_>,
    readings: &[Option<Reading>],
    now: &Misses,
    suspects: &[usize],
) -> Vec<Trial> {
    let zoom = |reading: Reading, by: f64| Reading { zoom: reading.zoom * by, ..reading };
    let all = |by: f64| {
        let readings = readings.iter().map(|r| Some(zoom((*r)?, by))).collect();
        Trial::new(scene, now, CameraFault::AllZoomed(by), readings)
    };
    let one = |camera: usize, by: f64| {
        let mut one = readings.to_vec();
        one[camera] = Some(zoom(one[camera]?, by));
        Trial::new(scene, now, CameraFault::Zoomed(CameraId(camera), by), one)
    };

    let each = suspects.iter().flat_map(|camera| ZOOMS.iter().filter_map(|by| one(*camera, *by)));
    ZOOMS.iter().filter_map(|by| all(*by)).chain(each).collect()
}

/// The shift of a camera's clock under which it agrees best with the others.
fn shifted(
    scene: &Scene<'_>,
    readings: &[Option<Reading>],
    now: &Misses,
    camera: usize,
) -> Option<Trial> {
    let own = readings[camera]?;
    let at = |by: isize| {
        let mut late = readings.to_vec();
        late[camera] = Some(Reading { late: own.late + by, ..own });
        let fault = CameraFault::Late(CameraId(camera), own.late + by);
        Some((by, Trial::new(scene, now, fault, late)?))
    };
    let order = |a: &(isize, Trial), b: &(isize, Trial)| Trial::order(&a.1, &b.1);

    let (coarse, best) = SHIFTS.iter().flat_map(|by| [*by, -by]).filter_map(at).min_by(order)?;
    let around = [coarse - 3, coarse - 2, coarse - 1, coarse + 1, coarse + 2, coarse + 3];
    let untried = around.into_iter().filter(|by| *by != 0 && !SHIFTS.contains(&by.abs()));
    let (_, finest) = untried.filter_map(at).chain([(coarse, best)]).min_by(order)?;
    Some(finest)
}

impl CameraFault {
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
    use std::path::Path;

    use nalgebra::Vector3;

    use super::*;
    use crate::camera::Rig;
    use crate::math::Rigid3;
    use crate::silhouette::{FrameIndex, FrameObservations, SilhouetteOptions, extract};
    use crate::synth::Recipe;

    /// A walker before a ring of cameras.
    fn recording() -> (Rig, Vec<FrameObservations>) {
        let person = crate::io::model::load("walker-metaballs", Path::new("")).unwrap();
        let recipe = Recipe { frames: Some(16), fps: 25.0, ..Recipe::default() };
        let walker = recipe.walker(&person).unwrap();
        let shown = |number: usize| {
            let mut seen = FrameObservations::nothing(FrameIndex(number));
            for (id, camera) in walker.rig.iter() {
                let mask = walker.mask(seen.frame, id).unwrap();
                if let Ok(silhouette) = extract(&mask, camera, &SilhouetteOptions::default()) {
                    seen.views.push((id, silhouette));
                }
            }
            seen
        };
        (walker.rig.clone(), (0..walker.frames()).map(shown).collect())
    }

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
        let mut late = frames.clone();
        for (i, frame) in late.iter_mut().enumerate() {
            let shown = i.checked_sub(3).map(|i| frames[i].views[1].clone());
            frame.views.retain(|(id, _)| *id != CameraId(1));
            frame.views.extend(shown);
            frame.views.sort_by_key(|(id, _)| *id);
        }
        assert_eq!(faults(&rig, &late), [CameraFault::Late(CameraId(1), 3)]);
    }
}
