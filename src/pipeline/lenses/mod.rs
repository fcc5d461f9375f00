//! Where cameras are of which the lenses alone are known, by the joints of a person who moves before them.
//!
//! | step | file |
//! |---|---|
//! | 1. what each camera sees of each joint | `sights.rs` |
//! | 2. how pairs of cameras stand to each other: essential matrices of the same joints in the same frames | `pairs.rs` |
//! | 3. the cameras one after the other, from the pairs that tell most | `chain.rs` |
//! | 4. all cameras and joints at once; how well the cameras are known | `bundle.rs` |
//! | 5. the world: up, floor and walk | `room.rs` |
//! | 6. how large it is, once a body was fitted | `size.rs` |
//!
//! A joint is a point that all cameras see: what a detector means by it lies a centimetre beside the anatomical joint, but for all cameras at the
//! same place. So it serves as a target's corner does, with an error of its own: σ as of published labels, times a factor a that is
//! estimated, a² = median(‖e‖²/σ²)/(2 ln 2) over the share of the sights that is left beside the unknowns.
//!
//! Errors last for a while: a hundred sights of a knee may say no more than two. With the correlation r_k of errors that are k frames
//! apart, variances are larger by 1 + 2Σr_k, summed up to five times itself.
//!
//! # Scale
//! Nothing in the pictures tells it. The bones say how tall the person is, in the rig's unit of length; the stature, if it is given, or else the mean body's, makes
//! metres of it.
//!
//! # Source
//! How long errors last: Sokal 1997, *Monte Carlo methods in statistical mechanics*, § 3 (the window).

mod bundle;
mod chain;
mod error;
mod pairs;
mod room;
mod sights;
mod size;
#[cfg(test)]
mod tests;

use nalgebra::{DMatrix, Point3, Translation3};
use rayon::prelude::*;

use super::diagnosis::stature_m;
use crate::body::{BodyModel, Motion, Posed, Shape};
use crate::camera::Rig;
use crate::inference::camera_prior::PoseErrors;
use crate::inference::joints::{BONES, Joints};
use crate::inference::rig_motion::RigMotion;
use crate::math::Rigid3;
use crate::math::stats::median;
use crate::silhouette::FramePeople;
use bundle::{Adjusted, Bundle, POSE, Placed, off};
use chain::chained;
pub use error::LensError;
use pairs::{LEAST_COMMON, Pair};
use room::{Walk, joints_of_frames};
use sights::Sights;
pub use size::{Scale, Size, SizeError};

/// Frames of which the cameras are placed, and of which all is adjusted in the end.
const FEW_FRAMES: usize = 60;
const MOST_FRAMES: usize = 400;
/// Pairs from which the cameras are placed; the chain that fits best counts.
const BEGINNINGS: usize = 3;
const ITERATIONS: usize = 40;
/// Correlations are summed over so many times their sum.
const WINDOW: f64 = 5.0;
/// Detections that lie so many times as far off as published labels are not of one person.
const MOST_SPREAD: f64 = 3.0;
/// A camera that is known less well than this is not calibrated: degrees and metres.
const MOST_TURN_SD_DEG: f64 = 1.0;
const MOST_PLACE_SD_M: f64 = 0.05;

/// By how many times a prior is wider than what it is to say nothing of.
const WIDER: f64 = 10.0;

/// Cameras that were placed by a person.
#[derive(Debug, Clone)]
pub struct PlacedRig {
    /// The cameras, in metres: z up, the floor at 0, x along the walk.
    pub rig: Rig,
    /// How well each is known, relative to the rig.
    pub sds: Vec<PlaceSd>,
    /// a: how far detections lie off, over what published labels scatter by.
    pub spread: f64,
    /// Sights of joints.
    pub sights: usize,
    /// Pictures that were left out, for they show several people.
    pub crowded: usize,
}

/// How well a camera is known.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PlaceSd {
    /// Of its turn: root of the sum over three axes, degrees.
    pub turn_deg: f64,
    /// Of its place, metres.
    pub place_m: f64,
}

/// The person who moves before the cameras.
#[derive(Debug, Clone, Copy)]
pub struct Walker<'a> {
    /// What is known of people.
    pub model: &'a BodyModel,
    /// How tall this one is, metres, if that is known.
    pub height_m: Option<f64>,
    /// Frames a second.
    pub fps: f64,
}

impl PlacedRig {
    /// By how much the cameras may be elsewhere, for a fit that refines them: ten times the root mean square of their standard deviations about and along each
    /// axis. The fit sees the same detections again, so it must know next to nothing of the cameras beforehand.
    pub fn errors(&self) -> PoseErrors {
        let rms = |of: fn(&PlaceSd) -> f64| {
            let squares = self.sds.iter().map(|sd| of(sd).powi(2) / 3.0);
            (squares.sum::<f64>() / self.sds.len().max(1) as f64).sqrt()
        };
        PoseErrors {
            turn_deg: WIDER * rms(|sd| sd.turn_deg),
            displacement_m: WIDER * rms(|sd| sd.place_m),
        }
    }
}

