//! Keypoints: exported points as a detector of 2-D joints means them.
//!
//! A detector's "right hip" is where those who labelled its training pictures clicked, a centimetre or two from the centre of the
//! joint. For every keypoint k this place is
//!
//! X_k + R β_k,
//!
//! X_k the exported point, R the axes that it is fixed to, and β_k three coefficients of the body, metres, the same in all frames: 0 ± 2 cm along each
//! axis (E: half of what labels of one joint scatter by, [`KeypointOptions`](crate::likelihood::KeypointOptions)), of which the joint optimum finds out by
//! how much this recording's lie off. Without them a detector's hip would drag the body.
//!
//! Left and right ones are independent. Labels are mirror images of each other on the whole, but where a detector puts the knee of this person also
//! depends on which side the cameras see, and on a fold of the trousers. A body is its own mirror image: it cannot follow two knees that are meant
//! differently but by its motion. Fitted to detections alone with β mirrored, the elbows of a walk lay 9 cm off, bent by 25° too much
//! (docs/decisions, 0036).
//!
//! R are the axes of the last frame that the point's own turns leave alone: along the chain from the point to the root, the frame before
//! the joints that do not move it, as those after a joint, and a twist of the bone that leads to it. For a wrist it is the forearm's without its
//! twist, for a hip the pelvis, for a point that is no joint its own part. What does not move a point is often not seen at all: nothing
//! shows how a hand turns, and a straight arm hides its twist. There β would be a lever by which the errors of single detections turn
//! the hand, and the optimum would be one of long levers.

use std::ops::Range;

use nalgebra::{DMatrix, Point3, Vector3};

use super::jacobian::point_columns;
use super::{
    BodyModel, CoefficientId, FrameId, Layout, Motion, NamedPoint, PartId, Posed, ScaledVector,
    Shape, Shift,
};

/// σ of β along each axis, metres.
pub const KEYPOINT_SD_M: f64 = 0.02;

/// How a point moves with the components of the state that move it, ascending.
pub type PointSlopes = Vec<(usize, Vector3<f64>)>;

impl BodyModel {
    /// The body with a keypoint for each of these exported points that lies on one part; β are coefficients after all others.
    pub fn with_keypoints(&self, names: &[&str]) -> Self {
        let mut detailed = self.clone();
        let is_wanted =
            |point: &&NamedPoint| point.places.len() == 1 && names.contains(&point.name.as_str());
        let mut added: Vec<String> = Vec::new();
        for point in self.points.iter().filter(is_wanted) {
            let first = self.coefficients.len() + added.len();
            let name = |axis: &str| format!("{} keypoint {axis}", point.name);
            added.extend(["forward", "left", "up"].map(name));

            let shift = |k: usize| Shift {
                coefficient: CoefficientId(first + k),
                direction: Vector3::ith(k, 1.0),
            };
            let mut meant = ScaledVector::fixed(Vector3::zeros());
            meant.shifts.extend((0..3).map(shift));
            let (part, place) = &point.places[0];
            let meant = Some((self.steady_frame(*part, place), meant));
            detailed.keypoints.push(NamedPoint { meant, ..point.clone() });
        }
        let variance =
            DMatrix::from_diagonal_element(added.len(), added.len(), KEYPOINT_SD_M.powi(2));
        detailed.add_coefficients(&added, &variance);
        detailed
    }

    /// The coefficients β of all its keypoints: the last ones.
    pub fn keypoint_coefficients(&self) -> Range<usize> {
        let all = self.coefficients.len();
        all - 3 * self.keypoints.len()..all
    }

    /// The frame before the joints that do not move a point of a part, in any body near the mean.
    fn steady_frame(&self, part: PartId, place: &ScaledVector) -> FrameId {
        let mean = Shape(self.statistics.mean.clone());
        let straight = Motion::straight(self);
        let body = Posed::new(self, &mean, &straight);
        let point = body.point(part, place);
        let mut frame = FrameId::from_joint(self.parts[part.0].joint);
        while let Some(turn) = self.turn(frame) {
            let arm = point - Point3::from(body.frames[frame.0].origin_world);
            if body.turns_world[frame.0].cross(&arm).norm() > STEADY_M {
                break;
            }
            frame = turn.parent;
        }
        frame
    }
}

/// Turns by a radian that move a point by less do not show, metres: half of what labels of one joint scatter by.
const STEADY_M: f64 = KEYPOINT_SD_M;

impl Posed<'_> {
    /// Where a named point is in the world: the mean of its places.
    pub fn named_point(&self, point: &NamedPoint) -> Point3<f64> {
        let places = point.places.iter();
        let sum: Vector3<f64> = places.map(|(part, at)| self.point(*part, at).coords).sum();
        let meant = point.meant.as_ref().map_or_else(Vector3::zeros, |(frame, off)| {
            self.frames[frame.0].world_from_frame * off.at(self.shape())
        });
        Point3::from(sum / point.places.len() as f64 + meant)
    }

    /// How it moves; `slopes` receives it.
    pub fn named_point_slopes(&self, point: &NamedPoint, slopes: &mut PointSlopes) {
        slopes.clear();
        let share = 1.0 / point.places.len() as f64;
        for (part, place) in &point.places {
            let frame = FrameId::from_joint(self.model.parts[part.0].joint);
            point_columns(self, Layout::new(self.model), frame, place, |component, slope| {
                slopes.push((component, slope * share));
            });
        }
        // an offset is the difference of two points of its frame
        if let Some((frame, off)) = &point.meant {
            let (layout, origin) = (Layout::new(self.model), ScaledVector::fixed(Vector3::zeros()));
            point_columns(self, layout, *frame, off, |component, slope| {
                slopes.push((component, slope));
            });
            point_columns(self, layout, *frame, &origin, |component, slope| {
                slopes.push((component, -slope));
            });
        }
        slopes.sort_by_key(|(component, _)| *component);
        slopes.dedup_by(|later, first| {
            let is_same = later.0 == first.0;
            if is_same {
                first.1 += later.1;
            }
            is_same
        });
    }
}

