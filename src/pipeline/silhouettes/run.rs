//! The two pipelines of PF02 §4 over all frames of a recording.

use std::convert::Infallible;

use super::{ContourOptions, FrameSighting, Scene, StartingFit, UndistortedFrame};
use crate::body::{BodyModel, Posed};
use crate::image::Picture;
use crate::inference::Evidence;
use crate::likelihood::{LikelihoodOptions, Measure, SkinScale};
use crate::math::stats::mean;
use crate::pipeline::{PictureSource, Progress, span};
use crate::silhouette::{FrameIndex, FrameObservations};

/// Turns of contours and joint optimum: with two a body of plain build is still too thin, with more it may drift to edges
/// beside it.
const TURNS: usize = 4;

/// Mean reliability below which contours are not to be trusted: of people it was .54 to .70, of an arm sought in a person
/// .17 to .38.
const UNSURE: f64 = 0.45;

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
    pub sighting: FrameSighting,
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

/// The silhouettes of all frames.
#[derive(Debug, Clone)]
pub struct FoundSilhouettes {
    /// Silhouettes and points of each frame, to be fitted to.
    pub observations: Vec<FrameObservations>,
    /// Mean reliability of the contours, 0 to 1; `None` without any.
    pub reliability: Option<f64>,
    /// What was left out, and why, in one line each.
    pub notes: Vec<String>,
}

impl FoundSilhouettes {
    /// That the contours of this body hardly lie on edges; `None` where they do.
    pub fn doubt(&self, body: &str) -> Option<String> {
        let reliability = self.reliability.filter(|mean| *mean < UNSURE)?;
        Some(format!(
            "the contours hardly lie on edges (mean reliability {reliability:.2}): does {body} look like the person who is seen, and is the calibration right? Look with --overlays"
        ))
    }
}

impl<P: PictureSource> SilhouetteSearch<'_, P> {
    /// Hands the silhouettes of every frame to `take`, as soon as they are found.
    ///
    /// # Errors
    /// Whatever `take` fails with.
    pub fn run<E>(
        &self,
        progress: &dyn Progress,
        mut take: impl FnMut(&FrameSilhouettes<'_>) -> Result<(), E>,
    ) -> Result<FoundSilhouettes, E> {
        let rig = self.pictures.rig();
        let likelihood = LikelihoodOptions::default();
        let evidence = Evidence::new(self.model, rig, likelihood, Measure::Metaballs);

        // 1. the body of each frame
        let fitted = match self.pipeline {
            SilhouettePipeline::Simple => self.start.clone(),
            SilhouettePipeline::Joint => self.refit_by_turns(&evidence, progress),
        };

        // 2. active contours from its outline
        let (mut observations, mut reliabilities) = (Vec::new(), Vec::new());
        let notes = self.each_frame(&fitted, "silhouettes", progress, |found| {
            take(&found)?;
            let views = found.sighting.views.iter().flatten();
            reliabilities.extend(views.map(|view| view.contours.mean_reliability()));
            observations.push(found.sighting.observed);
            Ok(())
        })?;
        Ok(FoundSilhouettes { observations, reliability: mean(reliabilities), notes })
    }

    /// Shape and motion of all frames at once fitted to stereo and contours, and contours from there, by turns.
    fn refit_by_turns(&self, evidence: &Evidence<'_>, progress: &dyn Progress) -> StartingFit {
        let mut fitted = self.start.clone();
        for _ in 0..TURNS {
            let mut observed = Vec::new();
            let Ok(_) = self.each_frame(&fitted, "following", progress, |found| {
                observed.push(found.sighting.observed);
                Ok::<(), Infallible>(())
            });
            fitted = fitted.refitted(&observed, evidence, self.pictures.fps(), progress);
        }
        fitted
    }

    /// Hands what is seen of a body in every frame that it has to `take`; what was left out, and why.
    fn each_frame<E>(
        &self,
        fit: &StartingFit,
        stage: &'static str,
        progress: &dyn Progress,
        mut take: impl FnMut(FrameSilhouettes<'_>) -> Result<(), E>,
    ) -> Result<Vec<String>, E> {
        let scale = SkinScale::new(self.model);
        let mut skipped = Vec::new();

        progress.begin(stage, self.frames.len());
        for (frame, pictures) in self.pictures.pictures(span(self.frames)) {
            match self.sighting(fit, frame, &pictures, &scale) {
                Ok(sighting) => take(FrameSilhouettes { frame, pictures: &pictures, sighting })?,
                Err(why) => skipped.push(format!("{frame}: {why}")),
            }
            progress.step();
        }
        progress.end();
        Ok(skipped)
    }

    /// What is seen of a body in a frame, or why it is left out.
    fn sighting(
        &self,
        fit: &StartingFit,
        frame: FrameIndex,
        pictures: &[Option<Picture>],
        scale: &SkinScale,
    ) -> Result<FrameSighting, String> {
        let motion = fit.motions.get(&frame).ok_or("the first fit has no such frame")?;
        let rig = self.pictures.rig();
        let shown = UndistortedFrame::new(rig, pictures).map_err(|fault| fault.to_string())?;
        let body = Posed::new(self.model, &fit.shape, motion);
        let scene = Scene::new(rig, &shown, &fit.still, &body, ContourOptions::default());
        Ok(scene.sighting(frame, &body, scale))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn contours_that_lie_on_no_edges_are_doubted_and_others_are_not() {
        let doubt = |reliability| {
            let found =
                FoundSilhouettes { observations: Vec::new(), reliability, notes: Vec::new() };
            found.doubt("arm")
        };
        let line = doubt(Some(0.35)).expect("it is below the limit");
        assert!(line.contains("0.35") && line.contains("arm"), "{line}");
        assert!(!line.contains('\n'), "{line}");
        assert_eq!(doubt(Some(0.55)), None);
        assert_eq!(doubt(None), None);
    }
}
