//! Cameras that jump: touched while they recorded, or with frames lost.
//!
//! Where and when a camera is, is unknown, but taken to be the same in the whole recording. One turn for all frames is false before somebody ran
//! into the tripod and after it, and so is its standard deviation; a camera that has lost frames is on time before and late after. Both jump:
//! from one frame to the next, what the camera shows lies elsewhere beside the body or is of another time (`beside.rs`, `step.rs`).
//!
//! The body yields to a jump, and other cameras seem to jump with it. So each suspect is looked at alone, beside the body that the others show: by how
//! many frames it may have lost there, and by how much it may have been turned (`change.rs`), if either explains more than chance would. What leaves
//! the least cost is tried with all cameras, from the motion of the others, and whatever else leaves less than twice as much, for beside two
//! cameras a body yields to either.
//!
//! - Lost frames: what the camera shows behind the jump is numbered anew.
//! - A camera that was touched, turned by more than a usual calibration errs: the shorter side of the jump is left out.
//!
//! Where pictures are exchanged or mirrored, anything may seem to jump: that is told first, and nothing is looked for.
//!
//! If something still jumps there, it was not that. Of what is left, it is what makes all that is shown cost least. Then the next jump, while two other
//! cameras show something.

mod beside;
mod change;
mod step;

use std::borrow::Cow;
use std::ops::Range;

use beside::Moments;
use change::{Change, What, costs_turned};
use step::{Step, largest, largest_jump, steps};

use super::diagnosis::{CameraFaults, Cause};
use super::estimate::{Estimate, LastStage, Start};
use crate::body::Root;
use crate::camera::{CameraId, Rig};
use crate::inference::joint::JointOptions;
use crate::inference::search::Trial;
use crate::inference::{Evidence, Sequence};
use crate::likelihood::Measure;
use crate::math::stats::mean;
use crate::silhouette::{FrameIndex, FrameObservations, numbered_anew};
use crate::solver::Loss;

/// So many jumps are looked at.
const MOST_JUMPS: usize = 8;
/// Of the cameras that seem to jump, so many are looked at.
const SUSPECTS: usize = 3;
/// A change that costs less than so many times the least beside the others is tried with all.
const LIKELY: f64 = 2.0;
/// A suspect is looked at beside two others.
const LEAST_CAMERAS: usize = 3;

/// The optimum of a recording without jumps.
pub(super) struct Settled<'a> {
    pub(super) estimate: Estimate,
    pub(super) measure: Measure,
    /// What it is of.
    pub(super) frames: Cow<'a, [FrameObservations]>,
    /// What silhouettes alone say of the cameras there.
    pub(super) faults: Cow<'a, CameraFaults>,
    /// The jumps, the largest first.
    pub(super) causes: Vec<Cause>,
}

/// The optimum without a change that was tried.
struct Tried<'a> {
    settled: Settled<'a>,
    cause: Cause,
    /// What a view of a frame costs on the mean.
    cost: f64,
}

impl<'a> Settled<'a> {
    pub(super) fn new(stage: &LastStage<'a>, winner: &Trial) -> Self {
        let (estimate, measure) = stage.run(winner);
        let (frames, faults) = (Cow::Borrowed(stage.sequence.frames), Cow::Borrowed(stage.faults));
        let mut settled = Self { estimate, measure, frames, faults, causes: Vec::new() };
        let is_asked = stage.options.joint.is_some() && stage.evidence.model.root != Root::Fixed;
        if !is_asked || !stage.faults.are_of_unknowns() {
            return settled;
        }

        while settled.causes.len() < MOST_JUMPS {
            let Some(best) = settled.without_jump(stage, winner) else { break };
            let causes = [settled.causes, vec![best.cause]].concat();
            settled = Settled { causes, ..best.settled };
        }
        settled
    }

