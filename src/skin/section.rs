//! Cross-sections of the flesh, sampled by casting rays from the axis.

use std::f64::consts::TAU;

use nalgebra::Vector3;

use super::axis::{Frame, Station, Wall};
use super::flesh::{Flesh, Hit};

/// Length of the longest ray, metres.
const FARTHEST: f64 = 0.5;
/// Largest distance of a sample from the axis, over the median of its cross-section.
const WIDEST: f64 = 2.5;
/// Rays with which the middle of a cross-section is found.
const RAYS: usize = 16;
/// Share of the way to a wall after which a ray ends.
const BEFORE_WALL: f64 = 0.98;

/// A cross-section of one limb's flesh.
///
/// # Source
/// PFD99 § 3.1: "the implicit surface is sampled along cross-sections with a ray casting method".
#[derive(Debug, Clone)]
pub(super) struct Section {
    pub(super) frame: Frame,
    walls: Vec<Wall>,
}

impl Section {
    /// The cross-section at a place on the axis, its origin moved into its middle; angles are carried
    /// over from its neighbour. `None` if there is no flesh.
    pub(super) fn at(station: &Station, neighbour: &Frame, flesh: &Flesh) -> Option<Self> {
        let frame = neighbour.carried(station.origin, station.along);
        let mut section = Self { frame, walls: station.walls.clone() };
        section.frame.origin = section.within(flesh)?;

        for _ in 0..2 {
            let angles: Vec<f64> = (0..RAYS).map(|k| TAU * k as f64 / RAYS as f64).collect();
            let samples = section.samples(flesh, &angles)?;
            let middle = samples.iter().sum::<Vector3<f64>>() / samples.len() as f64;
            // a hollow cross-section may have its middle outside
            if flesh.value(&middle) < flesh.value(&section.frame.origin).min(0.75) {
                break;
            }
            section.frame.origin = middle;
        }

        Some(section)
    }

    /// A place within the flesh, at the origin or up to 5 cm from it along the rise of F in the plane.
    fn within(&self, flesh: &Flesh) -> Option<Vector3<f64>> {
        let mut place = self.frame.origin;
        for _ in 0..10 {
            let (value, gradient) = flesh.value_and_gradient(&place);
            if value > 0.55 {
                return Some(place);
            }
            let along = self.frame.along;
            let rise = gradient - along * gradient.dot(&along);
            place += rise.try_normalize(1e-12)? * 0.005;
        }
        None
    }

    /// The points in which rays at these angles leave the flesh.
    ///
    /// A ray ends earlier at a wall, where the flesh that the limb grows out of begins, and at 2.5 times the median of all.
    /// `None` if fewer than a quarter reach the skin.
    pub(super) fn samples(&self, flesh: &Flesh, angles: &[f64]) -> Option<Vec<Vector3<f64>>> {
        let origin = self.frame.origin;
        let rays: Vec<Vector3<f64>> = angles.iter().map(|a| self.frame.direction(*a)).collect();
        let hits = rays.iter();
        let hits = hits.map(|ray| flesh.cast(&origin, ray, self.farthest(ray)));
        let hits: Vec<Hit> = hits.collect();

        let on_skin = hits.iter().filter_map(|hit| match hit {
            Hit::Skin(distance) => Some(*distance),
            Hit::Flesh(_) | Hit::Nothing => None,
        });
        let mut on_skin: Vec<f64> = on_skin.collect();
        if on_skin.is_empty() || 4 * on_skin.len() < hits.len() {
            return None;
        }

        // a ray that runs along a neighbouring limb goes too far
        on_skin.sort_by(f64::total_cmp);
        let widest = WIDEST * on_skin[on_skin.len() / 2];
        let distance = |hit: &Hit| match hit {
            Hit::Skin(distance) | Hit::Flesh(distance) => distance.min(widest),
            Hit::Nothing => 0.0,
        };
        let samples = rays.iter().zip(&hits);
        let samples = samples.map(|(ray, hit)| origin + ray * distance(hit));
        Some(samples.collect())
    }

    /// How far a ray goes: to the nearest wall, or as far as any ray.
    fn farthest(&self, ray: &Vector3<f64>) -> f64 {
        let mut farthest = FARTHEST;
        for wall in &self.walls {
            let approach = ray.dot(&wall.normal);
            if approach > 1e-6 {
                let distance = (wall.point - self.frame.origin).dot(&wall.normal) / approach;
                farthest = farthest.min(BEFORE_WALL * distance.max(0.0));
            }
        }
        farthest.max(1e-3)
    }
}

/// How far the flesh reaches from a place within it along a direction; `None` if the place is outside.
pub(super) fn end(flesh: &Flesh, from: &Vector3<f64>, along: &Vector3<f64>) -> Option<f64> {
    match flesh.cast(from, along, FARTHEST) {
        Hit::Skin(distance) | Hit::Flesh(distance) => Some(distance),
        Hit::Nothing => None,
    }
}
