//! The two pipelines of PF02 §4 over all frames of a recording.

use std::convert::Infallible;

use super::abreast::each_frame;
use super::starting_fit::AbsentParts;
use super::{ContourOptions, FrameSighting, Scene, StartingFit, UndistortedFrame};
use crate::body::{BodyModel, Posed};
use crate::image::Picture;
use crate::inference::Evidence;
use crate::likelihood::{LikelihoodOptions, Measure, SkinScale};
use crate::math::stats::mean;
use crate::pipeline::{PictureSource, Progress};
use crate::silhouette::{FrameIndex, FrameObservations};

/// Turns of contours and joint optimum: four end at the same borders (docs/decisions, 0049).
const TURNS: usize = 2;

/// Mean reliability below which contours are not to be trusted: of people it was .54 to .70, of an arm sought in a person
/// .17 to .38.
pub const UNSURE_RELIABILITY: f64 = 0.45;

/// Backing below which contours are doubted. Of right contours of `maquette synth --clutter`, and of persons who walk on the
/// spot in such rooms, it was .85 to .97, of a person of whom too little had been found .57 to .87.
pub const UNSURE_BACKING: f64 = 0.8;

/// Which pipeline of PF02 (§ 4.1, § 4.3).
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum SilhouettePipeline {
    /// Active contours from the outline of the starting fit (§4.1).
    Simple,
    /// Contours, and a fit to them and to stereo, by turns (§4.3).
    ///
    /// **Differs** from the paper, which goes from frame to frame: each of two turns takes all frames at once.
    #[default]
    Joint,
    /// The same as published, each frame from the one before: a limb that is lost stays lost.
    FrameAfterFrame,
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
    /// In how many frames depth speaks against the contours, and in how many it could tell.
    pub unbacked: (usize, usize),
    /// The frames in which depth backs the contours of a view by less than [`UNSURE_BACKING`], or shows what stands behind a limb.
    pub doubtful: Vec<FrameIndex>,
    /// What was left out, and why, in one line each.
    pub notes: Vec<String>,
}

impl FoundSilhouettes {
    /// That the contours are nobody's outline; `None` where they are somebody's in most frames.
    pub fn failure(&self, body: &str) -> Option<String> {
        let (against, all) = self.unbacked;
        if self.observations.is_empty() {
            return Some("no frame has a contour: the first fit is lost in all of them".to_owned());
        }
        (2 * against > all).then(|| {
            format!(
                "the contours are nobody's outline: in {against} of {all} frames more of the depths speak against the fitted body than for it. Is somebody seen who moves, do they look like {body}, and is the calibration right? Look with --overlays"
            )
        })
    }

    /// Mean reliability of contours that hardly lie on edges; `None` where they do.
    pub fn off_edges(&self) -> Option<f64> {
        self.reliability.filter(|mean| *mean < UNSURE_RELIABILITY)
    }

    /// That the contours of this body hardly lie on edges, or that depth backs too little of them; `None` where neither is so.
    pub fn doubt(&self, body: &str) -> Option<String> {
        let Some(reliability) = self.off_edges() else {
            let (first, count) = (self.doubtful.first()?, self.doubtful.len());
            return Some(format!(
                "in {count} of {} frames (the first is {first}) less than {:.0} % of the contour of a view and of what stands out in depth about it is explained by {body}, or a limb of it is where depth shows what stands behind: see backing and faults in quality.csv, and look with --overlays",
                self.observations.len(),
                100.0 * UNSURE_BACKING
            ));
        };
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
        // 1. the body of each frame
        let detailed = self.model.detailed();
        let (body, fitted) = match self.pipeline {
            SilhouettePipeline::Simple => (self.model, self.start.clone()),
            SilhouettePipeline::Joint => (&detailed, self.refit_by_turns(&detailed, progress)),
            SilhouettePipeline::FrameAfterFrame => {
                (self.model, self.fitted_frame_after_frame(progress))
            }
        };

        // 2. active contours from its outline
        let (mut observations, mut reliabilities) = (Vec::new(), Vec::new());
        let (mut unbacked, mut doubtful) = ((0, 0), Vec::new());
        let notes = self.each_frame(body, &fitted, "silhouettes", progress, |found| {
            take(&found)?;
            let views = found.sighting.views.iter().flatten();
            reliabilities.extend(views.map(|view| view.contours.mean_reliability()));
            if let Some(is_backed) = found.sighting.is_backed() {
                unbacked = (unbacked.0 + usize::from(!is_backed), unbacked.1 + 1);
            }
            let backing = found.sighting.least_backing();
            if backing.is_some_and(|least| least < UNSURE_BACKING)
                || !found.sighting.absent.is_empty()
            {
                doubtful.push(found.frame);
            }
            observations.push(found.sighting.observed);
            Ok(())
        })?;
        Ok(FoundSilhouettes {
            observations,
            reliability: mean(reliabilities),
            unbacked,
            doubtful,
            notes,
        })
    }

