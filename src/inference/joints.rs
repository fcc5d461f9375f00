//! Joints in space, from detections by several cameras: where a person is and how they stand, before any body is fitted.
//!
//! Camera c sees joint k at u_c. Any two cameras propose the point X nearest to both lines of sight; of all proposals the one is taken that
//! most cameras agree with,
//!
//! X = argmin Σ_c min(‖u_c − π_c(X)‖²/σ_c², 3²),  σ_c = 0.1 s_c,
//!
//! s_c the person's size in the picture: about what published labels of a joint scatter by. Then the point nearest to the lines of sight of
//! those that agree, within 3σ, replaces it. A leg that one detector takes for the other is thus outvoted by two others. Where only two
//! cameras see a joint, they must agree.
//!
//! # Source
//! The vote is the least median of squares' idea with a truncated cost: Torr & Zisserman 2000, *MLESAC*. 0.1: as in
//! [`KeypointOptions`](crate::likelihood::KeypointOptions).

use std::f64::consts::FRAC_1_SQRT_2;

use nalgebra::{Matrix3, Point2, Point3, Rotation3, Vector3};

use crate::body::Side;
use crate::camera::{Camera, CameraId, Ray, Rig, closest_point};
use crate::math::stats::median;
use crate::silhouette::Detection;

/// σ of a detection, over the person's size in the picture.
const SPREAD: f64 = 0.1;
/// Detections farther off than so many σ do not agree.
const AGREE: f64 = 3.0;
/// Fewer joints do not tell how a person stands.
const LEAST_JOINTS: usize = 4;
/// The points of a detector that lie on the trunk.
const TRUNK: [&str; 6] = ["RHip", "LHip", "Hip", "RShoulder", "LShoulder", "Neck"];

/// Bones whose lengths tell how tall a person is.
pub const BONES: [[&str; 2]; 10] = [
    ["RHip", "RKnee"],
    ["LHip", "LKnee"],
    ["RKnee", "RAnkle"],
    ["LKnee", "LAnkle"],
    ["RShoulder", "RElbow"],
    ["LShoulder", "LElbow"],
    ["RElbow", "RWrist"],
    ["LElbow", "LWrist"],
    ["RHip", "RShoulder"],
    ["LHip", "LShoulder"],
];

/// The joints of one person in one frame, in space.
#[derive(Debug, Clone, PartialEq)]
pub struct Joints {
    /// Name and place of each.
    pub places: Vec<(&'static str, Point3<f64>)>,
}

/// What one camera sees of one joint.
struct Sight<'a> {
    camera: &'a Camera,
    pixel: Point2<f64>,
    sigma_px: f64,
    ray: Ray,
}

impl Sight<'_> {
    /// The squared distance from a point, in σ; none agrees from behind.
    fn square(&self, point: &Point3<f64>) -> f64 {
        let at = self.camera.project_undistorted(point);
        at.map_or(f64::INFINITY, |at| (self.pixel - at).norm_squared() / self.sigma_px.powi(2))
    }
}

/// Whether detections may tell where a person is: two cameras have some.
pub fn may_locate(detections: &[(CameraId, Detection)]) -> bool {
    let tells = |(_, detection): &&(CameraId, Detection)| detection.keypoints.len() >= LEAST_JOINTS;
    detections.iter().filter(tells).take(2).count() == 2
}

impl Joints {
    /// Those that two cameras or more agree about; `None` where these are too few to tell how the person stands.
    pub fn new(rig: &Rig, detections: &[(CameraId, Detection)]) -> Option<Self> {
        let mut names: Vec<&'static str> =
            detections.iter().flat_map(|(_, d)| d.keypoints.iter().map(|k| k.name)).collect();
        names.sort_unstable();
        names.dedup();
        let place =
            |name: &'static str| Some((name, intersection(&sights(rig, detections, name))?));
        let places: Vec<_> = names.into_iter().filter_map(place).collect();
        (places.len() >= LEAST_JOINTS).then_some(Self { places })
    }

