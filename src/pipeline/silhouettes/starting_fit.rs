//! The fit that says where to look first: of an earlier run, or found by depth alone.

use std::collections::BTreeMap;
use std::collections::btree_map::Entry;
use std::convert::Infallible;

use super::abreast::each_frame;
use super::followed::followed;
use super::seen_depths::SeenDepths;
use super::{SilhouetteError, StillScenes, UndistortedFrame};
use crate::body::{BodyModel, Layout, Motion, PartId, Shape};
use crate::camera::CameraId;
use crate::inference::SequenceState;
use crate::inference::camera_prior::CameraPrior;
use crate::inference::joint::{Differences, JointOptions, joint_optimum_from_terms};
use crate::inference::step::between;
use crate::inference::{Evidence, Sequence};
use crate::likelihood::Measure;
use crate::pipeline::fit::estimated_of_any;
use crate::pipeline::unseen::own_joints;
use crate::pipeline::{EstimateOptions, PictureSource, Progress};
use crate::silhouette::{FrameIndex, FrameObservations};
use crate::stereo::SideBySide;

/// Most frames from which the still scene is learnt.
const STILL_FRAMES: usize = 40;
/// Ways in which the first body may differ from the mean: as many as the shipped bodies have common factors (stature,
/// girth, sex).
const BUILDS: usize = 3;
/// Share of their standard deviation that is left to the other ways.
const HELD: f64 = 0.05;

/// Shape and motion to begin with, and what stands still in the room.
#[derive(Debug, Clone)]
pub struct StartingFit {
    pub(super) shape: Shape,
    pub(super) motions: BTreeMap<FrameIndex, Motion>,
    pub(super) still: StillScenes,
}

impl StartingFit {
    /// Begins with an earlier fit of the same body.
    pub fn from_motions(
        shape: Shape,
        motions: BTreeMap<FrameIndex, Motion>,
        pictures: &dyn PictureSource,
        frames: &[FrameIndex],
        progress: &dyn Progress,
    ) -> Self {
        Self { shape, motions, still: still_scenes(pictures, frames, progress) }
    }

    /// Fits a body of plain build to what moves, by depth alone (PF02, §4.1).
    ///
    /// **Differs** from the paper, which fits to stereo points alone: the silhouettes of what moves in depth count too.
    ///
    /// # Errors
    /// [`SilhouetteError::NoDepth`] if no two cameras stand side by side, [`SilhouetteError::Fit`] if nothing that moves
    /// can be fitted.
    pub fn find(
        pictures: &dyn PictureSource,
        frames: &[FrameIndex],
        model: &BodyModel,
        progress: &dyn Progress,
    ) -> Result<Self, SilhouetteError> {
        SideBySide::choose(pictures.rig())?;

        // 1. what does not move
        let still = still_scenes(pictures, frames, progress);
        // 2. what does: points, and silhouettes where depth ends
        let rig = pictures.rig();
        let moving = each_shown(pictures, frames, ("depth", progress), |frame, shown| {
            (frame, still.moving(frame, rig, shown))
        });
        let things = followed(moving);
        // 3. the body on it; where several things move, on the one that is a body
        let options =
            EstimateOptions { measure: Some(Measure::Metaballs), ..EstimateOptions::default() };
        let of_thing = |frames| Sequence { frames, fps: pictures.fps() };
        let sequences: Vec<_> = things.iter().map(|thing| of_thing(thing)).collect();
        let plain = plain_build(model);
        let (which, found) = estimated_of_any(&plain, rig, &sequences, &options, progress)?;

        let fitted = things[which].iter().zip(found.frames);
        let motions = fitted.map(|(o, fit)| (o.frame, fit.motion)).collect();
        Ok(Self { shape: found.shape.first(model.coefficients.len()), motions, still })
    }

    /// The same of a body with more coefficients.
    pub(super) fn detailed(mut self, body: &BodyModel) -> Self {
        self.shape = SequenceState::new(self.shape, Vec::new()).detailed(body).shape;
        self
    }

