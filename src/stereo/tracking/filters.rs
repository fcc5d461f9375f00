//! Which trajectories are true: thresholds, and local uniformity in space and time (PFD99 § 2.2, Fig. 5).

use std::collections::HashMap;

use nalgebra::{Point3, Vector3};

use super::Trajectory;
use crate::math::stats::median;

/// What a trajectory of a body may do.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct FilterOptions {
    /// Largest speed, m/s. 10: a foot that runs.
    pub most_speed: f64,
    /// Largest acceleration, m/s². 200.
    pub most_acceleration: f64,
    /// Neighbours lie within this distance, m. 0.06.
    pub neighbourhood: f64,
    /// And at most so many frames away. 1.
    pub neighbour_frames: usize,
    /// Fewer neighbours say nothing, and the point is not believed. 6.
    pub least_neighbours: usize,
    /// Largest difference from the neighbours' velocity, m/s. 0.3.
    pub most_difference: f64,
    /// The same as a share of the neighbours' speed. 0.2.
    pub most_share: f64,
    /// Trajectories that are true in fewer frames are removed. 3.
    pub least_frames: usize,
}

impl Default for FilterOptions {
    fn default() -> Self {
        Self {
            most_speed: 10.0,
            most_acceleration: 200.0,
            neighbourhood: 0.06,
            neighbour_frames: 1,
            least_neighbours: 6,
            most_difference: 0.3,
            most_share: 0.2,
            least_frames: 3,
        }
    }
}

/// The true parts of trajectories.
#[derive(Debug, Clone, PartialEq)]
pub struct FilteredTrajectories {
    /// Those that are left, truncated where they became false.
    pub trajectories: Vec<Trajectory>,
    /// Place of each in what was given.
    pub kept: Vec<usize>,
    /// How many were truncated.
    pub truncated: usize,
    /// How many were removed; their first points were errors of the first frame.
    pub removed: usize,
}

/// Truncates trajectories where they are faster or accelerate more than a body can, and where their velocity is not
/// that of their neighbours; removes those that are too short then.
///
/// The neighbours' velocity is the median, by component, of the velocities within a ball around the point, in the
/// frames beside it too. The first pass leaves few false ones, so a second one judges by these alone.
///
/// # Source
/// PFD99 § 2.2. **Differs**: the median instead of the mean, which a false neighbour would draw along.
pub fn filter_trajectories(
    trajectories: &[Trajectory],
    options: &FilterOptions,
) -> FilteredTrajectories {
    let mut ends: Vec<usize> = trajectories
        .iter()
        .map(|t| thresholds(t, options))
        .collect();
    for _ in 0..2 {
        let known = Neighbours::of(trajectories, &ends, options);
        let judged = trajectories.iter().zip(&ends);
        ends = judged
            .map(|(t, end)| uniform(t, *end, &known, options))
            .collect();
    }
    let mut filtered = FilteredTrajectories {
        trajectories: Vec::new(),
        kept: Vec::new(),
        truncated: 0,
        removed: 0,
    };
    for (i, (trajectory, end)) in trajectories.iter().zip(ends).enumerate() {
        if end < options.least_frames {
            filtered.removed += 1;
            continue;
        }
        filtered.truncated += usize::from(end < trajectory.points.len());
        filtered.kept.push(i);
        filtered.trajectories.push(Trajectory {
            first_frame: trajectory.first_frame,
            points: trajectory.points[..end].to_vec(),
        });
    }
    filtered
}

/// How many points come before the first that is too fast.
fn thresholds(trajectory: &Trajectory, options: &FilterOptions) -> usize {
    let points = &trajectory.points;
    let good = |i: &usize| {
        points[*i].velocity.norm() <= options.most_speed
            && points[*i].acceleration.norm() <= options.most_acceleration
    };
    (0..points.len()).take_while(good).count()
}

fn uniform(
    trajectory: &Trajectory,
    end: usize,
    known: &Neighbours,
    options: &FilterOptions,
) -> usize {
    let good = |i: &usize| {
        let point = &trajectory.points[*i];
        let around = known.velocity(trajectory.first_frame + i, &point.position_world, options);
        around.is_some_and(|around| {
            let most = options
                .most_difference
                .max(options.most_share * around.norm());
            (point.velocity - around).norm() <= most
        })
    };
    (0..end).take_while(good).count()
}

/// A place and a velocity.
type Motion = (Point3<f64>, Vector3<f64>);

/// Motions by frame and cell of space.
struct Neighbours {
    cells: HashMap<(usize, [i64; 3]), Vec<Motion>>,
}

impl Neighbours {
    fn of(trajectories: &[Trajectory], ends: &[usize], options: &FilterOptions) -> Self {
        let mut cells: HashMap<_, Vec<_>> = HashMap::new();
        for (trajectory, end) in trajectories.iter().zip(ends) {
            for (i, point) in trajectory.points[..*end].iter().enumerate() {
                let cell = cell(&point.position_world, options);
                let here = cells.entry((trajectory.first_frame + i, cell)).or_default();
                here.push((point.position_world, point.velocity));
            }
        }
        Self { cells }
    }

    /// Median velocity around a point, itself included; `None` where there are too few.
    fn velocity(
        &self,
        frame: usize,
        at: &Point3<f64>,
        options: &FilterOptions,
    ) -> Option<Vector3<f64>> {
        let [x, y, z] = cell(at, options);
        let mut velocities = [const { Vec::new() }; 3];
        for frame in
            frame.saturating_sub(options.neighbour_frames)..=frame + options.neighbour_frames
        {
            for i in 0..27 {
                let cell = [x + i % 3 - 1, y + i / 3 % 3 - 1, z + i / 9 - 1];
                let points = self.cells.get(&(frame, cell)).into_iter().flatten();
                for (_, velocity) in
                    points.filter(|(p, _)| (p - at).norm() <= options.neighbourhood)
                {
                    velocities
                        .iter_mut()
                        .zip(velocity)
                        .for_each(|(all, v)| all.push(*v));
                }
            }
        }
        if velocities[0].len() <= options.least_neighbours {
            return None;
        }
        let [x, y, z] = velocities.each_mut().map(median);
        Some(Vector3::new(x?, y?, z?))
    }
}

fn cell(point: &Point3<f64>, options: &FilterOptions) -> [i64; 3] {
    [0, 1, 2].map(|i| (point[i] / options.neighbourhood.max(1e-6)).floor() as i64)
}
