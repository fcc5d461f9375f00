//! Which triangle of a scene each sample of a camera's picture sees: a depth buffer.
//!
//! A triangle's corners are projected; within it 1/z and the corners' weights over z are linear in the picture, which gives
//! depth and perspective-correct weights (Heckbert & Moreton 1991). Of several triangles the nearest counts.

use nalgebra::{Point2, Point3, Vector3};

use crate::camera::Camera;
use crate::image::Plane;

/// Nearest depth that is drawn, metres.
const NEAREST: f64 = 0.05;

/// The place on a triangle that one sample sees.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Fragment {
    /// z in the camera frame, metres; infinite where nothing is seen.
    pub depth: f32,
    /// Number of the triangle.
    pub triangle: u32,
    /// Weights of its corners; they sum to 1.
    pub weights: [f32; 3],
}

impl Fragment {
    /// The fragment of a sample that sees no triangle.
    pub const NOTHING: Self = Self { depth: f32::INFINITY, triangle: u32::MAX, weights: [0.0; 3] };

    /// The weighted mean of what the corners carry.
    pub fn mix<const N: usize>(&self, corners: [[f32; N]; 3]) -> [f32; N] {
        let [a, b, c] = self.weights;
        std::array::from_fn(|i| a * corners[0][i] + b * corners[1][i] + c * corners[2][i])
    }
}

/// A picture of fragments, `samples` × `samples` in each pixel of a camera.
///
/// Sample (i, j) lies at pixel ((i + ½)/samples − ½, (j + ½)/samples − ½). Pictures are undistorted ones.
#[derive(Debug, Clone)]
pub struct Raster<'a> {
    camera: &'a Camera,
    samples: usize,
    fragments: Plane<Fragment>,
}

impl<'a> Raster<'a> {
    /// A raster that sees nothing yet.
    pub fn new(camera: &'a Camera, samples: usize) -> Self {
        let side = |px: u32| px as usize * samples;
        let (width, height) = (side(camera.width_px), side(camera.height_px));
        Self { camera, samples, fragments: Plane::filled(width, height, Fragment::NOTHING) }
    }

    /// The fragments, sample by sample.
    pub fn fragments(&self) -> &Plane<Fragment> {
        &self.fragments
    }

    /// Draws triangles, seen from both sides, numbered from `first` on. Those that reach behind the camera are left out.
    pub fn draw(&mut self, vertices: &[Vector3<f64>], triangles: &[[u32; 3]], first: u32) {
        let projected: Vec<Option<Corner>> = vertices.iter().map(|v| self.corner(v)).collect();
        for (number, triangle) in (first..).zip(triangles) {
            let corners = triangle.map(|i| projected.get(i as usize).copied().flatten());
            if let [Some(a), Some(b), Some(c)] = corners {
                self.fill([a, b, c], number);
            }
        }
    }

    /// A vertex in the picture; `None` behind the camera.
    fn corner(&self, vertex: &Vector3<f64>) -> Option<Corner> {
        let place = Point3::from(*vertex);
        let depth = (self.camera.camera_from_world * place).z;
        let pixel = self.camera.project_undistorted(&place)?;
        let samples = self.samples as f64;
        let at = pixel.map(|x| (x + 0.5) * samples - 0.5);
        (depth > NEAREST).then(|| Corner { at, inverse_depth: depth.recip() })
    }

    /// Draws one triangle where nothing nearer was drawn.
    fn fill(&mut self, corners: [Corner; 3], number: u32) {
        let [a, b, c] = corners.map(|corner| corner.at);
        let twice_area = cross(&a, &b, &c);
        if twice_area.abs() < 1e-12 {
            return;
        }

        let (low, high) = (a.inf(&b).inf(&c), a.sup(&b).sup(&c));
        let range = |low: f64, high: f64, size: usize| {
            low.ceil().max(0.0) as usize..(high.floor() + 1.0).clamp(0.0, size as f64) as usize
        };
        let columns = range(low.x, high.x, self.fragments.width());
        for y in range(low.y, high.y, self.fragments.height()) {
            let row = self.fragments.row_mut(y);
            for x in columns.clone() {
                // the corners' weights in the picture: shares of the area
                let p = Point2::new(x as f64, y as f64);
                let share = [cross(&b, &c, &p), cross(&c, &a, &p), cross(&a, &b, &p)]
                    .map(|w| w / twice_area);
                if share.iter().any(|w| *w < 0.0) {
                    continue;
                }

                // and in space
                let over_z: [f64; 3] = std::array::from_fn(|k| share[k] * corners[k].inverse_depth);
                let depth = over_z.iter().sum::<f64>().recip();
                if (depth as f32) < row[x].depth {
                    row[x] = Fragment {
                        depth: depth as f32,
                        triangle: number,
                        weights: over_z.map(|w| (w * depth) as f32),
                    };
                }
            }
        }
    }
}