    /// Where a joint is.
    pub fn place(&self, name: &str) -> Option<Point3<f64>> {
        self.places.iter().find(|(known, _)| *known == name).map(|(_, place)| *place)
    }

    /// The middle of the trunk, or of all joints where nothing is seen of it.
    pub fn middle(&self) -> Point3<f64> {
        let of_trunk = self.places.iter().filter(|(name, _)| TRUNK.contains(name));
        let trunk: Vec<Vector3<f64>> = of_trunk.map(|(_, place)| place.coords).collect();
        let all = || self.places.iter().map(|(_, place)| place.coords).collect();
        let used: Vec<Vector3<f64>> = if trunk.is_empty() { all() } else { trunk };
        Point3::from(used.iter().sum::<Vector3<f64>>() / used.len() as f64)
    }

    /// The heading of the person, radians from the world's x axis: ahead is across what leads from right to left hip and shoulder.
    pub fn heading(&self) -> Option<f64> {
        let left = self.left()?.xy();
        (left.norm() > f64::EPSILON).then(|| (-left.x).atan2(left.y))
    }

    /// How a person is turned who lies or goes on all fours: up is from the hips to the shoulders; `None` where the trunk is steeper than 45°.
    pub fn lying(&self) -> Option<Rotation3<f64>> {
        let between = |joint: &str| {
            let at = |side: &str| self.place(&format!("{side}{joint}"));
            Some(nalgebra::center(&at("L")?, &at("R")?))
        };
        let up = (between("Shoulder")? - between("Hip")?).try_normalize(f64::EPSILON)?;
        let left = self.left()?;
        let left = (left - up * left.dot(&up)).try_normalize(f64::EPSILON)?;
        let axes = Matrix3::from_columns(&[left.cross(&up), left, up]);
        (up.z < FRAC_1_SQRT_2).then(|| Rotation3::from_matrix_unchecked(axes))
    }

    /// What leads from right to left, of hips and shoulders together.
    fn left(&self) -> Option<Vector3<f64>> {
        let across = |joint: &str| {
            let at = |side: &str| self.place(&format!("{side}{joint}"));
            Some(at("L")? - at("R")?)
        };
        ["Hip", "Shoulder"].into_iter().filter_map(across).reduce(|a, b| a + b)
    }

    /// The median of the lengths between pairs of joints over those of another body, whose joints are at `other`.
    pub fn ratio(
        &self,
        bones: &[[&str; 2]],
        other: impl Fn(&str) -> Option<Point3<f64>>,
    ) -> Option<f64> {
        let ratio = |joint: &[&str; 2]| {
            let own = (self.place(joint[0])? - self.place(joint[1])?).norm();
            let length = (other(joint[0])? - other(joint[1])?).norm();
            (length > 0.0).then(|| own / length)
        };
        median(&mut bones.iter().filter_map(ratio).collect())
    }
}

fn sights<'a>(rig: &'a Rig, detections: &[(CameraId, Detection)], name: &str) -> Vec<Sight<'a>> {
    let sight = |(id, detection): &(CameraId, Detection)| {
        let camera = rig.camera(*id)?;
        let seen = detection.keypoint(name)?;
        let (pixel, sigma_px) = (seen.pixel, SPREAD * detection.size_px);
        Some(Sight { camera, pixel, sigma_px, ray: camera.ray(&pixel) })
    };
    detections.iter().filter_map(sight).collect()
}