    /// Without the largest jump; `None` where none jumps, or nothing that is known to happen explains it.
    fn without_jump(&self, stage: &LastStage<'_>, winner: &Trial) -> Option<Tried<'a>> {
        let ids = || stage.evidence.rig.iter().map(|(id, _)| id);
        let shows = |id: &CameraId| self.frames.iter().any(|frame| frame.is_shown_by(*id));
        if ids().filter(shows).count() < LEAST_CAMERAS {
            return None;
        }

        let steps = self.steps(stage);
        largest_jump(&steps)?;
        let of_camera = |id| largest(steps.iter().filter(|step| step.camera == id));
        let mut suspects: Vec<Step> = ids().filter_map(of_camera).collect();
        suspects.sort_by(|a, b| b.times().total_cmp(&a.times()));

        // what may have changed, beside the body that the others show
        let suspects = suspects.iter().take(SUSPECTS);
        let changes = suspects.flat_map(|jump| self.changes(stage, winner, jump));
        let mut changes: Vec<(Change, Start)> = changes.collect();
        changes.sort_by(|(a, _), (b, _)| a.cost.total_cmp(&b.cost));

        // what did change, with all
        let most = LIKELY * changes.first()?.0.cost;
        let likely = changes.iter().take_while(|(change, _)| change.cost <= most);
        let tried = likely.filter_map(|(change, start)| self.without(stage, start, change));
        tried.min_by(|a, b| a.cost.total_cmp(&b.cost))
    }

    /// What may have changed of a camera that seems to jump, and the motion of the others.
    fn changes(&self, stage: &LastStage<'_>, winner: &Trial, jump: &Step) -> Vec<(Change, Start)> {
        let Some(joint) = stage.options.of_trial_alone().joint else { return Vec::new() };
        let others = self.frames.iter().map(|frame| frame.without(jump.camera)).collect();
        let start = Start::of_winner(stage, winner);
        let others = self.again(stage, (&start, &joint), others);
        let evidence = others.evidence(stage);
        let sequence = Sequence { frames: &self.frames, ..stage.sequence };
        let changes = Change::both(&Moments::new(&evidence, &others.estimate, sequence), jump);
        let start = start.moving_as(&others.estimate);
        changes.into_iter().map(|change| (change, start.clone())).collect()
    }

    /// Without a change, from the motion of the others; `None` if something still jumps there.
    fn without(&self, stage: &LastStage<'_>, start: &Start, change: &Change) -> Option<Tried<'a>> {
        let joint = stage.options.joint.as_ref()?;
        let Change { camera: id, frame, .. } = *change;
        let camera = stage.evidence.rig.cameras[id.0].name.clone();
        let (side, frames, cause) = match change.what {
            What::Frames(frames) => {
                let numbered = numbered_anew(&self.frames, id, frame, frames);
                (0..0, numbered, Cause::LostFrames { camera, frame, frames })
            }
            What::Turn(turn_rad) => {
                let side = shorter_side(&self.frames, id, frame)?;
                let kept = left_out(&self.frames, id, &side);
                let left_out = [side.start, side.end - 1].map(FrameIndex);
                let turn_deg = turn_rad.to_degrees();
                (side, kept, Cause::TouchedWhile { camera, frame, turn_deg, left_out })
            }
        };

        let settled = self.again(stage, (start, joint), frames);
        let steps = settled.steps(stage);
        let jumps = |step: &&Step| step.is_about(frame);
        if largest_jump(steps.iter().filter(jumps)).is_some() {
            return None;
        }

        let cost = settled.cost_per_view(stage, (&self.frames, id, &side))?;
        Some(Tried { settled, cause, cost })
    }

    /// What a view of a frame costs on the mean. Those that were left out of a camera count as if it had been turned to what it shows there.
    fn cost_per_view(
        &self,
        stage: &LastStage<'_>,
        (all, camera, side): (&[FrameObservations], CameraId, &Range<usize>),
    ) -> Option<f64> {
        let evidence = self.evidence(stage);
        let moments =
            |frames| Moments::new(&evidence, &self.estimate, Sequence { frames, ..stage.sequence });
        let used = moments(&self.frames).costs(|_| true);
        mean(used.into_iter().chain(costs_turned(&moments(all), camera, side)?))
    }

    /// The optimum of other frames.
    fn again(
        &self,
        stage: &LastStage<'_>,
        (start, joint): (&Start, &JointOptions),
        frames: Vec<FrameObservations>,
    ) -> Settled<'a> {
        let faults = CameraFaults::of(stage.evidence.rig, &frames);
        let sequence = Sequence { frames: &frames, ..stage.sequence };
        let stage = LastStage { sequence, faults: &faults, ..*stage };
        let (estimate, measure) = stage.run_from(start, joint);
        let (frames, faults) = (Cow::Owned(frames), Cow::Owned(faults));
        Settled { estimate, measure, frames, faults, causes: Vec::new() }
    }

    /// Every step of what cameras show beside this optimum.
    fn steps(&self, stage: &LastStage<'_>) -> Vec<Step> {
        let evidence = self.evidence(stage);
        let sequence = Sequence { frames: &self.frames, ..stage.sequence };
        steps(&Moments::new(&evidence, &self.estimate, sequence).beside(stage.evidence.rig))
    }

    /// The body before the cameras where they were found to be. All errors count as they are: a jump is no outlier.
    fn evidence<'e>(&'e self, stage: &'e LastStage<'_>) -> Evidence<'e> {
        let mut likelihood = stage.options.likelihood;
        (likelihood.rays.loss, likelihood.ellipses.loss) = (Loss::Squared, Loss::Squared);
        Evidence::new(stage.evidence.model, &self.estimate.rig, likelihood, self.measure)
    }
}

