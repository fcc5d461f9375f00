//! A body followed from frame to frame: the joint pipeline (PF02 § 4.3).

use rayon::prelude::*;

use super::Seen;
use super::scene::Scene;
use crate::body::{Layout, Motion, Posed, Shape};
use crate::inference::Evidence;
use crate::inference::frame::FramePosterior;
use crate::inference::start::Detail;
use crate::inference::step::{StepPrior, extrapolate};
use crate::likelihood::SkinScale;
use crate::silhouette::{FrameIndex, FrameObservations};
use crate::solver::{Options, levenberg_marquardt};

/// Steps of a frame's fit at most.
const ITERATIONS: usize = 10;

/// Follows a body of known shape from frame to frame by silhouettes and depth together (PF02 § 4.3).
///
/// **Differs** from the paper in step 1: the previous frame's silhouette is carried along by the motion, as the outline of the body
/// that was fitted to it, in the pose that its velocity predicts; a leg that swings at 3 m/s is 20 pixels from where it was.
/// And self-occlusion is provided for: the outline is that of what is visible, so there are no lines of sight on hidden parts, and where
/// one part's contour ends behind another it is not relied on.
#[derive(Debug)]
pub struct Follower<'a> {
    evidence: &'a Evidence<'a>,
    shape: &'a Shape,
    scale: SkinScale,
    fps: f64,
    before: Option<(FrameIndex, Motion)>,
    last: Option<(FrameIndex, Motion)>,
}

/// One frame of the joint pipeline.
#[derive(Debug)]
pub struct Followed {
    /// The fitted motion.
    pub motion: Motion,
    /// The contours of its outline, in the order of the rig.
    pub seen: Vec<Option<Seen>>,
    /// What was fitted to, with those contours.
    pub observed: FrameObservations,
}

impl<'a> Follower<'a> {
    /// Begins nowhere; `evidence` looks at metaballs.
    pub fn new(evidence: &'a Evidence<'a>, shape: &'a Shape, fps: f64) -> Self {
        Self {
            scale: SkinScale::of(evidence.model),
            evidence,
            shape,
            fps,
            before: None,
            last: None,
        }
    }

    /// The next frame; `stereo` is its motion by stereo alone.
    pub fn advance(&mut self, frame: FrameIndex, scene: &Scene<'_>, stereo: &Motion) -> Followed {
        let posed = |motion: &Motion| Posed::new(self.evidence.model, self.shape, motion);
        // 1. the previous silhouette, carried along
        let predicted = self.predicted(frame).unwrap_or_else(|| stereo.clone());
        // 2. active contours from it
        let first = scene.contours(&posed(&predicted));
        // 3. the body fitted to stereo and silhouettes, from there and from where stereo alone has it
        let either = [posed(&predicted), posed(stereo)];
        let points = scene.points_near(&either, &first, &self.scale);
        let observed = scene.observed(frame, &first, points);
        let motion = self.fitted(frame, &observed, &[&predicted, stereo]);
        // 4. active contours from its outline
        let body = posed(&motion);
        let seen = scene.contours(&body);
        let points = scene.points_near(&[body], &seen, &self.scale);
        let observed = scene.observed(frame, &seen, points);
        let motion = self.fitted(frame, &observed, &[&motion]);
        self.remember(frame, &motion);
        Followed {
            motion,
            seen,
            observed,
        }
    }

    /// The next frame's motion by stereo alone, of which `stereo` is a first guess: the simple pipeline (PF02 § 4.1).
    pub fn by_stereo(&mut self, frame: FrameIndex, scene: &Scene<'_>, stereo: &Motion) -> Motion {
        let predicted = self.predicted(frame).unwrap_or_else(|| stereo.clone());
        let posed = |motion: &Motion| Posed::new(self.evidence.model, self.shape, motion);
        let either = [posed(&predicted), posed(stereo)];
        let points = scene.points_near(&either, &[], &self.scale);
        let observed = scene.observed(frame, &[], points);
        let motion = self.fitted(frame, &observed, &[&predicted, stereo]);
        self.remember(frame, &motion);
        motion
    }

    fn remember(&mut self, frame: FrameIndex, motion: &Motion) {
        self.before = self.last.replace((frame, motion.clone()));
    }

    /// Where constant velocity leads; `None` in the first frame.
    fn predicted(&self, frame: FrameIndex) -> Option<Motion> {
        let (last, motion) = self.last.as_ref()?;
        let Some((before, earlier)) = &self.before else {
            return Some(motion.clone());
        };
        let ratio = interval(*last, frame) / interval(*before, *last);
        let layout = Layout::of(self.evidence.model);
        Some(extrapolate(layout, earlier, motion, ratio))
    }

    /// The most probable motion of a frame from any of some starts, of which there is at least one.
    fn fitted(
        &self,
        frame: FrameIndex,
        observed: &FrameObservations,
        starts: &[&Motion],
    ) -> Motion {
        let seconds = |last: FrameIndex| interval(last, frame) / self.fps;
        let step = self
            .last
            .as_ref()
            .map(|(last, motion)| (StepPrior::new(self.evidence.model, seconds(*last)), motion));
        let terms = self.evidence.terms(observed, Detail::Fine);
        let posterior = FramePosterior {
            model: self.evidence.model,
            shape: self.shape,
            pose_prior: &self.evidence.pose_prior,
            step: step.as_ref().map(|(step, mean)| (step, *mean)),
            terms: &terms,
        };
        let options = Options {
            max_iterations: ITERATIONS,
            damping: 1e-4,
            relative_decrease: 1e-4,
        };
        let solved: Vec<_> = starts
            .par_iter()
            .map(|start| levenberg_marquardt(&posterior, (*start).clone(), &options))
            .collect();
        let best = solved.into_iter().min_by(|a, b| a.cost.total_cmp(&b.cost));
        best.map_or_else(|| starts[0].clone(), |best| best.state)
    }
}

/// Frames from one to a later one, at least one.
fn interval(from: FrameIndex, to: FrameIndex) -> f64 {
    to.0.abs_diff(from.0).max(1) as f64
}
