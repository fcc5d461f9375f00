//! The frames of a run, one after another, and in the joint pipeline all at once.

use std::path::Path;

use super::{First, Pipeline};
use crate::error::CliError;
use maquette::body::{BodyModel, Posed};
use maquette::image::Picture;
use maquette::inference::Evidence;
use maquette::io::folder::silhouettes::{SilhouetteExtras, SilhouetteFolder};
use maquette::io::recording::footage::Footage;
use maquette::likelihood::{LikelihoodOptions, Measure, SkinScale};
use maquette::pipeline::silhouettes::{ContourOptions, Scene, ShownFrame, Sighting};
use maquette::pipeline::{Progress, span};
use maquette::silhouette::{FrameIndex, FrameObservations};

/// Turns of contours and joint optimum: with two a body of plain build is still too thin, with more it may drift to edges beside it.
const TURNS: usize = 4;

/// What contours and depths are compared with: a skin of metaballs.
pub(super) fn evidence<'a>(model: &'a BodyModel, footage: &'a Footage) -> Evidence<'a> {
    let likelihood = LikelihoodOptions::default();
    Evidence::new(model, &footage.rig, likelihood, Measure::Metaballs)
}

/// A run.
pub(super) struct Work<'a> {
    pub(super) footage: &'a Footage,
    pub(super) frames: &'a [FrameIndex],
    pub(super) evidence: &'a Evidence<'a>,
    pub(super) first: &'a First,
    pub(super) pipeline: Pipeline,
}

/// What one frame gave.
pub(super) struct Found<'a> {
    pub(super) frame: FrameIndex,
    pub(super) pictures: &'a [Option<Picture>],
    pub(super) sighting: Sighting,
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
            .sighting
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
        progress: &dyn Progress,
        take: impl FnMut(Found<'_>) -> Result<(), CliError>,
    ) -> Result<Vec<String>, CliError> {
        // 1. the body of each frame
        let fitted = match self.pipeline {
            Pipeline::Simple => self.first.clone(),
            Pipeline::Joint => self.together(progress)?,
        };
        // 2. active contours from its outline
        self.each(&fitted, (progress, "silhouettes"), take)
    }

    /// Shape and motion of all frames at once fitted to stereo and contours, and contours from there, by turns.
    fn together(&self, progress: &dyn Progress) -> Result<First, CliError> {
        let mut fitted = self.first.clone();
        for _ in 0..TURNS {
            let mut observed = Vec::new();
            self.each(&fitted, (progress, "following"), |found| {
                observed.push(found.sighting.observed);
                Ok(())
            })?;
            fitted = fitted.fitted_to(&observed, self.evidence, self.footage.fps);
        }
        Ok(fitted)
    }

    /// Hands what is seen of a body in every frame that it has to `take`; what was left out, and why.
    fn each(
        &self,
        fit: &First,
        (progress, stage): (&dyn Progress, &'static str),
        mut take: impl FnMut(Found<'_>) -> Result<(), CliError>,
    ) -> Result<Vec<String>, CliError> {
        let rig = &self.footage.rig;
        let scale = SkinScale::new(self.evidence.model);
        let mut skipped = Vec::new();
        progress.begin(stage, self.frames.len());
        for (frame, pictures) in self.footage.frame_sets(span(self.frames)) {
            progress.step();
            let Some(motion) = fit.motions.get(&frame) else {
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
            let body = Posed::new(self.evidence.model, &fit.shape, motion);
            let scene = Scene::new(rig, (&shown, &fit.still), &body, ContourOptions::default());
            take(Found {
                frame,
                pictures: &pictures,
                sighting: scene.sighting(frame, &body, &scale),
            })?;
        }
        progress.end();
        Ok(skipped)
    }
}

/// Silhouettes and points of some frames by the joint pipeline, to be fitted to; and what was left out.
///
/// Masks, contours and quality are kept in a folder.
pub(crate) fn observe(
    (footage, frames, out): (&Footage, &[FrameIndex], &Path),
    model: &BodyModel,
    progress: &dyn Progress,
) -> Result<(Vec<FrameObservations>, Vec<String>), CliError> {
    let evidence = evidence(model, footage);
    let first = First::found(footage, frames, model, progress)?;
    let work = Work {
        footage,
        frames,
        evidence: &evidence,
        first: &first,
        pipeline: Pipeline::Joint,
    };
    let mut folder = SilhouetteFolder::open(out, SilhouetteExtras::default())?;
    let mut observed = Vec::new();
    let notes = work.run(progress, |found| {
        found.write(&mut folder, footage, model)?;
        observed.push(found.sighting.observed);
        Ok(())
    })?;
    folder.finish()?;
    Ok((observed, notes))
}
