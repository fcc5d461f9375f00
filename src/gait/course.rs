//! The direction of walking, and whether the floor moves.

use nalgebra::Vector3;
use serde::{Deserialize, Serialize};

use super::filter;
use super::landmark::{Landmark, Paired, Side};
use super::movement::{Movement, Track};
use crate::math::stats::median;

/// What the person walks on.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Surface {
    /// The floor of the room.
    Ground,
    /// A belt.
    Treadmill,
}

/// How the body moves through the room.
#[derive(Debug, Clone, PartialEq)]
pub struct Course {
    /// Direction of walking in each frame: horizontal, unit length.
    pub heading: Vec<Vector3<f64>>,
    /// Floor or belt.
    pub surface: Surface,
    /// Speed of the belt, m/s; 0 on the floor.
    pub belt_m_s: f64,
    /// Speed of the pelvis in the room along the heading, m/s, median over time; negative: backwards.
    pub speed_m_s: f64,
}

/// Speed below which a pelvis does not walk through the room, and a belt does not run, m/s.
///
/// # Source
/// OpenCap's gait analysis: over ground where the standing foot is slower than 0.3 m/s.
const STILL_M_S: f64 = 0.3;
/// Time over which a direction is taken, seconds: about one stride, so that sway cancels.
const WINDOW_S: f64 = 1.0;

impl Course {
    /// The course of a movement; `None` if hips or feet are nowhere known. A `surface` of `None` is found.
    ///
    /// The heading is the direction in which the middle of the hips moves within a second. While a person who walks
    /// through the room stands, and throughout a movement on the spot, the heading is the direction in which the pelvis
    /// faces; between the two it passes gradually from one to the other. The belt's speed is the median backward speed of
    /// the lower foot, which is the one that stands.
    pub(super) fn find(movement: &Movement, surface: Option<Surface>) -> Option<Self> {
        let pelvis = movement.track(Landmark::MidHip)?;
        let facing = facing(movement)?;
        let velocity = velocity(pelvis, movement.rate_hz);
        // what is not known of other passes is no standing still
        let along =
            |(v, facing): (&Option<Vector3<f64>>, &Vector3<f64>)| Some(v.as_ref()?.dot(facing));
        let mut speeds: Vec<f64> = velocity.iter().zip(&facing).filter_map(along).collect();
        let speed_m_s = median(&mut speeds).unwrap_or(0.0);

        let walks = speed_m_s > STILL_M_S;
        let direction = |(v, facing): (&Option<Vector3<f64>>, &Vector3<f64>)| match v {
            Some(v) if walks && v.norm() > STILL_M_S && v.dot(facing) > 0.0 => {
                let way = v / v.norm();
                let share = (v.norm() / STILL_M_S - 1.0).clamp(0.0, 1.0);
                let between = facing * (1.0 - share) + way * share;
                between.try_normalize(1e-9).unwrap_or(way)
            }
            _ => *facing,
        };
        let heading: Vec<Vector3<f64>> = velocity.iter().zip(&facing).map(direction).collect();

        let belt_m_s = -standing_foot_speed(movement, &heading)?;
        let surface =
            surface.unwrap_or(match belt_m_s.abs() >= STILL_M_S && speed_m_s.abs() < STILL_M_S {
                true => Surface::Treadmill,
                false => Surface::Ground,
            });
        let belt_m_s = match surface {
            Surface::Treadmill => belt_m_s,
            Surface::Ground => 0.0,
        };

        Some(Self { heading, surface, belt_m_s, speed_m_s })
    }

    /// Whether the person walks with the back first.
    pub(super) fn is_backwards(&self) -> bool {
        self.speed_m_s < -STILL_M_S
            || (self.surface == Surface::Treadmill && self.belt_m_s < -STILL_M_S)
    }

    /// The nearest frame's heading.
    pub(super) fn heading_at(&self, frame: f64) -> Vector3<f64> {
        let last = self.heading.len() - 1;
        self.heading[(frame.round().max(0.0) as usize).min(last)]
    }
}

/// Where the pelvis faces, averaged over [`WINDOW_S`]; a frame in which it is unknown takes its neighbour's.
fn facing(movement: &Movement) -> Option<Track> {
    let sides = |place| {
        Some((
            movement.paired_track(Side::Left, place)?,
            movement.paired_track(Side::Right, place)?,
        ))
    };
    let (left, right) = sides(Paired::Asis).or_else(|| sides(Paired::Hip))?;
    let pairs = left.iter().zip(right);
    let forwards: Track = pairs.map(|(l, r)| (l - r).cross(&Vector3::z())).collect();

    let n = forwards.len();
    let half = (0.5 * WINDOW_S * movement.rate_hz) as usize;
    let mean = |i: usize| {
        let near = &forwards[i.saturating_sub(half)..(i + half + 1).min(n)];
        let sum: Vector3<f64> = near.iter().filter(|v| v.x.is_finite()).sum();
        sum.try_normalize(1e-9)
    };
    let known: Vec<Option<Vector3<f64>>> = (0..n).map(mean).collect();

    let mut before = known.iter().flatten().next().copied()?;
    let filled = known.into_iter().map(|v| {
        before = v.unwrap_or(before);
        before
    });
    Some(filled.collect())
}

/// Horizontal velocity over [`WINDOW_S`] about each frame, m/s; `None` where it is unknown.
///
/// No window reaches across a gap: near one it moves to where the pelvis is known, as at the ends of the recording. A stretch
/// between gaps that is shorter than half a window tells no velocity.
fn velocity(pelvis: &Track, rate_hz: f64) -> Vec<Option<Vector3<f64>>> {
    let whole = ((WINDOW_S * rate_hz).round() as usize).max(1);
    let xs: Vec<f64> = pelvis.iter().map(|place| place.x).collect();
    let mut velocity = vec![None; pelvis.len()];

    for known in filter::stretches(&xs) {
        let is_all = known.len() == pelvis.len();
        let window = whole.min(known.len() - 1);
        if window == 0 || (2 * window < whole && !is_all) {
            continue;
        }
        for i in known.clone() {
            let first = i.saturating_sub(window / 2).clamp(known.start, known.end - 1 - window);
            let v = (pelvis[first + window] - pelvis[first]) * rate_hz / window as f64;
            velocity[i] = Some(Vector3::new(v.x, v.y, 0.0));
        }
    }
    velocity
}

/// Median velocity along the heading of the lower foot's middle, m/s.
fn standing_foot_speed(movement: &Movement, heading: &[Vector3<f64>]) -> Option<f64> {
    let foot = |side| -> Option<Track> {
        let heel = movement.paired_track(side, Paired::Heel)?;
        let toe = movement.paired_track(side, Paired::Toe)?;
        Some(heel.iter().zip(toe).map(|(h, t)| (h + t) * 0.5).collect())
    };
    let feet = [foot(Side::Left)?, foot(Side::Right)?];
    let speed = |i: usize| {
        let lower = usize::from(feet[1][i].z < feet[0][i].z);
        (feet[lower][i + 1] - feet[lower][i - 1]).dot(&heading[i]) * 0.5 * movement.rate_hz
    };
    let mut speeds: Vec<f64> = (1..movement.frames - 1).map(speed).collect();
    median(&mut speeds)
}
