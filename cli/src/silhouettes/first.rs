//! The first fit, which says where to look: read, or fitted to what moves.

use std::collections::BTreeMap;
use std::path::Path;

use crate::error::CliError;
use maquette::body::{BodyModel, Motion, Shape};
use maquette::camera::CameraId;
use maquette::inference::joint::{JointOptions, joint_optimum};
use maquette::inference::search::NoJournal;
use maquette::inference::sequence_posterior::SequenceState;
use maquette::inference::{Evidence, Sequence};
use maquette::io::recording::footage::Footage;
use maquette::io::result::ResultFile;
use maquette::likelihood::Measure;
use maquette::pipeline::silhouettes::{ShownFrame, StillScenes, nearness};
use maquette::pipeline::{self, FitOptions};
use maquette::pipeline::{Progress, span};
use maquette::silhouette::{FrameIndex, FrameObservations};
use maquette::stereo::SideBySide;

/// Frames of which the still scene is made at most.
const STILL_FRAMES: usize = 40;
/// Ways in which the first body may differ from the mean: as many as the shipped bodies have common factors (stature, girth, sex).
const BUILDS: usize = 3;
/// Share of their standard deviation that is left to the other ways.
const HELD: f64 = 0.05;

/// Shape and motion to begin with.
#[derive(Debug, Clone)]
pub(crate) struct First {
    pub(super) shape: Shape,
    pub(super) motions: BTreeMap<FrameIndex, Motion>,
    /// What stands still.
    pub(super) still: StillScenes,
}

impl First {
    /// That of an earlier fit of the same body.
    pub(super) fn read(
        folder: &Path,
        footage: &Footage,
        frames: &[FrameIndex],
        model: &BodyModel,
        progress: &dyn Progress,
    ) -> Result<Self, CliError> {
        let result = ResultFile::read(folder)?;
        let fitted = result.motion.frames.iter();
        Ok(Self {
            shape: result.shape_of(model)?,
            motions: fitted.map(|f| (FrameIndex(f.frame), f.motion())).collect(),
            still: still_scenes(footage, frames, progress),
        })
    }

    /// Fitted to what moves, by depth alone.
    pub(super) fn found(
        footage: &Footage,
        frames: &[FrameIndex],
        model: &BodyModel,
        progress: &dyn Progress,
    ) -> Result<Self, CliError> {
        SideBySide::choose(&footage.rig).map_err(|e| {
            CliError::Arguments(format!("{e}; give a fitted body to begin with: --fit DIR"))
        })?;
        // 1. what does not move
        let still = still_scenes(footage, frames, progress);
        // 2. what does: points, and where they are none
        let mut observed = Vec::new();
        each_shown(footage, frames, (progress, "depth"), |frame, shown| {
            observed.push(still.moving(frame, &footage.rig, &shown));
        });
        // 3. the body on it
        let options = FitOptions {
            measure: Some(Measure::Metaballs),
            ..FitOptions::default()
        };
        let sequence = Sequence {
            frames: &observed,
            fps: footage.fps,
        };
        let plain = of_plain_build(model);
        let fit = pipeline::fit(&plain, &footage.rig, sequence, &options, &NoJournal)?;
        let motions = fit.frames.into_iter().map(|f| (f.frame, f.fit.motion));
        Ok(Self {
            shape: fit.shape,
            motions: motions.collect(),
            still,
        })
    }

    /// Shape and motion of all frames at once, fitted to what was observed in them (PF02 § 4.3, step 3).
    pub(super) fn fitted_to(
        mut self,
        observed: &[FrameObservations],
        evidence: &Evidence<'_>,
        fps: f64,
    ) -> Self {
        if observed.is_empty() {
            return self;
        }
        let motions = observed.iter().filter_map(|o| self.motions.get(&o.frame));
        let start = SequenceState {
            shape: self.shape.clone(),
            motions: motions.cloned().collect(),
        };
        let sequence = Sequence {
            frames: observed,
            fps,
        };
        let joint = joint_optimum(evidence, sequence, start, &JointOptions::default());
        let fitted = observed.iter().zip(joint.frames);
        self.motions
            .extend(fitted.map(|(o, fit)| (o.frame, fit.motion)));
        Self {
            shape: joint.shape,
            ..self
        }
    }
}

/// A model whose shape varies in no more ways than [`BUILDS`], those in which people differ most.
///
/// Points of one side tell how tall and how stout somebody is, but not each girth, nor the length of a foot on the ground: fitted freely,
/// the flesh that nobody sees grows.
fn of_plain_build(model: &BodyModel) -> BodyModel {
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

/// What the cameras see that does not move, of frames spread over the recording.
fn still_scenes(footage: &Footage, frames: &[FrameIndex], progress: &dyn Progress) -> StillScenes {
    let mut maps = BTreeMap::<CameraId, Vec<_>>::new();
    if SideBySide::choose(&footage.rig).is_err() {
        // no camera sees depth
        return StillScenes::default();
    }
    let some = spread(frames, STILL_FRAMES);
    each_shown(footage, &some, (progress, "still scene"), |_, shown| {
        for (camera, map) in shown.depths(&footage.rig) {
            maps.entry(camera).or_default().push(nearness(&map));
        }
    });
    StillScenes::of(&maps)
}

/// At most so many frames, spread over all.
fn spread(frames: &[FrameIndex], most: usize) -> Vec<FrameIndex> {
    let step = frames.len().div_ceil(most).max(1);
    frames.iter().step_by(step).copied().collect()
}

/// The pictures of some frames (ascending); those that cannot be used are left out.
fn each_shown(
    footage: &Footage,
    frames: &[FrameIndex],
    (progress, stage): (&dyn Progress, &'static str),
    mut take: impl FnMut(FrameIndex, ShownFrame),
) {
    progress.begin(stage, frames.len());
    for (frame, pictures) in footage.frame_sets(span(frames)) {
        if frames.binary_search(&frame).is_err() {
            continue;
        }
        if let Ok(shown) = ShownFrame::of(&footage.rig, &pictures) {
            take(frame, shown);
        }
        progress.step();
    }
    progress.end();
}

#[cfg(test)]
mod tests {
    use super::*;
    use maquette::io::model;

    #[test]
    fn a_plain_build_varies_in_three_ways_as_people_do_and_hardly_in_others() {
        let model = model::load("human-metaballs", Path::new("")).unwrap();
        let variances = |model: &BodyModel| {
            let spread = model.statistics.covariance.clone().symmetric_eigen();
            let mut values: Vec<f64> = spread.eigenvalues.iter().copied().collect();
            values.sort_by(|a, b| b.total_cmp(a));
            values
        };
        let (free, held) = (variances(&model), variances(&of_plain_build(&model)));
        for way in 0..BUILDS {
            assert!((held[way] / free[way] - 1.0).abs() < 1e-6);
        }
        assert!(held[BUILDS] < 0.01 * free[BUILDS] && held.iter().all(|v| *v > 0.0));
    }
}
