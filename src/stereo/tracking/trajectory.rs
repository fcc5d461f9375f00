//! The path of one point.

use nalgebra::{Point3, Vector3};

use crate::stereo::{CloudPoint, Spread};

/// A point of a trajectory.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct TrackPoint {
    /// Where, metres.
    pub position_world: Point3<f64>,
    /// How far it may be from the true point.
    pub spread: Spread,
    /// By central differences, at the ends by one-sided ones, m/s.
    pub velocity: Vector3<f64>,
    /// By second differences, at the ends those beside them, m/s².
    pub acceleration: Vector3<f64>,
}

/// Where a point of the surface was in successive frames.
#[derive(Debug, Clone, PartialEq)]
pub struct Trajectory {
    /// The frame of the first point.
    pub first_frame: usize,
    /// One point for each frame.
    pub points: Vec<TrackPoint>,
}

impl Trajectory {
    /// The path through places one frame apart.
    pub fn new(first_frame: usize, path: &[CloudPoint], fps: f64) -> Self {
        let at = |i: usize| path[i].position_world;
        let last = path.len().saturating_sub(1);
        let point = |i: usize| {
            let (before, after) = (i.saturating_sub(1), (i + 1).min(last));
            let frames = (after - before).max(1) as f64;

            // 0 of fewer than three points
            let middle = i.clamp(1, last.saturating_sub(1).max(1));
            let acceleration = if last >= 2 {
                (at(middle + 1) - at(middle)) - (at(middle) - at(middle - 1))
            } else {
                Vector3::zeros()
            };

            TrackPoint {
                position_world: at(i),
                spread: path[i].spread,
                velocity: (at(after) - at(before)) * (fps / frames),
                acceleration: acceleration * fps * fps,
            }
        };
        Self { first_frame, points: (0..path.len()).map(point).collect() }
    }

    /// The point of a frame.
    pub fn at(&self, frame: usize) -> Option<&TrackPoint> {
        self.points.get(frame.checked_sub(self.first_frame)?)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn path(x: impl Fn(f64) -> f64, count: usize) -> Trajectory {
        let point = |i: usize| CloudPoint {
            position_world: Point3::new(x(i as f64 / 50.0), 0.0, 0.0),
            spread: Spread::Unknown,
        };
        Trajectory::new(3, &(0..count).map(point).collect::<Vec<_>>(), 50.0)
    }

    #[test]
    fn a_fall_has_a_constant_acceleration_and_a_growing_velocity() {
        let fall = path(|t| -4.905 * t * t, 6);
        for point in &fall.points {
            approx::assert_relative_eq!(point.acceleration.x, -9.81, epsilon = 1e-9);
        }
        approx::assert_relative_eq!(fall.at(5).unwrap().velocity.x, -9.81 * 0.04, epsilon = 1e-9);
        assert_eq!(fall.at(2), None);
        assert_eq!(fall.at(9), None);
    }

    #[test]
    fn paths_of_none_one_and_two_points_have_no_acceleration() {
        for count in 0..3 {
            let points = path(|t| t, count).points;
            assert_eq!(points.len(), count);
            assert!(points.iter().all(|p| p.acceleration.norm() == 0.0));
        }
        approx::assert_relative_eq!(path(|t| t, 2).points[0].velocity.x, 1.0, epsilon = 1e-12);
    }
}