/// A vertex as the camera sees it.
#[derive(Clone, Copy)]
struct Corner {
    /// In samples.
    at: Point2<f64>,
    inverse_depth: f64,
}

/// Twice the area of a triangle in the picture, with the sign of its sense.
fn cross(a: &Point2<f64>, b: &Point2<f64>, c: &Point2<f64>) -> f64 {
    (b - a).perp(&(c - a))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::camera::{Distortion, Intrinsics};
    use crate::math::Rigid3;

    /// Looks along the world's z axis from the origin.
    fn camera() -> Camera {
        Camera {
            name: "one".into(),
            width_px: 40,
            height_px: 30,
            intrinsics: Intrinsics {
                fx_px: 40.0,
                fy_px: 40.0,
                cx_px: 19.5,
                cy_px: 14.5,
                skew_px: 0.0,
            },
            distortion: Distortion::None,
            camera_from_world: Rigid3::identity(),
        }
    }

    const SLOPE: [Vector3<f64>; 3] =
        [Vector3::new(-2.0, -1.0, 2.0), Vector3::new(3.0, -1.5, 6.0), Vector3::new(0.0, 2.0, 3.0)];

    #[test]
    fn weights_are_those_of_the_place_in_space_that_the_sample_sees() {
        let camera = camera();
        let mut raster = Raster::new(&camera, 2);
        raster.draw(&SLOPE, &[[0, 1, 2]], 7);
        let mut seen = 0;
        for y in 0..60 {
            for x in 0..80 {
                let fragment = raster.fragments().get(x, y).unwrap();
                if fragment.triangle != 7 {
                    continue;
                }
                seen += 1;
                let weights = fragment.weights.map(f64::from);
                let place: Vector3<f64> = (0..3).map(|k| SLOPE[k] * weights[k]).sum();
                let pixel = camera.project_undistorted(&place.into()).unwrap();
                approx::assert_relative_eq!(place.z, f64::from(fragment.depth), epsilon = 1e-4);
                approx::assert_relative_eq!(pixel.x, (x as f64 + 0.5) / 2.0 - 0.5, epsilon = 1e-3);
                approx::assert_relative_eq!(pixel.y, (y as f64 + 0.5) / 2.0 - 0.5, epsilon = 1e-3);
            }
        }
        assert!(seen > 500, "{seen}");
    }

    #[test]
    fn the_nearer_triangle_is_seen_whichever_is_drawn_first() {
        let camera = camera();
        let near = SLOPE.map(|v| v * 0.5 + Vector3::z() * 0.2);
        let (mut one, mut other) = (Raster::new(&camera, 1), Raster::new(&camera, 1));
        one.draw(&SLOPE, &[[0, 1, 2]], 0);
        one.draw(&near, &[[0, 1, 2]], 1);
        other.draw(&near, &[[2, 1, 0]], 1);
        other.draw(&SLOPE, &[[0, 1, 2]], 0);
        let numbers = |raster: &Raster<'_>| raster.fragments().map(|f| f.triangle);
        assert_eq!(numbers(&one), numbers(&other));
        assert_eq!(one.fragments().get(19, 14).unwrap().triangle, 1);
    }

    #[test]
    fn what_is_behind_the_camera_flat_or_no_number_draws_nothing() {
        let camera = camera();
        let mut raster = Raster::new(&camera, 1);
        let behind = SLOPE.map(|v| v - Vector3::z() * 4.0);
        let flat = [SLOPE[0], SLOPE[0], SLOPE[1]];
        let nowhere = [SLOPE[0], SLOPE[1], Vector3::from_element(f64::NAN)];
        for vertices in [behind, flat, nowhere] {
            raster.draw(&vertices, &[[0, 1, 2], [0, 1, 9]], 0);
        }
        let all = raster.fragments().values();
        assert!(all.iter().all(|f| *f == Fragment::NOTHING));
    }
}
