//! The model's points over time, for other programs.

use crate::body::BodyModel;
use crate::io::points::trc::Trajectories;
use crate::pipeline::{Fit, FittedFrame};

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

/// Most rows that gaps in the frame numbers may add, for each frame that there is.
const MOST_GAPS: usize = 1000;

/// The points of every frame from the first to the last.
///
/// A frame of the recording that no camera saw, and a number between two frames that no mask has, is a frame
/// without points, so that rows stay evenly spaced in time. (Where numbers are so sparse that there would be a
/// thousand rows to a frame, only the frames themselves are listed.)
pub fn trajectories(fit: &Fit, model: &BodyModel, fps: f64) -> Trajectories {
    let order = order(model);
    let first = fit.frames.first().map_or(0, |f| f.frame.0);
    let last = fit.frames.last().map_or(0, |f| f.frame.0);
    let points = |frame: &FittedFrame| {
        let is_seen = frame.is_observed();
        let place = |i: &usize| is_seen.then(|| frame.points_world[*i]);
        order.iter().map(place).collect()
    };
    let is_sparse = (last - first) / MOST_GAPS > fit.frames.len();
    let mut frames: Vec<Vec<_>> = Vec::new();
    for frame in &fit.frames {
        if !is_sparse {
            frames.resize(frame.frame.0 - first, vec![None; order.len()]);
        }
        frames.push(points(frame));
    }
    Trajectories {
        rate_hz: fps,
        first_frame: first,
        names: order
            .iter()
            .map(|i| model.points[*i].name.clone())
            .collect(),
        frames,
    }
}

/// Indices of the model's points, Pose2Sim's first.
fn order(model: &BodyModel) -> Vec<usize> {
    let known = POSE2SIM.iter().filter_map(|name| model.point(name));
    let is_other = |i: &usize| !POSE2SIM.contains(&model.points[*i].name.as_str());
    known
        .chain((0..model.points.len()).filter(is_other))
        .collect()
}

#[cfg(test)]
mod tests {
    use std::path::Path;

    use super::*;

    #[test]
    fn the_points_stand_in_the_order_of_pose2sim_and_others_follow() {
        let model = crate::io::model::load("human-ellipsoids", Path::new("")).unwrap();
        let names: Vec<&str> = order(&model)
            .iter()
            .map(|i| model.points[*i].name.as_str())
            .collect();
        assert_eq!(names[..17], POSE2SIM);
        assert_eq!(names.len(), model.points.len());
        let arm = crate::io::model::load("arm-2d", Path::new("")).unwrap();
        assert_eq!(order(&arm), [0, 1, 2]);
    }
}
