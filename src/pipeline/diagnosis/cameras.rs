//! Which cameras do not show what the others show, and why: exchanged, flipped, late, or elsewhere.
//!
//! Each hypothesis reads the pictures in another way ([`Reading`]); the one under which the silhouettes miss each other least
//! is the cause, if it explains as much as leaving the camera out does. A camera that no other reading explains, and without
//! which the others agree, is elsewhere than its calibration says. What was found is applied, and the search goes on.

use super::coherence::Scene;
use super::fault::CameraFault;
use super::hypotheses::{
    ENOUGH, EXPLAINED, Hypothesis, Now, Trial, exchanged, flipped, present, raced, shifted, zoomed,
};
use super::reading::Reading;
use crate::camera::{CameraId, Rig};
use crate::math::stats::median;
use crate::silhouette::FrameObservations;

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

/// Faults of cameras that leave less than this share of the misses are all there is.
const NEARLY_ALL: f64 = 0.3;
/// Rounds in which several late clocks settle at most.
const SETTLING_ROUNDS: usize = 4;

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
        [] => present(&now.readings).collect(),
        sorted => sorted.iter().take(2).filter_map(|t| t.fault.camera()).collect(),
    };

    // other ways to read the pictures
    let mut hypotheses = flipped(now);
    hypotheses.extend(exchanged(now));
    hypotheses.extend(zoomed(now, &suspects));
    let mut trials = raced(scene, now, hypotheses);
    trials.extend(suspects.iter().filter_map(|camera| shifted(scene, now, *camera)));
    let best = trials.into_iter().filter(Trial::explains).min_by(Trial::order);

    // the cause is what explains as much as leaving the camera out does
    let odd = odd_one(scene, without, now);
    match (best, odd) {
        (Some(best), Some(odd)) => {
            // one camera less leaves less to miss, with four by far
            let looser = if present(&now.readings).count() > 4 { 1.5 } else { 3.5 };
            let floor = looser * odd.left.max(0.25 * scene.quiet_m() / now.misses.mean_m());
            Some(if best.left <= floor { best } else { odd })
        }
        (best, odd) => best.or(odd),
    }
}

/// Leaves out each camera, where that leaves enough.
fn left_out(scene: &Scene<'_>, now: &Now) -> Vec<Trial> {
    if present(&now.readings).count() < ENOUGH {
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
    present(&now.readings).filter_map(without).collect()
}

/// The first of the sorted trials, if the others agree much better without its camera than without another.
fn odd_one(scene: &Scene<'_>, without: Vec<Trial>, now: &Now) -> Option<Trial> {
    let mut sorted = without.into_iter();
    let first = sorted.next()?;
    let usual = median(&mut sorted.map(|t| t.left).collect())?;
    let is_odd = first.left < EXPLAINED * usual && usual * now.misses.mean_m() > scene.quiet_m();
    is_odd.then_some(first)
}

#[cfg(test)]
mod tests {
    use nalgebra::Vector3;

    use super::*;
    use crate::math::Rigid3;
    use crate::pipeline::diagnosis::figures::{hang, late, walker as recording};
    use crate::pipeline::diagnosis::reading::Flip;

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

        // one that hangs, and all
        let mut hanging = rig.clone();
        hang(&mut hanging.cameras[1]);
        let found = faults(&hanging, &frames);
        assert_eq!(found, [CameraFault::Flipped(CameraId(1), Flip::UpsideDown)]);
        let mut hanging = rig.clone();
        hanging.cameras.iter_mut().for_each(hang);
        assert_eq!(faults(&hanging, &frames), [CameraFault::AllFlipped(Flip::UpsideDown)]);

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
