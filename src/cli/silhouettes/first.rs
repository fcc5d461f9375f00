//! The first fit, which says where to look: read, or fitted to the depths of what moves.

use std::collections::BTreeMap;
use std::path::Path;

use crate::body::{BodyModel, Motion, Shape};
use crate::camera::CameraId;
use crate::cli::error::CliError;
use crate::cli::frame_range::span;
use crate::cli::progress::Progress;
use crate::inference::propagate::Sequence;
use crate::inference::search::NoJournal;
use crate::io::frames::Footage;
use crate::io::result::ResultFile;
use crate::pipeline::silhouettes::{ShownFrame, StillScene, nearness};
use crate::pipeline::{self, FitOptions, FitTo};
use crate::silhouette::{FrameIndex, FrameObservations};
use crate::stereo::{CloudPoint, DepthMap, SideBySide};

/// Frames of which the still scene is made at most.
const STILL_FRAMES: usize = 40;
/// Points of one frame that are fitted to at most.
const MOST_POINTS: usize = 4000;
/// Ways in which the first body may differ from the mean: as many as the shipped bodies have common factors (stature, girth, sex).
const BUILDS: usize = 3;
/// Share of their standard deviation that is left to the other ways.
const HELD: f64 = 0.05;

/// Shape and motion to begin with.
#[derive(Debug)]
pub(in crate::cli) struct First {
    pub(super) shape: Shape,
    pub(super) motions: BTreeMap<FrameIndex, Motion>,
}

impl First {
    /// That of an earlier fit of the same body.
    pub(super) fn read(folder: &Path, model: &BodyModel) -> Result<Self, CliError> {
        let result = ResultFile::read(folder)?;
        let frames = result.motion.frames.iter();
        Ok(Self {
            shape: result.shape_of(model)?,
            motions: frames.map(|f| (FrameIndex(f.frame), f.motion())).collect(),
        })
    }

    /// Fitted to the points of what moves, by stereo alone.
    pub(super) fn by_depth(
        footage: &Footage,
        frames: &[FrameIndex],
        model: &BodyModel,
        progress: Progress,
    ) -> Result<Self, CliError> {
        let chosen = SideBySide::of(&footage.rig).map_err(|e| {
            CliError::Arguments(format!("{e}; give a fitted body to begin with: --fit DIR"))
        })?;
        let template = chosen.template;
        // 1. what does not move
        let step = frames.len().div_ceil(STILL_FRAMES).max(1);
        let some: Vec<FrameIndex> = frames.iter().step_by(step).copied().collect();
        let mut maps = Vec::new();
        each_depth(
            footage,
            (&some, template),
            (progress, "still scene"),
            |_, map| maps.push(nearness(map)),
        );
        let still = StillScene::of(&maps);
        // 2. what does
        let mut observed = Vec::new();
        each_depth(
            footage,
            (frames, template),
            (progress, "depth"),
            |frame, map| {
                observed.push(FrameObservations {
                    points: thinned(still.moving(map)),
                    ..FrameObservations::nothing(frame)
                });
            },
        );
        // 3. the body on it
        let options = FitOptions {
            fit_to: FitTo::Points,
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
        })
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

fn thinned(points: Vec<CloudPoint>) -> Vec<CloudPoint> {
    let step = points.len().div_ceil(MOST_POINTS).max(1);
    points.into_iter().step_by(step).collect()
}

/// The depth map of one camera in some frames (ascending); frames without one are left out.
fn each_depth(
    footage: &Footage,
    (frames, camera): (&[FrameIndex], CameraId),
    (progress, stage): (Progress, &'static str),
    mut take: impl FnMut(FrameIndex, &DepthMap),
) {
    let bar = progress.bar(stage, frames.len());
    for (frame, pictures) in footage.frame_sets(span(frames)) {
        if frames.binary_search(&frame).is_err() {
            continue;
        }
        let shown = ShownFrame::of(&footage.rig, &pictures);
        if let Some(map) = shown.ok().and_then(|s| s.depth(&footage.rig, camera, None)) {
            take(frame, &map);
        }
        bar.inc(1);
    }
    bar.finish_and_clear();
}

#[cfg(test)]
mod tests {
    use super::*;
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
        let (free, held) = (variances(&model), variances(&of_plain_build(&model)));
        for way in 0..BUILDS {
            assert!((held[way] / free[way] - 1.0).abs() < 1e-6);
        }
        assert!(held[BUILDS] < 0.01 * free[BUILDS] && held.iter().all(|v| *v > 0.0));
    }
}