/// A trial's frames without its jumps, as they were found when it was fitted alone.
pub(super) fn without_jumps<'a>(
    rig: &Rig,
    frames: Cow<'a, [FrameObservations]>,
    jumps: &[Cause],
) -> Cow<'a, [FrameObservations]> {
    let id = |camera: &str| rig.by_name(camera).map(|(id, _)| id);
    let without = |frames: Cow<'a, [FrameObservations]>, jump: &Cause| match jump {
        Cause::LostFrames { camera, frame, frames: lost } => id(camera)
            .map(|id| Cow::Owned(numbered_anew(&frames, id, *frame, *lost)))
            .unwrap_or(frames),
        Cause::TouchedWhile { camera, left_out: [first, last], .. } => id(camera)
            .map(|id| Cow::Owned(left_out(&frames, id, &(first.0..last.0 + 1))))
            .unwrap_or(frames),
        _ => frames,
    };
    jumps.iter().fold(frames, without)
}

/// The number of the frame whose body a camera shows in a frame, by the number of its file.
pub(super) fn shown_number<'c>(
    rig: &Rig,
    jumps: impl Iterator<Item = &'c Cause>,
    id: CameraId,
    frame: FrameIndex,
) -> usize {
    let later = |number: FrameIndex, jump: &Cause| match jump {
        Cause::LostFrames { camera, frame, frames }
            if number >= *frame && *camera == rig.cameras[id.0].name =>
        {
            FrameIndex(number.0.saturating_add_signed(*frames))
        }
        _ => number,
    };
    jumps.fold(frame, later).0
}

/// The frame numbers on that side of a jump on which a camera shows less; `None` without frames.
fn shorter_side(
    frames: &[FrameObservations],
    camera: CameraId,
    jump: FrameIndex,
) -> Option<Range<usize>> {
    let shown = frames.iter().filter(|frame| frame.is_shown_by(camera));
    let (before, behind): (Vec<_>, Vec<_>) = shown.partition(|frame| frame.frame < jump);
    let (first, last) = (frames.first()?.frame.0, frames.last()?.frame.0);
    Some(if behind.len() <= before.len() { jump.0..last + 1 } else { first..jump.0 })
}

