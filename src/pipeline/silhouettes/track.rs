//! The simple and the joint pipeline (PF02 § 4.1 and § 4.3).

use rayon::prelude::*;

use super::contour::{ViewContours, px_per_m};
use super::filter::{Edges, Filtered, band_mask, disparity_mask};
use super::shown::ShownFrame;
use super::{ContourOptions, Seen};
use crate::body::{Layout, Motion, Posed, Shape};
use crate::camera::{CameraId, Rig};
use crate::inference::Evidence;
use crate::inference::frame::FramePosterior;
use crate::inference::start::Detail;
use crate::inference::step::{StepPrior, extrapolate};
use crate::likelihood::{PointField, PointOptions, SkinScale, SurfacePoint};
use crate::render::{ModelOutline, outline};
use crate::silhouette::{FrameIndex, FrameObservations};
use crate::solver::{Options, levenberg_marquardt};
use crate::stereo::{CloudPoint, DepthMap};

/// One frame's pictures, their edges and their depths: what does not depend on where the body is.
#[derive(Debug)]
pub struct Scene<'a> {
    rig: &'a Rig,
    shown: &'a ShownFrame,
    depths: Vec<Option<DepthMap>>,
    edges: Vec<Option<Edges>>,
    options: ContourOptions,
}

/// Points of one frame that are fitted to at most.
const MOST_POINTS: usize = 4000;
/// Steps of a frame's fit at most.
const ITERATIONS: usize = 10;

impl<'a> Scene<'a> {
    /// Looks for edges and depths.
    pub fn new(
        rig: &'a Rig,
        shown: &'a ShownFrame,
        depths: Vec<Option<DepthMap>>,
        options: ContourOptions,
    ) -> Self {
        let views = shown.views.par_iter();
        let edges = views.map(|view| Some(Edges::of(view.as_ref()?, &options)));
        Self {
            edges: edges.collect(),
            rig,
            shown,
            depths,
            options,
        }
    }

    /// The contours of every view from where a body is expected, in the order of the rig; `None` where there is no picture.
    pub fn contours(&self, body: &Posed<'_>) -> Vec<Option<Seen>> {
        let cameras = self.rig.cameras.par_iter().enumerate();
        let seen = cameras.map(|(i, camera)| {
            let view = self.shown.views.get(i)?.as_ref()?;
            let expected = outline(&view.grey.camera, body, self.options.outline_px);
            let filtered = self.filtered(i, body, &expected)?;
            Some(Seen {
                contours: ViewContours::of(camera, &expected, &filtered, &self.options),
                filtered,
            })
        });
        seen.collect()
    }

    /// The edges of a view that can be the body's.
    fn filtered(&self, i: usize, body: &Posed<'_>, expected: &ModelOutline) -> Option<Filtered> {
        let (camera, edges) = (&self.rig.cameras[i], self.edges.get(i)?.as_ref()?);
        let mask = match &self.depths.get(i).and_then(Option::as_ref) {
            Some(depth) => disparity_mask(camera, &depth.points, body, &self.options),
            None => {
                let half_px = self.options.search_m * px_per_m(camera, expected);
                band_mask(camera, expected, half_px)
            }
        };
        Some(Filtered::of(edges, mask, &self.options))
    }

    /// The points of all depth maps that lie near a body's skin.
    pub fn points_near(&self, body: &Posed<'_>, scale: &SkinScale) -> Vec<CloudPoint> {
        let Some((low, high)) = body.bounds() else {
            return Vec::new();
        };
        let low = low.add_scalar(-self.options.near_m);
        let high = high.add_scalar(self.options.near_m);
        let is_in = |p: &&CloudPoint| {
            let x = p.position_world.coords;
            (0..3).all(|k| (low[k]..=high[k]).contains(&x[k]))
        };
        let maps = self.depths.iter().flatten().flat_map(|map| &map.points);
        let inside: Vec<CloudPoint> = maps.filter(is_in).copied().collect();
        let stride = inside.len().div_ceil(2 * MOST_POINTS).max(1);
        let some: Vec<CloudPoint> = inside.into_iter().step_by(stride).collect();
        let places = some.iter().map(SurfacePoint::from).collect();
        let field = PointField::new(places, PointOptions::default(), scale.clone());
        let touches = field.residuals(body);
        if touches.len() != some.len() {
            return some;
        }
        let near = some.into_iter().zip(touches);
        let near = near.filter(|(_, t)| t.residual_m.abs() < self.options.near_m);
        near.map(|(point, _)| point).take(MOST_POINTS).collect()
    }

    /// What a frame shows: silhouettes and points.
    pub fn observed(
        &self,
        frame: FrameIndex,
        seen: &[Option<Seen>],
        points: Vec<CloudPoint>,
    ) -> FrameObservations {
        let views = seen.iter().enumerate().filter_map(|(i, seen)| {
            let silhouette = seen.as_ref()?.contours.silhouette.clone()?;
            Some((CameraId(i), silhouette))
        });
        FrameObservations {
            views: views.collect(),
            points,
            ..FrameObservations::nothing(frame)
        }
    }
}

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
        let points = scene.points_near(&posed(stereo), &self.scale);
        let observed = scene.observed(frame, &first, points);
        let motion = self.fitted(frame, &observed, [&predicted, stereo]);
        // 4. active contours from its outline
        let seen = scene.contours(&posed(&motion));
        let points = scene.points_near(&posed(&motion), &self.scale);
        let observed = scene.observed(frame, &seen, points);
        let motion = self.fitted(frame, &observed, [&motion, &motion]);
        self.before = self.last.replace((frame, motion.clone()));
        Followed {
            motion,
            seen,
            observed,
        }
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

    /// The most probable motion of a frame from either start.
    fn fitted(
        &self,
        frame: FrameIndex,
        observed: &FrameObservations,
        starts: [&Motion; 2],
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
        let count = if starts[0] == starts[1] { 1 } else { 2 };
        let solved: Vec<_> = starts[..count]
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
