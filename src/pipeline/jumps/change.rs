//! What changed of a camera, and when: it has lost frames, or was touched.
//!
//! Beside the body that the others show, C_i(n, R) is what frame i of the camera costs before the body of n frames later, turned by R about the
//! camera's centre. Up to some frame the camera shows the body of n₀ frames later, turned by R₀: both are usually nothing. From this frame on
//! either n is another, or R. Of either, the frame is the one with which all frames of the camera together cost least, and so are n and R.
//! Where frames come twice, n falls.
//!
//! More numbers always cost less. A change is one that explains what the camera shows if Schwarz's criterion prefers it: of N frames that cost
//! C₀ with one n and one R, and C with a change of k numbers more, N ln(C₀/C) > k ln N; k = 3 of a touch, the frame and the two numbers of R, and 2 of lost frames. What
//! masks lack, they lack in many frames in a row: frames that are worth one count once in N ([`in_a_row`]), by what they cost on either side of the change.
//!
//! What the others cost is added. So all changes of all cameras are compared by what all that is shown costs: without the camera that changed the
//! others agree, without another they do not.
//!
//! # Source
//! Schwarz 1978, *Estimating the dimension of a model*; errors whose variance is not known.

use std::ops::Range;

use nalgebra::UnitQuaternion;
use rayon::prelude::*;

use super::beside::Moments;
use super::step::{SIDE, Step};
use crate::body::Motion;
use crate::camera::CameraId;
use crate::inference::Look;
use crate::inference::camera_offset::CameraOffset;
use crate::inference::camera_prior::TURN_SD;
use crate::inference::noise::in_a_row;
use crate::pipeline::joint_stage::turn_towards;
use crate::silhouette::FrameIndex;

/// At most so many frames are lost at once.
const MOST_LOST: isize = 25;
/// So many n are tried.
const CHOICES: usize = 2 * MOST_LOST as usize + 1;
/// By how many frames it is ahead on either side of a jump, so many frames tell.
const NEAR: usize = 12;
/// A turn is found in so many steps.
const STEPS: usize = 5;
/// Two turns and the frame between them are found in so many rounds.
const ROUNDS: usize = 4;

/// A change of a camera.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Change {
    pub(super) camera: CameraId,
    /// The first frame after it.
    pub(super) frame: FrameIndex,
    pub(super) what: What,
    /// What all cameras show costs with it, beside the body that the others show.
    pub(super) cost: f64,
    /// As many frames without lasting errors as those of the camera are worth.
    frames: f64,
}

/// What changed.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum What {
    /// So many frames are lost; negative: they come twice.
    Frames(isize),
    /// The camera was turned by this angle, radians.
    Turn(f64),
}

impl Change {
    /// Both that are possible of a camera that jumps somewhere, beside the body of the others.
    pub(super) fn both(moments: &Moments<'_>, jump: &Step) -> Vec<Self> {
        let shown = Shown::new(moments, jump.camera);
        let by_frames = shown.by_whole_frames();
        let Some(split) = Split::best(&by_frames, &by_frames) else { return Vec::new() };
        let lost = shown.lost(&by_frames, split);

        // of a camera that was touched the frames of either side may tell n
        let mut ahead = vec![whole_frames(split.before), whole_frames(split.behind)];
        ahead.dedup();
        let touched = ahead.into_iter().filter_map(|ahead| shown.touched(ahead, jump.frame));
        let touched = touched.min_by(|a, b| a.cost.total_cmp(&b.cost));

        // one that explains nothing is none
        let both = lost.into_iter().chain(touched);
        let unchanged = shown.unchanged([split.before, split.behind].map(whole_frames));
        let both = both.filter(|change| unchanged.is_none_or(|cost| change.explains(cost)));

        let others: f64 = moments.costs(|id| id != jump.camera).iter().sum();
        both.map(|change| Self { cost: change.cost + others, ..change }).collect()
    }

    /// Whether it explains more of what the camera shows than its numbers would by chance, while it counts what this camera costs alone.
    fn explains(&self, unchanged: f64) -> bool {
        let numbers = match self.what {
            What::Frames(_) => 2.0,
            What::Turn(_) => 3.0,
        };
        self.frames * (unchanged / self.cost).ln() > numbers * self.frames.ln()
    }
}

/// What each frame of a camera costs beside a body, on the side of a jump that was left out: before the camera turned to what it shows there.
pub(super) fn costs_turned(
    moments: &Moments<'_>,
    camera: CameraId,
    side: &Range<usize>,
) -> Option<Vec<f64>> {
    let mut shown = Shown::new(moments, camera);
    shown.frames.retain(|shown| side.contains(&shown.frame.0));
    let all = 0..shown.frames.len();
    let turn = shown.turn(&[(all.clone(), 0)], UnitQuaternion::identity())?;
    Some(shown.costs(all, 0, turn).into_iter().flatten().collect())
}

/// What a camera shows.
struct Shown<'m> {
    moments: &'m Moments<'m>,
    camera: CameraId,
    frames: Vec<ShownFrame<'m>>,
}