/// The point that most lines of sight agree about; `None` where no two do.
fn intersection(sights: &[Sight<'_>]) -> Option<Point3<f64>> {
    let pairs = (0..sights.len()).flat_map(|i| (0..i).map(move |j| (i, j)));
    let proposals = pairs.filter_map(|(i, j)| closest_point(&[sights[i].ray, sights[j].ray]));
    let cost = |point: &Point3<f64>| -> f64 {
        sights.iter().map(|sight| sight.square(point).min(AGREE * AGREE)).sum()
    };
    let best = proposals.min_by(|a, b| cost(a).total_cmp(&cost(b)))?;

    let agreeing = sights.iter().filter(|sight| sight.square(&best) < AGREE * AGREE);
    let rays: Vec<Ray> = agreeing.map(|sight| sight.ray).collect();
    (rays.len() >= 2).then(|| closest_point(&rays)).flatten()
}

/// The same joint of the other side, or itself where there are no sides.
pub fn twin(name: &str) -> String {
    Side::mirrored(name).unwrap_or_else(|| name.to_owned())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::silhouette::Keypoint;
    use crate::synth::Ring;

    const PLACES: [(&str, [f64; 3]); 5] = [
        ("RHip", [0.0, -0.1, 0.9]),
        ("LHip", [0.0, 0.1, 0.9]),
        ("RKnee", [0.1, -0.1, 0.5]),
        ("LKnee", [-0.1, 0.1, 0.5]),
        ("Neck", [0.0, 0.0, 1.4]),
    ];

    fn seen(rig: &Rig) -> Vec<(CameraId, Detection)> {
        let of_camera = |(id, camera): (CameraId, &Camera)| {
            let keypoint = |(name, place): &(&'static str, [f64; 3])| Keypoint {
                name,
                pixel: camera.project_undistorted(&Point3::from(*place)).unwrap(),
                confidence: 0.9,
            };
            (id, Detection { keypoints: PLACES.iter().map(keypoint).collect(), size_px: 100.0 })
        };
        rig.iter().map(of_camera).collect()
    }

    #[test]
    fn joints_are_found_where_they_are_and_one_detector_with_exchanged_knees_is_outvoted() {
        let rig = Ring { cameras: 3, ..Ring::default() }.regular();
        let mut seen = seen(&rig);
        let knees = [seen[0].1.keypoints[2].pixel, seen[0].1.keypoints[3].pixel];
        seen[0].1.keypoints[2].pixel = knees[1];
        seen[0].1.keypoints[3].pixel = knees[0];
        seen[0].1.size_px = 30.0;
        let joints = Joints::new(&rig, &seen).unwrap();
        for (name, place) in PLACES {
            let off = (joints.place(name).unwrap() - Point3::from(place)).norm();
            assert!(off < 0.02, "{name}: {off}");
        }
        // ahead is along x
        assert!(joints.heading().unwrap().abs() < 1e-6);
        assert!((joints.middle() - Point3::new(0.0, 0.0, 1.07)).norm() < 0.05);
    }

    #[test]
    fn who_lies_is_turned_as_hips_and_shoulders_say() {
        let trunk = [("RHip", [0.0, -0.1, 0.9]), ("LHip", [0.0, 0.1, 0.9])]
            .into_iter()
            .chain([("RShoulder", [0.0, -0.2, 1.4]), ("LShoulder", [0.0, 0.2, 1.4])]);
        let trunk: Vec<(&'static str, Point3<f64>)> =
            trunk.map(|(name, place)| (name, Point3::from(place))).collect();
        assert_eq!(Joints { places: trunk.clone() }.lying(), None);

        let turn = Rotation3::from_euler_angles(0.3, -1.4, 0.7);
        let turned = trunk.into_iter().map(|(name, place)| (name, turn * place)).collect();
        let found = Joints { places: turned }.lying().unwrap();
        assert!(found.angle_to(&turn) < 1e-6, "{found}");
    }

    #[test]
    fn two_cameras_that_see_different_people_agree_about_no_joint() {
        let rig = Ring { cameras: 3, ..Ring::default() }.regular();
        let mut seen = seen(&rig);
        seen.pop();
        assert!(may_locate(&seen));
        for keypoint in &mut seen[0].1.keypoints {
            keypoint.pixel.y += 80.0;
        }
        seen.iter_mut().for_each(|(_, detection)| detection.size_px = 50.0);
        assert_eq!(Joints::new(&rig, &seen), None);
    }
}