/// How well each camera of a rig is known relative to the others, by the covariance of turns (rad) and displacements (m) of all of them.
pub fn relative_sds(rig: &Rig, covariance: &DMatrix<f64>) -> Option<Vec<PlaceSd>> {
    let centres: Vec<Point3<f64>> = rig.cameras.iter().map(|c| c.centre_world()).collect();
    let relative = RigMotion::new(&centres)?.relative(covariance);
    let sd = |first: usize| relative.view((first, first), (3, 3)).trace().max(0.0).sqrt();
    let of_camera =
        |c: usize| PlaceSd { turn_deg: sd(POSE * c).to_degrees(), place_m: sd(POSE * c + 3) };
    Some((0..centres.len()).map(of_camera).collect())
}

/// Where the cameras of a rig are whose poses are not known, and are not looked at.
///
/// # Errors
/// [`LensError`] for what the motion does not tell.
pub fn placed_rig(
    rig: &Rig,
    frames: &[FramePeople],
    walker: Walker<'_>,
) -> Result<PlacedRig, LensError> {
    // 1. what is seen
    let sights = Sights::new(rig, frames);
    let thinned = sights.thinned(MOST_FRAMES);
    let stride = sights.frames.div_ceil(MOST_FRAMES).max(1);

    // 2. – 3. pairs, and the cameras one after the other
    let start = started(rig, &thinned.thinned(FEW_FRAMES))?;

    // 4. all at once, with the errors that the first adjustment shows
    let first = Bundle::adjusted(&thinned, &Placed::new(&thinned, start), ITERATIONS);
    let spread = spread(&thinned, &first.placed);
    if spread > MOST_SPREAD {
        return Err(LensError::Disagreeing { spread });
    }
    let scaled = thinned.scaled(spread);
    let adjusted = Bundle::adjusted(&scaled, &first.placed, ITERATIONS);

    // 5. metres, the world
    let joints = joints_of_frames(&scaled, &adjusted.placed);
    let metres = metres(walker, &joints).ok_or(LensError::NoSize)?;
    let (sds, worst) = sds(&scaled, &adjusted, metres.unit);
    if sds[worst].turn_deg > MOST_TURN_SD_DEG || sds[worst].place_m > MOST_PLACE_SD_M {
        return Err(LensError::Undetermined {
            camera: rig.cameras[worst].name.clone(),
            turn_sd_deg: sds[worst].turn_deg,
            place_sd_mm: 1e3 * sds[worst].place_m,
        });
    }
    let in_metres = |joints: &Joints| Joints {
        places: joints.places.iter().map(|(name, at)| (*name, at * metres.unit)).collect(),
    };
    let joints: Vec<Joints> = joints.iter().map(in_metres).collect();
    let walk =
        Walk { frames: &joints, fps: walker.fps / stride as f64, stature_m: metres.stature_m };
    let world_from_cameras = walk.world_from_cameras().ok_or(LensError::NoUp)?;
    let mut placed = rig.clone();
    for (camera, pose) in placed.cameras.iter_mut().zip(adjusted.placed.poses.iter().flatten()) {
        let pose = Rigid3::from_parts(
            Translation3::from(pose.translation.vector * metres.unit),
            pose.rotation,
        );
        camera.camera_from_world = pose * world_from_cameras.inverse();
    }
    Ok(PlacedRig { rig: placed, sds, spread, sights: adjusted.seen(), crowded: sights.crowded })
}

/// The poses of all cameras, from the pairs that tell most.
fn started(rig: &Rig, sights: &Sights) -> Result<Vec<Option<Rigid3>>, LensError> {
    let count = rig.cameras.len();
    let all: Vec<[usize; 2]> = (0..count).flat_map(|b| (0..b).map(move |a| [a, b])).collect();
    let mut pairs: Vec<Pair> =
        all.par_iter().filter_map(|cameras| Pair::new(sights, *cameras)).collect();
    pairs.sort_by(|a, b| b.weight.total_cmp(&a.weight));
    let common = |[a, b]: [usize; 2]| sights.common(a, b).len();
    if pairs.is_empty() {
        let most = all.iter().map(|pair| common(*pair)).max().unwrap_or(0);
        return Err(LensError::NeverTogether { most, least: LEAST_COMMON });
    }

    let beginnings = pairs.par_iter().take(BEGINNINGS);
    let chains: Vec<Adjusted> = beginnings.map(|first| chained(sights, &pairs, first)).collect();
    let unplaced = |chain: &Adjusted| chain.placed.poses.iter().filter(|p| p.is_none()).count();
    let order = |a: &Adjusted, b: &Adjusted| {
        let costs = a.mean_cost().total_cmp(&b.mean_cost());
        unplaced(a).cmp(&unplaced(b)).then(costs)
    };
    let best = chains.into_iter().min_by(order).map(|chain| chain.placed.poses);
    let poses = best.unwrap_or_default();
    match poses.iter().position(Option::is_none) {
        None => Ok(poses),
        Some(apart) => Err(LensError::Apart {
            camera: rig.cameras[apart].name.clone(),
            common: (0..count)
                .filter(|c| *c != apart)
                .map(|c| common([c, apart]))
                .max()
                .unwrap_or(0),
        }),
    }
}

