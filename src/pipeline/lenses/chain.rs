//! The cameras one after the other, from the pair that tells most.
//!
//! A camera that is not placed yet stands to each of those that are as [`Pair`] says, but for the distance s. Where joint X is known,
//! u × (R X + s t) = 0 gives it, and the median over the joints counts. Of several cameras that place it, that counts under which its
//! sights fit best to the joints that are known. After each camera all that are placed are adjusted.

use nalgebra::Point3;

use super::bundle::{Adjusted, Bundle, Placed, off};
use super::pairs::Pair;
use super::sights::Sights;
use crate::math::Rigid3;
use crate::math::stats::{mean, median};

const ITERATIONS: usize = 15;
/// What a joint costs at most, standard deviations squared.
const MOST: f64 = 9.0;

/// All cameras, begun with a pair; those that no pair leads to are not placed.
pub(super) fn chained(sights: &Sights, pairs: &[Pair], first: &Pair) -> Adjusted {
    let mut poses = vec![None; sights.cameras.len()];
    poses[first.cameras[0]] = Some(Rigid3::identity());
    poses[first.cameras[1]] = Some(first.second_from_first);
    let mut adjusted = adjusted(sights, poses);
    while let Some((camera, pose)) = next(sights, pairs, &adjusted.placed) {
        let mut poses = adjusted.placed.poses.clone();
        poses[camera] = Some(pose);
        adjusted = self::adjusted(sights, poses);
    }
    adjusted
}

/// Cameras where they fit best.
fn adjusted(sights: &Sights, poses: Vec<Option<Rigid3>>) -> Adjusted {
    Bundle::adjusted(sights, &Placed::new(sights, poses), ITERATIONS)
}

/// The camera of whose place most is known, and the place.
fn next(sights: &Sights, pairs: &[Pair], placed: &Placed) -> Option<(usize, Rigid3)> {
    let is_placed = |camera: usize| placed.poses[camera].is_some();
    let leading = |camera: usize| {
        let of_camera = pairs.iter().filter(move |pair| pair.cameras.contains(&camera));
        of_camera.filter(move |pair| pair.cameras.iter().any(|c| *c != camera && is_placed(*c)))
    };
    let told = |camera: usize| leading(camera).map(|pair| pair.weight).sum::<f64>();
    let free = (0..placed.poses.len()).filter(|camera| !is_placed(*camera));
    let free = free.filter(|camera| told(*camera) > 0.0);
    let camera = free.max_by(|a, b| told(*a).total_cmp(&told(*b)))?;

    let by_pair = |pair: &Pair| {
        let other = pair.cameras.iter().copied().find(|c| *c != camera)?;
        let pose = pose(sights, placed, [camera, other], &pair.camera_from_other(camera))?;
        Some((misfit(sights, placed, camera, &pose)?, pose))
    };
    let best = leading(camera).filter_map(by_pair).min_by(|a, b| a.0.total_cmp(&b.0))?;
    Some((camera, best.1))
}

/// The pose of a camera that stands to a placed one as `from_other` says, but for the distance.
fn pose(
    sights: &Sights,
    placed: &Placed,
    [camera, other]: [usize; 2],
    from_other: &Rigid3,
) -> Option<Rigid3> {
    let other_from_world = placed.poses[other]?;
    let way = from_other.translation.vector;
    let distance = |(joint, place): (usize, &Option<Point3<f64>>)| {
        let seen = sights.cameras[camera][joint]?.at.to_homogeneous();
        let turned = from_other.rotation * (other_from_world * (*place)?).coords;
        let (a, b) = (seen.cross(&way), -seen.cross(&turned));
        (a.norm() > 0.0).then(|| a.dot(&b) / a.norm_squared())
    };
    let all = placed.joints.iter().enumerate();
    let distance = median(&mut all.filter_map(distance).collect()).filter(|s| *s > 0.0)?;
    let from_other = Rigid3::from_parts((way * distance).into(), from_other.rotation);
    Some(from_other * other_from_world)
}

/// How far the sights of a camera lie from the joints that are known, on the mean.
fn misfit(sights: &Sights, placed: &Placed, camera: usize, pose: &Rigid3) -> Option<f64> {
    let square = |(joint, place): (usize, &Option<Point3<f64>>)| {
        let (sight, place) = (sights.cameras[camera][joint]?, (*place)?);
        let off = off(pose, &sight, &place);
        Some(off.map_or(MOST, |off| (off.norm() / sight.sigma).powi(2).min(MOST)))
    };
    mean(placed.joints.iter().enumerate().filter_map(square))
}
