//! A pose from nothing: visual hull, headings, canonical poses.
//!
//! At a keyframe nothing is known about m. The hull (or the points, without silhouettes) gives place and height. The
//! body stands there in each canonical leg pose of its model, turned to each of eight headings, and a dozen damped
//! iterations on thinned contours sort these starts: half of them by the motion alone, and the better half of the starts by the others.
//! The best few try the canonical arm poses and are refined. Where the hull is longer than high, bodies lie along it, too: the head at either end, on the
//! back, the front or a side, if the cameras say that the world's z is up.
//! Silhouettes confuse front and back: the best start of another heading is kept as a second reading.
//!
//! Where only detections show the body, their joints in space ([`Joints`]) give place, heading and size: the mean body, of the height that
//! is as many times the mean's as the joints lie farther apart, stands, or lies as hips and shoulders say, with its joints where they are on the mean. Detections
//! tell right from left, so no other heading is tried.

use nalgebra::{DVector, Point3, Rotation3, Vector3};
use rayon::prelude::*;

use super::detail::Detail;
use super::frame::{FramePosterior, KeyframePosterior};
use super::hull::{self, Hull};
use super::joints::{BONES, Joints};
use super::{Evidence, Terms};
use crate::body::{BodyModel, Limbs, Motion, Pose, Posed, Root, Shape, State};
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
        Self { headings: 8, iterations: 12, kept: 8 }
    }
}

/// One reading of a frame: a local optimum of its keyframe posterior.
#[derive(Debug, Clone)]
pub struct Reading {
    /// Motion and shape.
    pub state: State,
    /// −log p(mₖ, s | Zₖ) there.
    pub cost: f64,
}

/// The readings of one frame, best first: at most one per direction of view (front, back, …).
pub fn readings(
    evidence: &Evidence<'_>,
    frame: &FrameObservations,
    options: &StartOptions,
) -> Vec<Reading> {
    readings_by(evidence, frame, &evidence.terms(frame, Detail::Fine), options)
}

/// The same; `fine_terms` are the frame's in full detail.
pub(super) fn readings_by(
    evidence: &Evidence<'_>,
    frame: &FrameObservations,
    fine_terms: &Terms<'_>,
    options: &StartOptions,
) -> Vec<Reading> {
    // 1. where the body is, and how tall
    let hull = hull::hull(evidence.rig, frame);
    let joints = if hull.is_none() { Joints::new(evidence.rig, &frame.detections) } else { None };
    if hull.is_none() && joints.is_none() && evidence.model.root != Root::Fixed {
        return Vec::new();
    }

    // 2. every canonical leg pose at every heading, a dozen iterations on thinned contours
    let coarse_terms = evidence.terms(frame, Detail::Coarse);
    let sort = |starts| sorted(evidence, &coarse_terms, starts, options);
    let starts = match joints {
        Some(joints) => states_at_joints(evidence, &joints, options),
        None => starting_states(evidence, hull.as_ref(), options),
    };
    let mut found = sort(starts);
    keep_best(&mut found, options.kept);

    // 3. the best of them try the arm poses
    let arms = canonical_poses(evidence.model, Limbs::Arms);
    let with_arms = found.iter().flat_map(|reading| {
        arms.iter().map(|pose| {
            let mut state = reading.state.clone();
            pose.apply(&mut state.motion);
            state
        })
    });
    let with_arms = sort(with_arms.collect());
    found.extend(with_arms);
    keep_best(&mut found, options.kept);

    // 4. refine on a part of the border, and the best of each heading on all of it
    let thinned_terms = evidence.terms(frame, Detail::Thinned);
    let approach = |reading: Reading| refined(evidence, &thinned_terms, reading.state);
    let mut near: Vec<Reading> = found.into_par_iter().map(approach).collect();
    keep_best(&mut near, options.kept);
    let refine = |reading: Reading| refined(evidence, fine_terms, reading.state);
    let mut fine: Vec<Reading> = distinct_headings(near).into_par_iter().map(refine).collect();
    keep_best(&mut fine, options.kept);
    fine
}

/// The reading that is reached from a state.
pub(super) fn refined(evidence: &Evidence<'_>, terms: &Terms<'_>, state: State) -> Reading {
    improve(evidence, terms, state, &solver_options(30, 1e-4))
}

/// Half of the starts go on with their shape, after half of the iterations, which all of them take without.
const PROMISING: usize = 2;

