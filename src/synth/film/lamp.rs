//! The lamp, and the shadow that the person casts in its light.

use nalgebra::{Point3, Vector3};

use super::super::scene::looking_at;
use crate::camera::{Camera, Distortion, Intrinsics};
use crate::image::Plane;
use crate::render::Raster;

/// Where the lamp is, and what it shines on, metres.
const PLACE: [f64; 3] = [5.0, -4.0, 7.0];
const AIM: [f64; 3] = [0.0, 0.0, 0.9];
/// The lamp's picture of the person: width and height, and focal length, px.
const SIZE_PX: u32 = 320;
const FOCAL_PX: f64 = 950.0;
/// Only what lies farther than this behind the first surface that the lamp sees is in the shadow, metres.
const TOLERANCE: f32 = 0.04;

/// A lamp that shines on the person.
#[derive(Debug, Clone)]
pub(super) struct Lamp {
    camera: Camera,
}

/// Column and row in the lamp's picture, and the distance from it along its axis.
pub(super) type InLamp = [f32; 3];

impl Lamp {
    pub(super) fn new() -> Self {
        let middle_px = 0.5 * (f64::from(SIZE_PX) - 1.0);
        let camera = Camera {
            name: "lamp".into(),
            width_px: SIZE_PX,
            height_px: SIZE_PX,
            intrinsics: Intrinsics {
                fx_px: FOCAL_PX,
                fy_px: FOCAL_PX,
                cx_px: middle_px,
                cy_px: middle_px,
                skew_px: 0.0,
            },
            distortion: Distortion::None,
            camera_from_world: looking_at(&Point3::from(PLACE), &Point3::from(AIM), 0.0),
        };
        Self { camera }
    }

    /// Towards the lamp, of length 1.
    pub(super) fn direction() -> Vector3<f64> {
        let towards = Vector3::from(PLACE) - Vector3::from(AIM);
        towards / towards.norm()
    }

    /// Where the lamp sees a place of the world; far outside its picture if it does not.
    pub(super) fn sees(&self, place: Point3<f64>) -> InLamp {
        let depth = (self.camera.camera_from_world * place).z;
        let pixel = self.camera.project_undistorted(&place);
        pixel.map_or([-9.0; 3], |p| [p.x as f32, p.y as f32, depth as f32])
    }

    /// The shadow of triangles.
    pub(super) fn shadow(&self, vertices: &[Vector3<f64>], triangles: &[[u32; 3]]) -> Shadow {
        let mut raster = Raster::new(&self.camera, 1);
        raster.draw(vertices, triangles, 0);
        Shadow { depth: raster.fragments().map(|fragment| fragment.depth) }
    }
}

/// How far the light comes in each direction.
#[derive(Debug, Clone)]
pub(super) struct Shadow {
    depth: Plane<f32>,
}

impl Shadow {
    /// Share of the light that reaches a place: the mean of four neighbours, so that the edge is soft.
    pub(super) fn light_at(&self, [x, y, depth]: InLamp) -> f32 {
        let (column, row) = (x.floor(), y.floor());
        let inside = 0.0..(SIZE_PX - 1) as f32;
        if !inside.contains(&column) || !inside.contains(&row) {
            return 1.0;
        }
        let is_lit = |i: usize, j: usize| {
            let nearest = self.depth.get(column as usize + i, row as usize + j);
            f32::from(u8::from(nearest.is_none_or(|d| depth < d + TOLERANCE)))
        };
        let (u, v) = (x - column, y - row);
        (1.0 - v) * ((1.0 - u) * is_lit(0, 0) + u * is_lit(1, 0))
            + v * ((1.0 - u) * is_lit(0, 1) + u * is_lit(1, 1))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_lies_behind_a_sheet_from_the_lamp_is_dark_and_what_lies_beside_it_is_not() {
        let lamp = Lamp::new();
        let at = |x: f64, y: f64| Vector3::new(x, y, 1.0);
        let sheet = [at(-0.3, -0.3), at(0.3, -0.3), at(0.3, 0.3), at(-0.3, 0.3)];
        let shadow = lamp.shadow(&sheet, &[[0, 1, 2], [0, 2, 3]]);
        let light = |place: Vector3<f64>| shadow.light_at(lamp.sees(place.into()));
        let away = -Lamp::direction();
        approx::assert_relative_eq!(light(at(0.0, 0.0) + away * 0.5), 0.0);
        approx::assert_relative_eq!(light(at(0.0, 0.0)), 1.0);
        approx::assert_relative_eq!(light(at(0.0, 0.0) - away * 0.5), 1.0);
        approx::assert_relative_eq!(light(at(0.6, 0.0) + away * 0.5), 1.0);
        approx::assert_relative_eq!(light(at(90.0, 0.0)), 1.0);
    }
}