    /// Shape and motion of all frames at once fitted to stereo and contours, and contours from there, by turns.
    ///
    /// The body may have its surface outside the model's, and so may the outline that is expected of it: one that is expected without
    /// cloth is drawn to the edges of the limbs within, and one of a body whose flesh must grow to fill the cloth grows on with every
    /// turn.
    fn refit_by_turns(&self, body: &BodyModel, progress: &dyn Progress) -> StartingFit {
        let rig = self.pictures.rig();
        let evidence = Evidence::new(body, rig, LikelihoodOptions::default(), Measure::Metaballs);
        let mut fitted = self.start.clone().detailed(body);
        for _ in 0..TURNS {
            let (mut observed, mut absent) = (Vec::new(), AbsentParts::new());
            let Ok(_) = self.each_frame(body, &fitted, "following", progress, |found| {
                absent.insert(found.frame, found.sighting.absent);
                observed.push(found.sighting.observed);
                Ok::<(), Infallible>(())
            });
            fitted = fitted.without(&absent, body);
            fitted = fitted.refitted(&observed, &evidence, self.pictures.fps(), progress);
        }
        fitted
    }

    /// Hands what is seen of a body in every frame that it has to `take`; what was left out, and why.
    fn each_frame<E>(
        &self,
        body: &BodyModel,
        fit: &StartingFit,
        stage: &'static str,
        progress: &dyn Progress,
        mut take: impl FnMut(FrameSilhouettes<'_>) -> Result<(), E>,
    ) -> Result<Vec<String>, E> {
        let scale = SkinScale::new(body);
        let mut skipped = Vec::new();

        let look = |frame, pictures: &[_]| self.sighting(body, fit, frame, pictures, &scale);
        let stage = (stage, progress);
        each_frame(self.pictures, self.frames, stage, look, |frame, pictures, seen| match seen {
            Ok(sighting) => take(FrameSilhouettes { frame, pictures, sighting }),
            Err(why) => {
                skipped.push(format!("{frame}: {why}"));
                Ok(())
            }
        })?;
        Ok(skipped)
    }

    /// What is seen of a body in a frame, or why it is left out.
    pub(super) fn sighting(
        &self,
        body: &BodyModel,
        fit: &StartingFit,
        frame: FrameIndex,
        pictures: &[Option<Picture>],
        scale: &SkinScale,
    ) -> Result<FrameSighting, String> {
        let motion = fit.motions.get(&frame).ok_or("the first fit has no such frame")?;
        let rig = self.pictures.rig();
        let shown = UndistortedFrame::new(rig, pictures).map_err(|fault| fault.to_string())?;
        let body = Posed::new(body, &fit.shape, motion);
        let scene = Scene::new(rig, &shown, &fit.still, &body, ContourOptions::default());
        Ok(scene.sighting(frame, &body, scale))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn found(reliability: Option<f64>, unbacked: (usize, usize)) -> FoundSilhouettes {
        let observations = vec![FrameObservations::nothing(FrameIndex(0))];
        FoundSilhouettes {
            observations,
            reliability,
            unbacked,
            doubtful: Vec::new(),
            notes: Vec::new(),
        }
    }

    #[test]
    fn contours_that_depth_speaks_against_in_most_frames_are_a_failure_and_others_are_none() {
        let line = found(Some(0.6), (21, 40)).failure("body").expect("more than half");
        assert!(line.contains("21 of 40") && line.contains("body"), "{line}");
        assert!(!line.contains('\n'), "{line}");
        assert_eq!(found(Some(0.6), (20, 40)).failure("body"), None);
        assert_eq!(found(None, (0, 0)).failure("body"), None);
        let nothing = FoundSilhouettes { observations: Vec::new(), ..found(None, (0, 0)) };
        assert!(nothing.failure("body").is_some());
    }

    #[test]
    fn contours_that_lie_on_no_edges_are_doubted_and_others_are_not() {
        let doubt = |reliability| found(reliability, (0, 0)).doubt("arm");
        let line = doubt(Some(0.35)).expect("it is below the limit");
        assert!(line.contains("0.35") && line.contains("arm"), "{line}");
        assert!(!line.contains('\n'), "{line}");
        assert_eq!(doubt(Some(0.55)), None);
        assert_eq!(doubt(None), None);
        let doubtful = vec![FrameIndex(3), FrameIndex(4)];
        let weak = FoundSilhouettes { doubtful, ..found(Some(0.55), (0, 2)) };
        let line = weak.doubt("arm").expect("two frames");
        assert!(line.contains("in 2 of 1") && line.contains("frame 3"), "{line}");
    }
}
