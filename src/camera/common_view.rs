//! Whether the cameras of a rig look at one volume, and which of them do not.

use super::{Camera, CameraId, Ray, Rig, closest_point};
use nalgebra::{Point2, Point3};
use std::fmt;

/// Columns and rows of the grid of lines of sight that are tried in each camera; edges are left out.
const GRID: u32 = 5;
/// Nearest point tried on each line of sight, in typical distances between cameras.
const NEAREST: f64 = 0.05;
/// Farthest point tried on each line of sight, in typical distances between cameras.
const FARTHEST: f64 = 50.0;
/// Number of points tried on each line of sight; their distances are equally spaced in the logarithm.
const DEPTHS: u32 = 60;

/// The point that most cameras see, and the cameras that do not see it.
#[derive(Debug, Clone, PartialEq)]
pub struct CommonView {
    /// Of all points tried, the one that most cameras see; among equals, the one nearest to the middle of their images.
    pub point_world: Point3<f64>,
    /// The cameras that see it.
    pub seeing: Vec<CameraId>,
    /// The cameras that do not see it, and why.
    pub blind: Vec<(CameraId, Blindness)>,
}

impl CommonView {
    /// Whether all cameras see one point.
    pub fn is_complete(&self) -> bool {
        self.blind.is_empty()
    }

    /// Whether more than half of the cameras, and at least two, see one point: then those in [`CommonView::blind`] are the odd
    /// ones out.
    pub fn has_majority(&self) -> bool {
        self.seeing.len() >= 2 && self.seeing.len() > self.blind.len()
    }
}

/// Why a camera does not see a point.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Blindness {
    /// The point is behind the camera.
    Behind,
    /// The point is so far to the side that the lens model gives it no image.
    BeyondLens,
    /// The point's image lies outside the sensor.
    OutsideImage {
        /// Where, in pixels of the recorded image.
        pixel: Point2<f64>,
    },
}

impl fmt::Display for Blindness {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("what they see is ")?;
        match self {
            Self::Behind => write!(f, "behind it"),
            Self::BeyondLens => write!(f, "beyond the view of its lens"),
            Self::OutsideImage { pixel } => {
                write!(f, "outside its image, at ({:.0}, {:.0}) px", pixel.x, pixel.y)
            }
        }
    }
}

impl Rig {
    /// Looks for the point that most cameras see, and says which cameras do not see it.
    ///
    /// It tries the point closest to the optical axes, and points along 25 lines of sight of every camera, at distances
    /// of 0.05 to 50 times the typical distance between cameras. So parallel cameras side by side agree as well as
    /// cameras in a ring. Each camera has one vote for a point, hence a camera with a wrong pose cannot draw the point
    /// away from the others. A wrong unit or world axis moves all cameras together and does not show here.
    ///
    /// `None` for a rig without cameras.
    pub fn common_view(&self) -> Option<CommonView> {
        let best = self
            .candidates()
            .into_iter()
            .map(|point| (self.votes(&point), point))
            .reduce(|best, next| if next.0.beats(&best.0) { next } else { best })?;
        Some(self.view_of(best.1))
    }

    fn view_of(&self, point_world: Point3<f64>) -> CommonView {
        let mut view = CommonView { point_world, seeing: Vec::new(), blind: Vec::new() };
        for (id, camera) in self.iter() {
            match visible_pixel(camera, &point_world) {
                Ok(_) => view.seeing.push(id),
                Err(blindness) => view.blind.push((id, blindness)),
            }
        }
        view
    }

    fn votes(&self, point_world: &Point3<f64>) -> Votes {
        let eccentricities = self.cameras.iter().filter_map(|camera| {
            Some(eccentricity(camera, &visible_pixel(camera, point_world).ok()?))
        });
        eccentricities.fold(Votes::default(), |votes, eccentricity| Votes {
            cameras: votes.cameras + 1,
            eccentricity: votes.eccentricity + eccentricity,
        })
    }

    fn candidates(&self) -> Vec<Point3<f64>> {
        let axes: Vec<Ray> = self.cameras.iter().map(Camera::optical_axis).collect();
        let scale = self.typical_distance();
        let step = (FARTHEST / NEAREST).ln() / f64::from(DEPTHS - 1);
        let depths: Vec<f64> =
            (0..DEPTHS).map(|i| scale * NEAREST * (step * f64::from(i)).exp()).collect();
        let rays = self.cameras.iter().flat_map(lines_of_sight);
        let along =
            rays.flat_map(|ray| depths.iter().map(move |&t| ray.point_at(t)).collect::<Vec<_>>());
        closest_point(&axes).into_iter().chain(along).collect()
    }

    /// Median distance between two cameras; 1 m if there is none or it is zero.
    fn typical_distance(&self) -> f64 {
        let centres: Vec<Point3<f64>> = self.cameras.iter().map(Camera::centre_world).collect();
        let mut distances: Vec<f64> = centres
            .iter()
            .enumerate()
            .flat_map(|(i, a)| centres[..i].iter().map(move |b| (a - b).norm()))
            .collect();
        crate::math::stats::median(&mut distances).filter(|&distance| distance > 0.0).unwrap_or(1.0)
    }
}

#[derive(Default)]
struct Votes {
    cameras: u32,
    eccentricity: f64,
}