/// All iterations from the better half of the starts; which half that is, is told by half of the iterations, of the motion alone (one
/// round of successive halving: Jamieson & Talwalkar, *Non-stochastic best arm identification*, AISTATS 2016).
fn sorted(
    evidence: &Evidence<'_>,
    terms: &Terms<'_>,
    starts: Vec<State>,
    options: &StartOptions,
) -> Vec<Reading> {
    let few = options.iterations.div_ceil(PROMISING);
    let begin = |state| moved(evidence, terms, state, &solver_options(few, SORTED));
    let mut found: Vec<Reading> = starts.into_par_iter().map(begin).collect();
    let promising = found.len().div_ceil(PROMISING).max(options.kept);
    keep_best(&mut found, promising);

    let solver = solver_options(options.iterations - few, SORTED);
    let go_on = |reading: Reading| improve(evidence, terms, reading.state, &solver);
    found.into_par_iter().map(go_on).collect()
}

/// A state whose shape stays.
fn moved(evidence: &Evidence<'_>, terms: &Terms<'_>, state: State, options: &Options) -> Reading {
    let State { motion, shape } = state;
    let posterior = FramePosterior {
        model: evidence.model,
        shape: &shape,
        pose_prior: &evidence.pose_prior,
        step: None,
        terms,
    };
    let solution = levenberg_marquardt(&posterior, motion, options);
    let cost = solution.cost + evidence.shape_prior.cost(&shape);
    Reading { state: State { motion: solution.state, shape }, cost }
}

fn solver_options(max_iterations: usize, relative_decrease: f64) -> Options {
    Options { max_iterations, damping: 1e-2, relative_decrease }
}

/// The optimum of the keyframe posterior that is reached from a state.
fn improve(evidence: &Evidence<'_>, terms: &Terms<'_>, state: State, options: &Options) -> Reading {
    let posterior = KeyframePosterior {
        model: evidence.model,
        shape_prior: &evidence.shape_prior,
        pose_prior: &evidence.pose_prior,
        terms,
    };
    let solution = levenberg_marquardt(&posterior, state, options);
    Reading { state: solution.state, cost: solution.cost }
}

/// The fraction of the cost below which a step's decrease ends the sorting of starts.
const SORTED: f64 = 1e-3;

fn keep_best(readings: &mut Vec<Reading>, kept: usize) {
    readings.sort_by(|a, b| a.cost.total_cmp(&b.cost));
    readings.truncate(kept);
}

fn canonical_poses(model: &BodyModel, limbs: Limbs) -> Vec<&Pose> {
    model.poses.iter().filter(|p| p.limbs == limbs).collect()
}

/// The body where the hull is, at every heading in every canonical leg pose; where the hull is low, also along it.
fn starting_states(
    evidence: &Evidence<'_>,
    hull: Option<&Hull>,
    options: &StartOptions,
) -> Vec<State> {
    let model = evidence.model;
    let mean = evidence.shape_prior.mean();
    let as_tall = |hull: &Hull| shape_of_height(model, hull.top - hull.bottom);
    let shape = hull.map_or_else(|| mean.clone(), as_tall);
    let (Some(hull), Root::Free { .. }) = (hull, model.root) else {
        return in_leg_poses(model, &shape, Motion::rest(model)).collect();
    };

    // upright, the head at the top of the hull
    let mut place = hull.centroid_world.coords;
    place.z = hull.top - vertical_extent(model, &shape).1;
    let upright = headings(options.headings).flat_map(|heading| {
        let world_from_root = Rotation3::from_axis_angle(&Vector3::z_axis(), heading);
        let motion = Motion { position_world: place, world_from_root, ..Motion::rest(model) };
        in_leg_poses(model, &shape, motion)
    });
    let mut states: Vec<State> = upright.collect();

    if hull.is_low() && evidence.rig.is_upright() {
        states.extend(lying_states(model, &mean, hull));
    }
    states
}

/// Rolls about its long axis in which a body may lie: on its back, its front and its sides.
const ROLLS: usize = 4;