    /// The same with the parts that are absent in a frame as they go between the frames about it in which they are not; at rest where there are
    /// none.
    pub(super) fn without(mut self, absent: &AbsentParts, body: &BodyModel) -> Self {
        for part in 0..body.parts.len() {
            let own = own_joints(body, part);
            let is_absent =
                |frame: &FrameIndex| absent.get(frame).is_some_and(|p| p.contains(&PartId(part)));
            let (lost, present): (Vec<FrameIndex>, Vec<FrameIndex>) =
                self.motions.keys().partition(|frame| is_absent(frame));
            for frame in lost {
                let expected = self.as_between(&present, frame, body);
                if let Some(motion) = self.motions.get_mut(&frame) {
                    own.iter().for_each(|joint| motion.angles[*joint] = expected.angles[*joint]);
                }
            }
        }
        self
    }

    /// The motion of a frame as it goes between the nearest of some frames (ascending), that of the nearest where all are on one side; at
    /// rest without any.
    fn as_between(&self, known: &[FrameIndex], frame: FrameIndex, body: &BodyModel) -> Motion {
        let place = known.partition_point(|f| *f < frame);
        let (before, after) = (known[..place].last(), known[place..].first());
        let (Some(before), Some(after)) = (before, after) else {
            let nearest = before.or(after).map(|frame| self.motions[frame].clone());
            return nearest.unwrap_or_else(|| Motion::rest(body));
        };
        let part = (frame.0 - before.0) as f64 / (after.0 - before.0) as f64;
        between(Layout::new(body), &self.motions[before], &self.motions[after], part)
    }

    /// Shape and motion of all frames at once, fitted to what was observed in them (PF02, §4.3, step 3).
    pub(super) fn refitted(
        mut self,
        observed: &[FrameObservations],
        evidence: &Evidence<'_>,
        fps: f64,
        progress: &dyn Progress,
    ) -> Self {
        if observed.is_empty() {
            return self;
        }
        let motions = observed.iter().filter_map(|o| self.motions.get(&o.frame));
        let start = SequenceState::new(self.shape.clone(), motions.cloned().collect());
        let sequence = Sequence { frames: observed, fps };
        // contours of a turn differ from camera to camera as the body does from which they were drawn
        let options = JointOptions { differences: Differences::LeftOut, ..JointOptions::default() };
        let terms = evidence.sequence_terms(sequence, CameraPrior::trusting());
        let seconds = sequence.intervals_s();
        progress.begin("joint optimum", options.most_steps());
        let step = || progress.step();
        let joint = joint_optimum_from_terms(evidence, &terms, &seconds, start, &options, &step);
        progress.end();

        let fitted = observed.iter().zip(joint.frames);
        let motions = fitted.map(|(o, fit)| (o.frame, fit.motion));
        self.motions.extend(motions);
        Self { shape: joint.shape, ..self }
    }
}

/// The parts of a body that are not where a fit has them, frame by frame.
pub(super) type AbsentParts = BTreeMap<FrameIndex, Vec<PartId>>;

/// A model whose shape varies in no more ways than [`BUILDS`], those in which people differ most.
///
/// Points of one side tell how tall and how stout somebody is, but not each girth, nor the length of a foot on the
/// ground: fitted freely, the flesh that nobody sees grows.
fn plain_build(model: &BodyModel) -> BodyModel {
    let mut plain = model.clone();
    let mut spread = model.statistics.covariance.clone().symmetric_eigen();
    let mut order: Vec<usize> = (0..spread.eigenvalues.len()).collect();
    order.sort_by(|a, b| spread.eigenvalues[*b].total_cmp(&spread.eigenvalues[*a]));
    for rare in order.into_iter().skip(BUILDS) {
        spread.eigenvalues[rare] *= HELD * HELD;
    }
    plain.statistics.covariance = spread.recompose();
    plain
}

/// What the cameras see that does not move, learnt from frames spread over the recording.
fn still_scenes(
    pictures: &dyn PictureSource,
    frames: &[FrameIndex],
    progress: &dyn Progress,
) -> StillScenes {
    if SideBySide::choose(pictures.rig()).is_err() {
        // no camera sees depth
        return StillScenes::default();
    }
    let mut seen = BTreeMap::<CameraId, SeenDepths>::new();
    let some = spread(frames, STILL_FRAMES);
    let rig = pictures.rig();
    let maps = each_shown(pictures, &some, ("still scene", progress), |frame, shown| {
        let depths = shown.depths(rig).into_iter();
        depths.map(|(camera, map)| (camera, SeenDepths::of(frame, &map))).collect::<Vec<_>>()
    });
    for (camera, depths) in maps.into_iter().flatten() {
        match seen.entry(camera) {
            Entry::Occupied(earlier) => earlier.into_mut().maps.extend(depths.maps),
            Entry::Vacant(first) => {
                first.insert(depths);
            }
        }
    }
    let mut still = StillScenes::learn(&seen);
    still.put_behind_who_stays(&seen);
    still
}

