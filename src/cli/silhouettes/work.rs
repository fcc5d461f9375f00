//! The frames of a run, one after another, and in the joint pipeline all at once.

use std::path::Path;

use super::{First, Pipeline};
use crate::body::{BodyModel, Motion, Posed};
use crate::cli::error::CliError;
use crate::cli::frame_range::span;
use crate::cli::progress::Progress;
use crate::image::Picture;
use crate::inference::Evidence;
use crate::io::frames::Footage;
use crate::io::silhouettes::{SilhouetteExtras, SilhouetteFolder};
use crate::likelihood::{LikelihoodOptions, Measure, SkinScale};
use crate::pipeline::silhouettes::{ContourOptions, Follower, Scene, Seen, ShownFrame};
use crate::silhouette::{FrameIndex, FrameObservations};

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
        // 1. the body of each frame
        let fitted = match self.pipeline {
            Pipeline::Simple => self.by_stereo(progress)?,
            Pipeline::Joint => self.together(progress)?,
        };
        // 2. active contours from its outline
        let model = self.evidence.model;
        let scale = SkinScale::of(model);
        self.each(
            &fitted,
            (progress, "silhouettes"),
            |frame, pictures, scene, motion| {
                let body = Posed::new(model, &fitted.shape, motion);
                let seen = scene.contours(&body);
                let points = match self.pipeline {
                    Pipeline::Simple => Vec::new(),
                    Pipeline::Joint => scene.points_near(&[body], &seen, &scale),
                };
                let observed = scene.observed(frame, &seen, points);
                take(Found {
                    frame,
                    pictures,
                    seen,
                    observed,
                })
            },
        )
    }

    /// The body of each frame by stereo alone, of the first fit's shape.
    fn by_stereo(&self, progress: Progress) -> Result<First, CliError> {
        let mut fitted = self.first.clone();
        let mut follower = Follower::new(self.evidence, &self.first.shape, self.footage.fps);
        self.each(
            self.first,
            (progress, "following"),
            |frame, _, scene, motion| {
                let motion = follower.by_stereo(frame, scene, motion);
                fitted.motions.insert(frame, motion);
                Ok(())
            },
        )?;
        Ok(fitted)
    }

    /// Shape and motion fitted to stereo and to the contours of all frames at once, from where they were followed.
    fn together(&self, progress: Progress) -> Result<First, CliError> {
        let mut fitted = self.first.clone();
        let mut observed = Vec::new();
        let mut follower = Follower::new(self.evidence, &self.first.shape, self.footage.fps);
        self.each(
            self.first,
            (progress, "following"),
            |frame, _, scene, motion| {
                let followed = follower.advance(frame, scene, motion);
                fitted.motions.insert(frame, followed.motion);
                observed.push(followed.observed);
                Ok(())
            },
        )?;
        Ok(fitted.fitted_to(&observed, self.evidence, self.footage.fps))
    }

    /// Hands every frame that a fit has, with its motion there, to `take`; what was left out, and why.
    fn each(
        &self,
        fit: &First,
        (progress, stage): (Progress, &'static str),
        mut take: impl FnMut(
            FrameIndex,
            &[Option<Picture>],
            &Scene<'_>,
            &Motion,
        ) -> Result<(), CliError>,
    ) -> Result<Vec<String>, CliError> {
        let rig = &self.footage.rig;
        let mut skipped = Vec::new();
        let bar = progress.bar(stage, self.frames.len());
        for (frame, pictures) in self.footage.frame_sets(span(self.frames)) {
            bar.inc(1);
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
            take(frame, &pictures, &scene, motion)?;
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
    let evidence = evidence(model, footage);
    let first = First::found(footage, frames, &evidence, progress)?;
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
        observed.push(found.observed);
        Ok(())
    })?;
    folder.finish()?;
    Ok((observed, notes))
}