/// a.
fn spread(sights: &Sights, placed: &Placed) -> f64 {
    let known = placed.joints.iter().flatten().count();
    let mut squares = squares(sights, placed);
    let unknowns = 3 * known + POSE * placed.poses.len();
    let left = 1.0 - unknowns as f64 / (2 * squares.len()).max(1) as f64;
    let middle = median(&mut squares).unwrap_or(0.0);
    (middle / (2.0 * std::f64::consts::LN_2 * left.max(0.1))).sqrt()
}

/// ‖e‖²/σ² of all sights of joints whose places are known.
fn squares(sights: &Sights, placed: &Placed) -> Vec<f64> {
    let of_camera = |(pose, seen): (&Option<Rigid3>, &Vec<_>)| {
        errors(pose.as_ref(), seen, &placed.joints).into_iter().flatten().collect::<Vec<_>>()
    };
    let all = placed.poses.iter().zip(&sights.cameras).flat_map(of_camera);
    all.map(|e| e.norm_squared()).collect()
}

/// e/σ of a camera, joint by joint.
fn errors(
    pose: Option<&Rigid3>,
    seen: &[Option<sights::Sight>],
    joints: &[Option<Point3<f64>>],
) -> Vec<Option<nalgebra::Vector2<f64>>> {
    let error = |(sight, place): (&Option<sights::Sight>, &Option<Point3<f64>>)| {
        let sight = sight.as_ref()?;
        Some(off(pose?, sight, place.as_ref()?)? / sight.sigma)
    };
    seen.iter().zip(joints).map(error).collect()
}

/// 1 + 2Σr_k: by how much variances are larger than those of errors that are independent.
fn lasting(sights: &Sights, placed: &Placed) -> f64 {
    let of_camera =
        |(pose, seen): (&Option<Rigid3>, &Vec<_>)| errors(pose.as_ref(), seen, &placed.joints);
    let errors: Vec<_> = placed.poses.iter().zip(&sights.cameras).map(of_camera).collect();
    let correlation = |k: usize| {
        let (mut product, mut square) = (0.0, 0.0);
        for errors in &errors {
            let later = errors.iter().skip(k * sights.joints.len());
            for (now, later) in errors.iter().zip(later) {
                if let (Some(now), Some(later)) = (now, later) {
                    product += now.dot(later);
                    square += 0.5 * (now.norm_squared() + later.norm_squared());
                }
            }
        }
        if square > 0.0 { product / square } else { 0.0 }
    };

    let mut sum = 1.0;
    for k in 1..sights.frames {
        sum += 2.0 * correlation(k);
        if k as f64 >= WINDOW * sum {
            break;
        }
    }
    sum.max(1.0)
}

/// How well each camera is known, and which is known least.
fn sds(sights: &Sights, adjusted: &Adjusted, unit_m: f64) -> (Vec<PlaceSd>, usize) {
    let covariance: DMatrix<f64> = adjusted.covariance() * lasting(sights, &adjusted.placed);
    let sd = |first: usize| covariance.view((first, first), (3, 3)).trace().max(0.0).sqrt();
    let of_camera = |c: usize| PlaceSd {
        turn_deg: sd(POSE * c).to_degrees(),
        place_m: unit_m * sd(POSE * c + 3),
    };
    let all: Vec<PlaceSd> = (0..covariance.nrows() / POSE).map(of_camera).collect();
    let share = |sd: &PlaceSd| (sd.turn_deg / MOST_TURN_SD_DEG).max(sd.place_m / MOST_PLACE_SD_M);
    let worst = (0..all.len()).max_by(|a, b| share(&all[*a]).total_cmp(&share(&all[*b])));
    (all, worst.unwrap_or(0))
}

/// What makes metres of the rig's unit of length.
struct Metres {
    unit: f64,
    stature_m: f64,
}

/// By the bones' lengths: those of a body as tall as the person is, or of the mean one.
fn metres(walker: Walker<'_>, joints: &[Joints]) -> Option<Metres> {
    let model = walker.model;
    let mean = Shape(model.statistics.mean.clone());
    let at_rest = Posed::new(model, &mean, &Motion::rest(model)).points();
    let place = |name: &str| model.point(name).map(|index| at_rest[index]);
    let mut ratios: Vec<f64> = joints.iter().filter_map(|j| j.ratio(&BONES, place)).collect();
    let ratio = median(&mut ratios).filter(|ratio| *ratio > 0.0)?;
    let usual_m = stature_m(model, &mean);
    let stature_m = walker.height_m.unwrap_or(usual_m);
    Some(Metres { unit: stature_m / (ratio * usual_m), stature_m })
}
