//! The frames of a run, one after another.

use std::path::Path;

use super::{First, Pipeline};
use crate::body::{BodyModel, Posed};
use crate::cli::error::CliError;
use crate::cli::frame_range::span;
use crate::cli::progress::Progress;
use crate::image::Picture;
use crate::inference::Evidence;
use crate::io::frames::Footage;
use crate::io::silhouettes::{SilhouetteExtras, SilhouetteFolder};
use crate::likelihood::{LikelihoodOptions, Measure};
use crate::pipeline::silhouettes::{ContourOptions, Follower, Scene, Seen, ShownFrame};
use crate::silhouette::{FrameIndex, FrameObservations};

/// A run.
pub(super) struct Work<'a> {
    pub(super) footage: &'a Footage,
    pub(super) frames: &'a [FrameIndex],
    pub(super) model: &'a BodyModel,
    pub(super) first: &'a First,
    pub(super) pipeline: Pipeline,
}

/// What one frame gave.
pub(super) struct Found<'a> {
    pub(super) frame: FrameIndex,
    pub(super) pictures: &'a [Option<Picture>],
    pub(super) seen: Vec<Option<Seen>>,
    /// Silhouettes and points; of the simple pipeline silhouettes alone.
    pub(super) observed: FrameObservations,
}

impl Found<'_> {
    /// Writes every view.
    pub(super) fn write(
        &self,
        folder: &mut SilhouetteFolder,
        footage: &Footage,
        model: &BodyModel,
    ) -> Result<(), CliError> {
        let views = self
            .seen
            .iter()
            .zip(self.pictures)
            .zip(&footage.rig.cameras);
        for ((seen, picture), camera) in views {
            if let (Some(seen), Some(picture)) = (seen, picture) {
                folder.view(self.frame, (camera, picture), seen, model)?;
            }
        }
        Ok(())
    }
}

impl Work<'_> {
    /// Hands every frame to `take`; what was left out, and why.
    pub(super) fn run(
        &self,
        progress: Progress,
        mut take: impl FnMut(Found<'_>) -> Result<(), CliError>,
    ) -> Result<Vec<String>, CliError> {
        let rig = &self.footage.rig;
        let evidence = Evidence::new(
            self.model,
            rig,
            LikelihoodOptions::default(),
            Measure::Metaballs,
        );
        let mut follower = Follower::new(&evidence, &self.first.shape, self.footage.fps);
        let mut skipped = Vec::new();
        let bar = progress.bar("silhouettes", self.frames.len());
        for (frame, pictures) in self.footage.frame_sets(span(self.frames)) {
            bar.inc(1);
            let Some(motion) = self.first.motions.get(&frame) else {
                skipped.push(format!("{frame}: the first fit has no such frame"));
                continue;
            };
            let shown = match ShownFrame::of(rig, &pictures) {
                Ok(shown) => shown,
                Err(fault) => {
                    skipped.push(format!("{frame}: {fault}"));
                    continue;
                }
            };
            let body = Posed::new(self.model, &self.first.shape, motion);
            let scene = Scene::new(rig, &shown, &body, ContourOptions::default());
            let (seen, observed) = match self.pipeline {
                Pipeline::Simple => {
                    let seen = scene.contours(&body);
                    let observed = scene.observed(frame, &seen, Vec::new());
                    (seen, observed)
                }
                Pipeline::Joint => {
                    let followed = follower.advance(frame, &scene, motion);
                    (followed.seen, followed.observed)
                }
            };
            take(Found {
                frame,
                pictures: &pictures,
                seen,
                observed,
            })?;
        }
        bar.finish_and_clear();
        Ok(skipped)
    }
}

/// Silhouettes and points of some frames by the joint pipeline, to be fitted to; and what was left out.
///
/// Masks, contours and quality are kept in a folder.
pub(in crate::cli) fn observe(
    (footage, frames, out): (&Footage, &[FrameIndex], &Path),
    model: &BodyModel,
    progress: Progress,
) -> Result<(Vec<FrameObservations>, Vec<String>), CliError> {
    let first = First::by_depth(footage, frames, model, progress)?;
    let work = Work {
        footage,
        frames,
        model,
        first: &first,
        pipeline: Pipeline::Joint,
    };
    let mut folder = SilhouetteFolder::open(out, SilhouetteExtras::default())?;
    let mut observed = Vec::new();
    let notes = work.run(progress, |found| {
        found.write(&mut folder, footage, model)?;
        observed.push(found.observed);
        Ok(())
    })?;
    folder.finish()?;
    Ok((observed, notes))
}