#[cfg(test)]
mod tests {
    use std::path::Path;

    use super::*;
    use crate::body::{State, check_kinematics};

    #[test]
    fn what_a_detector_means_by_each_hip_moves_with_its_own_coefficients() {
        let model = crate::io::model::load("human-ellipsoids", Path::new("")).unwrap();
        let with = model.with_keypoints(&["RHip", "LHip", "Neck", "Hip", "no point"]);
        let names: Vec<&str> = with.keypoints.iter().map(|k| k.name.as_str()).collect();
        assert_eq!(names.len(), 3, "the mid-hip lies on two parts: {names:?}");
        assert_eq!(with.coefficients.len(), model.coefficients.len() + 9);
        assert_eq!(with.keypoint_coefficients(), model.coefficients.len()..with.coefficients.len());

        let mut shape = Shape(with.statistics.mean.clone());
        let first = with.coefficients.iter().position(|c| c == "RHip keypoint forward").unwrap();
        shape.0[first] = 0.01;
        shape.0[first + 1] = -0.02;
        let motion = Motion::straight(&with);
        let body = Posed::new(&with, &shape, &motion);
        let off = |name: &str| {
            let keypoint = with.keypoints.iter().find(|k| k.name == name).unwrap();
            let point = &with.points[with.point(name).unwrap()];
            body.named_point(keypoint) - body.named_point(point)
        };
        approx::assert_relative_eq!(off("RHip"), Vector3::new(0.01, -0.02, 0.0), epsilon = 1e-12);
        approx::assert_relative_eq!(off("LHip"), Vector3::zeros(), epsilon = 1e-12);
        approx::assert_relative_eq!(off("Neck"), Vector3::zeros(), epsilon = 1e-12);
    }

    #[test]
    fn a_detectors_joint_does_not_turn_by_what_does_not_move_it_and_lies_on_the_joint_if_it_means_that()
     {
        let model = crate::io::model::load("human-metaballs", Path::new("")).unwrap().detailed();
        let names: Vec<&str> = model.points.iter().map(|p| p.name.as_str()).collect();
        let with = model.with_keypoints(&names);
        let mut motion = Motion::rest(&with);
        motion.angles.iter_mut().enumerate().for_each(|(i, a)| *a += 0.3 * (i as f64).sin());
        let mut shape = Shape(with.statistics.mean.clone());
        shape.0.iter_mut().take(model.coefficients.len()).enumerate().for_each(|(i, s)| {
            *s += 0.01 * (2.0 * i as f64).cos();
        });
        let body = Posed::new(&with, &shape, &motion);
        for keypoint in &with.keypoints {
            let point = &with.points[with.point(&keypoint.name).unwrap()];
            let off = body.named_point(keypoint) - body.named_point(point);
            assert!(off.norm() < 1e-12, "{}: {off}", keypoint.name);
        }

        let axes = |name: &str| {
            let keypoint = with.keypoints.iter().find(|k| k.name == name).unwrap();
            let (frame, _) = keypoint.meant.as_ref().unwrap();
            frame.0.checked_sub(1).map_or("root", |joint| with.joints[joint].name.as_str())
        };
        let found = ["RWrist", "LElbow", "RHip", "RKnee", "RAnkle", "Head"].map(axes);
        let right = [
            "elbow_flexion_r",
            "shoulder_abduction_l",
            "root",
            "hip_abduction_r",
            "knee_flexion_r",
            "head_flexion",
        ];
        assert_eq!(found, right);
    }

    #[test]
    fn the_slopes_of_keypoints_are_those_of_kinematics_and_name_each_component_once() {
        let model = crate::io::model::load("human-ellipsoids", Path::new("")).unwrap();
        let model = model.detailed().with_keypoints(&["RKnee", "LKnee", "Head"]);
        let mut motion = Motion::rest(&model);
        motion.angles.iter_mut().enumerate().for_each(|(i, a)| *a += 0.1 * (i as f64).sin());
        let state = State { motion, shape: Shape(model.statistics.mean.clone()) };
        check_kinematics(&model, &state, 1e-7).unwrap();

        let body = Posed::new(&model, &state.shape, &state.motion);
        let mut slopes = PointSlopes::new();
        for point in model.points.iter().chain(&model.keypoints) {
            body.named_point_slopes(point, &mut slopes);
            assert!(slopes.is_sorted_by(|a, b| a.0 < b.0), "{}", point.name);
        }
    }
}