struct ShownFrame<'m> {
    frame: FrameIndex,
    /// Its position in the recording.
    position: usize,
    looks: Vec<Look<'m>>,
}

impl<'m> Shown<'m> {
    fn new(moments: &'m Moments<'m>, camera: CameraId) -> Self {
        let shown = moments.looks(camera).into_iter();
        let frames = shown.map(|(frame, position, looks)| ShownFrame { frame, position, looks });
        Self { moments, camera, frames: frames.collect() }
    }

    /// What the frames cost with each n.
    fn by_whole_frames(&self) -> Vec<Sums> {
        let costs =
            |i| self.costs(0..self.frames.len(), whole_frames(i), UnitQuaternion::identity());
        (0..CHOICES).map(|i| Sums::new(&costs(i))).collect()
    }

    /// What all frames cost with one n of these and one R.
    fn unchanged(&self, ahead: [isize; 2]) -> Option<f64> {
        let all = 0..self.frames.len();
        let cost = |ahead: isize| {
            let turn = self.turn(&[(all.clone(), ahead)], UnitQuaternion::identity())?;
            Sums::new(&self.costs(all.clone(), ahead, turn)).of(all.clone())
        };
        ahead.into_iter().filter_map(cost).reduce(f64::min)
    }

    /// n where it changes, by what the frames cost with each; `None` if it does not.
    fn lost(&self, by_frames: &[Sums], split: Split) -> Option<Change> {
        if split.before == split.behind {
            return None;
        }

        // R₀ of both sides together
        let (first, end) = (split.first_behind, self.frames.len());
        let [before, behind] = [split.before, split.behind].map(whole_frames);
        let sides = [(0..first, before), (first..end, behind)];
        let still = self.turn(&sides, UnitQuaternion::identity())?;
        let costs = sides.map(|(side, ahead)| self.costs(side, ahead, still));

        // it may change elsewhere, too: the frames near it tell by how much
        let near = [first.saturating_sub(NEAR)..first, first..end.min(first + NEAR)];
        let near = near.map(|side| least(by_frames, side).map(|(i, _)| whole_frames(i)));
        let frames = near[1].unwrap_or(behind) - near[0].unwrap_or(before);
        (frames != 0).then(|| self.change(What::Frames(frames), costs)).flatten()
    }

    /// R where it changes, with the same n in all frames; `None` if it changes by less than a calibration errs.
    fn touched(&self, ahead: isize, jump: FrameIndex) -> Option<Change> {
        let end = self.frames.len();
        let mut first = self.frames.partition_point(|shown| shown.frame < jump);
        let mut found = None;
        for _ in 0..ROUNDS {
            let still = self.turn(&[(0..first, ahead)], UnitQuaternion::identity())?;
            let turn = self.turn(&[(first..end, ahead)], still)?;
            let sums = |turn| [Sums::new(&self.costs(0..end, ahead, turn))];
            let split = Split::best(&sums(still), &sums(turn))?;
            found = Some((split, still, turn));
            if split.first_behind == first {
                break;
            }
            first = split.first_behind;
        }
        let (Split { first_behind, .. }, still, turn) = found?;
        let costs = [(0..first_behind, still), (first_behind..end, turn)];
        let costs = costs.map(|(side, turn)| self.costs(side, ahead, turn));
        let turn_rad = still.angle_to(&turn);
        (turn_rad >= TURN_SD).then(|| self.change(What::Turn(turn_rad), costs)).flatten()
    }

    /// A change, by what the frames before it and behind it cost with it; `None` of too few frames.
    fn change(&self, what: What, costs: [Vec<Option<f64>>; 2]) -> Option<Change> {
        let sums = costs.each_ref().map(|side| Sums::new(side).of(0..side.len()));
        let first = costs[0].len();
        let known = |(i, cost): (usize, &Option<f64>)| Some((self.frames[i].frame.0, (*cost)?));
        let [before, behind] = &costs;
        let before: Vec<_> = before.iter().enumerate().filter_map(known).collect();
        let behind: Vec<_> = (first..).zip(behind).filter_map(known).collect();
        let lasting = in_a_row([before.as_slice(), behind.as_slice()].into_iter());
        Some(Change {
            camera: self.camera,
            frame: self.frames.get(first)?.frame,
            what,
            cost: sums[0]? + sums[1]?,
            frames: self.frames.len() as f64 / lasting,
        })
    }

    /// The body of n frames later before the camera turned by R.
    fn seen(&self, position: usize, ahead: isize, turn: UnitQuaternion<f64>) -> Option<Motion> {
        let camera = &self.moments.evidence.rig.cameras[self.camera.0];
        let instant = self.moments.later(self.camera, position, ahead)?;
        let offset = CameraOffset { turn, ..CameraOffset::none() };
        Some(offset.seen(camera, &instant.motion))
    }

