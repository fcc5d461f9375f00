//! The two pipelines of PF02 §4 over all frames of a recording.

use super::{ContourOptions, Scene, ShownFrame, Sighting, SilhouetteError, StartingFit};
use crate::body::{BodyModel, Posed};
use crate::image::Picture;
use crate::inference::Evidence;
use crate::likelihood::{LikelihoodOptions, Measure, SkinScale};
use crate::pipeline::{PictureSource, Progress, span};
use crate::silhouette::FrameIndex;

/// Turns of contours and joint optimum: with two a body of plain build is still too thin, with more it may drift to edges
/// beside it.
const TURNS: usize = 4;

/// Which pipeline of PF02.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum SilhouettePipeline {
    /// Active contours from the outline of the starting fit (§4.1).
    Simple,
    /// Contours, and a fit to them and to stereo, by turns (§4.3).
    ///
    /// **Differs** from the paper, which goes from frame to frame: each of four turns takes all frames at once.
    #[default]
    Joint,
}

/// What one frame gave.
#[derive(Debug)]
pub struct FrameSilhouettes<'a> {
    /// Which frame.
    pub frame: FrameIndex,
    /// What the cameras show, a place for each of the rig.
    pub pictures: &'a [Option<Picture>],
    /// The contours of each view, and what a fit can use of the frame.
    pub sighting: Sighting,
}

/// A search for silhouettes: in which pictures, with which body, from where, and how.
#[derive(Debug, Clone, Copy)]
pub struct SilhouetteSearch<'a, P: PictureSource + ?Sized> {
    /// The pictures.
    pub pictures: &'a P,
    /// The frames, ascending.
    pub frames: &'a [FrameIndex],
    /// The body that predicts the outlines; it has metaballs.
    pub model: &'a BodyModel,
    /// Where it is at first.
    pub start: &'a StartingFit,
    /// Which pipeline.
    pub pipeline: SilhouettePipeline,
}

impl<P: PictureSource> SilhouetteSearch<'_, P> {
    /// Hands the silhouettes of every frame to `take`; what was left out, and why, in one line each.
    ///
    /// # Errors
    /// Whatever `take` fails with.
    pub fn run<E: From<SilhouetteError>>(
        &self,
        progress: &dyn Progress,
        take: impl FnMut(FrameSilhouettes<'_>) -> Result<(), E>,
    ) -> Result<Vec<String>, E> {
        let rig = self.pictures.rig();
        let likelihood = LikelihoodOptions::default();
        let evidence = Evidence::new(self.model, rig, likelihood, Measure::Metaballs);

        // 1. the body of each frame
        let fitted = match self.pipeline {
            SilhouettePipeline::Simple => self.start.clone(),
            SilhouettePipeline::Joint => self.refit_by_turns(&evidence, progress)?,
        };
        // 2. active contours from its outline
        self.each_frame(&fitted, "silhouettes", progress, take)
    }

    /// Shape and motion of all frames at once fitted to stereo and contours, and contours from there, by turns.
    fn refit_by_turns<E: From<SilhouetteError>>(
        &self,
        evidence: &Evidence<'_>,
        progress: &dyn Progress,
    ) -> Result<StartingFit, E> {
        let mut fitted = self.start.clone();
        for _ in 0..TURNS {
            let mut observed = Vec::new();
            self.each_frame(&fitted, "following", progress, |found| {
                observed.push(found.sighting.observed);
                Ok::<(), E>(())
            })?;
            fitted = fitted.refitted(&observed, evidence, self.pictures.fps());
        }
        Ok(fitted)
    }

    /// Hands what is seen of a body in every frame that it has to `take`; what was left out, and why.
    fn each_frame<E: From<SilhouetteError>>(
        &self,
        fit: &StartingFit,
        stage: &'static str,
        progress: &dyn Progress,
        mut take: impl FnMut(FrameSilhouettes<'_>) -> Result<(), E>,
    ) -> Result<Vec<String>, E> {
        let rig = self.pictures.rig();
        let scale = SkinScale::new(self.model);
        let mut skipped = Vec::new();

        progress.begin(stage, self.frames.len());
        for (frame, pictures) in self.pictures.pictures(span(self.frames)) {
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

            let body = Posed::new(self.model, &fit.shape, motion);
            let scene = Scene::new(rig, (&shown, &fit.still), &body, ContourOptions::default());
            take(FrameSilhouettes {
                frame,
                pictures: &pictures,
                sighting: scene.sighting(frame, &body, &scale),
            })?;
        }
        progress.end();
        Ok(skipped)
    }
}
