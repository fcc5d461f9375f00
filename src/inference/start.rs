//! A pose from nothing: visual hull, headings, canonical poses.
//!
//! At a keyframe nothing is known about m. The hull (or the points, without silhouettes) gives place and height; the body stands there in
//! each canonical leg pose of its model, turned to each of eight headings; a dozen damped iterations on
//! thinned contours sort them; the best few try the canonical arm poses and are refined. Silhouettes
//! confuse front and back: the best start of another heading is kept as a second reading.

use nalgebra::{DVector, Rotation3, Vector3};

use super::Evidence;
use super::frame::KeyframePosterior;
use super::hull::{self, Hull};
use crate::body::{BodyModel, Limbs, Motion, Posed, Root, Shape, State};
use crate::silhouette::FrameObservations;
use crate::solver::{Options, levenberg_marquardt};

/// Settings of the search for a start.
#[derive(Debug, Clone, Copy, PartialEq, serde::Serialize, serde::Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct StartOptions {
    /// Headings that are tried.
    pub headings: usize,
    /// Iterations of each start on thinned contours.
    pub iterations: usize,
    /// Starts that are refined.
    pub kept: usize,
}

impl Default for StartOptions {
    fn default() -> Self {
        Self {
            headings: 8,
            iterations: 12,
            kept: 6,
        }
    }
}

/// A fitted start.
#[derive(Debug, Clone)]
pub struct Start {
    /// Motion and shape at the optimum of the keyframe posterior.
    pub state: State,
    /// −log p(mₖ, s | Zₖ) there.
    pub cost: f64,
}

/// The readings of one frame, best first: at most one per direction of view (front, back, …).
pub fn readings(
    evidence: &Evidence<'_>,
    frame: &FrameObservations,
    options: &StartOptions,
) -> Vec<Start> {
    // 1. where the body is, and how tall
    let hull = hull::hull(evidence.rig, frame);
    if hull.is_none() && evidence.model.root != Root::Fixed {
        return Vec::new();
    }
    // 2. every canonical leg pose at every heading, a dozen iterations on thinned contours
    let mut starts: Vec<Start> = first_states(evidence, hull.as_ref(), options)
        .into_iter()
        .map(|state| improve(evidence, frame, state, Detail::Coarse, options.iterations))
        .collect();
    keep_best(&mut starts, options.kept);
    // 3. the best of them try the arm poses
    let arms: Vec<_> = evidence
        .model
        .poses
        .iter()
        .filter(|p| p.limbs == Limbs::Arms)
        .collect();
    let with_arms: Vec<Start> = starts
        .iter()
        .flat_map(|start| arms.iter().map(move |pose| (start, pose)))
        .map(|(start, pose)| {
            let mut state = start.state.clone();
            pose.apply(&mut state.motion);
            improve(evidence, frame, state, Detail::Coarse, options.iterations)
        })
        .collect();
    starts.extend(with_arms);
    keep_best(&mut starts, options.kept);
    // 4. refine, and keep the best of each heading
    let mut refined: Vec<Start> = starts
        .into_iter()
        .map(|s| improve(evidence, frame, s.state, Detail::Fine, 30))
        .collect();
    keep_best(&mut refined, options.kept);
    distinct_headings(refined)
}

/// How many border points a posterior looks at.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Detail {
    /// Few, and forgiving: to sort starts.
    Coarse,
    /// All: to measure.
    Fine,
}

fn improve(
    evidence: &Evidence<'_>,
    frame: &FrameObservations,
    state: State,
    detail: Detail,
    max_iterations: usize,
) -> Start {
    let terms = evidence.terms(frame, detail);
    let problem = KeyframePosterior {
        model: evidence.model,
        shape_prior: &evidence.shape_prior,
        pose_prior: &evidence.pose_prior,
        terms: &terms,
    };
    let options = Options {
        max_iterations,
        damping: 1e-2,
        relative_decrease: if detail == Detail::Coarse { 1e-3 } else { 1e-4 },
    };
    let solution = levenberg_marquardt(&problem, state, &options);
    Start {
        state: solution.state,
        cost: solution.cost,
    }
}

fn keep_best(starts: &mut Vec<Start>, kept: usize) {
    starts.sort_by(|a, b| a.cost.total_cmp(&b.cost));
    starts.truncate(kept);
}

fn first_states(
    evidence: &Evidence<'_>,
    hull: Option<&Hull>,
    options: &StartOptions,
) -> Vec<State> {
    let model = evidence.model;
    let legs: Vec<_> = model
        .poses
        .iter()
        .filter(|p| p.limbs == Limbs::Legs)
        .collect();
    let shape = hull.map_or_else(
        || evidence.shape_prior.mean(),
        |h| shape_of_height(model, h.top - h.bottom),
    );
    let headings = if model.root == Root::Fixed {
        1
    } else {
        options.headings
    };
    let mut states = Vec::new();
    for heading in 0..headings {
        let angle = std::f64::consts::TAU * heading as f64 / headings as f64;
        let mut motion = Motion::rest(model);
        if let (Some(hull), Root::Free { .. }) = (hull, model.root) {
            motion.world_from_root = Rotation3::from_axis_angle(&Vector3::z_axis(), angle);
            motion.position_world = hull.centroid_world.coords;
            motion.position_world.z = hull.top - vertical_extent(model, &shape).1;
        }
        if legs.is_empty() {
            states.push(State {
                motion: motion.clone(),
                shape: shape.clone(),
            });
        }
        for pose in &legs {
            let mut posed = motion.clone();
            pose.apply(&mut posed);
            states.push(State {
                motion: posed,
                shape: shape.clone(),
            });
        }
    }
    states
}

/// Lowest and highest point of the body at rest, about its root.
fn vertical_extent(model: &BodyModel, shape: &Shape) -> (f64, f64) {
    let body = Posed::new(model, shape, &Motion::rest(model));
    body.bounds()
        .map_or((0.0, 0.0), |(low, high)| (low.z, high.z))
}

/// The most probable shape of a body that stands `height` tall: E\[s | h(s) = height\], h linearised.
///
/// A body that does not stand (crouched, seated, arms up) is taken for the mean: the height counts only
/// within three standard deviations of h under p(s).
fn shape_of_height(model: &BodyModel, height: f64) -> Shape {
    let mean = Shape(model.statistics.mean.clone());
    let tall = |shape: &Shape| {
        let (low, high) = vertical_extent(model, shape);
        high - low
    };
    let gradient = DVector::from_fn(mean.0.len(), |i, _| {
        let mut moved = mean.clone();
        moved.0[i] += 1e-4;
        (tall(&moved) - tall(&mean)) / 1e-4
    });
    let gain = &model.statistics.covariance * &gradient;
    let variance = gradient.dot(&gain);
    let excess = height - tall(&mean);
    if variance <= 0.0 || excess.abs() > 3.0 * variance.sqrt() {
        return mean;
    }
    Shape(&mean.0 + gain * (excess / variance))
}

/// The best start of each side that the body can face: a turn of more than 90° is another reading.
fn distinct_headings(starts: Vec<Start>) -> Vec<Start> {
    let forward = |s: &Start| s.state.motion.world_from_root * Vector3::x();
    let mut distinct: Vec<Start> = Vec::new();
    for start in starts {
        if distinct
            .iter()
            .all(|kept| forward(kept).dot(&forward(&start)) < 0.0)
        {
            distinct.push(start);
        }
    }
    distinct.truncate(2);
    distinct
}
