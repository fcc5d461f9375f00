//! A slanted, textured wall before cameras side by side, drawn by intersecting every pixel's line of sight with it.

use maquette::camera::{Camera, Distortion, Intrinsics};
use maquette::image::Plane;
use maquette::math::Rigid3;
use maquette::stereo::StereoView;
use nalgebra::{Point2, Point3, Translation3, UnitQuaternion, Vector3};

pub const SIZE: (u32, u32) = (120, 90);

/// A camera at (x, 0, 0) that looks along z, turned a little about its vertical.
pub fn camera(name: &str, x: f64, turn: f64, distortion: Distortion) -> Camera {
    let rotation = UnitQuaternion::from_axis_angle(&Vector3::y_axis(), turn);
    Camera {
        name: name.into(),
        width_px: SIZE.0,
        height_px: SIZE.1,
        intrinsics: Intrinsics {
            fx_px: 150.0,
            fy_px: 150.0,
            cx_px: 59.5,
            cy_px: 44.5,
            skew_px: 0.0,
        },
        distortion,
        camera_from_world: Rigid3::from_parts(Translation3::identity(), rotation)
            * Translation3::new(-x, 0.0, 0.0),
    }
}

/// The same camera with so many times the pixels to each side.
pub fn finer(camera: &Camera, times: f64) -> Camera {
    let size = |pixels: u32| (f64::from(pixels) * times).round() as u32;
    let centre = |c_px: f64| (c_px + 0.5) * times - 0.5;
    let of = camera.intrinsics;
    Camera {
        width_px: size(camera.width_px),
        height_px: size(camera.height_px),
        intrinsics: Intrinsics {
            fx_px: of.fx_px * times,
            fy_px: of.fy_px * times,
            cx_px: centre(of.cx_px),
            cy_px: centre(of.cy_px),
            ..of
        },
        ..camera.clone()
    }
}

/// z = 2 + 0.3·x + 0.1·y, moved by `shift`.
#[derive(Clone, Copy)]
pub struct Wall {
    pub shift: Vector3<f64>,
}

impl Wall {
    pub const STILL: Self = Self { shift: Vector3::new(0.0, 0.0, 0.0) };

    /// Height of a point above the wall along z, m.
    pub fn off(&self, point: &Point3<f64>) -> f64 {
        let p = point - self.shift;
        p.z - (2.0 + 0.3 * p.x + 0.1 * p.y)
    }

    /// What a camera shows of it.
    pub fn seen_by(&self, camera: &Camera) -> Plane<u8> {
        let (width, height) = (camera.width_px, camera.height_px);
        let pixel = |i: u32| {
            let recorded = Point2::new(f64::from(i % width), f64::from(i / width));
            let ray = camera.ray(&camera.undistort(&recorded).expect("a mild lens"));
            let (at_0, at_1) = (self.off(&ray.point_at(0.0)), self.off(&ray.point_at(1.0)));
            let hit = ray.point_at(at_0 / (at_0 - at_1)) - self.shift;
            brightness(&hit)
        };
        let values = (0..width * height).map(pixel).collect();
        Plane::from_values(width as usize, height as usize, values).expect("as many as pixels")
    }

    pub fn view(&self, camera: &Camera) -> StereoView {
        StereoView::undistorted(camera, &self.seen_by(camera)).expect("the camera's size")
    }
}

/// Waves in many directions: smooth, and nowhere the same.
fn brightness(place: &Point3<f64>) -> u8 {
    let wave = |i: usize| {
        let angle = 2.4 * i as f64;
        let frequency = 14.0 + 5.3 * i as f64;
        (frequency * (angle.cos() * place.x + angle.sin() * place.y) + 1.7 * (i * i) as f64).sin()
    };
    (128.0 + 28.0 * (0..8).map(wave).sum::<f64>() / 2.0).round().clamp(0.0, 255.0) as u8
}

/// Left, middle and right, 15 cm apart.
pub fn three() -> [Camera; 3] {
    [
        camera("left", -0.15, 0.02, Distortion::None),
        camera("middle", 0.0, 0.0, Distortion::None),
        camera("right", 0.15, -0.03, Distortion::None),
    ]
}
