//! Detections: where another program sees the joints of a person in one picture.

use nalgebra::{Point2, Point3};

use super::{FrameIndex, Silhouette};
use crate::camera::{Camera, CameraId};

/// One named point of a person in one picture.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Keypoint {
    /// Its name, as Pose2Sim has it: `RKnee`.
    pub name: &'static str,
    /// Where it was seen, undistorted pixels.
    pub pixel: Point2<f64>,
    /// How sure the detector is: above 0, at most 1.
    pub confidence: f64,
}

/// The keypoints of one person in one picture.
#[derive(Debug, Clone, PartialEq)]
pub struct Detection {
    /// Those that were seen, at most one of each name.
    pub keypoints: Vec<Keypoint>,
    /// The person's size in the picture: √ of the area of the silhouette, or of half the box around the keypoints, px.
    pub size_px: f64,
}

/// All people whom other programs see in the pictures of one frame.
#[derive(Debug, Clone, PartialEq)]
pub struct FramePeople {
    /// Which frame.
    pub frame: FrameIndex,
    /// The people in each picture that shows any, in the order of the rig.
    pub pictures: Vec<(CameraId, Vec<Vec<Keypoint>>)>,
}

impl Detection {
    /// Of keypoints whose person's silhouette is not known; `None` without any.
    pub fn new(keypoints: Vec<Keypoint>) -> Option<Self> {
        let (low, high) = bounds(&keypoints)?;
        let size = high - low;
        // a person is wider than the joints of one who stands straight and is seen from the side
        let narrowest = size.max() / SLENDER;
        let size_px = (0.5 * size.x.max(narrowest) * size.y.max(narrowest)).sqrt();
        (size_px > 0.0).then_some(Self { keypoints, size_px })
    }

    /// The least and the largest pixel of the keypoints.
    pub fn bounds(&self) -> Option<(Point2<f64>, Point2<f64>)> {
        bounds(&self.keypoints)
    }

    /// The keypoint of a name.
    pub fn keypoint(&self, name: &str) -> Option<&Keypoint> {
        self.keypoints.iter().find(|keypoint| keypoint.name == name)
    }
}

fn bounds(keypoints: &[Keypoint]) -> Option<(Point2<f64>, Point2<f64>)> {
    let pixels = keypoints.iter().map(|keypoint| (keypoint.pixel, keypoint.pixel));
    pixels.reduce(|a, b| (a.0.inf(&b.0), a.1.sup(&b.1)))
}

/// How far keypoints lie from where a body has them, undistorted px; of those that it has, and that are before the camera.
pub fn distances_px(
    keypoints: &[Keypoint],
    camera: &Camera,
    place_world: impl Fn(&str) -> Option<Point3<f64>>,
) -> Vec<f64> {
    let off = |seen: &Keypoint| {
        let at = camera.project_undistorted(&place_world(seen.name)?)?;
        Some((seen.pixel - at).norm())
    };
    keypoints.iter().filter_map(off).collect()
}

/// The box around a standing person is so many times as high as wide at most.
const SLENDER: f64 = 4.0;

/// A detection is the silhouette's if this share of its keypoints, by confidence, lies within it or near it.
const LEAST_INSIDE: f64 = 0.5;
/// Keypoints lie so near to the silhouette that they are of, over its size: hands and feet are thin, masks are ragged.
const NEAR: f64 = 0.05;

impl Silhouette {
    /// The one of several people in the picture whose silhouette this is, if it is one's.
    pub fn detection(&self, people: Vec<Vec<Keypoint>>) -> Option<Detection> {
        let size_px = self.area_px.sqrt();
        let is_near = |k: &Keypoint| {
            let is_about = || self.outside.sample(&k.pixel).0 <= NEAR * size_px;
            self.contains(&k.pixel) || self.sees(&k.pixel) && is_about()
        };
        let share = |keypoints: &[Keypoint]| {
            let all: f64 = keypoints.iter().map(|k| k.confidence).sum();
            let near = keypoints.iter().filter(|k| is_near(k));
            near.map(|k| k.confidence).sum::<f64>() / all.max(f64::MIN_POSITIVE)
        };

        // of two that lie within it the one with more keypoints there
        let seen = people.into_iter().filter(|keypoints| share(keypoints) > LEAST_INSIDE);
        let weight = |keypoints: &[Keypoint]| share(keypoints) * keypoints.len() as f64;
        let keypoints = seen.max_by(|a, b| weight(a).total_cmp(&weight(b)))?;
        Some(Detection { keypoints, size_px })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::camera::{Camera, Distortion, Intrinsics};
    use crate::image::Mask;
    use crate::math::Rigid3;
    use crate::silhouette::{SilhouetteOptions, extract};

    fn people(at: [f64; 2]) -> Vec<Keypoint> {
        let seen =
            |name, y| Keypoint { name, pixel: Point2::new(at[0], at[1] + y), confidence: 0.8 };
        vec![seen("RHip", 0.0), seen("RKnee", 20.0), seen("RAnkle", 40.0)]
    }

    #[test]
    fn of_two_people_the_one_in_the_silhouette_is_taken_and_nobody_if_none_is() {
        let mask = Mask::from_fn(160, 120, |x, y| (30..50).contains(&x) && (20..100).contains(&y));
        let intrinsics =
            Intrinsics { fx_px: 200.0, fy_px: 200.0, cx_px: 79.5, cy_px: 59.5, skew_px: 0.0 };
        let camera = Camera {
            name: "a".into(),
            width_px: 160,
            height_px: 120,
            intrinsics,
            distortion: Distortion::None,
            camera_from_world: Rigid3::identity(),
        };
        let silhouette = extract(&mask, &camera, &SilhouetteOptions::default()).unwrap();
        let found =
            silhouette.detection(vec![people([120.0, 40.0]), people([40.0, 40.0])]).unwrap();
        assert!(found.keypoints[0].pixel.x < 60.0);
        approx::assert_relative_eq!(found.size_px, 40.0, max_relative = 0.02);
        assert_eq!(silhouette.detection(vec![people([120.0, 40.0])]), None);
        assert_eq!(silhouette.detection(Vec::new()), None);
    }
}
