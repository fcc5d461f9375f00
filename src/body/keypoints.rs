//! Keypoints: exported points as a detector of 2-D joints means them.
//!
//! A detector's "right hip" is where those who labelled its training pictures clicked, a centimetre or two from the centre of the
//! joint. For every keypoint k this place is
//!
//! X_k + R β_k,
//!
//! X_k the exported point, R the axes of its part, and β_k three coefficients of the body, metres, the same in all frames: 0 ± 2 cm along each
//! axis (E: half of what labels of one joint scatter by, [`KeypointOptions`](crate::likelihood::KeypointOptions)). That of a left
//! keypoint is the mirror image of the right one's, by (βx, −βy, βz). Without them a detector's hip would drag the body.

use nalgebra::{DMatrix, Point3, Vector3};

use super::jacobian::point_columns;
use super::{BodyModel, CoefficientId, FrameId, Layout, NamedPoint, Posed, Shift};

/// σ of β along each axis, metres.
pub const KEYPOINT_SD_M: f64 = 0.02;

/// How a point moves with the components of the state that move it, ascending.
pub type PointSlopes = Vec<(usize, Vector3<f64>)>;

impl BodyModel {
    /// The body with a keypoint for each of these exported points that lies on one part; β are coefficients after all others.
    pub fn with_keypoints(&self, names: &[&str]) -> Self {
        let mut detailed = self.clone();
        let twins: Vec<(usize, usize)> = self.point_pairs();
        let is_wanted = |index: &usize| {
            let point = &self.points[*index];
            point.places.len() == 1 && names.contains(&point.name.as_str())
        };
        let wanted: Vec<usize> = (0..self.points.len()).filter(is_wanted).collect();

        let mut added: Vec<String> = Vec::new();
        for index in &wanted {
            // a left one has its right twin's coefficients, if that is wanted too
            let right = twins.iter().find(|(right, left)| left == index && wanted.contains(right));
            let owner = right.map_or(*index, |(right, _)| *right);
            let mirror = if right.is_some() { -1.0 } else { 1.0 };
            let name = |axis: &str| format!("{} keypoint {axis}", self.points[owner].name);
            let own = name("forward");
            let first = added.iter().position(|other| *other == own).unwrap_or_else(|| {
                added.extend(["forward", "left", "up"].map(name));
                added.len() - 3
            });

            let mut keypoint: NamedPoint = self.points[*index].clone();
            let coefficient = |k: usize| CoefficientId(self.coefficients.len() + first + k);
            let shift = |k: usize| Shift {
                coefficient: coefficient(k),
                direction: Vector3::ith(k, if k == 1 { mirror } else { 1.0 }),
            };
            keypoint.places[0].1.shifts.extend((0..3).map(shift));
            detailed.keypoints.push(keypoint);
        }
        let variance =
            DMatrix::from_diagonal_element(added.len(), added.len(), KEYPOINT_SD_M.powi(2));
        detailed.add_coefficients(&added, &variance);
        detailed
    }
}

impl Posed<'_> {
    /// Where a named point is in the world: the mean of its places.
    pub fn named_point(&self, point: &NamedPoint) -> Point3<f64> {
        let places = point.places.iter();
        let sum: Vector3<f64> = places.map(|(part, at)| self.point(*part, at).coords).sum();
        Point3::from(sum / point.places.len() as f64)
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
    use crate::body::{Motion, Shape, State, check_kinematics};

    #[test]
    fn a_detectors_hips_are_mirror_images_and_move_with_their_own_coefficients() {
        let model = crate::io::model::load("human-ellipsoids", Path::new("")).unwrap();
        let with = model.with_keypoints(&["RHip", "LHip", "Neck", "Hip", "no point"]);
        let names: Vec<&str> = with.keypoints.iter().map(|k| k.name.as_str()).collect();
        assert_eq!(names.len(), 3, "the mid-hip lies on two parts: {names:?}");
        assert_eq!(with.coefficients.len(), model.coefficients.len() + 6);

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
        approx::assert_relative_eq!(off("LHip"), Vector3::new(0.01, 0.02, 0.0), epsilon = 1e-12);
        approx::assert_relative_eq!(off("Neck"), Vector3::zeros(), epsilon = 1e-12);
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
