//! The model's points over time, for other programs.

use std::collections::BTreeSet;

use nalgebra::Point3;

use super::{FramePart, ResultFile};
use crate::io::points::trc::Trajectories;

/// The joint centres in the order in which Pose2Sim lists them; other points follow.
const POSE2SIM: [&str; 17] = [
    "Hip",
    "RHip",
    "RKnee",
    "RAnkle",
    "RBigToe",
    "LHip",
    "LKnee",
    "LAnkle",
    "LBigToe",
    "Neck",
    "Head",
    "RShoulder",
    "RElbow",
    "RWrist",
    "LShoulder",
    "LElbow",
    "LWrist",
];

/// The points of every frame from the first to the last.
///
/// A frame of the recording that no camera saw, and a number between two frames that no mask has, is a frame
/// without points, so that rows stay evenly spaced in time.
pub fn trajectories(result: &ResultFile) -> Trajectories {
    let (names, fitted) = (&result.motion.points, &result.motion.frames);
    let order = order(names);
    let first = fitted.first().map_or(0, |f| f.frame);
    let with_points: BTreeSet<usize> = result.quality.points.iter().map(|p| p.frame.0).collect();
    let points = |frame: &FramePart| {
        let is_seen = frame.views > 0 || with_points.contains(&frame.frame);
        let place =
            |i: &usize| frame.points_m.get(*i).filter(|_| is_seen).map(|p| Point3::from(*p));
        order.iter().map(place).collect()
    };

    let mut frames: Vec<Vec<_>> = Vec::new();
    for frame in fitted {
        frames.resize(frame.frame.saturating_sub(first), vec![None; order.len()]);
        frames.push(points(frame));
    }
    Trajectories {
        rate_hz: result.recording.fps,
        first_frame: first,
        names: order.iter().map(|i| names[*i].clone()).collect(),
        frames,
    }
}

/// Indices of the points, Pose2Sim's first.
fn order(names: &[String]) -> Vec<usize> {
    let position = |wanted: &&str| names.iter().position(|name| name == wanted);
    let known = POSE2SIM.iter().filter_map(position);
    let is_other = |i: &usize| !POSE2SIM.contains(&names[*i].as_str());
    known.chain((0..names.len()).filter(is_other)).collect()
}

#[cfg(test)]
mod tests {
    use std::path::Path;

    use super::*;

    fn points_of(model: &str) -> Vec<String> {
        let model = crate::io::model::load(model, Path::new("")).unwrap();
        model.points.iter().map(|p| p.name.clone()).collect()
    }

    #[test]
    fn the_points_stand_in_the_order_of_pose2sim_and_others_follow() {
        let points = points_of("human-ellipsoids");
        let order_of_human = order(&points);
        let names: Vec<&str> = order_of_human.iter().map(|i| points[*i].as_str()).collect();
        assert_eq!(names[..17], POSE2SIM);
        assert_eq!(names.len(), points.len());
        assert_eq!(order(&points_of("arm-2d")), [0, 1, 2]);
    }
}