/// Without what a camera shows in a range of frame numbers.
fn left_out(
    frames: &[FrameObservations],
    camera: CameraId,
    numbers: &Range<usize>,
) -> Vec<FrameObservations> {
    let kept = |frame: &FrameObservations| match numbers.contains(&frame.frame.0) {
        true => frame.without(camera),
        false => frame.clone(),
    };
    frames.iter().map(kept).collect()
}

#[cfg(test)]
mod tests {
    use nalgebra::Point2;

    use super::*;
    use crate::silhouette::{Detection, Keypoint};
    use crate::synth::Ring;

    /// Eight frames of three cameras: in x what a camera shows, the moment.
    fn frames() -> Vec<FrameObservations> {
        let seen = |moment: usize| {
            let pixel = Point2::new(moment as f64, 0.0);
            let names = ["RHip", "LHip", "Neck"];
            let keypoints = names.map(|name| Keypoint { name, pixel, confidence: 1.0 });
            Detection { keypoints: keypoints.to_vec(), size_px: 100.0 }
        };
        let frame = |i: usize| FrameObservations {
            detections: (0..3).map(|camera| (CameraId(camera), seen(i))).collect(),
            ..FrameObservations::nothing(FrameIndex(10 + i))
        };
        (0..8).map(frame).collect()
    }

    /// The moments that a camera shows, frame by frame.
    fn shown(frames: &[FrameObservations], camera: usize) -> Vec<Option<usize>> {
        let of = |frame: &FrameObservations| {
            let (_, seen) = frame.detections.iter().find(|(id, _)| id.0 == camera)?;
            Some(seen.keypoints[0].pixel.x as usize)
        };
        frames.iter().map(of).collect()
    }

    #[test]
    fn what_is_shown_behind_lost_frames_is_later_and_a_side_that_is_left_out_is_gone() {
        let rig = Ring { cameras: 3, ..Ring::default() }.regular();
        let camera = rig.cameras[1].name.clone();
        let lost = |frames: isize| Cause::LostFrames {
            camera: camera.clone(),
            frame: FrameIndex(13),
            frames,
        };
        let without = |jumps: &[Cause]| without_jumps(&rig, Cow::Owned(frames()), jumps);
        let all = |moments: [usize; 8]| moments.map(Some).to_vec();

        let two = without(&[lost(2)]);
        let [a, b, c, d, e, f] = [0, 1, 2, 3, 4, 5].map(Some);
        assert_eq!(shown(&two, 1), [a, b, c, None, None, d, e, f]);
        assert_eq!(shown(&two, 0), all([0, 1, 2, 3, 4, 5, 6, 7]));
        assert!(two.iter().all(|frame| frame.detections.is_sorted_by_key(|(id, _)| *id)));
        let twice = without(&[lost(-2)]);
        assert_eq!(shown(&twice, 1), [a, b, c, f, Some(6), Some(7), None, None]);

        let jumps = [lost(2)];
        let number = |id: usize, frame: usize| {
            shown_number(&rig, jumps.iter(), CameraId(id), FrameIndex(frame))
        };
        assert_eq!([number(1, 12), number(1, 13), number(2, 13)], [12, 15, 13]);

        let side = shorter_side(&frames(), CameraId(1), FrameIndex(13)).expect("frames");
        assert_eq!(side, 10..13);
        let left_out = [side.start, side.end - 1].map(FrameIndex);
        let touched =
            Cause::TouchedWhile { camera, frame: FrameIndex(13), turn_deg: 1.0, left_out };
        let kept = without(&[touched]);
        let [g, h] = [6, 7].map(Some);
        assert_eq!(shown(&kept, 1), [None, None, None, d, e, f, g, h]);
        assert_eq!(shown(&kept, 2), all([0, 1, 2, 3, 4, 5, 6, 7]));
    }
}
