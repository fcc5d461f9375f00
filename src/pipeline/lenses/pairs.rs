//! How pairs of cameras stand to each other, by the joints that both see.
//!
//! Five joints, of any frames, propose essential matrices. Of all proposals the one counts under which
//!
//! Σ min(e², 3²),  e = bᵀEa / √(σ_b² ‖(Ea)_xy‖² + σ_a² ‖(Eᵀb)_xy‖²),
//!
//! is least: Sampson's distance, over the standard deviations of published labels. Two cameras and the joints are then adjusted to each other, from the
//! best few.
//!
//! # Source
//! Torr & Zisserman 2000, *MLESAC* (truncated squares); Hartley & Zisserman 2004, § 11.4 (Sampson's distance).

use nalgebra::{Matrix3, Point2};
use rand::seq::index::sample;
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

use super::bundle::{Bundle, Placed, ray};
use super::sights::{Sight, Sights};
use crate::camera::{essential_matrices, poses_of_essential};
use crate::math::Rigid3;
use crate::math::stats::median;

/// Proposals: of so many, one has five joints that are all right at 99.9 % where half of all joints are wrong.
const PROPOSALS: usize = 300;
/// Joints that a proposal is tried on.
const TRIED: usize = 400;
/// Proposals from which two cameras are adjusted.
const ADJUSTED: usize = 4;
const ITERATIONS: usize = 20;
/// Joints farther off than so many standard deviations are wrong.
const WRONG: f64 = 3.0;
/// Fewer joints in common tell nothing: those of two pictures.
pub(super) const LEAST_COMMON: usize = 30;

/// Two cameras.
#[derive(Debug, Clone)]
pub(super) struct Pair {
    /// Which.
    pub(super) cameras: [usize; 2],
    /// The second one's pose from the first; the unit of length is their distance.
    pub(super) second_from_first: Rigid3,
    /// How much the pair tells: joints that agree, times the sine of the angle between their lines of sight.
    pub(super) weight: f64,
}

impl Pair {
    /// How two cameras stand to each other; `None` where they see too few joints together, or nothing fits.
    pub(super) fn new(sights: &Sights, cameras: [usize; 2]) -> Option<Self> {
        let [a, b] = cameras;
        let common = sights.common(a, b);
        if common.len() < LEAST_COMMON {
            return None;
        }
        let seen = |joint: &usize| Some([sights.cameras[a][*joint]?, sights.cameras[b][*joint]?]);
        let all: Vec<[Sight; 2]> = common.iter().filter_map(seen).collect();

        let of_two = sights.only(&cameras);
        let adjusted = |essential: &Matrix3<f64>| {
            let poses = poses_of_essential(essential).into_iter();
            let placed = poses
                .map(|second| Placed::new(&of_two, vec![Some(Rigid3::identity()), Some(second)]));
            let before = |placed: &Placed| placed.joints.iter().flatten().count();
            let start = placed.max_by_key(before)?;
            let adjusted = Bundle::adjusted(&of_two, &start, ITERATIONS);
            // joints that no longer lie before both cameras count as wrong
            let lost = (common.len() - before(&start)) as f64;
            Some((adjusted.mean_cost() + lost / common.len() as f64, adjusted.placed))
        };
        let tried = proposals(&all, [a, b]).into_iter().take(ADJUSTED);
        let (_, placed) = tried
            .filter_map(|essential| adjusted(&essential))
            .min_by(|a, b| a.0.total_cmp(&b.0))?;
        let second = placed.poses[1]?;
        let length = second.translation.vector.norm();
        let second_from_first =
            Rigid3::from_parts((second.translation.vector / length).into(), second.rotation);
        let weight = weight(&of_two, &placed);
        (length > 0.0).then_some(Self { cameras, second_from_first, weight })
    }

    /// The pose of a camera of the pair from the other.
    pub(super) fn camera_from_other(&self, camera: usize) -> Rigid3 {
        match camera == self.cameras[1] {
            true => self.second_from_first,
            false => self.second_from_first.inverse(),
        }
    }
}

/// Essential matrices that were proposed, the best first.
fn proposals(all: &[[Sight; 2]], cameras: [usize; 2]) -> Vec<Matrix3<f64>> {
    // a stream for each pair: what is drawn depends on nothing else
    let mut rng = ChaCha8Rng::seed_from_u64(0);
    rng.set_stream(((cameras[0] << 16) | cameras[1]) as u64);
    let tried: Vec<[Sight; 2]> =
        sample(&mut rng, all.len(), TRIED.min(all.len())).iter().map(|i| all[i]).collect();

    let mut found: Vec<(f64, Matrix3<f64>)> = Vec::new();
    for _ in 0..PROPOSALS {
        let five: [[Point2<f64>; 2]; 5] =
            std::array::from_fn(|_| all[rng.random_range(0..all.len())].map(|sight| sight.at));
        for essential in essential_matrices(&five) {
            found.push((cost(&essential, &tried), essential));
        }
    }
    found.sort_by(|a, b| a.0.total_cmp(&b.0));
    found.into_iter().map(|(_, essential)| essential).collect()
}

/// Σ min(e², 3²).
fn cost(essential: &Matrix3<f64>, pairs: &[[Sight; 2]]) -> f64 {
    let square = |[a, b]: &[Sight; 2]| {
        let (at, other) = (a.at.to_homogeneous(), b.at.to_homogeneous());
        let line = essential * at;
        let back = essential.tr_mul(&other);
        let variance =
            b.sigma.powi(2) * line.xy().norm_squared() + a.sigma.powi(2) * back.xy().norm_squared();
        (other.dot(&line).powi(2) / variance).min(WRONG * WRONG)
    };
    pairs.iter().map(square).sum()
}

/// Joints that agree, times the sine of the median angle between their lines of sight.
fn weight(sights: &Sights, placed: &Placed) -> f64 {
    let mut sines = Vec::new();
    for (joint, place) in placed.joints.iter().enumerate() {
        let Some(place) = place else { continue };
        let seen = placed.poses.iter().zip(&sights.cameras);
        let seen: Vec<(&Rigid3, Sight)> =
            seen.filter_map(|(pose, seen)| Some((pose.as_ref()?, seen[joint]?))).collect();
        let agrees = |(pose, sight): &(&Rigid3, Sight)| {
            let off = super::bundle::off(pose, sight, place);
            off.is_some_and(|off| off.norm() < WRONG * sight.sigma)
        };
        if let [a, b] = seen.as_slice()
            && seen.iter().all(agrees)
        {
            let [a, b] = [a, b].map(|(pose, sight)| ray(pose, sight).direction_world);
            sines.push(a.cross(&b).norm());
        }
    }
    let count = sines.len() as f64;
    count * median(&mut sines).unwrap_or(0.0)
}
