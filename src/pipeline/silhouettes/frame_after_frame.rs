//! PF02 §4.3 as published: each frame from the one before.

use super::{SilhouetteSearch, StartingFit};
use crate::body::{Motion, Shape};
use crate::inference::frame::FramePosterior;
use crate::inference::step::StepPrior;
use crate::inference::{Detail, Evidence};
use crate::likelihood::{LikelihoodOptions, Measure, SkinScale};
use crate::pipeline::{PictureSource, Progress, span};
use crate::silhouette::{FrameIndex, FrameObservations};
use crate::solver::{Options, levenberg_marquardt};

impl<P: PictureSource> SilhouetteSearch<'_, P> {
    /// The motion of each frame, fitted to its stereo and to the contours that begin at the body of the frame before (§4.3, steps 1 to
    /// 3); the shape is the first fit's. Step 4, contours from the fitted body, is left to the caller.
    ///
    /// **Differs** from the paper, where the last frame's contour itself is the first guess: here the outline of its body is.
    pub(super) fn fitted_frame_after_frame(&self, progress: &dyn Progress) -> StartingFit {
        let (rig, fps) = (self.pictures.rig(), self.pictures.fps());
        let options = LikelihoodOptions::default();
        let evidence = Evidence::new(self.model, rig, options, Measure::Metaballs);
        let scale = SkinScale::new(self.model);
        let mut fitted = self.start.clone();

        let mut last: Option<(FrameIndex, Motion)> = None;
        progress.begin("following", self.frames.len());
        for (frame, pictures) in self.pictures.pictures(span(self.frames)) {
            if let Some((_, motion)) = &last {
                fitted.motions.insert(frame, motion.clone());
            }
            // 1, 2. contours from the body of the frame before
            let seen = self.sighting(self.model, &fitted, frame, &pictures, &scale);
            // 3. the body on stereo and contours
            if let (Ok(seen), Some(motion)) = (seen, fitted.motions.get_mut(&frame)) {
                let interval_s = |earlier: FrameIndex| (frame.0 - earlier.0) as f64 / fps;
                let step = last.as_ref().map(|(earlier, mean)| {
                    (StepPrior::new(self.model, interval_s(*earlier)), mean)
                });
                let step = step.as_ref().map(|(step, mean)| (step, *mean));
                *motion = fitted_motion(&evidence, &fitted.shape, &seen.observed, step, motion);
            }
            last = fitted.motions.get(&frame).map(|motion| (frame, motion.clone())).or(last);
            progress.step();
        }
        progress.end();
        fitted
    }
}

/// The most probable motion of a frame (ZS06, eq. 3) that is reached from another.
fn fitted_motion(
    evidence: &Evidence<'_>,
    shape: &Shape,
    observed: &FrameObservations,
    step: Option<(&StepPrior, &Motion)>,
    start: &Motion,
) -> Motion {
    let terms = evidence.terms(observed, Detail::Fine);
    let Evidence { model, pose_prior, .. } = evidence;
    let posterior = FramePosterior { model, shape, pose_prior, step, terms: &terms };
    levenberg_marquardt(&posterior, start.clone(), &Options::default()).state
}
