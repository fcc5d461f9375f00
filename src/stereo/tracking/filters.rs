//! Which trajectories are true, by thresholds and by local uniformity in space and time (PFD99 § 2.2, Fig. 5).

use std::collections::HashMap;

use nalgebra::{Point3, Vector3};

use super::Trajectory;
use crate::math::stats::median;

/// Which motion is that of a body.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct FilterOptions {
    /// Largest speed, m/s. 10: a foot that runs.
    pub most_speed: f64,
    /// Largest acceleration, m/s². 200.
    pub most_acceleration: f64,
    /// Largest distance of neighbours, m. 0.06.
    pub neighbourhood: f64,
    /// Most frames between neighbours. 1.
    pub neighbour_frames: usize,
    /// A point with fewer neighbours is not believed. 6.
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

/// Truncates trajectories where they are faster or accelerate more than a body can, and where their velocity is not
/// that of their neighbours; removes those that are then too short. Each that is left comes with its index.
///
/// The neighbours' velocity is the median, by component, of the velocities within a ball around the point, in the
/// frames beside it too. Two passes are made: in the second, the neighbours are those that the first left.
///
/// # Source
/// PFD99 § 2.2. **Differs**: the median instead of the mean, which a false neighbour would draw along.
pub fn filter_trajectories(
    trajectories: &[Trajectory],
    options: &FilterOptions,
) -> Vec<(usize, Trajectory)> {
    let within = trajectories.iter().map(|t| within_thresholds(t, options));
    let mut ends: Vec<usize> = within.collect();
    for _ in 0..2 {
        let neighbours = Neighbours::new(trajectories, &ends, options);
        let known = trajectories.iter().zip(&ends);
        let uniform = known.map(|(t, end)| uniform(t, *end, &neighbours, options));
        ends = uniform.collect();
    }

    let whole = trajectories.iter().zip(ends).enumerate();
    let lasting = whole.filter(|(_, (_, end))| *end >= options.least_frames);
    let truncated = lasting.map(|(index, (trajectory, end))| {
        let points = trajectory.points[..end].to_vec();
        (index, Trajectory { first_frame: trajectory.first_frame, points })
    });
    truncated.collect()
}

/// How many points come before the first that is too fast or accelerates too much.
fn within_thresholds(trajectory: &Trajectory, options: &FilterOptions) -> usize {
    let points = &trajectory.points;
    let good = |i: &usize| {
        points[*i].velocity.norm() <= options.most_speed
            && points[*i].acceleration.norm() <= options.most_acceleration
    };
    (0..points.len()).take_while(good).count()
}

/// How many of the points before `end` come before the first that does not move as its neighbours do.
fn uniform(
    trajectory: &Trajectory,
    end: usize,
    neighbours: &Neighbours,
    options: &FilterOptions,
) -> usize {
    let good = |i: &usize| {
        let point = &trajectory.points[*i];
        let frame = trajectory.first_frame + i;
        let around = neighbours.velocity(frame, &point.position_world, options);
        around.is_some_and(|around| {
            let share = options.most_share * around.norm();
            (point.velocity - around).norm() <= options.most_difference.max(share)
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
    fn new(trajectories: &[Trajectory], ends: &[usize], options: &FilterOptions) -> Self {
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
        let first = frame.saturating_sub(options.neighbour_frames);
        for frame in first..=frame + options.neighbour_frames {
            // the cell itself and the 26 around it
            for i in 0..27 {
                let cell = [x + i % 3 - 1, y + i / 3 % 3 - 1, z + i / 9 - 1];
                let points = self.cells.get(&(frame, cell)).into_iter().flatten();
                for (_, velocity) in
                    points.filter(|(p, _)| (p - at).norm() <= options.neighbourhood)
                {
                    let components = velocities.iter_mut().zip(velocity);
                    components.for_each(|(all, v)| all.push(*v));
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