/// At most so many frames, spread over all.
fn spread(frames: &[FrameIndex], most: usize) -> Vec<FrameIndex> {
    let step = frames.len().div_ceil(most).max(1);
    frames.iter().step_by(step).copied().collect()
}

/// What is seen in some frames (ascending); those whose pictures cannot be used are left out.
fn each_shown<T: Send>(
    pictures: &dyn PictureSource,
    frames: &[FrameIndex],
    stage: (&'static str, &dyn Progress),
    look: impl Fn(FrameIndex, &UndistortedFrame) -> T + Sync,
) -> Vec<T> {
    let undistorted = |frame, seen: &[_]| {
        let shown = UndistortedFrame::new(pictures.rig(), seen).ok()?;
        Some(look(frame, &shown))
    };
    let mut looks = Vec::new();
    let Ok(()) = each_frame(pictures, frames, stage, undistorted, |_, _, seen| {
        looks.extend(seen);
        Ok::<(), Infallible>(())
    });
    looks
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::path::Path;

    use crate::io::model;

    #[test]
    fn a_plain_build_varies_in_three_ways_as_people_do_and_hardly_in_others() {
        let model = model::load("human-metaballs", Path::new("")).unwrap();
        let variances = |model: &BodyModel| {
            let spread = model.statistics.covariance.clone().symmetric_eigen();
            let mut values: Vec<f64> = spread.eigenvalues.iter().copied().collect();
            values.sort_by(|a, b| b.total_cmp(a));
            values
        };
        let (free, held) = (variances(&model), variances(&plain_build(&model)));
        for way in 0..BUILDS {
            assert!((held[way] / free[way] - 1.0).abs() < 1e-6);
        }
        assert!(held[BUILDS] < 0.01 * free[BUILDS] && held.iter().all(|v| *v > 0.0));
    }

    #[test]
    fn a_part_that_is_absent_goes_as_between_the_frames_about_it_and_others_stay() {
        let model = model::load("human-metaballs", Path::new("")).unwrap();
        let part = model.parts.iter().position(|part| part.name == "forearm_l").unwrap();
        let own = own_joints(&model, part);
        let motion = |frame: usize| {
            let mut motion = Motion::rest(&model);
            motion.angles.add_scalar_mut(frame as f64);
            motion
        };
        let motions = (0..8).map(|i| (FrameIndex(i), motion(i))).collect();
        let shape = Shape(model.statistics.mean.clone());
        let fit = StartingFit { shape, motions, still: StillScenes::default() };

        // the frames 2, 3, 6 and 7; and then all
        let absent = |frames: &[usize]| {
            frames.iter().map(|i| (FrameIndex(*i), vec![PartId(part)])).collect::<AbsentParts>()
        };
        let mut lost = fit.clone();
        for frame in [2, 3, 6, 7] {
            let motion = lost.motions.get_mut(&FrameIndex(frame)).unwrap();
            own.iter().for_each(|joint| motion.angles[*joint] = -9.0);
        }
        let found = lost.without(&absent(&[2, 3, 6, 7]), &model);
        for (frame, held) in [(1, 1), (2, 2), (3, 3), (4, 4), (6, 5), (7, 5)] {
            for joint in 0..model.joints.len() {
                let expected = if own.contains(&joint) { held } else { frame };
                let rest = model.joints[joint].rest;
                let angle = found.motions[&FrameIndex(frame)].angles[joint];
                assert!((angle - rest - expected as f64).abs() < 1e-12, "{frame}: {joint}");
            }
        }
        let all = fit.without(&absent(&[0, 1, 2, 3, 4, 5, 6, 7]), &model);
        let at_rest =
            |joint: &usize| all.motions[&FrameIndex(5)].angles[*joint] - model.joints[*joint].rest;
        assert!(own.iter().all(|joint| at_rest(joint).abs() < 1e-12));
    }
}