    /// C_i(n, R); none where the body of n frames later is before or after the recording.
    fn costs(
        &self,
        side: Range<usize>,
        ahead: isize,
        turn: UnitQuaternion<f64>,
    ) -> Vec<Option<f64>> {
        let cost = |shown: &ShownFrame<'_>| {
            let motion = self.seen(shown.position, ahead, turn)?;
            Some(self.moments.cost(&shown.looks, &motion))
        };
        self.frames[side].par_iter().map(cost).collect()
    }

    /// R of some frames, each side with its n.
    fn turn(
        &self,
        sides: &[(Range<usize>, isize)],
        first: UnitQuaternion<f64>,
    ) -> Option<UnitQuaternion<f64>> {
        let camera = &self.moments.evidence.rig.cameras[self.camera.0];
        let mut turn = first;
        for _ in 0..STEPS {
            let place = |shown: &ShownFrame<'_>, ahead: isize| {
                let motion = self.seen(shown.position, ahead, turn)?;
                let pixel = self.moments.shown_px(self.camera, &shown.looks, &motion)?;
                Some((pixel, motion.position_world.into()))
            };
            let of_side = |(side, ahead): &(Range<usize>, isize)| {
                let frames = self.frames[side.clone()].par_iter();
                frames.filter_map(|shown| place(shown, *ahead)).collect::<Vec<_>>()
            };
            let places: Vec<_> = sides.iter().flat_map(of_side).collect();
            turn *= turn_towards(camera, places.into_iter());
        }
        Some(turn)
    }
}

/// The n of a choice.
fn whole_frames(choice: usize) -> isize {
    choice as isize - MOST_LOST
}

/// Costs of frames, added up from the first on.
struct Sums {
    /// Before each frame, and after the last: the sum, and of how many frames it is known.
    before: Vec<(f64, usize)>,
}

impl Sums {
    fn new(costs: &[Option<f64>]) -> Self {
        let mut sum = (0.0, 0);
        let mut before = vec![sum];
        for cost in costs {
            sum = cost.map_or(sum, |cost| (sum.0 + cost, sum.1 + 1));
            before.push(sum);
        }
        Self { before }
    }

    /// What some frames cost; where it is not known, as much as on the mean. `None` of too few frames.
    fn of(&self, frames: Range<usize>) -> Option<f64> {
        let (first, end) = (self.before[frames.start], self.before[frames.end]);
        let known = end.1 - first.1;
        (known >= SIDE).then(|| (end.0 - first.0) / known as f64 * frames.len() as f64)
    }
}

/// Which of some choices costs least on a side, and what; `None` of too few frames.
fn least(choices: &[Sums], side: Range<usize>) -> Option<(usize, f64)> {
    let costs = choices.iter().enumerate();
    let costs = costs.filter_map(|(i, sums)| Some((i, sums.of(side.clone())?)));
    costs.min_by(|a, b| a.1.total_cmp(&b.1))
}

/// Where frames are split so that both sides together cost least.
#[derive(Debug, Clone, Copy)]
struct Split {
    first_behind: usize,
    /// Which of the choices of either side costs least.
    before: usize,
    behind: usize,
    cost: f64,
}

impl Split {
    /// Of some choices for either side; `None` of too few frames.
    fn best(before: &[Sums], behind: &[Sums]) -> Option<Self> {
        let frames = before.first()?.before.len() - 1;
        let at = |first_behind: usize| {
            let (before, cost_before) = least(before, 0..first_behind)?;
            let (behind, cost_behind) = least(behind, first_behind..frames)?;
            Some(Self { first_behind, before, behind, cost: cost_before + cost_behind })
        };
        (0..frames).filter_map(at).min_by(|a, b| a.cost.total_cmp(&b.cost))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_side_of_each_frame_is_the_one_that_costs_it_least() {
        let known = |costs: [f64; 12]| Sums::new(&costs.map(Some));
        let early = [1.0, 0.9, 1.1, 1.0, 0.8, 1.0, 3.0, 3.0, 3.0, 3.0, 3.0, 3.0];
        let late = early.map(|cost| 4.0 - cost);
        let choices = [known([2.0; 12]), known(early), known(late)];
        let split = Split::best(&choices, &choices).expect("twelve frames");
        assert_eq!((split.first_behind, split.before, split.behind), (6, 1, 2));

        // of frames that are beyond the recording the others tell
        let mut beyond = late.map(Some);
        beyond[11] = None;
        let split = Split::best(&choices, &[Sums::new(&beyond)]).expect("eleven frames");
        assert_eq!((split.first_behind, split.before), (6, 1));
        beyond[10..].fill(None);
        let split = Split::best(&choices, &[Sums::new(&beyond)]).expect("ten frames");
        assert_eq!(split.first_behind, 5, "no later one leaves five frames behind it");
        beyond[9] = None;
        assert!(Split::best(&choices, &[Sums::new(&beyond)]).is_none());
    }

    #[test]
    fn a_change_must_explain_more_the_fewer_frames_tell_and_the_more_numbers_it_has() {
        let explains = |what: What, frames: f64| {
            let (camera, frame) = (CameraId(0), FrameIndex(17));
            Change { camera, frame, what, cost: 1.0, frames }.explains(1.13)
        };
        assert!(explains(What::Frames(-2), 100.0) && !explains(What::Frames(-2), 12.0));
        assert!(!explains(What::Turn(0.01), 100.0) && explains(What::Turn(0.01), 200.0));
    }
}