/// The body along a hull, the head at either end, its middle where the hull's is.
fn lying_states(model: &BodyModel, shape: &Shape, hull: &Hull) -> Vec<State> {
    let ways = [hull.axis_world, -hull.axis_world].into_iter();
    let turns = ways.flat_map(|head| {
        let on_its_side = Rotation3::face_towards(&head, &Vector3::z());
        let rolled = move |roll| on_its_side * Rotation3::from_axis_angle(&Vector3::z_axis(), roll);
        headings(ROLLS).map(rolled)
    });
    let states = turns.flat_map(|world_from_root| {
        in_leg_poses(model, shape, Motion { world_from_root, ..Motion::rest(model) })
    });
    let placed = |mut state: State| {
        let off = hull.centroid_world - middle(model, shape, &state.motion);
        state.motion.position_world += off;
        state
    };
    states.map(placed).collect()
}

/// The middle of the body's joints.
fn middle(model: &BodyModel, shape: &Shape, motion: &Motion) -> Point3<f64> {
    let points = Posed::new(model, shape, motion).points();
    let sum: Vector3<f64> = points.iter().map(|point| point.coords).sum();
    Point3::from(sum / points.len().max(1) as f64)
}

/// Turns that are spread over a circle.
fn headings(count: usize) -> impl Iterator<Item = f64> {
    (0..count).map(move |i| std::f64::consts::TAU * i as f64 / count as f64)
}

/// A motion in every canonical leg pose; a model without leg poses stays as it is.
fn in_leg_poses<'m>(
    model: &'m BodyModel,
    shape: &'m Shape,
    motion: Motion,
) -> impl Iterator<Item = State> + 'm {
    let legs = canonical_poses(model, Limbs::Legs);
    (0..legs.len().max(1)).map(move |i| {
        let mut motion = motion.clone();
        legs.iter().skip(i).take(1).for_each(|pose| pose.apply(&mut motion));
        State { motion, shape: shape.clone() }
    })
}

/// The body with its joints about where they are seen, in every canonical leg pose; at every heading where they do not tell it.
fn states_at_joints(
    evidence: &Evidence<'_>,
    joints: &Joints,
    options: &StartOptions,
) -> Vec<State> {
    let model = evidence.model;
    // as tall as its bones are long
    let mean = Shape(model.statistics.mean.clone());
    let at_rest = Posed::new(model, &mean, &Motion::rest(model)).points();
    let place = |name: &str| model.point(name).map(|index| at_rest[index]);
    let (low, high) = vertical_extent(model, &mean);
    let ratio = joints.ratio(&BONES, place).unwrap_or(1.0);
    let shape = shape_of_height(model, ratio * (high - low));

    let tried = joints.heading().map_or_else(|| headings(options.headings).collect(), |h| vec![h]);
    let upright = tried.into_iter().map(|h| Rotation3::from_axis_angle(&Vector3::z_axis(), h));
    let lying = joints.lying().filter(|_| evidence.rig.is_upright());
    let turns: Vec<Rotation3<f64>> = lying.map_or_else(|| upright.collect(), |turn| vec![turn]);
    let states = turns.into_iter().flat_map(|world_from_root| {
        in_leg_poses(model, &shape, Motion { world_from_root, ..Motion::rest(model) })
    });
    let placed = |mut state: State| {
        let off = off_joints(model, &shape, &state.motion, joints);
        state.motion.position_world += off;
        state
    };
    states.map(placed).collect()
}

/// How far the joints lie from the body's, on the mean.
fn off_joints(model: &BodyModel, shape: &Shape, motion: &Motion, joints: &Joints) -> Vector3<f64> {
    let points = Posed::new(model, shape, motion).points();
    let off = |(name, seen): &(&str, Point3<f64>)| Some(seen - points[model.point(name)?]);
    let all: Vec<Vector3<f64>> = joints.places.iter().filter_map(off).collect();
    all.iter().sum::<Vector3<f64>>() / all.len().max(1) as f64
}

/// Lowest and highest point of the body at rest, about its root.
fn vertical_extent(model: &BodyModel, shape: &Shape) -> (f64, f64) {
    let body = Posed::new(model, shape, &Motion::rest(model));
    body.bounds().map_or((0.0, 0.0), |(low, high)| (low.z, high.z))
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

/// The best reading of each side that the body can face; these are more than 90° apart.
fn distinct_headings(readings: Vec<Reading>) -> Vec<Reading> {
    let forward = |r: &Reading| r.state.motion.forwards_world();
    let mut distinct: Vec<Reading> = Vec::new();
    for reading in readings {
        let turned_away = |kept: &Reading| forward(kept).dot(&forward(&reading)) < 0.0;
        if distinct.iter().all(turned_away) {
            distinct.push(reading);
        }
    }
    distinct.truncate(2);
    distinct
}