impl Votes {
    fn beats(&self, other: &Self) -> bool {
        self.cameras > other.cameras
            || self.cameras == other.cameras && self.eccentricity < other.eccentricity
    }
}

/// The pixel of the recorded image at which a camera sees a point.
fn visible_pixel(camera: &Camera, point_world: &Point3<f64>) -> Result<Point2<f64>, Blindness> {
    camera.project_undistorted(point_world).ok_or(Blindness::Behind)?;
    let pixel = camera.project(point_world).ok_or(Blindness::BeyondLens)?;
    if camera.contains(&pixel) { Ok(pixel) } else { Err(Blindness::OutsideImage { pixel }) }
}

/// 0 in the middle of the image, 1 at its edge.
fn eccentricity(camera: &Camera, pixel: &Point2<f64>) -> f64 {
    let off = |x: f64, size: u32| ((2.0 * x + 1.0) / f64::from(size) - 1.0).abs();
    off(pixel.x, camera.width_px).max(off(pixel.y, camera.height_px))
}

fn lines_of_sight(camera: &Camera) -> Vec<Ray> {
    let inner = |pixel: &Point2<f64>| eccentricity(camera, pixel) < 1.0 - f64::EPSILON;
    camera
        .pixel_grid(GRID + 2, GRID + 2)
        .iter()
        .filter(|pixel| inner(pixel))
        .filter_map(|pixel| Some(camera.ray(&camera.undistort(pixel)?)))
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::camera::{Distortion, Intrinsics};
    use crate::math::Rigid3;
    use nalgebra::{Isometry3, Vector3};

    fn looking(from: [f64; 3], at: [f64; 3]) -> Camera {
        // nalgebra's view looks along −z with y up: half a turn about x makes it z forward, y down
        let view = Isometry3::look_at_rh(&Point3::from(from), &Point3::from(at), &Vector3::z());
        let half_turn = Rigid3::rotation(Vector3::x() * std::f64::consts::PI);
        Camera {
            name: "camera".into(),
            width_px: 640,
            height_px: 480,
            intrinsics: Intrinsics {
                fx_px: 700.0,
                fy_px: 700.0,
                cx_px: 319.5,
                cy_px: 239.5,
                skew_px: 0.0,
            },
            distortion: Distortion::None,
            camera_from_world: half_turn * view,
        }
    }

    fn ring() -> Rig {
        let at = [0.0, 0.0, 1.0];
        let cameras = (0..5)
            .map(|i| f64::from(i) * 1.2)
            .map(|angle| looking([4.0 * angle.cos(), 4.0 * angle.sin(), 2.0], at))
            .collect();
        Rig { cameras }
    }

    #[test]
    fn cameras_in_a_ring_see_its_middle() {
        let view = ring().common_view().unwrap();
        assert!(view.is_complete());
        assert!((view.point_world - Point3::new(0.0, 0.0, 1.0)).norm() < 0.5);
    }

    #[test]
    fn parallel_cameras_side_by_side_agree() {
        let cameras = (0..3)
            .map(|i| f64::from(i) * 0.2)
            .map(|x| looking([x, 0.0, 1.0], [x, 4.0, 1.0]))
            .collect();
        let view = Rig { cameras }.common_view().unwrap();
        assert!(view.is_complete() && view.has_majority(), "{view:?}");
    }

    #[test]
    fn the_camera_that_looks_away_is_named_wherever_it_stands() {
        for odd in 0..5 {
            let mut rig = ring();
            let away = rig.cameras[odd].optical_axis().point_at(-3.0);
            let from = rig.cameras[odd].centre_world();
            rig.cameras[odd] = looking(from.coords.into(), away.coords.into());
            let view = rig.common_view().unwrap();
            assert_eq!(view.blind, [(CameraId(odd), Blindness::Behind)]);
            assert!(view.has_majority());
        }
    }

    #[test]
    fn the_camera_that_looks_aside_has_the_point_outside_its_image() {
        let mut rig = ring();
        let from = rig.cameras[2].centre_world();
        // 70° off the middle: still before the camera, outside its image
        let aside = Rigid3::rotation(Vector3::z() * 1.22) * -from;
        rig.cameras[2] = looking(from.coords.into(), (from + aside.coords).coords.into());
        let view = rig.common_view().unwrap();
        assert_eq!(view.blind.len(), 1);
        assert_eq!(view.blind[0].0, CameraId(2));
        let reason = view.blind[0].1.to_string();
        assert!(reason.contains("outside its image, at"), "{reason}");
    }

    #[test]
    fn two_cameras_back_to_back_have_no_majority() {
        let cameras = vec![
            looking([0.0, 1.0, 1.0], [0.0, 5.0, 1.0]),
            looking([0.0, -1.0, 1.0], [0.0, -5.0, 1.0]),
        ];
        let view = Rig { cameras }.common_view().unwrap();
        assert!(!view.has_majority() && !view.is_complete());
    }

    #[test]
    fn a_rig_without_cameras_has_no_view_and_one_camera_agrees_with_itself() {
        assert_eq!(Rig::default().common_view(), None);
        let mut rig = ring();
        rig.cameras.truncate(1);
        assert!(rig.common_view().is_some_and(|view| view.is_complete()));
    }
}
